// A CiA 301 node: frames in, frames out, and the process image between it and the controller.
//
// Once a tick the board does, in this order: receive() every frame that has come, run the controller, tick(),
// and send what next_frame() yields. No heap, no clock: time is what tick() is told.
#pragma once

#include <cstdint>

#include "firmware/canopen/cia301.hpp"
#include "firmware/canopen/communication.hpp"
#include "firmware/canopen/eds.hpp"
#include "firmware/canopen/error_reports.hpp"
#include "firmware/canopen/kept_values.hpp"
#include "firmware/canopen/lss.hpp"
#include "firmware/canopen/object_dictionary.hpp"
#include "firmware/canopen/sdo_server.hpp"
#include "firmware/canopen/transmit_queue.hpp"

namespace plenum::canopen {

/// What has happened within the last ten seconds: frames that do not fit come in rows, and are told once.
class Lately {
 public:
  void happens() noexcept { left_us_ = 10'000'000; }
  /// Time passes. Returns whether it has happened lately.
  bool elapse(std::uint32_t elapsed_us) noexcept {
    const bool lately = left_us_ > 0;
    left_us_ -= left_us_ < elapsed_us ? left_us_ : elapsed_us;
    return lately;
  }

 private:
  std::uint32_t left_us_ = 0;
};

class Node {
 public:
  /// Queues the boot-up message; the node is then pre-operational. Without a node id it is silent and waits for
  /// LSS. `image`, `desk` and `recorder` must outlive it.
  Node(const Config& config, ProcessImage& image, config::ModelDesk& desk, config::SettingsDesk& settings,
       telemetry::Recorder& recorder) noexcept;

  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// Before the first tick: what would take long in one (about a millisecond: the size of the data sheet).
  void prepare() noexcept { sheet_.size(); }

  /// Takes one frame, at any time between ticks. Bounded work: an SDO request finds its
  /// object by halving the table. A frame that is foreign, malformed, remote, extended or carries a refused value changes
  /// nothing but a counter. A reset is noted here and worked off by tick(), however many have come; until its boot-up message
  /// the node hears nothing else but that LSS goes back to waiting.
  void receive(const ports::CanFrame& frame) noexcept;

  /// `elapsed_us` has passed: reset, watchdog, emergency, heartbeat, TPDOs, SDO time-out. A reset of the node takes 6040h back as it
  /// comes, and brings stored values back once 6041h says INIT or FAULT_INIT: settings do not change under a regulation. A
  /// reset takes as many ticks as what is stored asks for, each of bounded work, and ends with the boot-up message.
  void tick(std::uint32_t elapsed_us) noexcept;

  /// Takes the next frame to send. Returns false when there is none. Segments of a block upload are made here, one at a
  /// time and only when nothing else waits.
  bool next_frame(ports::CanFrame& frame) noexcept;

  /// It is a TPDO of this node.
  bool is_tpdo(const ports::CanFrame& frame) const noexcept;

  /// What the bus wants of the parameter store: for its owner, between two ticks.
  StoreOrder& order() noexcept { return device_.order; }

  /// The stored rows, which take effect with each reset, and the node id they were saved at; the bytes stay where they
  /// are until the next call.
  void keep(std::span<const std::uint8_t> rows, std::uint8_t saved_id) noexcept;
  /// Begins anew, with the boot-up message, the stored rows in force, and `node_id` where it is 1..127.
  Restored restart(std::uint8_t node_id) noexcept;
  /// Adds the values in force of `group`.
  void collect(Kept group, config::RowWriter& rows) const noexcept { collect_kept(device_, group, rows); }
  /// A reset is asked for, or under way: what collect() would find is half of one set and half of another.
  bool is_resetting() const noexcept { return reset_ != Reset::none; }
  std::uint8_t node_id() const noexcept { return config_.node_id; }
  /// No bit has flipped in what says where orders come from and go to: the parameters of the RPDOs. A reset of the communication
  /// makes them anew.
  bool intact() const noexcept {
    for (const Rpdo& rpdo : device_.communication.rpdo) {
      if (!rpdo.intact()) return false;
    }
    return true;
  }

  NmtState state() const noexcept { return state_; }
  const Counters& counters() const noexcept { return device_.counters; }
  /// As objects 1005h to 1A0Bh show them, and what the PDOs are doing.
  const Communication& communication() const noexcept { return device_.communication; }

 private:
  enum class Reset : std::uint8_t { none, communication, node };
  /// What is to be done next in a reset; one of the communication has the first and the last two.
  enum class Step : std::uint8_t { begin, application, settings, communication_defaults, communication };

  void receive_nmt(const ports::CanFrame& frame) noexcept;
  void receive_heartbeat(const ports::CanFrame& frame) noexcept;
  void receive_sync(const ports::CanFrame& frame) noexcept;
  void receive_lss(const ports::CanFrame& frame) noexcept;
  void receive_sdo(const ports::CanFrame& frame) noexcept;
  void receive_pdo(Rpdo& rpdo, const ports::CanFrame& frame) noexcept;
  void apply(Rpdo& rpdo) noexcept;
  bool streams_setpoints() const noexcept;
  void enter(NmtState state) noexcept;
  void ask_for(Reset reset) noexcept;
  void work_off_reset() noexcept;
  void begin_reset() noexcept;
  void go_on(Work& work) noexcept;
  void forget_process() noexcept;
  void take_restored(std::size_t owner) noexcept;
  void end_watches() noexcept;
  void begin_communication() noexcept;
  void boot_up() noexcept;
  void forget_old_orders(std::uint32_t elapsed_us) noexcept;
  void watch_setpoints(std::uint32_t elapsed_us) noexcept;
  void watch_heartbeats(std::uint32_t elapsed_us) noexcept;
  void obey_error_behaviour() noexcept;
  void obey(ErrorBehaviour behaviour) noexcept;
  void forget_unsent_tpdos() noexcept;
  void beat(std::uint32_t elapsed_us) noexcept;
  void transmit_pdo(std::size_t number, std::uint32_t elapsed_us) noexcept;
  void send(std::uint32_t id, const SdoServer::Bytes& bytes) noexcept;

  Config config_;
  DataSheet sheet_;
  Device device_;
  SdoServer sdo_;
  LssSlave lss_;
  TransmitQueue queue_;
  std::span<const std::uint8_t> kept_;
  std::uint8_t saved_id_ = 0;
  NmtState state_ = NmtState::initialising;
  Reset reset_ = Reset::none;  ///< asked for and not worked off yet
  Step step_ = Step::begin;    ///< of reset_
  std::size_t owner_ = 0;      ///< in Step::settings, whose come next
  KeptRestoration restoration_;
  Restored restored_;  ///< of the last reset
  /// Watches that a reset has ended since the last tick, while the machine was regulated.
  bool setpoint_watch_ended_ = false;
  bool heartbeat_watch_ended_ = false;
  bool communication_failed_ = false;  ///< as of the last tick: bus-off, or a heartbeat lost
  bool device_failed_ = false;         ///< likewise: a fault to which the board reacts
  std::uint32_t since_heartbeat_us_ = 0;
  Lately pdo_short_, pdo_long_, sync_misfits_;
  ErrorReports errors_;
};

}  // namespace plenum::canopen
