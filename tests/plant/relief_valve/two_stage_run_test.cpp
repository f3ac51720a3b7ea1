#include "host-sim/plant/relief_valve/two_stage_run.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "host-sim/plant/relief_valve/inch_units.hpp"
#include "host-sim/plant/relief_valve/two_stage_static.hpp"

namespace {

using namespace plenum::host::plant::relief_valve;

constexpr double kSupply_m3_s = 250.0 * kInch3_m3;

TEST(TwoStageRun, AtRestItStaysAtRest) {
  const TwoStagePhysics physics(appendix_a_settling());
  const TwoStageState rest = two_stage_at_rest(physics, kSupply_m3_s);
  TwoStageValve valve(physics.config(), rest);
  valve.advance(kSupply_m3_s, kSupply_m3_s, 0.1);
  EXPECT_NEAR(valve.state()[kP1], rest[kP1], 1e-6 * rest[kP1]);
  EXPECT_NEAR(valve.state()[kX], rest[kX], 1e-6 * rest[kX]);
}

TEST(TwoStageRun, ShutItRisesWithTheSupply) {
  TwoStageValve valve(appendix_a_as_printed(), {});
  valve.advance(0.0, kSupply_m3_s, 0.004);
  const double expected_Pa = valve.physics().upstream_stiffness_Pa_m3() * 0.5 * kSupply_m3_s * 0.004;
  EXPECT_NEAR(valve.state()[kP1], expected_Pa, 1e-6 * expected_Pa);
  EXPECT_NEAR(valve.state()[kP2], expected_Pa, 1e-6 * expected_Pa) << "VI.F: the chamber follows the line";
  EXPECT_EQ(valve.state()[kX], 0.0);
}

TEST(TwoStageRun, ConvergesWithTheFourthPowerOfTheStep) {
  const TwoStagePhysics physics(appendix_a_settling());
  const TwoStageState rest = two_stage_at_rest(physics, kSupply_m3_s);
  const auto run = [&](double tolerance, long* steps) {
    TwoStageValve valve(physics.config(), rest, tolerance);
    valve.advance(kSupply_m3_s, 1.02 * kSupply_m3_s, 0.005);
    valve.advance(1.02 * kSupply_m3_s, 1.02 * kSupply_m3_s, 0.015);
    if (steps != nullptr) *steps = valve.effort().steps;
    return valve.state()[kP1];
  };
  const double fine = run(1e-12, nullptr);
  long few = 0;
  long many = 0;
  const double coarse_error = std::abs(run(1e-6, &few) - fine);
  const double fine_error = std::abs(run(1e-9, &many) - fine);
  const double order =
      std::log(coarse_error / fine_error) / std::log(static_cast<double>(many) / static_cast<double>(few));
  EXPECT_GT(order, 3.3);
  EXPECT_LT(order, 5.2);
}

TEST(TwoStageRun, LateRingingIsTheLeastDampedMode) {
  const TwoStagePhysics physics(appendix_a_settling());
  const TwoStageState end = two_stage_at_rest(physics, kSupply_m3_s);
  TwoStageValve valve(physics.config(), two_stage_at_rest(physics, 0.98 * kSupply_m3_s), 1e-9);
  valve.advance(kSupply_m3_s, kSupply_m3_s, 0.15);
  std::vector<double> crossings_s;
  std::vector<double> peaks_Pa{0.0};
  double before_Pa = valve.state()[kP1] - end[kP1];
  constexpr double kStep_s = 1e-5;
  for (int i = 0; i < 4000; ++i) {
    valve.advance(kSupply_m3_s, kSupply_m3_s, kStep_s);
    const double now_Pa = valve.state()[kP1] - end[kP1];
    if ((now_Pa > 0.0) != (before_Pa > 0.0)) {
      crossings_s.push_back(kStep_s * (i + now_Pa / (before_Pa - now_Pa)));
      peaks_Pa.push_back(0.0);
    }
    peaks_Pa.back() = std::max(peaks_Pa.back(), std::abs(now_Pa));
    before_Pa = now_Pa;
  }
  ASSERT_GE(crossings_s.size(), 8u);
  const double half_periods = static_cast<double>(crossings_s.size() - 1);
  const double ringing_s = crossings_s.back() - crossings_s.front();
  const Mode mode = modes(physics, end).front();
  EXPECT_NEAR(0.5 * half_periods / ringing_s, mode.frequency_Hz, 0.01 * mode.frequency_Hz) << "Hz";
  // The first and the last arch may be cut off: those between.
  const double decay_1_s = std::log(peaks_Pa[1] / peaks_Pa[peaks_Pa.size() - 2]) /
                           (ringing_s * (half_periods - 1.0) / half_periods);
  EXPECT_NEAR(decay_1_s, -mode.growth_1_s, 0.03 * -mode.growth_1_s) << "1/s";
}

// From rest the printed valve runs into a limit cycle that meets its seats and stops again and again.
TEST(TwoStageRun, ConstraintsHoldAfterEveryStep) {
  for (const bool follows : {true, false}) {
    TwoStageConfig config = appendix_a_as_printed();
    config.chamber_follows_while_pilot_shut = follows;
    TwoStageValve valve(config, {}, 1e-6);
    valve.advance(kSupply_m3_s, kSupply_m3_s, 0.05, [&](double time_s, const TwoStageState& s) {
      ASSERT_GE(s[kP1], -0.1) << "Pa at " << time_s << " s";
      ASSERT_GE(s[kP2], -0.1) << "Pa at " << time_s << " s";
      ASSERT_GE(s[kX], -1e-9 * config.main.travel_m);
      ASSERT_LE(s[kX], (1.0 + 1e-9) * config.main.travel_m);
      ASSERT_GE(s[kY], -1e-9 * config.pilot.travel_m);
      ASSERT_LE(s[kY], (1.0 + 1e-9) * config.pilot.travel_m);
    });
    EXPECT_GT(valve.effort().events, 10) << "nothing was met";
  }
}

TEST(TwoStageRun, VelocityIsZeroOnASeatAndAtAStop) {
  TwoStageConfig config = appendix_a_as_printed();
  TwoStageValve valve(config, {}, 1e-6);
  int seated = 0;
  int stopped = 0;
  valve.advance(kSupply_m3_s, kSupply_m3_s, 0.05, [&](double, const TwoStageState& s) {
    if (s[kY] == 0.0) {
      ++seated;
      EXPECT_EQ(s[kU], 0.0);
    }
    if (s[kY] == config.pilot.travel_m) {
      ++stopped;
      EXPECT_EQ(s[kU], 0.0);
    }
  });
  EXPECT_GT(seated, 0);
  EXPECT_GT(stopped, 0);
}

TEST(TwoStageRun, EventsAreLocatedWhateverTheTolerance) {
  const auto end_Pa = [](double tolerance) {
    TwoStageValve valve(appendix_a_as_printed(), {}, tolerance);
    valve.advance(kSupply_m3_s, kSupply_m3_s, 0.04);
    return valve.state()[kP1];
  };
  const double fine_Pa = end_Pa(1e-9);
  EXPECT_NEAR(end_Pa(1e-6), fine_Pa, 1e-5 * fine_Pa);
  EXPECT_NEAR(end_Pa(1e-4), fine_Pa, 1e-3 * fine_Pa);
}

TEST(TwoStageRun, ResultDoesNotDependOnHowTheIntervalIsCut) {
  TwoStageValve whole(appendix_a_settling(), {}, 1e-9);
  TwoStageValve parts(appendix_a_settling(), {}, 1e-9);
  whole.advance(0.0, kSupply_m3_s, 0.03);
  for (int i = 0; i < 60; ++i) parts.advance(kSupply_m3_s * i / 60.0, kSupply_m3_s * (i + 1) / 60.0, 0.0005);
  EXPECT_NEAR(parts.state()[kP1], whole.state()[kP1], 1e-6 * whole.state()[kP1]);
}

TEST(TwoStageRun, UpstreamPressureNeverFallsBelowTheTanks) {
  // A supply that draws more than there is: empty, then filled again.
  TwoStageValve valve(appendix_a_settling(), {1e6, 1e6, 0.0, 0.0, 0.0, 0.0}, 1e-6);
  valve.advance(-1e-3, -1e-3, 0.02);
  EXPECT_EQ(valve.state()[kP1], 0.0);
  valve.advance(1e-3, 1e-3, 0.002);
  EXPECT_NEAR(valve.state()[kP1], valve.physics().upstream_stiffness_Pa_m3() * 1e-3 * 0.002, 10.0);
}

// The header states it of the source's response.
TEST(TwoStageRun, UnsteadyForceLeftOutIsSmall) {
  constexpr double kSecondLength_m = 0.15 * kInch_m;
  const TwoStageConfig config = appendix_a_settling();
  TwoStageValve valve(config, {}, 1e-6);
  double worst = 0.0;
  TwoStageState before{};
  double before_s = 0.0;
  valve.advance(kSupply_m3_s, kSupply_m3_s, 0.04, [&](double t, const TwoStageState& s) {
    const double rate_Pa_s = (s[kP1] - before[kP1]) / (t - before_s);
    if (s[kP1] > 1e5) {
      const double Q = valve.physics().main_flow_m3_s(s[kP1], s[kX]);
      const double force_N = config.density_kg_m3 * kSecondLength_m * Q * rate_Pa_s / (2.0 * s[kP1]);
      worst = std::max(worst, std::abs(force_N));
    }
    before = s;
    before_s = t;
  });
  EXPECT_LT(worst, 0.01 * config.main.spring_N_m * config.main.preload_m) << "N";
  EXPECT_GT(worst, 0.0);
}

TEST(TwoStageRun, RefusesAStartOutOfItsConstraints) {
  EXPECT_THROW(TwoStageValve(appendix_a_settling(), {-1.0, 0, 0, 0, 0, 0}), std::invalid_argument);
  EXPECT_THROW(TwoStageValve(appendix_a_settling(), {0, 0, 1.0, 0, 0, 0}), std::invalid_argument);
  EXPECT_THROW(TwoStageValve(appendix_a_settling(), {}, 1.0), std::invalid_argument);
  TwoStageValve valve(appendix_a_settling(), {});
  EXPECT_THROW(valve.advance(0.0, 0.0, 0.0), std::invalid_argument);
}

}  // namespace
