// Chambers behind the measured MPYE tables, moving as violently as the population's: for what is measured on both.
//
// Channel A for odd seeds, B for even ones; 400 to 1100 mL, a size to the flow as the population's, doubling at 0.4 to 1.6 Hz; the
// population's controller, 0 to 10 V. What a rig file would tell of them is the default of trace::RigDescription.
#pragma once

#include <cstddef>
#include <numbers>
#include <random>

#include "host-sim/plant/chamber.hpp"
#include "host-sim/reproduce/actuators/population.hpp"
#include "host-sim/trace/log.hpp"

namespace plenum::bench {

inline constexpr std::size_t kMpyeChambers = 12;  ///< their seeds are 1 to 12

inline host::trace::Log record_mpye(unsigned seed, std::size_t rows) {
  using namespace plenum::host;
  std::mt19937_64 random(seed);
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const double mean_m3 = draw(400e-6, 1100e-6);
  const double share = draw(0.31, 0.355);
  const double frequency_Hz = draw(0.4, 1.6);
  const plant::VolumeSine sine{share * mean_m3, frequency_Hz, draw(0.0, 2.0 * std::numbers::pi)};
  plant::ChamberConfig config;
  config.gas = plant::reference_atmosphere();
  config.initial_pressure_Pa = 200e3;
  const auto channel = seed % 2 == 1 ? plant::MpyeChannel::a : plant::MpyeChannel::b_mirrored;
  plant::ChamberPlant chamber(plant::MpyeValve(channel, config.gas), config,
                              plant::VolumeMotion(mean_m3, {sine}));
  return reproduce::actuators::record_under_pid(random, chamber, 0.0, 10.0, rows);
}

}  // namespace plenum::bench
