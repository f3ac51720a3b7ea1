#include "host-sim/plant/regulator_valve/valve.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace plenum::host::plant::regulator_valve {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kSample_s = 0.005;

void turn(Valve& valve, double screw_m, double turn_s, double rest_s) {
  const double from_m = valve.screw_m();
  const int turning = static_cast<int>(std::lround(turn_s / kSample_s));
  for (int k = 1; k <= turning; ++k) valve.advance(from_m + (screw_m - from_m) * k / turning, kSample_s);
  valve.advance(screw_m, rest_s);
}

double gauge_Pa(const Valve& valve) {
  return valve.state().pressure_Pa - 1e5;
}

TEST(RegulatorValvePorts, FlowIsThatOfTheBlockedNozzleInTheBlockedRange) {
  const ValveConfig config = bench_valve();
  const Ports ports(config);
  const double k_a = std::sqrt(1.4 / (287.04 * 298.0) * std::pow(2.0 / 2.4, 6.0));
  const double d = overlap_m(config);
  for (double p = 1.9e5; p < 4.22e5; p += 1.1e4) {
    EXPECT_NEAR(ports.inlet_kg_s(d + 1e-4, p) / (config.inlet_width_m * 1e-4 * k_a * 8e5), 1.0, 1e-12)
        << p << " Pa";
    EXPECT_NEAR(ports.exhaust_kg_s(-1e-4, p) / (config.exhaust_width_m * 1e-4 * k_a * p), 1.0, 1e-12)
        << p << " Pa";
  }
}

TEST(RegulatorValvePorts, FlowFallsToNothingBeyondTheBlockedRange) {
  const ValveConfig config = bench_valve();
  const Ports ports(config);
  const double open = overlap_m(config) + 1e-4;
  double last = ports.inlet_kg_s(open, 4.22e5);
  for (double p = 4.3e5; p <= 8e5; p += 1e4) {
    const double flow = ports.inlet_kg_s(open, p);
    EXPECT_LT(flow, last) << p;
    last = flow;
  }
  EXPECT_EQ(last, 0.0);
  EXPECT_EQ(ports.exhaust_kg_s(-1e-4, 1e5), 0.0);
}

TEST(RegulatorValvePorts, NeverBothOpenAndBothShutWithinTheOverlap) {
  const ValveConfig config = bench_valve();
  const Ports ports(config);
  const double d = overlap_m(config);
  for (double x = -1e-3; x < 1e-3; x += 1e-5) {
    EXPECT_EQ(ports.inlet_kg_s(x, 3e5) > 0.0, x > d) << x;
    EXPECT_EQ(ports.exhaust_kg_s(x, 3e5) > 0.0, x < 0.0) << x;
  }
}

TEST(RegulatorValve, SettlesWhereTheForcesBalanceOnEitherSideOfTheDeadBand) {
  const ValveConfig config = bench_valve();
  Valve valve(config, 0.0, 1e5);
  const double slope = config.plunger_spring_N_m / config.diaphragm_area_m2;  // (26)
  for (double screw_m : {1.15e-3, 1.9e-3, 2.8e-3}) {
    turn(valve, screw_m, 0.2, 6.0);
    EXPECT_NEAR(gauge_Pa(valve), slope * (screw_m - 0.9e-3), 0.5) << screw_m;
    EXPECT_NEAR(valve.state().plunger_m, overlap_m(config), 1e-11) << screw_m;
  }
  for (double screw_m : {1.7e-3, 1.1e-3, 0.7e-3}) {
    turn(valve, screw_m, 0.2, 15.0);
    EXPECT_NEAR(gauge_Pa(valve), slope * screw_m, 0.5) << screw_m;
    EXPECT_NEAR(valve.state().plunger_m, 0.0, 1e-11) << screw_m;
  }
}

TEST(RegulatorValve, NothingHappensOverTheFirstDeadBand) {
  Valve valve(bench_valve(), 0.0, 1e5);
  turn(valve, 0.89e-3, 0.2, 3.0);
  EXPECT_EQ(valve.state().pressure_Pa, 1e5);
  turn(valve, 0.95e-3, 0.2, 3.0);
  EXPECT_GT(gauge_Pa(valve), 7000.0);
}

TEST(RegulatorValve, PressureStaysWhileTheScrewTurnsBackThroughTheDeadBand) {
  Valve valve(bench_valve(), 0.0, 1e5);
  turn(valve, 2.4e-3, 0.2, 6.0);
  const double before = valve.state().pressure_Pa;
  turn(valve, 1.55e-3, 0.5, 3.0);
  EXPECT_NEAR(valve.state().pressure_Pa, before, 0.5);
  turn(valve, 1.4e-3, 0.2, 3.0);
  EXPECT_LT(valve.state().pressure_Pa, before - 10e3);
}

TEST(RegulatorValve, WithoutADeadBandItRisesAndFallsOnOneLine) {
  ValveConfig config = bench_valve();
  config.dead_band_m = 0.0;
  Valve valve(config, 0.0, 1e5);
  turn(valve, 1.2e-3, 0.2, 6.0);
  const double risen = gauge_Pa(valve);
  turn(valve, 1.8e-3, 0.2, 6.0);
  turn(valve, 1.2e-3, 0.2, 15.0);
  EXPECT_NEAR(gauge_Pa(valve), risen, 0.5);
  EXPECT_NEAR(risen, 1.56e8 * 1.2e-3, 0.5);
}

TEST(RegulatorValve, MassIsConservedWhilePlungerAndSpoolMeetAndPart) {
  const ValveConfig config = bench_valve();
  Valve valve(config, 0.0, 1e5);
  const double filling = 1.4 * 287.04 * 298.0 / config.volume_m3;
  for (const double screw_m : {2.2e-3, 0.9e-3, 3.0e-3, 0.0, 1.6e-3}) {
    turn(valve, screw_m, 0.1, 1.0);
    const ValveState& s = valve.state();
    EXPECT_NEAR(s.pressure_Pa - 1e5, filling * (s.supplied_kg - s.vented_kg), 1e-6) << screw_m;
  }
  EXPECT_GT(valve.state().vented_kg, 0.0);
}

// Near equal pressures a wide port is the fastest part of all.
TEST(RegulatorValve, PortsAHundredTimesWiderEmptyAndFillItWithoutRinging) {
  ValveConfig config = bench_valve();
  config.inlet_width_m *= 100.0;
  config.exhaust_width_m *= 100.0;
  config.dead_band_m = 0.0;
  Valve valve(config, 0.0, 1.5e5);
  double last = 1.5e5;
  for (int k = 0; k < 200; ++k) {
    valve.advance(-1e-3, 0.001);
    EXPECT_LE(valve.state().pressure_Pa, last) << k << " ms";
    last = valve.state().pressure_Pa;
  }
  EXPECT_NEAR(last, 1e5, 1e-3);
  for (int k = 0; k < 200; ++k) {
    valve.advance(6e-3, 0.001);
    EXPECT_GE(valve.state().pressure_Pa, last - 1e-6) << k << " ms";
    last = valve.state().pressure_Pa;
  }
  EXPECT_NEAR(last, 8e5, 1e-3);
}

TEST(RegulatorValve, ConditionsPartWhereTheSpoolIsOnItsStop) {
  Valve valve(bench_valve(), 0.0, 1e5);
  turn(valve, 2.4e-3, 0.2, 1.0);
  for (int k = 0; k < 400; ++k) {
    valve.advance(k < 40 ? 2.4e-3 - 1.8e-3 * k / 40.0 : 0.6e-3, kSample_s);
    if (valve.state().plunger_m != 0.0) {
      EXPECT_EQ(valve.joined(), valve.state().plunger_m > 0.0) << k;
    }
  }
  EXPECT_FALSE(valve.joined());
}

TEST(RegulatorValve, APlungerThatMeetsTheSpoolSharesItsMomentum) {
  const ValveConfig config = bench_valve();
  Valve valve(config, 1.0e-3, 1e5 + 1.56e8 * 1.3e-3);  // exhausting, 0.3 mm off the spool
  ASSERT_FALSE(valve.joined());
  valve.advance(3.0e-3, 1e-9);
  double before_m_s = 0.0;
  while (!valve.joined()) {
    before_m_s = valve.state().plunger_m_s;
    valve.advance(3.0e-3, 1e-7);
  }
  ASSERT_GT(before_m_s, 0.1);
  EXPECT_NEAR(valve.state().plunger_m_s / before_m_s, 17.30 / (17.30 + 16.77), 1e-3);
}

TEST(RegulatorValve, TheSpoolThatStopsLeavesThePlungerItsVelocity) {
  Valve valve(bench_valve(), 3.0e-3, 1e5 + 1.56e8 * 2.1e-3);
  ASSERT_TRUE(valve.joined());
  valve.advance(0.5e-3, 1e-9);
  double before_m_s = 0.0;
  while (valve.joined()) {
    before_m_s = valve.state().plunger_m_s;
    valve.advance(0.5e-3, 1e-7);
  }
  ASSERT_LT(before_m_s, -0.1);
  EXPECT_NEAR(valve.state().plunger_m_s / before_m_s, 1.0, 1e-3);
}

TEST(RegulatorValve, ThePlungerAtRestHasNoForceLeft) {
  const ValveConfig c = bench_valve();
  for (double screw_m : {0.0, 0.4e-3, 1.3e-3, 2.9e-3}) {
    for (double p = 1e5; p < 8e5; p += 0.9e5) {
      const double x = plunger_at_rest_m(c, screw_m, p);
      const double k = c.plunger_spring_N_m + (x > 0.0 ? c.spool_spring_N_m : 0.0);
      EXPECT_NEAR(c.plunger_spring_N_m * screw_m - k * x, c.diaphragm_area_m2 * (p - 1e5), 1e-12);
    }
  }
}

TEST(RegulatorValve, RefusesWhatCannotBeAndNamesIt) {
  EXPECT_THAT([] { Valve(bench_valve(), 0.0, 9e5); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("pressure_Pa: 900000")));
  EXPECT_THAT([] { Valve(bench_valve(), std::numeric_limits<double>::quiet_NaN(), 1e5); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("screw_m")));
  Valve valve(bench_valve(), 0.0, 1e5);
  EXPECT_THAT([&] { valve.advance(1e-3, 0.0); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("duration_s")));
  EXPECT_THAT([&] { valve.advance(std::numeric_limits<double>::infinity(), 0.1); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("screw_m")));
}

}  // namespace
}  // namespace plenum::host::plant::regulator_valve
