// The regulator on a chamber whose supply is not what its model states: it droops, or another machine draws from it. The chamber
// is (1)-(4) of "Modeling and Identification of Pneumatic Actuators" with a vessel behind a resistance, in double at 0.1 ms.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "firmware/control/greybox.hpp"
#include "firmware/control/regulator.hpp"
#include "tests/firmware/scalars.hpp"

namespace plenum::control {
namespace {

constexpr double kSupply_kPa = 700, kAmbient_kPa = 101.325, kVolume_mL = 100, kGain_mL_s_V = 150,
                 kExponent = 1.4;
constexpr double kOpenAbove_V = 5.05, kExhaustBelow_V = 4.95;

Greybox model() {
  std::array<float, Greybox::kParameters> set{};
  set[Greybox::kOpenAbove] = static_cast<float>(kOpenAbove_V);
  set[Greybox::kExhaustBelow] = static_cast<float>(kExhaustBelow_V);
  set[Greybox::kInletConductance] = set[Greybox::kExhaustConductance] = static_cast<float>(kGain_mL_s_V);
  set[Greybox::kInletLeak] = set[Greybox::kExhaustLeak] = 1e-3F;
  set[Greybox::kTransition] = 0.01F;
  set[Greybox::kCriticalRatio] = 0.5282818F;
  set[Greybox::kSubsonicIndex] = 0.5F;
  set[Greybox::kCrackingRatio] = 1.0F;
  set[Greybox::kVolumeExponent] = static_cast<float>(kExponent);
  set[Greybox::kSupply] = static_cast<float>(kSupply_kPa);
  set[Greybox::kAmbient] = static_cast<float>(kAmbient_kPa);
  Greybox made;
  made.configure(scalars(set), 0, 10);
  return made;
}

double thin_plate_kPa(double from_kPa, double to_kPa) {
  if (from_kPa < to_kPa) return -thin_plate_kPa(to_kPa, from_kPa);
  constexpr double kCritical = 0.5282818;
  const double ratio = std::max(to_kPa / from_kPa, kCritical);
  const auto difference = [](double r) { return std::pow(r, 2 / 1.4) - std::pow(r, 2.4 / 1.4); };
  return from_kPa * std::sqrt(difference(ratio) / difference(kCritical));
}

struct Chamber {
  double resistance_s_L = 0, recovery_s = 0.05;
  double line_kPa = kSupply_kPa;  ///< before the resistance
  double pressure_kPa = 400, droop_kPa = 0;

  /// Returns the mean over the tick.
  double tick(double command_V) {
    constexpr double kStep_s = 1e-4;
    double sum_kPa = 0;
    for (int i = 0; i < 100; ++i) {
      const double inlet_L_s = 1e-3 * kGain_mL_s_V * std::max(command_V - kOpenAbove_V, 0.0);
      const double exhaust_L_s = 1e-3 * kGain_mL_s_V * std::max(kExhaustBelow_V - command_V, 0.0);
      const double in = inlet_L_s * thin_plate_kPa(line_kPa - droop_kPa, pressure_kPa);
      const double out = exhaust_L_s * thin_plate_kPa(pressure_kPa, kAmbient_kPa);
      droop_kPa += kStep_s / recovery_s * (resistance_s_L * in - droop_kPa);
      pressure_kPa += kStep_s * (in - out) / (1e-3 * kVolume_mL);
      sum_kPa += pressure_kPa;
    }
    return sum_kPa / 100;
  }
};

/// RMS error [kPa] behind a sine of 2 Hz that is known in advance, while the line does what `line_kPa` says of the tick.
double rms_kPa(
    Chamber chamber, const SupplyLine::Config& told,
    const std::function<double(int)>& line_kPa = [](int) { return kSupply_kPa; }) {
  const Greybox of = model();
  Regulator regulator;
  Regulator::Config config;
  config.valve_delay_ticks = 0;
  config.command_low_V = 0;
  config.command_high_V = 10;
  regulator.configure(config);
  regulator.take_over({}, 0, told);
  regulator.reset(400, 5);
  const ChamberMotion motion{.volume_mL = kVolume_mL, .volume_rate_mL_s = 0};
  const auto reference = [](double t) { return 400 + 80 * std::sin(2 * std::numbers::pi * 0.02 * t); };
  double measured_kPa = 400, square = 0;
  constexpr int kTicks = 600, kSkipped = 100;
  for (int t = 0; t < kTicks; ++t) {
    regulator.observe(of, static_cast<Scalar>(measured_kPa), motion);
    ReferenceShaper::Reference wanted;
    for (std::size_t i = 0; i < wanted.kPa.size(); ++i)
      wanted.kPa[i] = static_cast<Scalar>(reference(t + static_cast<double>(i)));
    const Scalar command_V = regulator.regulate(of, wanted, motion).command_V;
    regulator.sent(command_V);
    chamber.line_kPa = line_kPa(t);
    measured_kPa = chamber.tick(real(command_V));
    regulator.supply_measured(static_cast<Scalar>(chamber.line_kPa));
    if (t >= kSkipped) square += std::pow(chamber.pressure_kPa - reference(t + 1), 2) / (kTicks - kSkipped);
  }
  return std::sqrt(square);
}

SupplyLine::Config told_of(const Chamber& chamber) {
  return {.supply_kPa = Scalar(kSupply_kPa),
          .resistance_s_L = static_cast<Scalar>(chamber.resistance_s_L),
          .recovery_ticks = static_cast<Scalar>(100 * chamber.recovery_s),
          .followed_share = 0};
}

TEST(RegulatorAndSupply, ADroopThatTheModelKnowsIsFeltNoMore) {
  for (const double recovery_s : {0.005, 0.05, 0.3}) {
    Chamber chamber;
    chamber.resistance_s_L = 2.0;
    chamber.recovery_s = recovery_s;
    const double untold_kPa = rms_kPa(chamber, {});
    const double told_kPa = rms_kPa(chamber, told_of(chamber));
    EXPECT_GT(untold_kPa, 0.5) << "kPa, " << recovery_s << " s";
    EXPECT_LT(told_kPa, 0.15 * untold_kPa) << "kPa, " << recovery_s << " s, untold " << untold_kPa;
  }
}

TEST(RegulatorAndSupply, WhereTheLineIsTooNarrowForTheReferenceKnowingItDoesNoHarm) {
  for (const double recovery_s : {0.005, 0.05}) {
    Chamber chamber;
    chamber.resistance_s_L = 4.0;
    chamber.recovery_s = recovery_s;
    EXPECT_LT(rms_kPa(chamber, told_of(chamber)), rms_kPa(chamber, {})) << "kPa, " << recovery_s << " s";
  }
}

TEST(RegulatorAndSupply, ALineThatOthersDrawFromIsFollowedAsItIsMeasured) {
  // another machine takes up to three tenths of the line's pressure
  const auto line_kPa = [](int t) { return kSupply_kPa * (0.85 + 0.15 * std::cos(0.05 * t)); };
  const SupplyLine::Config told{
      .supply_kPa = Scalar(kSupply_kPa), .resistance_s_L = 0, .recovery_ticks = 0, .followed_share = 1};
  EXPECT_LT(rms_kPa({}, told, line_kPa), 0.5 * rms_kPa({}, {}, line_kPa));
}

TEST(RegulatorAndSupply, WhatIsMeasuredMovesNothingOfAModelThatDoesNotFollowIt) {
  const auto line_kPa = [](int t) { return kSupply_kPa * (0.85 + 0.15 * std::cos(0.05 * t)); };
  const SupplyLine::Config deaf{
      .supply_kPa = Scalar(kSupply_kPa), .resistance_s_L = 0, .recovery_ticks = 0, .followed_share = 0};
  EXPECT_EQ(rms_kPa({}, deaf, line_kPa), rms_kPa({}, {}, line_kPa));
}

}  // namespace
}  // namespace plenum::control
