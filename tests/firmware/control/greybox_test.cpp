// The grey-box model against its differential equation integrated in double, and its inverse against its
// own step.
#include "firmware/control/greybox.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "firmware/config/valve_curve.hpp"
#include "tests/firmware/control/random_greybox.hpp"
#include "tests/firmware/scalars.hpp"

namespace plenum::control {
namespace {

using Case = testing::GreyboxCase;
using Set = testing::GreyboxSet;

/// The same, its pressure as far between, with another supply than its model states.
Case supplied(Case of, std::mt19937& random) {
  std::uniform_real_distribution<float> supply(0.5F, 1.3F);
  const float of_model_kPa = of.set[Greybox::kSupply], ambient_kPa = of.set[Greybox::kAmbient];
  const float share = (of.pressure_kPa - ambient_kPa) / (of_model_kPa - ambient_kPa);
  const float drawn = supply(random);
  of.motion.supply = drawn;
  of.pressure_kPa = ambient_kPa + share * (drawn * of_model_kPa - ambient_kPa);
  return of;
}

/// Of every other one the supply is as its model states.
Case random_case(std::mt19937& random) {
  const Case of = testing::random_case(random);
  return random() % 2 != 0 ? of : supplied(of, random);
}

Scalar supply_kPa(const Case& of) {
  return of.motion.supply * of.set[Greybox::kSupply];
}

/// A thin plate of a small valve, without leaks worth mention.
constexpr Set small_valve() {
  Set set{};
  set[Greybox::kOpenAbove] = 5.08F;
  set[Greybox::kExhaustBelow] = 4.92F;
  set[Greybox::kInletConductance] = 60.0F;
  set[Greybox::kExhaustConductance] = 64.0F;
  set[Greybox::kInletLeak] = set[Greybox::kExhaustLeak] = 1e-3F;
  set[Greybox::kTransition] = 0.01F;
  set[Greybox::kCriticalRatio] = 0.5282818F;
  set[Greybox::kSubsonicIndex] = 0.5F;
  set[Greybox::kCrackingRatio] = 1.0F;
  set[Greybox::kVolumeExponent] = 1.4F;
  set[Greybox::kSupply] = 700.0F;
  set[Greybox::kAmbient] = 101.325F;
  return set;
}
constexpr Set kSmallValve = small_valve();

Greybox model_of(const Set& set) {
  Greybox model;
  model.configure(scalars(set), 0.0F, 10.0F);
  return model;
}

// ---- the equations once more, in double, from the header

double figure(const Set& of, std::size_t which) {
  return static_cast<double>(of[which]);
}

double thin_plate(double ratio) {
  const auto difference = [](double r) { return std::pow(r, 2.0 / 1.4) - std::pow(r, 2.4 / 1.4); };
  const double critical = std::pow(2.0 / 2.4, 3.5);
  return ratio <= critical ? 1.0 : std::sqrt(difference(std::min(ratio, 1.0)) / difference(critical));
}

double flow_function(const Set& of, double ratio) {
  const double critical = std::pow(2.0 / 2.4, 3.5);
  const double b = figure(of, Greybox::kCriticalRatio), a = figure(of, Greybox::kCrackingRatio);
  const double as_plate = critical + (ratio - b) * (1.0 - critical) / (a - b);
  return (1.0 + figure(of, Greybox::kDischargeSlope) * (critical - ratio)) *
         std::pow(thin_plate(as_plate), 2.0 * figure(of, Greybox::kSubsonicIndex));
}

double phi(const Set& of, double from_kPa, double to_kPa) {
  return from_kPa >= to_kPa ? from_kPa * flow_function(of, to_kPa / from_kPa)
                            : -to_kPa * flow_function(of, from_kPa / to_kPa);
}

/// `first` of the shape's three figures.
double conductance(const Set& of, double gain, double leak, Greybox::Parameter first, double opening_V) {
  const double o = std::max(opening_V, 0.0), g = o / (o + 2.0);
  const double q = figure(of, first), c = figure(of, first + 1), e = figure(of, first + 2);
  const double bent = opening_V * std::max(1.0 + q * g + c * g * g + e * g * g * g, 0.05);
  const double w = figure(of, Greybox::kTransition);
  const double x = (gain * bent - leak) / w;
  return leak + w * 0.5 * (x + std::sqrt(x * x + 1.0));
}

/// (G1) with the volume at the middle of the tick held, as the model is told it.
double rate_kPa_s(const Case& of, double pressure_kPa, double command_V) {
  const Set& p = of.set;
  const double inlet = conductance(p, figure(p, Greybox::kInletConductance), figure(p, Greybox::kInletLeak),
                                   Greybox::kInletSlope, command_V - figure(p, Greybox::kOpenAbove));
  const double exhaust =
      conductance(p, figure(p, Greybox::kExhaustConductance), figure(p, Greybox::kExhaustLeak),
                  Greybox::kExhaustSlope, figure(p, Greybox::kExhaustBelow) - command_V);
  const double flows = inlet * phi(p, real(supply_kPa(of)), pressure_kPa) -
                       exhaust * phi(p, pressure_kPa, figure(p, Greybox::kAmbient));
  const double moved =
      figure(p, Greybox::kVolumeExponent) * static_cast<double>(of.motion.volume_rate_mL_s) * pressure_kPa;
  const double ambient = figure(p, Greybox::kAmbient);
  const double leak =
      figure(p, Greybox::kChamberLeak) * (pressure_kPa * pressure_kPa - ambient * ambient) / (2.0 * ambient);
  return (flows - leak - moved) /
         (static_cast<double>(of.motion.volume_mL) + figure(p, Greybox::kDeadVolume));
}

struct Exact {
  double end_kPa = 0.0;
  double mean_kPa = 0.0;
};

/// By Runge-Kutta in steps that the fastest of the cases needs.
Exact integrated(const Case& of, double command_V, double duration_s) {
  constexpr int kSteps = 1000;
  const double h = duration_s / kSteps;
  double p = static_cast<double>(of.pressure_kPa), area = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double k1 = rate_kPa_s(of, p, command_V);
    const double k2 = rate_kPa_s(of, p + 0.5 * h * k1, command_V);
    const double k3 = rate_kPa_s(of, p + 0.5 * h * k2, command_V);
    const double k4 = rate_kPa_s(of, p + h * k3, command_V);
    area += h * (p + h / 6.0 * (k1 + k2 + k3));
    p += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return {p, area / duration_s};
}

TEST(Greybox, IsExactWhileBothPortsAreChokedAndTheVolumeRests) {
  // 500 kPa behind a supply of 1000, a sonic inlet: the pressure rises on a straight line
  Set set = kSmallValve;
  set[Greybox::kSupply] = 2000.0F;
  const Case of{set, {.volume_mL = 100.0F, .volume_rate_mL_s = 0.0F}, 500.0F};
  const Prediction got = model_of(set).step(500.0F, 6.08F, of.motion, 1.0F);
  const double rise = 60.0 * 2000.0 / 100.0 * 0.01;  // the exhaust's leak takes a thousandth of a kPa
  EXPECT_NEAR(real(got.end_kPa), 500.0 + rise, 0.01);
  EXPECT_NEAR(real(got.mean_kPa), 500.0 + 0.5 * rise, 0.01);
}

TEST(Greybox, EmptiesThroughAChokedExhaustAsAnExponential) {
  const Case of{kSmallValve, {.volume_mL = 100.0F, .volume_rate_mL_s = 0.0F}, 600.0F};
  const Prediction got = model_of(kSmallValve).step(600.0F, 3.92F, of.motion, 1.0F);
  const double rate = 64.0 / 100.0 * 0.01;
  EXPECT_NEAR(real(got.end_kPa), 600.0 * std::exp(-rate), 0.02);
  EXPECT_NEAR(real(got.mean_kPa), 600.0 * -std::expm1(-rate) / rate, 0.02);
}

TEST(Greybox, CompressesASealedChamberAsThePolytropeOfTheVolumeAtTheMiddle) {
  Set set = kSmallValve;
  set[Greybox::kTransition] = 1e-5F;
  set[Greybox::kInletLeak] = set[Greybox::kExhaustLeak] = 1e-6F;
  const Prediction got =
      model_of(set).step(300.0F, 5.0F, {.volume_mL = 100.0F, .volume_rate_mL_s = -200.0F}, 1.0F);
  EXPECT_NEAR(real(got.end_kPa), 300.0 * std::exp(1.4 * 200.0 / 100.0 * 0.01), 0.002);
}

TEST(ValveCurve, ConductsAsItsEquationSaysHoweverSharplyItOpens) {
  for (const float gain : {1e-3F, 1.0F, 60.0F, 1e5F}) {
    for (const float transition : {1e-4F, 1e-2F, 1.0F, 1e5F}) {
      Set set = kSmallValve;
      set[Greybox::kInletConductance] = gain;
      set[Greybox::kTransition] = transition;
      set[Greybox::kInletSlope] = 20.0F;
      const config::ValveCurve curve = config::inlet_of(scalars(set));
      for (const float opening_V : {-15.0F, -1.0F, -1e-3F, 0.0F, 1e-5F, 1e-3F, 0.1F, 1.0F, 15.0F}) {
        const double exact = conductance(set, static_cast<double>(gain), figure(set, Greybox::kInletLeak),
                                         Greybox::kInletSlope, static_cast<double>(opening_V));
        EXPECT_NEAR(real(curve.conductance_mL_s(opening_V)), exact, 1e-6 * exact + 2e-6)
            << gain << " mL/(s V), " << transition << " mL/s, " << opening_V << " V";
      }
    }
  }
}

TEST(Greybox, FollowsItsEquationOverATick) {
  std::mt19937 random(1), of_supply(2);
  std::uniform_real_distribution<double> command(0.0, 10.0);
  double worst = 0.0;
  double sum = 0.0;
  int count = 0;
  for (int i = 0; i < 150; ++i) {
    const Case of_model = testing::random_case(random);
    const double u = command(random);
    for (const Case& of : {of_model, supplied(of_model, of_supply)}) {
      const Exact exact = integrated(of, u, 0.01);
      const Prediction got = model_of(of.set).step(of.pressure_kPa, static_cast<float>(u), of.motion, 1.0F);
      const double span = figure(of.set, Greybox::kSupply) - figure(of.set, Greybox::kAmbient);
      const double error = std::max(std::abs(real(got.end_kPa) - exact.end_kPa),
                                    std::abs(real(got.mean_kPa) - exact.mean_kPa)) /
                           span;
      worst = std::max(worst, error);
      sum += error * error;
      ++count;
    }
  }
  // what the chords of psi take away
  EXPECT_LT(worst, 5e-4) << "of span";
  EXPECT_LT(std::sqrt(sum / count), 1e-4) << "of span";
}

TEST(Greybox, ComesToRestAtTheSupplyHoweverStiff) {
  Set set = kSmallValve;
  set[Greybox::kInletConductance] = 20'000.0F;  // a chamber of 1 mL behind a tap
  const Greybox model = model_of(set);
  Scalar pressure_kPa = 101.325F;
  for (int k = 0; k < 50; ++k) {
    pressure_kPa =
        model.step(pressure_kPa, 10.0F, {.volume_mL = 1.0F, .volume_rate_mL_s = 0.0F}, 1.0F).end_kPa;
    ASSERT_GT(pressure_kPa, 0.0F) << "tick " << k;
    ASSERT_LT(pressure_kPa, 2000.0F) << "tick " << k;
  }
  EXPECT_NEAR(real(pressure_kPa), 700.0, 0.5);
}

TEST(Greybox, TwoPartsOfATickAreTheTick) {
  std::mt19937 random(6);
  std::uniform_real_distribution<float> command(0.0F, 10.0F), part(0.0F, 1.0F);
  for (int i = 0; i < 5000; ++i) {
    const Case of = random_case(random);
    const Greybox model = model_of(of.set);
    const float u = command(random), first = part(random);
    const Prediction whole = model.step(of.pressure_kPa, u, of.motion, 1.0F);
    const Prediction begun = model.step(of.pressure_kPa, u, of.motion, first);
    const Prediction ended = model.step(begun.end_kPa, u, of.motion, 1.0F - first);
    ASSERT_NEAR(real(whole.end_kPa), real(ended.end_kPa), 2e-5F * of.pressure_kPa) << "set " << i;
    ASSERT_NEAR(real(whole.mean_kPa), real(first * begun.mean_kPa + (1.0F - first) * ended.mean_kPa),
                2e-5F * of.pressure_kPa)
        << "set " << i;
  }
}

TEST(Greybox, RisesWithTheCommandBetweenAmbientAndSupply) {
  std::mt19937 random(4);
  int compared = 0;
  for (int i = 0; i < 500; ++i) {
    const Case of = random_case(random);
    const Greybox model = model_of(of.set);
    const auto within = [&of](Scalar kPa) { return kPa > of.set[Greybox::kAmbient] && kPa < supply_kPa(of); };
    Scalar last = model.step(of.pressure_kPa, 0.0F, of.motion, 1.0F).end_kPa;
    for (int k = 1; k <= 200; ++k) {
      const Scalar now = model.step(of.pressure_kPa, 0.05F * static_cast<float>(k), of.motion, 1.0F).end_kPa;
      if (within(last) && within(now)) {
        ASSERT_GT(now, last - 2e-6F * of.pressure_kPa) << "set " << i << " at " << 0.05 * k << " V";
        ++compared;
      }
      last = now;
    }
  }
  EXPECT_GT(compared, 50'000);
}

/// The end nearest to a target that any of many commands leads to; above the supply's pressure and below the ambient's
/// only those of the side on which the pressure rises with the command.
Scalar nearest_of_many(const Greybox& model, const Case& of, Scalar target_kPa) {
  const float null_V = 0.5F * (of.set[Greybox::kOpenAbove] + of.set[Greybox::kExhaustBelow]);
  Scalar nearest_kPa = 1e9F;
  for (int k = 0; k <= 200; ++k) {
    const float u = 0.05F * static_cast<float>(k);
    if (of.pressure_kPa > supply_kPa(of) && u > null_V) continue;
    if (of.pressure_kPa < of.set[Greybox::kAmbient] && u < null_V) continue;
    const Scalar end = model.step(of.pressure_kPa, u, of.motion, 1.0F).end_kPa;
    if (numeric::abs(end - target_kPa) < numeric::abs(nearest_kPa - target_kPa)) nearest_kPa = end;
  }
  return nearest_kPa;
}

/// A chamber above its supply or below the ambient may be drawn, too: compressed or expanded behind shut ports.
Case anywhere(std::mt19937& random) {
  Case of = random_case(random);
  std::uniform_real_distribution<float> factor(0.5F, 1.3F);
  of.pressure_kPa *= factor(random);
  return of;
}

TEST(Greybox, APortWhoseCurveFallsStaysAsOpenAsItWas) {
  // m = 1 - 1.4 g^2: o m is largest where (o + 2)^3 = 1.4 o^2 (o + 6), at 4.01 V
  Set set = small_valve();
  set[Greybox::kInletCurve] = set[Greybox::kExhaustCurve] = -1.4F;
  set[Greybox::kOpenAbove] = 5.0F;
  set[Greybox::kExhaustBelow] = 5.0F;
  const Greybox model = model_of(set);
  const ChamberMotion motion{.volume_mL = 200, .volume_rate_mL_s = 0};
  const auto end_kPa = [&](float command_V) { return model.step(300, command_V, motion, 1).end_kPa; };
  const auto exact_kPa = [&](double command_V) {
    return integrated({set, motion, 300}, command_V, 0.01).end_kPa;
  };
  EXPECT_NEAR(real(end_kPa(8.0F)), exact_kPa(8.0), 0.1) << "on its way";
  EXPECT_NEAR(real(end_kPa(9.9F)), exact_kPa(9.01), 0.1) << "saturated";
  EXPECT_LT(exact_kPa(9.9), exact_kPa(9.01) - 0.05) << "what the curve itself would do";
  EXPECT_NEAR(real(end_kPa(0.1F)), exact_kPa(0.99), 0.1);
  for (float command_V = 0.1F; command_V < 10; command_V += 0.1F)
    EXPECT_GE(end_kPa(command_V), end_kPa(command_V - 0.1F)) << command_V << " V";
}

TEST(Greybox, NoCommandLeadsNearerToATargetThanItsInverse) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> away(-0.2F, 0.2F);
  int reached = 0;
  for (int i = 0; i < 1500; ++i) {
    const Case of = anywhere(random);
    const Greybox model = model_of(of.set);
    const Scalar target = std::clamp(Scalar(of.pressure_kPa * (1.0F + away(random))),
                                     Scalar(of.set[Greybox::kAmbient]), supply_kPa(of));
    const Inverse got = model.inverse(of.pressure_kPa, target, of.motion, 5.0F);
    const Scalar end = model.step(of.pressure_kPa, got.command_V, of.motion, 1.0F).end_kPa;
    ASSERT_EQ(end, got.reached_kPa) << "set " << i;
    // outside, the limit is the one of 64 commands at which the pressure rises or falls fastest
    const bool inside = of.pressure_kPa >= of.set[Greybox::kAmbient] && of.pressure_kPa <= supply_kPa(of);
    const Scalar nearest = nearest_of_many(model, of, target);
    ASSERT_LE(numeric::abs(end - target),
              numeric::abs(nearest - target) + (inside ? 1e-5F : 1e-4F) * of.pressure_kPa)
        << "set " << i << " at " << got.command_V << " V";
    if (!got.saturated) {
      ASSERT_NEAR(real(end), real(target), 0.01) << "set " << i << " at " << got.command_V << " V";
      ++reached;
    }
  }
  EXPECT_GT(reached, 500);
}

TEST(Greybox, TellsTheSlopeOfTheEndWhereItsInverseAnswers) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> command(0.5F, 9.5F);
  int checked = 0, close = 0;
  for (int i = 0; i < 3000; ++i) {
    const Case of = random_case(random);
    const Greybox model = model_of(of.set);
    const Scalar target_kPa = model.step(of.pressure_kPa, command(random), of.motion, 1.0F).end_kPa;
    const Inverse got = model.inverse(of.pressure_kPa, target_kPa, of.motion, 5.0F);
    if (got.saturated) continue;
    const auto end = [&](float away_V) {
      return model.step(of.pressure_kPa, got.command_V + away_V, of.motion, 1.0F).end_kPa;
    };
    constexpr float kAway_V = 0.004F;
    const Scalar below = (got.reached_kPa - end(-kAway_V)) / kAway_V;
    const Scalar above = (end(kAway_V) - got.reached_kPa) / kAway_V;
    if (std::max(below, above) < 1.0F) continue;  // the chamber rests at the target, whatever the command
    // a broken line: between its slopes to either side
    const Scalar low = std::min(below, above), high = std::max(below, above);
    EXPECT_GE(got.by_command_kPa_V, Scalar(0.5F) * low) << "kPa/V, set " << i;
    EXPECT_LE(got.by_command_kPa_V, Scalar(1.5F) * high) << "kPa/V, set " << i;
    close += got.by_command_kPa_V >= Scalar(0.95F) * low && got.by_command_kPa_V <= Scalar(1.05F) * high;
    ++checked;
  }
  EXPECT_GT(checked, 1500);
  EXPECT_GT(close, checked * 98 / 100) << "within 5 %: a straight line and secants tell it, no derivative";
}

TEST(Greybox, DrawsWhatItsInletLetsThroughAndTellsHowThatRisesWithTheSupply) {
  std::mt19937 random(9);
  for (int i = 0; i < 300; ++i) {
    const Case of = random_case(random);
    const Greybox model = model_of(of.set);
    const double u = std::uniform_real_distribution<double>(0.0, 10.0)(random);
    const auto at = [&](Scalar supply) {
      ChamberMotion motion = of.motion;
      motion.supply = supply;
      return model.draw(of.pressure_kPa, model.opening(static_cast<float>(u)), model.moving(motion));
    };
    const Set& p = of.set;
    const double inlet = conductance(p, figure(p, Greybox::kInletConductance), figure(p, Greybox::kInletLeak),
                                     Greybox::kInletSlope, u - figure(p, Greybox::kOpenAbove));
    const double supply = real(supply_kPa(of)), pressure = static_cast<double>(of.pressure_kPa);
    const double most = inlet * 1e-3 * supply;
    const Draw got = at(of.motion.supply);
    // the chords of psi, and of C(u)
    EXPECT_NEAR(real(got.flow_kPa_L_s), inlet * 1e-3 * phi(p, supply, pressure), 0.04 * most) << "set " << i;
    // a broken line: between its slopes to either side
    constexpr float kAway = 1e-3F;
    const double below = real(got.flow_kPa_L_s - at(of.motion.supply - kAway).flow_kPa_L_s);
    const double above = real(at(of.motion.supply + kAway).flow_kPa_L_s - got.flow_kPa_L_s);
    const double told = 1e-3 * real(got.by_supply_kPa_L_s), close = 0.01 * std::abs(told) + 3e-6 * most;
    EXPECT_GE(told, std::min(below, above) - close) << "set " << i;
    EXPECT_LE(told, std::max(below, above) + close) << "set " << i;
  }
}

TEST(Greybox, ComesToRestAtTheSupplyThatThereIs) {
  const Greybox model = model_of(kSmallValve);
  for (const float supply : {0.6F, 0.9F, 1.2F}) {
    Scalar pressure_kPa = 101.325F;
    for (int k = 0; k < 300; ++k) {
      pressure_kPa = model
                         .step(pressure_kPa, 8.0F,
                               {.volume_mL = 50.0F, .volume_rate_mL_s = 0.0F, .supply = supply}, 1.0F)
                         .end_kPa;
    }
    EXPECT_NEAR(real(pressure_kPa), 700.0 * static_cast<double>(supply), 0.5);
  }
}

TEST(Greybox, AnswersEveryFiniteInputWithNumbers) {
  constexpr float kHuge = std::numeric_limits<float>::max();
  const Greybox model = model_of(kSmallValve);
  for (const float p : {-kHuge, -1.0F, 0.0F, 101.325F, 700.0F, kHuge}) {
    for (const float u : {-kHuge, 0.0F, 5.0F, 10.0F, kHuge}) {
      for (const float v : {-kHuge, 0.0F, 1e-30F, 100.0F, kHuge}) {
        for (const float s : {-kHuge, 0.0F, kHuge}) {
          const ChamberMotion motion{.volume_mL = v, .volume_rate_mL_s = s, .supply = s};
          const Prediction step = model.step(p, u, motion, 1.0F);
          EXPECT_TRUE(numeric::is_finite(step.end_kPa) && numeric::is_finite(step.mean_kPa))
              << p << " " << u << " " << v << " " << s;
          const Inverse back = model.inverse(p, 300.0F, motion, u);
          EXPECT_TRUE(numeric::is_finite(back.command_V) && numeric::is_finite(back.reached_kPa) &&
                      numeric::is_finite(back.by_command_kPa_V))
              << p << " " << u << " " << v << " " << s;
        }
      }
    }
  }
}

}  // namespace
}  // namespace plenum::control
