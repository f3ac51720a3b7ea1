// dead_time: what it makes of the command, against closed forms and the plant.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "host-sim/plant/chamber.hpp"
#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

DeadTime<double> dead_time_of(double ticks, double rise = 0.0) {
  const double x[] = {ticks * kTick_s, rise};
  DeadTime<double> dead_time;
  dead_time.prepare(x, kTick_s, 5.0);
  return dead_time;
}

TEST(DeadTime, OfWholeTicksIsTheCommandOfThatManyTicksBefore) {
  for (int late = 0; late <= 8; ++late) {
    DeadTime<double> dead_time = dead_time_of(late);
    const std::vector<double> command_V = jumping_command_V(200);
    for (int k = 0; k < 200; ++k) {
      dead_time.hold(command_V[static_cast<std::size_t>(k)]);
      const double expected_V = k < late ? 5.0 : command_V[static_cast<std::size_t>(k - late)];
      for (int i = 0; i < 4; ++i) {
        EXPECT_NEAR(dead_time.during(0.25 * i, 0.25 * (i + 1)).mean(), expected_V, 1e-13)
            << "V, tick " << k << " late " << late;
      }
    }
  }
}

TEST(DeadTime, FractionOfATickSharesOutTheStepInWhichItEnds) {
  DeadTime<double> dead_time = dead_time_of(2.3);
  for (const double u : {1.0, 2.0, 4.0, 8.0}) dead_time.hold(u);
  EXPECT_EQ(dead_time.during(0.0, 0.25).mean(), 1.0) << "V: the delay ends at 0.3 of the tick";
  const auto held = dead_time.during(0.25, 0.5);
  EXPECT_EQ(held.first, 1.0);
  EXPECT_EQ(held.second, 2.0);
  EXPECT_NEAR(held.share, 0.2, 1e-12);
  EXPECT_EQ(dead_time.during(0.5, 0.75).mean(), 2.0);
  EXPECT_NEAR(dead_time.during(0.0, 1.0).mean(), 0.3 * 1.0 + 0.7 * 2.0, 1e-12) << "V: interpolated";
}

TEST(DeadTime, BeyondWhatIsRememberedItStaysAtTheLongestDelay) {
  DeadTime<double> dead_time = dead_time_of(500.0);
  for (int k = 0; k < 100; ++k) dead_time.hold(static_cast<double>(k));
  EXPECT_EQ(dead_time.during(0.0, 1.0).mean(), 99.0 - 31.0);
}

/// x in each thousandth of each tick.
std::vector<double> traced_V(DeadTime<double> dead_time, const std::vector<double>& command_V) {
  constexpr int kParts = 1000;
  std::vector<double> traced;
  for (const double u : command_V) {
    dead_time.hold(u);
    for (int i = 0; i < kParts; ++i) {
      traced.push_back(dead_time.during(i / double{kParts}, (i + 1) / double{kParts}).mean());
    }
  }
  return traced;
}

struct Edges {
  double rise_tick, fall_tick;
};
/// Of a command that rises over 6.5 V and falls again.
Edges edges_of(const std::vector<double>& x) {
  const auto rise = std::find_if(x.begin(), x.end(), [](double u) { return u > 6.5; });
  const auto fall = std::find_if(rise, x.end(), [](double u) { return u < 6.5; });
  return {static_cast<double>(rise - x.begin()) / 1000.0, static_cast<double>(fall - x.begin()) / 1000.0};
}

TEST(DeadTime, ThatIsUnevenLetsARiseActLaterThanAFall) {
  std::vector<double> command_V(12, 5.0);
  std::fill(command_V.begin() + 2, command_V.begin() + 7, 8.0);
  for (const double a : {0.3, -0.3}) {
    const Edges x = edges_of(traced_V(dead_time_of(2.0, a), command_V));
    EXPECT_NEAR(x.rise_tick, 2.0 + 2.0 * (1.0 + a), 2e-3) << "tick, a " << a;
    EXPECT_NEAR(x.fall_tick, 7.0 + 2.0 * (1.0 - a), 2e-3) << "tick, a " << a;
  }
}

TEST(DeadTime, ThatIsUnevenKeepsItsRatioBeyondWhatIsRemembered) {
  std::vector<double> command_V(100, 5.0);
  std::fill(command_V.begin() + 10, command_V.begin() + 60, 8.0);
  const Edges x = edges_of(traced_V(dead_time_of(50.0, 0.6), command_V));
  EXPECT_NEAR(x.rise_tick, 10.0 + 31.0, 2e-3) << "tick: the longest that is known";
  EXPECT_NEAR(x.fall_tick, 60.0 + 31.0 * 0.4 / 1.6, 2e-3) << "tick";
}

TEST(DeadTime, ThatIsUnevenDoesNotSeeWhatIsTakenBackBeforeItActs) {
  std::vector<double> command_V(12, 5.0);
  command_V[3] = 8.0;  // a tick, where a rise is 1.2 ticks later than a fall
  EXPECT_THAT(traced_V(dead_time_of(2.0, 0.3), command_V), testing::Each(5.0));
  const std::vector<double> longer = traced_V(dead_time_of(2.0, -0.3), command_V);
  EXPECT_NEAR(std::accumulate(longer.begin(), longer.end(), 0.0) / 1000.0, 12 * 5.0 + 3.0 * 2.2, 1e-2)
      << "V tick";
}

TEST(DeadTime, ThatIsUnevenMirrorsWithItsCommandAndIsPlainAtZero) {
  const std::vector<double> command_V = jumping_command_V(60);
  std::vector<double> mirrored_V;
  for (const double u : command_V) mirrored_V.push_back(10.0 - u);
  const std::vector<double> one = traced_V(dead_time_of(1.7, 0.4), command_V);
  const std::vector<double> other = traced_V(dead_time_of(1.7, -0.4), mirrored_V);
  for (std::size_t i = 0; i < one.size(); ++i) ASSERT_NEAR(one[i], 10.0 - other[i], 1e-12);
  const std::vector<double> plain = traced_V(dead_time_of(1.7), command_V);
  const std::vector<double> nearly = traced_V(dead_time_of(1.7, 1e-9), command_V);
  for (std::size_t i = 0; i < plain.size(); ++i) ASSERT_NEAR(plain[i], nearly[i], 1e-4);
}

TEST(DeadTime, ThatIsUnevenHasOverAStepTheMeanOfItsParts) {
  DeadTime<double> dead_time = dead_time_of(2.3, 0.25);
  DeadTime<double> finely = dead_time;
  const std::vector<double> command_V = jumping_command_V(200);
  for (const double u : command_V) {
    dead_time.hold(u);
    finely.hold(u);
    for (int i = 0; i < 4; ++i) {
      double sum = 0.0;
      for (int k = 0; k < 100; ++k) {
        sum += finely.during(0.25 * i + 0.0025 * k, 0.25 * i + 0.0025 * (k + 1)).mean() / 100.0;
      }
      ASSERT_NEAR(dead_time.during(0.25 * i, 0.25 * (i + 1)).mean(), sum, 1e-9) << "V";
    }
  }
}

TEST(DeadTime, ChamberAgreesWithThePlantThatIsFedLate) {
  const std::vector<double> command_V = jumping_command_V(1500);
  for (const double delay_s : {0.0005, 0.002, 0.0063, 0.01}) {
    plant::ChamberConfig config;
    config.initial_pressure_Pa = 3e5;
    config.initial_command_V = command_V.front();
    config.tolerance_Pa = 0.02;
    plant::ChamberPlant plant(plant::ThinPlateValve({}), config, swinging_volume());
    std::vector<double> truth_Pa{3e5};
    for (std::size_t k = 0; k + 1 < command_V.size(); ++k) {
      double area = delay_s * plant.advance(command_V[k == 0 ? 0 : k - 1], delay_s).mean_Pa;
      const double rest_s = kTick_s - delay_s;
      if (rest_s > 1e-12) area += rest_s * plant.advance(command_V[k], rest_s).mean_Pa;
      truth_Pa.push_back(area / kTick_s);
    }
    const Figures figures = with(nominal(), kIdDeadTime, {delay_s});
    const auto error_Pa = [&](int steps) {
      return rms_difference(
          run(only(kIdDeadTime), figures, drive_of(command_V, swinging_volume(), steps), 3e5), truth_Pa);
    };
    EXPECT_LT(error_Pa(4), 40.0) << "Pa RMS, delay " << delay_s << " s";
    EXPECT_LT(error_Pa(16), 4.0) << "Pa RMS, delay " << delay_s << " s";
  }
}

}  // namespace
}  // namespace plenum::host::effects
