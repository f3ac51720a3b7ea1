// A board as a bystander on the bus sees it: what its PDOs, its master's, its heartbeat and its emergencies carry. Sends nothing but
// what learn_mapping() asks. What is older than kStale_s is not shown as if it were of now.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/pdo_directory.hpp"
#include "host-sim/client/stream.hpp"

namespace plenum::host::client {

/// A heartbeat comes every second and the status word every half by default, values with each SYNC.
inline constexpr double kStale_s = 2.0;

/// Empty: not heard yet, or not lately.
struct ChamberView {
  std::optional<double> setpoint_Pa;  ///< as the master sends it
  std::optional<double> actual_Pa;
  std::optional<double> command_V;  ///< of the stream, or of a PDO that carries 2210h + c:3
  std::optional<double> volume_m3;  ///< likewise, 2150h + c:3
};

struct BoardView {
  std::uint64_t frames = 0;              ///< of the board or to it
  std::optional<double> silent_s;        ///< since the board's last frame, once that is kStale_s ago
  std::optional<canopen::NmtState> nmt;  ///< of the newest heartbeat; a boot-up is none
  std::optional<std::uint16_t> status_word;
  std::optional<std::uint16_t> error_code;  ///< of the newest emergency; 0: gone; empty: none was heard
  unsigned fault_chamber = 0;               ///< from 1; 0: the whole board
  std::array<ChamberView, kChambers> chamber{};
};

class Watch {
 public:
  explicit Watch(std::uint8_t node_id) : node_id_(node_id) {}

  /// Asks the board how its PDOs are mapped, of which else is known what passes on the bus. Throws as a read does (errors.hpp).
  void learn_mapping(Session& session) { pdos_.learn(session); }
  /// Frames of a stream are understood, too.
  void follow(const Stream& stream) { stream_ = stream; }
  /// What the board says of its fault when asked, whose emergency may be long past.
  void know(const Emergency& fault) { emergency_ = fault; }
  /// `time_s` of the link, as `now_s` below.
  void take(double time_s, const CanFrame& frame);
  std::uint64_t frames() const { return frames_; }
  BoardView view(double now_s) const;

 private:
  template <class T>
  struct Heard {
    std::optional<T> value;
    double time_s = 0.0;

    std::optional<T> at(double now_s) const { return now_s - time_s < kStale_s ? value : std::nullopt; }
  };
  struct Chamber {
    Heard<double> setpoint_Pa, actual_Pa, command_V, volume_m3;
  };

  bool understand(double time_s, const CanFrame& frame);
  bool take_pdo(double time_s, const Pdo& pdo);
  void take_value(double time_s, const PdoValue& value);

  std::uint8_t node_id_;
  std::optional<Stream> stream_;
  PdoDirectory pdos_;
  std::uint64_t frames_ = 0;
  std::optional<double> board_s_;  ///< when its newest frame came
  Heard<canopen::NmtState> nmt_;
  Heard<std::uint16_t> status_word_;
  std::optional<Emergency> emergency_;
  std::array<Chamber, kChambers> chamber_{};
};

}  // namespace plenum::host::client
