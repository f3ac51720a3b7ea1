#include "host-sim/identify/relief_valve/static_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/plant/random.hpp"

namespace {

using namespace plenum::host::identify;
using namespace plenum::host::identify::relief_valve;
using plenum::host::plant::relief_valve::StaticGreyBox;

const StaticGreyBox kTruth{
    .k1_m2_Pa = 1.2e-12, .k2_s_m_sqrtPa = 2e-6, .k3_m2 = -2.3e-6, .density_kg_m3 = 865.0};

std::vector<StaticPoint> curve(const StaticGreyBox& valve, int points) {
  std::vector<StaticPoint> found;
  for (int i = 1; i <= points; ++i) {
    const double flow = 2e-3 * i / points;
    found.push_back({plenum::host::plant::relief_valve::pressure_Pa(valve, flow), flow});
  }
  return found;
}

std::string reason(const auto& attempt) {
  try {
    attempt();
  } catch (const CannotIdentify& error) {
    return error.what();
  }
  return "nothing thrown";
}

TEST(StaticFit, RecoversTheCurveThatMadeThePoints) {
  for (const int points : {3, 5, 40}) {  // three: the simultaneous equations of the source
    const StaticGreyBox found = fit_static(curve(kTruth, points), 865.0);
    EXPECT_NEAR(found.k1_m2_Pa, kTruth.k1_m2_Pa, 1e-6 * kTruth.k1_m2_Pa);
    EXPECT_NEAR(found.k2_s_m_sqrtPa, kTruth.k2_s_m_sqrtPa, 1e-6 * kTruth.k2_s_m_sqrtPa);
    EXPECT_NEAR(found.k3_m2, kTruth.k3_m2, 1e-6 * -kTruth.k3_m2);
  }
}

TEST(StaticFit, LineWithoutFlowForceIsRecoveredToo) {
  StaticGreyBox line = kTruth;
  line.k2_s_m_sqrtPa = 0.0;
  const StaticGreyBox found = fit_static(curve(line, 10), 865.0, FlowForce::kLeftOut);
  EXPECT_NEAR(found.k1_m2_Pa, line.k1_m2_Pa, 1e-9 * line.k1_m2_Pa);
  EXPECT_EQ(found.k2_s_m_sqrtPa, 0.0);
}

// Flow such that the opening errs by white noise at exact pressures, which is what the error speaks of.
TEST(StaticFit, StandardErrorIsTheScatterOfManyCurves) {
  constexpr int kCurves = 400;  // tells a deviation to 4 %
  StaticGreyBox line = kTruth;
  line.k2_s_m_sqrtPa = 0.0;
  const std::vector<StaticPoint> exact = curve(line, 30);
  plenum::host::plant::Random random(5);
  std::vector<double> k1;
  std::vector<double> cracking;
  double told_k1 = 0.0;
  double told_cracking = 0.0;
  double told_k2 = 0.0;
  for (int i = 0; i < kCurves; ++i) {
    std::vector<StaticPoint> points = exact;
    for (auto& [P, Q] : points) Q += 1e-8 * random.gaussian() / std::sqrt(865.0 / (2.0 * P));
    const StaticGreyBox found = fit_static(points, 865.0, FlowForce::kLeftOut);
    k1.push_back(found.k1_m2_Pa);
    cracking.push_back(cracking_pressure_Pa(found));
    const StaticError told = static_error(found, points, FlowForce::kLeftOut);
    told_k1 += told.k1_m2_Pa / kCurves;
    told_cracking += told.cracking_Pa / kCurves;
    told_k2 += told.k2_s_m_sqrtPa;
  }
  const auto scatter = [](const std::vector<double>& of) {
    double mean = 0.0;
    for (const double x : of) mean += x / kCurves;
    double squares = 0.0;
    for (const double x : of) squares += (x - mean) * (x - mean);
    return std::sqrt(squares / (kCurves - 1));
  };
  EXPECT_NEAR(told_k1 / scatter(k1), 1.0, 0.15);
  EXPECT_NEAR(told_cracking / scatter(cracking), 1.0, 0.15);
  EXPECT_EQ(told_k2, 0.0);
}

TEST(StaticFit, ExactCurveHasNoErrorAndTooFewPointsHaveNone) {
  const StaticGreyBox found = fit_static(curve(kTruth, 20), 865.0);
  const StaticError told = static_error(found, curve(kTruth, 20));
  EXPECT_LT(told.cracking_Pa, 1e-5 * cracking_pressure_Pa(kTruth));
  EXPECT_LT(told.maximum_Pa, 1e-5 * maximum_pressure_Pa(kTruth));
  EXPECT_NE(reason([&] { static_error(found, curve(kTruth, 3)); }).find("3 points for 3 parameters"),
            std::string::npos);
}

TEST(StaticFit, ResidualIsOrthogonalToTheColumns) {
  std::vector<StaticPoint> points = curve(kTruth, 9);
  for (std::size_t i = 0; i < points.size(); ++i)
    points[i].pressure_Pa *= 1.0 + 0.01 * std::sin(3.0 * static_cast<double>(i));
  const StaticGreyBox k = fit_static(points, 865.0);
  double by_P = 0, by_flow_force = 0, by_1 = 0, size_P = 0, size_flow_force = 0, size_1 = 0;
  for (const StaticPoint& point : points) {
    const double a = plenum::host::plant::relief_valve::opening_m2(point.flow_m3_s, point.pressure_Pa, 865.0);
    const double column = point.flow_m3_s * std::sqrt(point.pressure_Pa);
    const double e = a - k.k1_m2_Pa * point.pressure_Pa - k.k2_s_m_sqrtPa * column - k.k3_m2;
    by_P += e * point.pressure_Pa, size_P += std::abs(e * point.pressure_Pa);
    by_flow_force += e * column, size_flow_force += std::abs(e * column);
    by_1 += e, size_1 += std::abs(e);
  }
  EXPECT_LT(std::abs(by_P), 1e-6 * size_P);
  EXPECT_LT(std::abs(by_flow_force), 1e-6 * size_flow_force);
  EXPECT_LT(std::abs(by_1), 1e-6 * size_1);
}

TEST(StaticFit, ValveThatCracksAtNoPressureHasNoConstant) {
  // Openings that a line meets the axis of above 0: the bound is active, and no other valve with k3 <= 0 is
  // nearer.
  StaticGreyBox valve = kTruth;
  valve.k2_s_m_sqrtPa = 0.0;
  valve.k3_m2 = 0.0;
  std::vector<StaticPoint> points = curve(valve, 8);
  for (StaticPoint& point : points) point.flow_m3_s += 2e-4;
  const StaticGreyBox found = fit_static(points, 865.0, FlowForce::kLeftOut);
  EXPECT_EQ(found.k3_m2, 0.0);
  double gradient = 0.0;
  double size = 0.0;
  for (const StaticPoint& point : points) {
    const double a = plenum::host::plant::relief_valve::opening_m2(point.flow_m3_s, point.pressure_Pa, 865.0);
    gradient += (a - found.k1_m2_Pa * point.pressure_Pa) * point.pressure_Pa;
    size += a * point.pressure_Pa;
  }
  EXPECT_LT(std::abs(gradient), 1e-12 * size);
}

TEST(StaticFit, SaysWhyPointsDetermineNothing) {
  EXPECT_NE(reason([] { fit_static(curve(kTruth, 2), 865.0); }).find("2 points, expected at least 3"),
            std::string::npos);
  const std::vector<StaticPoint> same(5, curve(kTruth, 3)[1]);
  EXPECT_NE(reason([&] { fit_static(same, 865.0); }).find("determine 1 of 3"), std::string::npos);
  // An opening that falls as pressure rises is no relief valve.
  const std::vector<StaticPoint> falling{{5e6, 3e-3}, {6e6, 2e-3}, {7e6, 1e-3}};
  EXPECT_NE(reason([&] {
              fit_static(falling, 865.0, FlowForce::kLeftOut);
            }).find("opening falls as pressure rises"),
            std::string::npos);
  EXPECT_THROW(fit_static(std::vector<StaticPoint>(3, {-1.0, 1e-3}), 865.0), std::invalid_argument);
}

TEST(StaticFit, LineThroughTwoPointsMeetsBoth) {
  const StaticGreyBox line = static_through(6e6, {7e6, 1.7e-3}, 865.0);
  EXPECT_DOUBLE_EQ(cracking_pressure_Pa(line), 6e6);
  EXPECT_NEAR(flow_m3_s(line, 7e6), 1.7e-3, 1e-15);
  EXPECT_THROW(static_through(7e6, {7e6, 1.7e-3}, 865.0), std::invalid_argument);
}

TEST(WorstPressureError, KeepsWhatIsNoNumber) {
  std::vector<StaticPoint> points = curve(kTruth, 5);
  EXPECT_LT(worst_pressure_error(kTruth, points), 1e-9);
  points[1].pressure_Pa = std::nan("");
  EXPECT_TRUE(std::isnan(worst_pressure_error(kTruth, points)));
}

}  // namespace
