// Valve-chambers drawn from one fixed population, recorded through host-sim/plant: the paper's 76 valve-
// chambers with numbers that it does not print. The benchmarks use the same.
//
// Supply 620 kPa; area per volt 0.8-2.2 mm2 (C = 0.72), leaks 0.05-0.2 mm2, transition 0.1-0.4 mm2,
// null 4.85-5.15 V, ports 0.05-0.25 V apart; volume 40-300 mL, at rest, moving by 20-40 % at 0.1-1.5 Hz, or
// violently: by 31-35.5 % at 0.4-1.6 Hz, so that its largest is 1.9 to 2.1 times its smallest;
// command 3-7 V from a PID on random pressure targets; noise of 0.1 % of span on each of the 200 samples
// averaged a tick.
// Source: "Modeling and Identification of Pneumatic Actuators", V and V.C: 90 psi, 3-7 V, 100 Hz, 200 samples
// a tick, 100 s of violent movement under a PID. The rest is ours.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>

#include "host-sim/plant/chamber.hpp"
#include "host-sim/trace/log.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::reproduce::actuators {

inline constexpr double kPopulationSupply_Pa = 620e3;  ///< "P_c ~ 620 KPa ~ 90 psi", Fig. 3
inline constexpr std::size_t kPopulation = 76;         ///< valve-chambers; their seeds are 1 to 76

inline trace::RigDescription population_rig() {
  trace::RigDescription rig;
  rig.supply.pressure_Pa = kPopulationSupply_Pa;
  return rig;
}

/// One valve-chamber, as it is.
struct PopulationChamber {
  plant::ThinPlateValveConfig valve;
  plant::VolumeMotion volume;
};

/// How the volume moves. The valve and the mean volume of a seed are the same for each.
enum class Motion { rest, moderate, violent };

inline PopulationChamber draw_chamber(std::mt19937_64& random, Motion motion) {
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const double area_per_V_m2 = draw(0.8e-6, 2.2e-6);
  const double null_V = draw(4.85, 5.15);
  const double apart_V = draw(0.05, 0.25);
  plant::ThinPlateValveConfig valve;
  valve.inlet_area_per_V_m2 = valve.exhaust_area_per_V_m2 = area_per_V_m2;
  valve.open_above_V = null_V + 0.5 * apart_V;
  valve.exhaust_below_V = null_V - 0.5 * apart_V;
  valve.inlet_leak_m2 = draw(0.05e-6, 0.2e-6);
  valve.exhaust_leak_m2 = draw(0.05e-6, 0.2e-6);
  valve.transition_m2 = draw(0.1e-6, 0.4e-6);

  const double mean_m3 = draw(40e-6, 300e-6);
  const bool violent = motion == Motion::violent;
  const double share = violent ? draw(0.31, 0.355) : draw(0.2, 0.4);
  const double frequency_Hz = violent ? draw(0.4, 1.6) : draw(0.1, 1.5);
  const plant::VolumeSine sine{share * mean_m3, frequency_Hz, draw(0.0, 2.0 * std::numbers::pi)};
  return {valve,
          motion == Motion::rest ? plant::VolumeMotion(mean_m3) : plant::VolumeMotion(mean_m3, {sine})};
}

/// The truth behind record_chamber(seed, motion).
inline PopulationChamber chamber_of_seed(unsigned seed, Motion motion) {
  std::mt19937_64 random(seed);
  return draw_chamber(random, motion);
}

/// What a PID makes of random pressure targets on a chamber, as the board logs it.
inline trace::Log record_under_pid(std::mt19937_64& random, plant::ChamberPlant& chamber, double low_V,
                                   double high_V, std::size_t rows) {
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  std::normal_distribution<double> normal;
  constexpr double kTick_s = 0.01;
  const double noise_Pa = 1e-3 * (chamber.supply_Pa() - chamber.ambient_Pa()) / std::sqrt(200.0);
  trace::Log log;
  log.period_s = log.pressure_average_s = kTick_s;
  double measured_Pa = chamber.pressure_Pa();
  double target_Pa = 300e3, integral_V = 0.0, last_error_bar = 0.0;
  for (std::size_t k = 0; k < rows; ++k) {
    if (k % 25 == 0 && draw(0.0, 1.0) < 0.6) target_Pa = draw(130e3, 600e3);
    const double error_bar = 1e-5 * (target_Pa - measured_Pa);
    integral_V = std::clamp(integral_V + 0.02 * error_bar, -0.5, 0.5);
    const double command_V = std::clamp(
        5.0 + 1.2 * error_bar + integral_V + 0.3 * (error_bar - last_error_bar) + 0.1 * normal(random), low_V,
        high_V);
    last_error_bar = error_bar;
    log.time_s.push_back(kTick_s * static_cast<double>(k));
    log.command_V.push_back(command_V);
    log.pressure_Pa.push_back(measured_Pa);
    log.volume_m3.push_back(chamber.volume_m3());
    measured_Pa = chamber.advance(command_V, kTick_s).mean_Pa + noise_Pa * normal(random);
  }
  return log;
}

inline trace::Log record_chamber(unsigned seed, Motion motion, std::size_t rows = 10000) {
  std::mt19937_64 random(seed);
  const PopulationChamber drawn = draw_chamber(random, motion);
  plant::ChamberConfig config;
  config.supply_Pa = kPopulationSupply_Pa;
  config.initial_pressure_Pa = 200e3;
  plant::ChamberPlant chamber(plant::ThinPlateValve(drawn.valve), config, drawn.volume);
  return record_under_pid(random, chamber, 3.0, 7.0, rows);
}

}  // namespace plenum::host::reproduce::actuators
