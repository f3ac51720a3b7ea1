#include "host-sim/plant/relief_valve/grey_box.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace {

using namespace plenum::host::plant::relief_valve;

// A valve that cracks at 5 MPa and stays below 9 MPa.
const StaticGreyBox kStatic{
    .k1_m2_Pa = 1e-12, .k2_s_m_sqrtPa = 2.3e-6, .k3_m2 = -5e-6, .density_kg_m3 = 865.0};
const GreyBoxConfig kDynamic{.k1_m2_Pa = 1e-12, .k3_m2 = -5e-6, .lag_s = 0.02, .density_kg_m3 = 865.0};

TEST(StaticGreyBox, PassesNothingUpToItsCrackingPressureAndSomethingBeyond) {
  const double cracks_Pa = cracking_pressure_Pa(kStatic);
  EXPECT_DOUBLE_EQ(cracks_Pa, 5e6);
  EXPECT_EQ(flow_m3_s(kStatic, 0.5 * cracks_Pa), 0.0);
  EXPECT_EQ(flow_m3_s(kStatic, cracks_Pa), 0.0);
  EXPECT_GT(flow_m3_s(kStatic, 1.001 * cracks_Pa), 0.0);
}

TEST(StaticGreyBox, FlowGrowsWithoutBoundTowardTheMaximumPressure) {
  const double maximum_Pa = maximum_pressure_Pa(kStatic);
  EXPECT_NEAR(maximum_Pa, std::sqrt(865.0 / 2.0) / 2.3e-6, 1.0);
  double before = 0.0;
  for (const double gap : {1e-1, 1e-2, 1e-3, 1e-4}) {
    const double flow = flow_m3_s(kStatic, maximum_Pa * (1.0 - gap));
    EXPECT_GT(flow, 5.0 * before) << gap;
    before = flow;
  }
  EXPECT_THROW(flow_m3_s(kStatic, maximum_Pa), std::invalid_argument);
}

TEST(StaticGreyBox, PressureInvertsFlowAndSatisfiesTheForceBalance) {
  for (const double flow : {1e-6, 1e-4, 1e-3, 1e-2}) {
    const double P = pressure_Pa(kStatic, flow);
    EXPECT_NEAR(flow_m3_s(kStatic, P), flow, 1e-9 * flow);
    const double a = opening_m2(flow, P, 865.0);
    EXPECT_NEAR(kStatic.k1_m2_Pa * P + kStatic.k2_s_m_sqrtPa * flow * std::sqrt(P) + kStatic.k3_m2, a,
                1e-9 * a)
        << flow;
  }
}

TEST(GreyBox, PublishedRatesAreEachOthersInverse) {
  for (const double flow_rate : {-0.01, 0.0, 0.02}) {
    const double P_rate = pressure_rate_Pa_s(kDynamic, 6e6, 1e-4, flow_rate);
    EXPECT_NEAR(flow_rate_m3_s2(kDynamic, 6e6, 1e-4, P_rate), flow_rate, 1e-12);
  }
}

TEST(GreyBox, PublishedRatesVanishOnTheStaticLine) {
  const double P = 6e6;
  const double Q = (1e-12 * P - 5e-6) * std::sqrt(2.0 * P / 865.0);
  EXPECT_NEAR(pressure_rate_Pa_s(kDynamic, P, Q, 0.0), 0.0, 1e-3);
  EXPECT_GT(pressure_rate_Pa_s(kDynamic, P, 1.01 * Q, 0.0), 1e3);
}

// The published form (3.16), whose input is the flow's derivative, by Runge-Kutta with fine steps.
double pressure_by_published_rate(double P, double Q, double Q_rate, double duration_s) {
  constexpr int kSteps = 400000;
  const double h = duration_s / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    const auto f = [&](double p, double t) {
      return pressure_rate_Pa_s(kDynamic, p, Q + Q_rate * t, Q_rate);
    };
    const double k1 = f(P, 0.0);
    const double k2 = f(P + 0.5 * h * k1, 0.5 * h);
    const double k3 = f(P + 0.5 * h * k2, 0.5 * h);
    const double k4 = f(P + h * k3, h);
    P += h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
    Q += h * Q_rate;
  }
  return P;
}

TEST(GreyBox, OpeningAsTheStateGivesThePublishedPressure) {
  const double P0 = 6e6;
  GreyBoxValve valve(kDynamic, P0);
  const double Q0 = valve.flow_m3_s(P0);
  const double Q1 = 1.5 * Q0;
  constexpr double kDuration_s = 0.01;
  constexpr int kSteps = 4000;
  for (int i = 0; i < kSteps; ++i)
    valve.drive_flow(Q0 + (Q1 - Q0) * i / kSteps, Q0 + (Q1 - Q0) * (i + 1) / kSteps, kDuration_s / kSteps);
  const double published = pressure_by_published_rate(P0, Q0, (Q1 - Q0) / kDuration_s, kDuration_s);
  EXPECT_NEAR(valve.pressure_Pa(Q1), published, 1e-6 * published);
  EXPECT_GT(published, 1.05 * pressure_Pa(StaticGreyBox{1e-12, 0.0, -5e-6, 865.0}, Q1))
      << "Pa: no transient, nothing shown";
}

TEST(GreyBox, UnderConstantPressureTheOpeningDecaysExponentially) {
  GreyBoxValve valve(kDynamic, 6e6);
  const double from = valve.opening_m2();
  const double to = 1e-12 * 8e6 - 5e-6;
  valve.drive_pressure(8e6, 8e6, 0.03);
  EXPECT_NEAR(valve.opening_m2(), to + (from - to) * std::exp(-0.03 / 0.02), 1e-18);
}

TEST(GreyBox, PressureDrivenDoesNotDependOnTheTimeStep) {
  // Opening, shutting and a dip that shuts and opens again within the interval.
  struct Case {
    double start_Pa, from_Pa, to_Pa, duration_s;
  };
  for (const Case& c : {Case{6e6, 6e6, 8e6, 0.05}, Case{2e6, 2e6, 8e6, 0.01}, Case{8e6, 8e6, 1e6, 0.05},
                        Case{5.2e6, 1e6, 7e6, 0.05}, Case{5.05e6, 0.0, 30e6, 0.02}}) {
    GreyBoxValve whole(kDynamic, c.start_Pa);
    GreyBoxValve parts(kDynamic, c.start_Pa);
    whole.drive_pressure(c.from_Pa, c.to_Pa, c.duration_s);
    constexpr int kParts = 37;
    for (int i = 0; i < kParts; ++i) {
      parts.drive_pressure(c.from_Pa + (c.to_Pa - c.from_Pa) * i / kParts,
                           c.from_Pa + (c.to_Pa - c.from_Pa) * (i + 1) / kParts, c.duration_s / kParts);
    }
    EXPECT_NEAR(whole.opening_m2(), parts.opening_m2(), 1e-18)
        << "m2, from " << c.from_Pa << " to " << c.to_Pa << " Pa";
  }
}

TEST(GreyBox, StaysShutBelowItsCrackingPressure) {
  GreyBoxValve valve(kDynamic, 1e6);
  valve.drive_pressure(1e6, 4.9e6, 0.1);
  EXPECT_EQ(valve.opening_m2(), 0.0);
  valve.drive_pressure(4.9e6, 5.1e6, 0.1);
  EXPECT_GT(valve.opening_m2(), 0.0);
}

TEST(GreyBox, FlowDrivenUndoesPressureDriven) {
  constexpr double kStep_s = 1e-5;
  const auto pressure = [](double t) { return 6.5e6 + 5e5 * std::sin(200.0 * t); };
  for (const Damping damping : {Damping::kConstant, Damping::kOverPressure}) {
    GreyBoxConfig config = kDynamic;
    config.damping = damping;
    config.lag_pressure_Pa = 7e6;
    GreyBoxValve driven(config, pressure(0.0));
    GreyBoxValve back(config, pressure(0.0));
    double flow = driven.flow_m3_s(pressure(0.0));
    for (int k = 1; k <= 3000; ++k) {
      driven.drive_pressure(pressure(kStep_s * (k - 1)), pressure(kStep_s * k), kStep_s);
      const double next = driven.flow_m3_s(pressure(kStep_s * k));
      back.drive_flow(flow, next, kStep_s);
      flow = next;
      ASSERT_NEAR(back.pressure_Pa(flow), pressure(kStep_s * k), 2e3) << "Pa at " << kStep_s * k << " s";
    }
  }
}

TEST(GreyBox, FlowDrivenConvergesWithTheSquareOfTheStep) {
  const auto end = [](int steps) {
    GreyBoxValve valve(kDynamic, 6e6);
    const double Q = valve.flow_m3_s(6e6);
    for (int i = 0; i < steps; ++i)
      valve.drive_flow(Q * (1.0 + 0.5 * i / steps), Q * (1.0 + 0.5 * (i + 1) / steps), 0.02 / steps);
    return valve.opening_m2();
  };
  const double fine = end(20000);
  EXPECT_NEAR(std::abs(end(50) - fine) / std::abs(end(100) - fine), 4.0, 0.5);
}

TEST(GreyBox, LagOverPressureHalvesWherePressureDoubles) {
  GreyBoxConfig over = kDynamic;
  over.damping = Damping::kOverPressure;
  over.lag_pressure_Pa = 4e6;
  GreyBoxConfig half = kDynamic;
  half.lag_s = 0.5 * kDynamic.lag_s;
  GreyBoxValve a(over, 6e6);
  GreyBoxValve b(half, 6e6);
  a.drive_pressure(8e6, 8e6, 0.01);
  b.drive_pressure(8e6, 8e6, 0.01);
  EXPECT_NEAR(a.opening_m2(), b.opening_m2(), 1e-18);
}

TEST(GreyBox, WithoutLagItIsItsStaticLine) {
  GreyBoxConfig config = kDynamic;
  config.lag_s = 0.0;
  GreyBoxValve valve(config, 6e6);
  valve.drive_pressure(6e6, 7e6, 1e-3);
  EXPECT_DOUBLE_EQ(valve.opening_m2(), 1e-12 * 7e6 - 5e-6);
  valve.drive_flow(1e-4, 2e-4, 1e-3);
  EXPECT_NEAR(valve.pressure_Pa(2e-4), pressure_Pa(StaticGreyBox{1e-12, 0.0, -5e-6, 865.0}, 2e-4), 1.0);
}

TEST(GreyBox, RefusesWhatIsNoValveNamingTheField) {
  const auto message = [](const auto& attempt) -> std::string {
    try {
      attempt();
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "nothing thrown";
  };
  GreyBoxConfig config = kDynamic;
  config.lag_s = -1.0;
  EXPECT_NE(message([&] { GreyBoxValve(config, 6e6); }).find("lag_s: -1"), std::string::npos);
  config = kDynamic;
  config.k1_m2_Pa = 0.0;
  EXPECT_NE(message([&] { GreyBoxValve(config, 6e6); }).find("k1_m2_Pa: 0"), std::string::npos);
  GreyBoxValve valve(kDynamic, 6e6);
  EXPECT_NE(message([&] { valve.drive_flow(1e-4, 0.0, 1e-3); }).find("to_m3_s: 0"), std::string::npos);
  EXPECT_NE(message([&] { valve.drive_pressure(6e6, 6e6, 0.0); }).find("duration_s: 0"), std::string::npos);
  EXPECT_NE(
      message([&] { pressure_Pa(kStatic, std::numeric_limits<double>::quiet_NaN()); }).find("flow_m3_s: nan"),
      std::string::npos);
}

}  // namespace
