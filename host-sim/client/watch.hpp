// A board as a bystander on the bus sees it: what its default PDOs, its master's, its heartbeat and its emergencies
// carry. Sends nothing.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/stream.hpp"

namespace plenum::host::client {

/// Empty: not heard yet.
struct ChamberView {
  std::optional<double> setpoint_Pa;  ///< as the master sends it
  std::optional<double> actual_Pa;
  std::optional<double> command_V;  ///< of the stream alone, as the volume
  std::optional<double> volume_m3;
};

struct BoardView {
  double time_s = 0.0;  ///< of the link, when the newest frame of the board or to it came
  std::uint64_t frames = 0;
  std::optional<canopen::NmtState> nmt;
  std::optional<std::uint16_t> status_word;
  std::uint16_t error_code = 0;  ///< of the newest emergency; 0: gone, or never one
  unsigned fault_chamber = 0;    ///< from 1; 0: the whole board
  std::array<ChamberView, kChambers> chamber{};
};

class Watch {
 public:
  explicit Watch(std::uint8_t node_id) : node_id_(node_id) {}

  /// Frames of a stream are understood, too.
  void follow(const Stream& stream) { stream_ = stream; }
  void take(double time_s, const CanFrame& frame);
  const BoardView& view() const { return view_; }

 private:
  bool understand(const CanFrame& frame);
  void take_setpoints(std::size_t pdo, const CanFrame& frame);

  std::uint8_t node_id_;
  std::optional<Stream> stream_;
  bool pascal_ = false;  ///< the master sends set points as REAL32 (Session::configure_setpoints)
  BoardView view_;
};

}  // namespace plenum::host::client
