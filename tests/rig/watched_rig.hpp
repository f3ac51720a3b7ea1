// A rig whose every tick is written down, and the link of a client to it.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <vector>

#include "host-sim/client/link.hpp"
#include "host-sim/rig/standard_rigs.hpp"
#include "host-sim/tools/rig_link.hpp"

namespace plenum::host::rig {

/// The true state of one chamber at a tick, and what its board made of it.
struct Moment {
  double command_V = 0.0;  ///< at the valve, from this tick to the next
  double pressure_Pa = 0.0;
  double volume_m3 = 0.0;
  bool powered = false;
  plenum::canopen::ChamberImage image;
};

class WatchedRig final : public client::Link {
 public:
  explicit WatchedRig(const RigConfig& config) : rig(config), link_(rig) {}

  void send(const client::CanFrame& frame) override { link_.send(frame); }
  std::optional<client::CanFrame> receive(double timeout_s) override {
    // Strides shorter than a tick: none goes by unseen.
    constexpr double kStride_s = 0.001;
    for (const double end_s = now_s() + timeout_s;;) {
      const double left_s = end_s - now_s();
      const auto frame = link_.receive(left_s < kStride_s ? left_s : kStride_s);
      write_down();
      if (frame || left_s <= kStride_s) return frame;
    }
  }
  double now_s() const override { return link_.now_s(); }

  /// Lets the rig run, and forgets the frames that arrive.
  void wait(double duration_s) {
    const double end_s = now_s() + duration_s;
    while (receive(end_s - now_s())) {
    }
  }

  /// moments[tick][board][chamber], tick 0 at time 0.
  std::vector<std::vector<std::vector<Moment>>> moments;
  Rig rig;

 private:
  void write_down() {
    if (moments.size() == rig.ticks()) return;
    if (moments.size() + 1 != rig.ticks()) throw std::logic_error("a tick went by unseen");
    std::vector<std::vector<Moment>> boards;
    for (std::size_t b = 0; b < rig.boards(); ++b) {
      SimulatedBoard& board = rig.board(b);
      std::vector<Moment> chambers;
      for (std::size_t c = 0; c < board.chambers(); ++c) {
        chambers.push_back({board.analog_out().output_V(c), board.pressure_Pa(c), board.volume_m3(c),
                            board.digital().outputs().valve_power, board.controller().image().chamber[c]});
      }
      boards.push_back(std::move(chambers));
    }
    moments.push_back(std::move(boards));
  }

  tools::RigLink link_;
};

/// The rig's chambers as they were before anything ran: they can be run again, alone.
inline std::vector<plant::ChamberPlant> fresh_plants(const RigConfig& config, std::size_t board = 0) {
  std::vector<plant::ChamberPlant> plants;
  for (const ChamberConfig& chamber : config.board.at(board).chamber)
    plants.emplace_back(chamber.valve, chamber.chamber, chamber.volume);
  return plants;
}

/// What the noise of a converter's sample leaves in the mean over a tick, of a sensor [its unit].
inline double mean_noise(const BoardConfig& board, const SensorConfig& sensor) {
  return board.adc.sample_noise_V / std::sqrt(board.adc.samples_per_tick) * sensor.per_V;
}

}  // namespace plenum::host::rig
