#include "host-sim/rig/rig.hpp"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string>

namespace plenum::host::rig {
namespace {

using plenum::config::kChambers;

/// Settings as the installer gave them, with the channels that have no chamber taken out of use.
plenum::Settings checked_settings(const BoardConfig& config) {
  if (config.chamber.empty() || config.chamber.size() > kChambers) {
    throw std::invalid_argument("a board has 1 to " + std::to_string(kChambers) + " chambers, not " +
                                std::to_string(config.chamber.size()));
  }
  const auto require = [](const plenum::config::SettingVerdict& verdict, const std::string& where) {
    if (verdict) return;
    throw std::invalid_argument(where + ": " + verdict.field + " = " + std::to_string(verdict.value) +
                                ", expected " + std::to_string(verdict.low) + " to " +
                                std::to_string(verdict.high));
  };
  plenum::Settings settings = config.settings;
  require(plenum::config::validate(settings.board), "board settings");
  for (std::size_t c = 0; c < kChambers; ++c) {
    settings.chamber[c].in_use = c < config.chamber.size();
    require(plenum::config::validate(settings.chamber[c]), "settings of chamber " + std::to_string(c + 1));
  }
  return settings;
}

// One tick with the command held; what the sensor reads of it, and what it reads at rest.
double advance(plant::ChamberPlant& plant, double command_V) {
  return plant.advance(command_V, kTick_s).mean_Pa;
}
double advance(EffectsChamber& chamber, double command_V) {
  return chamber.advance(command_V);
}
double resting_reading_Pa(const plant::ChamberPlant& plant) {
  return plant.pressure_Pa();
}
double resting_reading_Pa(const EffectsChamber& chamber) {
  return chamber.resting_reading_Pa();
}

/// The bit rate of the bus as canopen::Config has it; none when CiA 305 does not know it.
std::uint16_t row_of(std::uint32_t bit_rate) {
  const auto row = canopen::row_of_bit_rate(bit_rate);
  return row ? static_cast<std::uint16_t>(1U << *row) : std::uint16_t{0};
}

double volts(const SensorConfig& sensor, double quantity) {
  return (quantity - sensor.at_zero_V) / sensor.per_V;
}

}  // namespace

SimulatedBoard::SimulatedBoard(const BoardConfig& config, ports::SimulatedCanPort& can,
                               const plant::Random& random)
    : config_(config),
      can_(can),
      analog_in_(config.adc, plenum::kAnalogInputs, random),
      analog_out_(kChambers, config.dac_bits),
      store_(config.store),
      board_(checked_settings(config), {analog_in_, analog_out_, digital_, can, store_}) {
  for (const ChamberConfig& chamber : config.chamber) {
    if (chamber.effects) {
      chamber_.emplace_back(std::in_place_type<EffectsChamber>, chamber.valve, chamber.chamber,
                            chamber.volume, *chamber.effects, kTick_s);
    } else {
      chamber_.emplace_back(std::in_place_type<plant::ChamberPlant>, chamber.valve, chamber.chamber,
                            chamber.volume);
    }
  }
  board_.start();
}

double SimulatedBoard::pressure_Pa(std::size_t chamber) const {
  return std::visit([](const auto& any) { return any.pressure_Pa(); }, chamber_.at(chamber));
}

double SimulatedBoard::volume_m3(std::size_t chamber) const {
  return std::visit([](const auto& any) { return any.volume().volume_m3; }, chamber_.at(chamber));
}

plant::ChamberPlant& SimulatedBoard::plant(std::size_t chamber) {
  auto* plant = std::get_if<plant::ChamberPlant>(&chamber_.at(chamber));
  if (plant == nullptr) {
    throw std::invalid_argument("chamber " + std::to_string(chamber + 1) + " has effects: it is no plant");
  }
  return *plant;
}

void SimulatedBoard::move_plants() {
  const bool powered = digital_.outputs().valve_power;
  for (std::size_t c = 0; c < chamber_.size(); ++c) {
    const ChamberConfig& config = config_.chamber[c];
    const auto move = [&](auto& chamber) {
      double mean_Pa = resting_reading_Pa(chamber);
      const plant::VolumeState start = chamber.volume();
      double mean_m3 = start.volume_m3;
      if (started_) {
        const std::optional<double> valve_V = analog_out_.valve_V(c);
        mean_Pa = advance(chamber, powered && valve_V ? *valve_V : config.unpowered_V);
        const plant::VolumeState end = chamber.volume();
        // The mean over the tick of the cubic through both ends and slopes: at 4 Hz exact to 1e-5 of the
        // amplitude.
        mean_m3 =
            0.5 * (start.volume_m3 + end.volume_m3) + kTick_s / 12.0 * (start.rate_m3_s - end.rate_m3_s);
      }
      analog_in_.set_mean_V(c, volts(config.pressure_Pa, mean_Pa));
      analog_in_.set_mean_V(kChambers + c, volts(config.volume_m3, mean_m3));
    };
    std::visit(move, chamber_[c]);
  }
  const double supply_Pa =
      std::visit([](const auto& chamber) { return chamber.supply_Pa(); }, chamber_.front());
  analog_in_.set_mean_V(2 * kChambers, volts(config_.supply_Pa, supply_Pa));
  started_ = true;
}

void SimulatedBoard::tick() {
  move_plants();
  board_.handle_frames();
  board_.tick({.overrun = late_ ? Overrun::fault : Overrun::none,
               .latency_us = late_ ? plenum::config::kTick_us : 0});
  late_ = false;
  board_.store_changed();
}

Rig::Rig(const RigConfig& config) : bus_(config.bus) {
  const plant::Random random(config.seed);
  std::set<int> node_ids;
  for (BoardConfig board : config.board) {
    board.settings.node.bit_rates = row_of(config.bus.bit_rate);
    const int id = board.settings.node.node_id;
    if (!node_ids.insert(id).second) {
      throw std::invalid_argument("two boards with node id " + std::to_string(id) + " on one bus");
    }
    const std::size_t number = board_.size();
    board_.push_back(std::make_unique<SimulatedBoard>(
        board, bus_.attach("board " + std::to_string(number + 1)), random.split(number)));
    const std::uint32_t stored = 1000U * board_.back()->lss().bit_rate_kbit;
    if (stored != 0 && stored != config.bus.bit_rate) {
      throw std::invalid_argument("board " + std::to_string(number + 1) + " was told by LSS to run at " +
                                  std::to_string(stored) + " bit/s and would hear nothing, expected the " +
                                  std::to_string(config.bus.bit_rate) + " bit/s of its bus");
    }
  }
}

void Rig::advance(std::uint64_t until_ns) {
  const std::uint64_t tick_ns = ticks_ * kTick_ns;
  if (bus_.run_to_next_delivery(std::min(until_ns, tick_ns))) {
    for (const auto& board : board_) board->handle_frames();
  } else if (tick_ns <= until_ns) {
    for (const auto& board : board_) board->tick();
    ++ticks_;
  }
}

void Rig::run_until(std::uint64_t until_ns) {
  while (bus_.now_ns() < until_ns || ticks_ * kTick_ns <= until_ns) advance(until_ns);
}

}  // namespace plenum::host::rig
