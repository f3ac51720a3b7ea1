// A conversation with one board over CANopen: settings, models, set points, capture.
//
// Every call that waits hands the frames which are not its own to the subscriber: emergencies, heartbeats and
// TPDOs are never lost to an SDO transfer that happens to be under way. One session at a time uses a link.
// Arguments number chambers from 0, as the objects do; messages from 1, as emergencies and people do.
#pragma once

#include <bit>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "firmware/canopen/cia301.hpp"
#include "firmware/canopen/objects.hpp"
#include "host-sim/client/errors.hpp"
#include "host-sim/client/link.hpp"
#include "host-sim/client/sdo_client.hpp"
#include "host-sim/client/stream.hpp"

namespace plenum::host::client {

/// A frame that was not an answer to this session's own request.
struct Arrival {
  double time_s = 0.0;  ///< of the link's world, when it was taken
  CanFrame frame;
};

struct Emergency {
  std::uint8_t node_id = 0;
  std::uint16_t code = 0;  ///< 0: the error is gone
  std::uint8_t error_register = 0;
  std::uint8_t chamber = 0;  ///< chamber of the error + 1; 0: the whole board
  std::uint8_t lost_node =
      0;  ///< of 8130h: the node whose heartbeat is missing; 0 of any other, and where no node is named
};

/// The emergency message in a frame with a predefined COB-ID; empty for any other frame.
std::optional<Emergency> decode_emergency(const CanFrame& frame);

struct ModelUpload {
  std::uint8_t chamber = 0;  ///< 0..7
  std::vector<std::uint8_t> image;
};

/// How the board has compared a model that it took with the one it had before, over its log of the chamber. The safety of a model
/// that was not compared is its user's to see to.
struct Comparison {
  enum class Outcome {
    no_model,     ///< there was none before
    same,         ///< it is the model that was in force before
    no_movement,  ///< its log, if there is one, has too little movement of the pressure to tell two models apart
    not_awaited,  ///< the commit was forced before there was a result
    worse,        ///< and was accepted
    passed
  };
  Outcome outcome = Outcome::no_model;
  double rms_Pa = 0.0;         ///< of the new model's prediction; when passed or worse
  double before_rms_Pa = 0.0;  ///< likewise
  std::string doubt;  ///< why the board doubted a model that was accepted: a clause; empty: it did not
};
/// A clause for a person; empty where there is nothing to see to.
std::string caveat_of(const Comparison& comparison);

/// What becomes of a model that the board doubts: it predicts worse than the one in force, or is of another valve.
enum class Doubted {
  refuse,
  accept,  ///< it is committed when the board has said why, and its Comparison tells
  force    ///< it is committed at once: nobody learns whether the board would have doubted it
};

enum class SetpointFormat {
  millibar,  ///< RPDO1 and 2 as the board has them by default: 1 mbar a step, control word by RPDO3
  pascal     ///< RPDO1..4, two REAL32 each; the control word then goes by SDO only
};

struct SessionConfig {
  SdoConfig sdo = {};
  double state_timeout_s = 2.0;  ///< for a state asked of the board
};

/// Of a session: the object that is being read or written, and how many of its bytes have come or gone.
struct Transfer {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::size_t done = 0;
  std::optional<std::size_t> total{};  ///< empty: the board does not know it, or nothing has come yet
};

class Session {
 public:
  /// `node_id` 1..127, otherwise std::invalid_argument. The link must outlive the session.
  Session(Link& link, std::uint8_t node_id, const SessionConfig& config = {});
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  std::uint8_t node_id() const { return node_id_; }
  Link& link() { return link_; }

  /// Who gets every frame that is no answer to this session. Replaces the one before.
  void subscribe(std::function<void(const Arrival&)> subscriber) { subscriber_ = std::move(subscriber); }

  /// Hands a frame that somebody else took from the link to the subscriber.
  void hear(const CanFrame& frame);

  /// Hands on what arrives for `duration_s`.
  void listen(double duration_s);

  /// Hands on what arrives until `done` is true; looks after each frame. Returns false when it is not within
  /// `timeout_s`.
  bool listen_until(const std::function<bool()>& done, double timeout_s);

  // ---- network ----

  void nmt(canopen::NmtCommand command);
  /// The state in the next heartbeat or boot-up message of this board. Throws Timeout.
  canopen::NmtState wait_heartbeat(double timeout_s);
  /// Hears heartbeats until one tells `wanted`, whatever beats before it. The state told last: another when the time is over, none
  /// where nothing beat.
  std::optional<canopen::NmtState> wait_state(canopen::NmtState wanted, double timeout_s);
  /// The boot-up message of this board, whatever beats before it. Throws Timeout, which says whether it beat.
  void wait_boot_up(double timeout_s);
  /// Reads 1005h and 1019h: from here on send_sync() is what this board takes for a SYNC, with its identifier and counter. Throws Refused
  /// where SYNCs are counted and another master sends them.
  void learn_sync();
  void send_sync();

  // ---- objects: SdoAbort, Timeout, ProtocolError, ChannelTaken ----

  /// Who is told of each transfer when it begins, and as it goes on. Replaces the one before.
  void watch_transfers(std::function<void(const Transfer&)> watcher) { watcher_ = std::move(watcher); }

  std::vector<std::uint8_t> sdo_read(std::uint16_t index, std::uint8_t sub) {
    tell({index, sub});
    return sdo_.read(index, sub);
  }
  /// For DOMAINs and other long values: by blocks where the board knows them.
  std::vector<std::uint8_t> sdo_read_domain(std::uint16_t index, std::uint8_t sub,
                                            const TransferProgress& progress = {}) {
    tell({index, sub});
    return sdo_.read_domain(index, sub, told(index, sub, progress));
  }
  /// Expedited up to four bytes; above in segments or blocks, as the board knows them.
  void sdo_write(std::uint16_t index, std::uint8_t sub, std::span<const std::uint8_t> bytes,
                 const TransferProgress& progress = {}) {
    tell({index, sub});
    sdo_.write(index, sub, bytes, told(index, sub, progress));
  }

  /// T is the object's type: std::uint8_t .. std::int32_t, float.
  template <class T>
  T read(std::uint16_t index, std::uint8_t sub) {
    static_assert(std::is_arithmetic_v<T> && sizeof(T) <= 4);
    const std::uint32_t bits = read_bits(index, sub, sizeof(T));
    if constexpr (std::is_floating_point_v<T>) {
      return std::bit_cast<T>(bits);
    } else {
      return static_cast<T>(bits);
    }
  }
  template <class T>
  void write(std::uint16_t index, std::uint8_t sub, T value) {
    static_assert(std::is_arithmetic_v<T> && sizeof(T) <= 4);
    if constexpr (std::is_floating_point_v<T>) {
      write_bits(index, sub, std::bit_cast<std::uint32_t>(value), sizeof(T));
    } else {
      write_bits(index, sub, static_cast<std::uint32_t>(value), sizeof(T));
    }
  }
  /// Legible: what a node says of itself moves no terminal.
  std::string read_text(std::uint16_t index);

  // ---- device control (CiA 408) ----

  std::uint16_t status_word() { return read<std::uint16_t>(canopen::object::kStatusWord, 0); }
  /// Writes 6040h and waits until 6041h shows the same state and "ready". Throws Refused when a fault stands,
  /// Timeout.
  void request_state(std::uint16_t control_word);
  /// DISABLED, HOLD, ACTIVE, one after the other. The set points should be good before.
  void enable();
  /// A board that is not in INIT or FAULT_INIT, the states in which it takes settings and a node id, gets 6040h = 0, and is there
  /// afterwards. Throws Timeout. One that regulates should not be asked: require_at_rest() of board_facts.hpp.
  void take_to_init();
  void disable() { request_state(canopen::word::kDisabled); }
  /// A rising edge of R, then waits until the board is ready and DISABLED. Throws Refused when the fault
  /// stays.
  void reset_fault();

  // ---- models ----

  /// Stages all, commits all at once, waits for the take-over and reads each back. Throws Refused (which
  /// chamber, which parameter, its value and range) when the board says no; then nothing in force has
  /// changed. Before the commit it waits for the board's comparison with the models in force, and says of each, in the order of
  /// `uploads`, how that ended.
  std::vector<Comparison> upload_models(std::span<const ModelUpload> uploads,
                                        Doubted doubted = Doubted::refuse);
  Comparison upload_model(std::uint8_t chamber, std::span<const std::uint8_t> image,
                          Doubted doubted = Doubted::refuse);
  /// The image in force; empty when there is none.
  std::vector<std::uint8_t> download_model(std::uint8_t chamber);

  // ---- set points and capture ----

  /// Maps RPDO1..4. The node must not be fed set points meanwhile.
  void configure_setpoints(SetpointFormat format);
  /// One set point a chamber [Pa, absolute]; they take effect with the next SYNC. Throws
  /// std::invalid_argument for one that the board would refuse.
  void send_setpoints(std::span<const double, kChambers> setpoints_Pa);

  /// Maps TPDO4 to the supply where that is asked for, and TPDO5+c for the chambers asked for to c of a block of identifiers on which
  /// nobody streams, by which it listens for 40 ms; switches those of the others off. Throws ChannelTaken when others stream on every
  /// block, std::invalid_argument for a pause that is none.
  Stream configure_stream(const StreamConfig& config);
  void stop_stream();

 private:
  void tell(const Transfer& transfer) const {
    if (watcher_) watcher_(transfer);
  }
  /// `progress`, and the watcher beside it.
  TransferProgress told(std::uint16_t index, std::uint8_t sub, const TransferProgress& progress) const;
  void transmit(std::uint32_t id, std::span<const std::uint8_t> data);
  std::uint32_t read_bits(std::uint16_t index, std::uint8_t sub, std::size_t size);
  void write_bits(std::uint16_t index, std::uint8_t sub, std::uint32_t bits, std::size_t size);
  /// Writes 6040h and waits until these bits of 6041h are the wanted ones, or the time is over. What 6041h is then.
  std::uint16_t control(std::uint16_t control_word, std::uint16_t bits, std::uint16_t wanted);
  void require_own_sync();
  std::uint32_t free_stream_ids();
  void map_pdo(std::uint16_t communication, std::uint16_t mapping, std::uint32_t cob_id,
               std::uint8_t transmission_type, std::span<const std::uint32_t> objects);
  void map_each_tick(std::uint32_t tpdo, std::uint32_t cob_id, unsigned every_ticks,
                     std::span<const std::uint32_t> objects);
  void dispatch(const CanFrame& frame);

  Link& link_;
  std::uint8_t node_id_;
  SessionConfig config_;
  SdoClient sdo_;
  std::function<void(const Arrival&)> subscriber_;
  std::function<void(const Transfer&)> watcher_;
  SetpointFormat setpoint_format_ = SetpointFormat::millibar;
  std::uint32_t sync_id_ = canopen::cob::kSync;
  std::uint8_t sync_overflow_ = 0;  ///< 0: without a counter
  std::uint8_t sync_counter_ = 0;   ///< of the last one
};

/// A subscriber for as long as this lives.
class Subscription {
 public:
  Subscription(Session& session, std::function<void(const Arrival&)> subscriber) : session_(session) {
    session_.subscribe(std::move(subscriber));
  }
  ~Subscription() { session_.subscribe({}); }
  Subscription(const Subscription&) = delete;
  Subscription& operator=(const Subscription&) = delete;

 private:
  Session& session_;
};

}  // namespace plenum::host::client
