// Random admissible grey-box models, and what a chamber that has one does.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "firmware/config/greybox_parameters.hpp"
#include "firmware/control/pressure_model.hpp"

namespace plenum::control::testing {

using GreyboxSet = std::array<float, config::kGreyboxParameters>;

struct GreyboxCase {
  GreyboxSet set;
  ChamberMotion motion;
  float pressure_kPa;
};

/// Valves from drops to litres a second that open at a corner or over a volt, chambers of 5 mL to 1 L that double or halve at up to 1.6 Hz.
template <class Random>
GreyboxCase random_case(Random& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto between = [&](double low, double high) { return low + (high - low) * unit(random); };
  const auto log_between = [&](double low, double high) { return low * std::pow(high / low, unit(random)); };
  const double gain = log_between(1.0, 1000.0);
  const double null = between(3.0, 7.0);
  const double overlap = between(-0.3, 0.3);
  const double supply = between(300.0, 1000.0);
  const double ambient = between(80.0, 105.0);
  const double volume = log_between(5.0, 1000.0);
  GreyboxCase made{};
  const auto put = [&made](config::GreyboxParameter which, double value) {
    made.set[which] = static_cast<float>(value);
  };
  put(config::kOpenAbove, null + overlap);
  put(config::kExhaustBelow, null - overlap);
  put(config::kInletConductance, gain);
  put(config::kExhaustConductance, gain * between(0.7, 1.4));
  put(config::kInletLeak, gain * log_between(1e-4, 0.1));
  put(config::kExhaustLeak, gain * log_between(1e-4, 0.1));
  put(config::kTransition, std::max(1e-4, gain * log_between(1e-7, 0.5)));
  for (const config::GreyboxParameter slope : {config::kInletSlope, config::kExhaustSlope}) {
    const double q = between(-0.5, 2.0);
    put(slope, q);
    put(static_cast<config::GreyboxParameter>(slope + 1), between(-0.3, 0.3));
    put(static_cast<config::GreyboxParameter>(slope + 2), between(-0.1, 0.2));
  }
  put(config::kCriticalRatio, between(0.1, 0.6));
  put(config::kSubsonicIndex, between(0.4, 1.0));
  put(config::kCrackingRatio, between(0.9, 1.0));
  put(config::kDischargeSlope, between(-0.3, 0.3));
  put(config::kDeadVolume, between(0.0, 20.0));
  put(config::kVolumeExponent, between(1.0, 1.4));
  put(config::kChamberLeak, gain * between(0.0, 0.02));
  put(config::kSpoolDamping, 0.7);  // without a spool period it is not used, but has a range
  put(config::kSupply, supply);
  put(config::kAmbient, ambient);
  made.motion.volume_mL = static_cast<float>(volume);
  made.motion.volume_rate_mL_s = static_cast<float>(between(-1.0, 1.0) * 5.0 * volume);
  made.pressure_kPa = static_cast<float>(between(ambient, supply));
  return made;
}

}  // namespace plenum::control::testing
