// The client's side of SDO: expedited, segmented and block transfers with one server (CiA 301, 7.2.4.3).
//
// Whatever a link does to frames (loses, doubles, delays them), a transfer ends with the right bytes or with an error,
// within the time-outs of its answers. Lost segments of a block are sent again; where a CRC watches over it, a block
// that falls silent in the middle is asked for again, once. After an error the server is told by an abort.
//
// Another master on the same channel is heard (foreign_transfer.hpp). A transfer begins when none of its is under way; one into which
// it spoke all the same is begun again after a random pause, until it has gone through undisturbed or is given up.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "firmware/canopen/cia301.hpp"
#include "host-sim/client/errors.hpp"
#include "host-sim/client/foreign_transfer.hpp"
#include "host-sim/client/link.hpp"

namespace plenum::host::client {

/// How far a transfer is [bytes]; no total when the server does not know it.
using TransferProgress = std::function<void(std::size_t done, std::optional<std::size_t> total)>;

/// CRC of block transfers: polynomial 1021h, initial value 0 (CiA 301, 7.2.4.3.16). 31C3h for "123456789".
std::uint16_t crc16(std::span<const std::uint8_t> bytes);

struct SdoConfig {
  double timeout_s = 0.5;  ///< for each answer, and for each segment of a block
  /// For the answer to a block sent: a server that has missed its last segment speaks only after a while of its own.
  double block_timeout_s = 1.5;
  std::size_t block_from_bytes = 28;  ///< from here on blocks take fewer frames than segments
  std::uint8_t block_size = 127;      ///< segments a block that this client asks for; 1..127
  std::size_t largest_bytes = std::size_t{64} << 20U;  ///< a value that goes on beyond this is given up
  double taken_timeout_s = 10.0;  ///< how long to wait for the channel while another master has it
  /// How long to listen before the first request: on a bus that others may use, who joins it may come into a transfer.
  double listen_first_s = 0.0;
  /// How long to listen for the heartbeat of a server that gave no answer: it may say why.
  double heartbeat_wait_s = 0.0;
  std::uint32_t seed = 0;  ///< of the pauses after a disturbance; 0: of this machine's random numbers
};

class SdoClient {
 public:
  using Bytes = std::array<std::uint8_t, 8>;

  /// `heard` gets every frame that is none of the server's answers. The link must outlive the client.
  SdoClient(Link& link, std::uint8_t node_id, const SdoConfig& config,
            std::function<void(const CanFrame&)> heard);

  /// A frame that the link's owner took himself.
  void observe(const CanFrame& frame);

  /// Expedited or segmented, as the server has it. Throws SdoAbort, Timeout, ProtocolError, ChannelTaken, as all of them.
  std::vector<std::uint8_t> read(std::uint16_t index, std::uint8_t sub);
  /// By blocks; in segments from a server that knows no blocks, and for values too short for them.
  std::vector<std::uint8_t> read_domain(std::uint16_t index, std::uint8_t sub,
                                        const TransferProgress& progress = {});
  /// Expedited up to four bytes, by blocks from `block_from_bytes` on where the server knows them, else in segments.
  void write(std::uint16_t index, std::uint8_t sub, std::span<const std::uint8_t> bytes,
             const TransferProgress& progress = {});

 private:
  /// The transfer under way, for messages and aborts.
  struct Object {
    std::uint16_t index;
    std::uint8_t sub;
    const char* doing;
  };

  void send(const Bytes& data);
  /// The server's next frame that belongs to `object`; empty after `timeout_s`. Throws SdoAbort for its abort.
  std::optional<Bytes> next(const Object& object, bool initiate, double timeout_s);
  Bytes exchange(const Object& object, const Bytes& request, bool initiate);
  [[noreturn]] void fail(const Object& object, canopen::Abort abort, const std::string& found);
  [[noreturn]] void time_out(const Object& object, double timeout_s);
  /// What the server's heartbeat says of its silence since `since_s`: a clause, or nothing.
  std::string silence_text(double since_s);
  void abort(const Object& object, canopen::Abort abort);

  // another master: sdo_sharing.cpp
  enum class Outcome : std::uint8_t { read, written, aborted, failed };
  /// What it said while a transfer of ours was under way.
  struct Disturbance {
    bool heard = false;
    bool downloads = false;      ///< it began one that is not expedited
    bool of_our_object = false;  ///< so that its answer could be taken for ours
  };
  /// Runs `transfer`, and again when another master came between.
  void share(const Object& object, Outcome wanted, const std::function<void()>& transfer);
  bool is_spoilt(Outcome outcome) const;
  void await_channel(const Object& object);
  void pause(double shortest_s, double longest_s);
  void listen(double duration_s);
  void hear(const CanFrame& frame);
  [[noreturn]] void give_up(const Object& object, const std::string& what) const;

  std::vector<std::uint8_t> read_long(const Object& object, const TransferProgress& progress);
  void write_any(const Object& object, std::span<const std::uint8_t> bytes, const TransferProgress& progress);
  std::vector<std::uint8_t> read_answered(const Object& object, const Bytes& first);
  void write_segments(const Object& object, std::span<const std::uint8_t> bytes,
                      const TransferProgress& progress);

  // blocks: sdo_blocks.cpp
  class BlockReader;
  std::vector<std::uint8_t> read_blocks(const Object& object, const Bytes& first,
                                        const TransferProgress& progress);
  /// False when the server knows no block transfer.
  bool write_blocks(const Object& object, std::span<const std::uint8_t> bytes,
                    const TransferProgress& progress);
  void send_block(const Object& object, std::span<const std::uint8_t> bytes, std::size_t segments);
  Bytes await_block_answer(const Object& object, std::uint8_t subcommand);

  Link& link_;
  std::uint8_t node_id_;
  SdoConfig config_;
  std::function<void(const CanFrame&)> heard_;
  /// The server's newest heartbeat.
  struct Beat {
    canopen::NmtState state;
    double time_s;
  };
  std::optional<Beat> beat_;
  bool beat_missed_ = false;         ///< it was waited for and did not come: it is not waited for again
  bool server_knows_blocks_ = true;  ///< until it says otherwise

  ForeignTransfer foreign_;
  std::minstd_rand random_;
  std::optional<Object> under_way_;  ///< our transfer
  int answers_ = 0;                  ///< to it, so far
  Disturbance disturbance_;          ///< of it
  bool listened_ = false;            ///< the first request may be sent
};

}  // namespace plenum::host::client
