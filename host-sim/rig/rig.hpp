// Boards, their plants and a CAN bus in lockstep on a virtual clock, repeatable bit for bit from a seed.
//
// Time advances by events: the end of a frame on the bus, or a tick of the boards (every 10 ms, all boards
// together). A tick, at time t_k: each plant moves from t_(k-1) to t_k with the command held since t_(k-1);
// the converters read the mean over that tick; the board steps; its commands are held until t_(k+1). Frames
// reach a board at their end on the wire and are answered at once, as on the real board.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "firmware/board.hpp"
#include "host-sim/plant/chamber.hpp"
#include "host-sim/plant/converter.hpp"
#include "host-sim/ports/simulated_analog.hpp"
#include "host-sim/ports/simulated_bus.hpp"
#include "host-sim/ports/simulated_digital.hpp"
#include "host-sim/rig/effects_chamber.hpp"
#include "host-sim/rig/simulated_store.hpp"

namespace plenum::host::rig {

inline constexpr std::uint64_t kTick_ns = 10'000'000;
inline constexpr double kTick_s = 0.01;

/// A sensor: volts = (quantity - at_zero_V) / per_V, white noise on each of the converter's samples.
struct SensorConfig {
  double at_zero_V = 0.0;  ///< the quantity at 0 V
  double per_V = 1.0;      ///< the quantity of one volt
};

struct ChamberConfig {
  plant::Valve valve;
  plant::ChamberConfig chamber;
  plant::VolumeMotion volume;
  SensorConfig pressure_Pa{.at_zero_V = 0.0, .per_V = 100'000.0};
  SensorConfig volume_m3;
  double unpowered_V =
      5.0;  ///< the command that a valve without power amounts to: its springs centre the spool
  std::optional<effects::ChamberEffects> effects =
      {};  ///< set: an EffectsChamber takes the place of the plant
};

struct BoardConfig {
  plenum::Settings settings;
  std::vector<ChamberConfig> chamber;  ///< 1 to config::kChambers; channels beyond are not in use
  SensorConfig supply_Pa{.at_zero_V = 0.0, .per_V = 100'000.0};
  /// 20 kHz samples, averaged by 200 a tick; the noise is that of one sample at the converter's input.
  plant::AdcConfig adc{
      .low_V = -10.0, .high_V = 10.0, .bits = 16, .sample_noise_V = 0.005, .samples_per_tick = 200};
  int dac_bits = 16;
  std::optional<std::filesystem::path> store;  ///< folder that keeps the models; none: they live in memory
};

struct RigConfig {
  std::vector<BoardConfig> board;
  ports::SimulatedBus::Config bus;
  std::uint64_t seed = 1;
};

/// One board with its drivers and plants.
class SimulatedBoard {
 public:
  /// Throws std::invalid_argument (what, value, range) for settings or a plant that cannot be.
  SimulatedBoard(const BoardConfig& config, ports::SimulatedCanPort& can, const plant::Random& random);

  const Controller& controller() const { return board_.controller(); }
  /// What LSS has stored.
  const plenum::config::LssSettings& lss() const { return board_.lss(); }
  std::size_t chambers() const { return chamber_.size(); }
  /// The true state of a chamber, whichever simulates it.
  double pressure_Pa(std::size_t chamber) const;
  double volume_m3(std::size_t chamber) const;

  // fault injection, and the world that the plants live in
  /// Throws std::invalid_argument for a chamber with effects, which is no plant.
  plant::ChamberPlant& plant(std::size_t chamber);
  ports::SimulatedAnalogInput& analog_in() { return analog_in_; }
  ports::SimulatedAnalogOutput& analog_out() { return analog_out_; }
  ports::SimulatedDigitalIo& digital() { return digital_; }
  ports::SimulatedCanPort& can() { return can_; }
  /// The next tick begins after its deadline.
  void delay_next_tick() { late_ = true; }

  void handle_frames() { board_.handle_frames(); }
  void tick();

 private:
  void move_plants();

  BoardConfig config_;
  ports::SimulatedCanPort& can_;
  ports::SimulatedAnalogInput analog_in_;
  ports::SimulatedAnalogOutput analog_out_;
  ports::SimulatedDigitalIo digital_;
  SimulatedStore store_;
  std::vector<std::variant<plant::ChamberPlant, EffectsChamber>> chamber_;
  plenum::Board board_;
  bool started_ = false;
  bool late_ = false;
};

class Rig {
 public:
  /// Throws std::invalid_argument as SimulatedBoard, for two boards with one node id, and for a board that LSS has told
  /// another bit rate than the bus has. Whatever the settings say, the boards can run the rate of the bus only.
  explicit Rig(const RigConfig& config);

  std::size_t boards() const { return board_.size(); }
  SimulatedBoard& board(std::size_t i) { return *board_.at(i); }
  ports::SimulatedBus& bus() { return bus_; }
  /// A further node on the bus, for a master.
  ports::SimulatedCanPort& attach(const std::string& name) { return bus_.attach(name); }

  double now_s() const { return bus_.now_s(); }
  std::uint64_t now_ns() const { return bus_.now_ns(); }
  std::uint64_t ticks() const { return ticks_; }

  /// Runs to the next event (a frame delivered, a tick), or to `until_ns` when none comes before.
  void advance(std::uint64_t until_ns);
  /// Runs everything up to and with `until_ns`.
  void run_until(std::uint64_t until_ns);

 private:
  ports::SimulatedBus bus_;
  std::vector<std::unique_ptr<SimulatedBoard>> board_;
  std::uint64_t ticks_ = 0;  ///< done; the next one is at ticks_ * kTick_ns
};

}  // namespace plenum::host::rig
