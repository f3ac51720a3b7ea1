#include "host-sim/identify/orifice/fit_orifice.hpp"

#include <ceres/ceres.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "host-sim/identify/orifice/filter.hpp"
#include "tests/identify/orifice/vessel_scene.hpp"

namespace plenum::host::identify::orifice {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

const plant::EllipsePort kMedium{4.0, 0.3, 0.97, 0.7};

Vessel vessel(Flow flow) {
  return {.volume_m3 = 0.4e-3,
          .flow_exponent = flow == Flow::kCharge ? 1.4 : 1.0,
          .discharge_coefficient = 0.575};
}

TEST(FitOrifice, RecoversTheOrificeOfANoiseFreeRecordInBothDirections) {
  for (const Flow flow : {Flow::kCharge, Flow::kDischarge}) {
    const OrificeFit fit = fit_orifice(record_of(kMedium, flow, 1500, 1e-3), vessel(flow));
    EXPECT_NEAR(fit.choked_rate_1_s.value, 4.0, 4e-4);
    EXPECT_NEAR(fit.critical_ratio.value, 0.3, 1e-3);
    EXPECT_NEAR(fit.cracking_ratio.value, 0.97, 1e-4);
    EXPECT_NEAR(fit.subsonic_index.value, 0.7, 1e-3);
    EXPECT_NEAR(fit.area_m2->value * choked_rate_of_area_1_s_m2(vessel(flow)).value(),
                fit.choked_rate_1_s.value, 1e-12);
    EXPECT_TRUE(fit.critical_ratio.identified && fit.cracking_ratio.identified &&
                fit.subsonic_index.identified);
  }
}

TEST(FitOrifice, RecoversAnyPortWithinTheBoundsThatTheRecordShows) {
  plant::Random random(7);
  for (int i = 0; i < 60; ++i) {
    const Flow flow = i % 2 == 0 ? Flow::kCharge : Flow::kDischarge;
    const plant::EllipsePort port{std::exp(random.uniform(-3.0, 2.0)), random.uniform(0.15, 0.5),
                                  random.uniform(0.8, 1.0), random.uniform(0.45, 0.95)};
    const VesselRecord record = record_of(port, flow, 800, 8.0 / 800.0 / port.choked_kg_s_Pa);
    const OrificeFit fit = fit_orifice(record, vessel(flow));
    const std::string which = "port " + std::to_string(i) + ": b " + std::to_string(port.critical_ratio) +
                              ", a " + std::to_string(port.cracking_ratio) + ", beta " +
                              std::to_string(port.subsonic_index);
    EXPECT_NEAR(fit.choked_rate_1_s.value / port.choked_kg_s_Pa, 1.0, 1e-3) << which;
    EXPECT_NEAR(fit.critical_ratio.value, port.critical_ratio, 0.005) << which;
    EXPECT_NEAR(fit.cracking_ratio.value, port.cracking_ratio, 0.001) << which;
    EXPECT_NEAR(fit.subsonic_index.value, port.subsonic_index, 0.01) << which;
  }
}

TEST(FitOrifice, RateFitRecoversASlowChargeToo) {
  const plant::EllipsePort slow{0.2, 0.3, 1.0, 0.7};
  const OrificeFit fit =
      fit_orifice(record_of(slow, Flow::kCharge, 4000, 5e-3), vessel(Flow::kCharge), {.pressure_fit = false});
  EXPECT_NEAR(fit.choked_rate_1_s.value, 0.2, 1e-4);
  EXPECT_NEAR(fit.critical_ratio.value, 0.3, 2e-3);
  EXPECT_NEAR(fit.subsonic_index.value, 0.7, 2e-3);
}

// The scatter over 100 noises is the standard error that each fit states, and the truth lies within it.
TEST(FitOrifice, StandardErrorsOfThePressureFitAreTheScatterOverNoises) {
  constexpr int kNoises = 100;
  double scatter[4] = {};
  double stated[4] = {};
  double mean[4] = {};
  const double truth[4] = {4.0, 0.3, 0.97, 0.7};
  for (int seed = 1; seed <= kNoises; ++seed) {
    const OrificeFit fit =
        fit_orifice(record_of(kMedium, Flow::kCharge, 800, 1e-3, 300.0, static_cast<std::uint64_t>(seed)),
                    vessel(Flow::kCharge));
    const OrificeParameter parameters[4] = {fit.choked_rate_1_s, fit.critical_ratio, fit.cracking_ratio,
                                            fit.subsonic_index};
    for (int i = 0; i < 4; ++i) {
      scatter[i] += std::pow(parameters[i].value - truth[i], 2.0) / kNoises;
      stated[i] += parameters[i].standard_error / kNoises;
      mean[i] += (parameters[i].value - truth[i]) / kNoises;
    }
  }
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(std::sqrt(scatter[i]) / stated[i], 1.0, 0.25) << "parameter " << i;  // 3.5 sigma of 100 draws
    EXPECT_LT(std::abs(mean[i]), 0.4 * stated[i]) << "parameter " << i;
  }
}

TEST(FitOrifice, PressureFitIsFreeOfTheBiasThatTheMovingAverageGivesAFastCharge) {
  const plant::EllipsePort fast{16.0, 0.528, 1.0, 0.418};
  const VesselRecord record = record_of(fast, Flow::kCharge, 500, 1e-3);
  const OrificeFit rate = fit_orifice(record, vessel(Flow::kCharge), {.pressure_fit = false});
  const OrificeFit pressure = fit_orifice(record, vessel(Flow::kCharge));
  EXPECT_GT(rate.subsonic_index.value - 0.418, 0.03);
  EXPECT_NEAR(pressure.subsonic_index.value, 0.418, 0.002);
}

TEST(FitOrifice, ScalesWithTimeAndPressureAsTheEquationsDo) {
  const VesselRecord record = record_of(kMedium, Flow::kCharge, 800, 1e-3, 300.0);
  VesselRecord slower = record;
  for (double& t : slower.time_s) t *= 10.0;
  for (double& p : slower.vessel_Pa) p *= 0.5;
  for (double& p : slower.far_Pa) p *= 0.5;
  const OrificeFit one = fit_orifice(record, vessel(Flow::kCharge));
  const OrificeFit other = fit_orifice(slower, vessel(Flow::kCharge));
  EXPECT_NEAR(other.choked_rate_1_s.value * 10.0 / one.choked_rate_1_s.value, 1.0, 1e-5);
  EXPECT_NEAR(other.critical_ratio.value, one.critical_ratio.value, 1e-4);
  EXPECT_NEAR(other.subsonic_index.value, one.subsonic_index.value, 1e-4);
}

TEST(FitOrifice, AreaTakesTheVesselOnItsWordAndTheRateDoesNot) {
  const VesselRecord record = record_of(kMedium, Flow::kCharge, 800, 1e-3, 300.0);
  Vessel doubled = vessel(Flow::kCharge);
  *doubled.volume_m3 *= 2.0;
  const OrificeFit one = fit_orifice(record, vessel(Flow::kCharge));
  const OrificeFit other = fit_orifice(record, doubled);
  EXPECT_NEAR(other.area_m2->value / one.area_m2->value, 2.0, 1e-6);
  EXPECT_NEAR(other.choked_rate_1_s.value / one.choked_rate_1_s.value, 1.0, 1e-6);
  EXPECT_FALSE(fit_orifice(record, Vessel{}).area_m2.has_value());
}

TEST(FitOrifice, RefusesAVesselThatNoAreaWouldFillAsFast) {
  const VesselRecord record = record_of(kMedium, Flow::kCharge, 800, 1e-3);
  Vessel of_mL = vessel(Flow::kCharge);
  *of_mL.volume_m3 *= 1e6;
  const OrificeFitOptions shape{.cracking_ratio = 0.97, .critical_ratio = 0.3, .subsonic_index = 0.7};
  EXPECT_THAT(
      [&] { fit_orifice(record, of_mL, shape); },
      ThrowsMessage<CannotIdentify>(AllOf(HasSubstr("choked rate is not fixed"), Not(HasSubstr("hold")))));
}

TEST(FitOrifice, SaysWhichParameterIsAtABoundOrHeld) {
  const plant::EllipsePort leak{0.12, 0.0, 0.75, 1.0};
  const VesselRecord record = record_of(leak, Flow::kCharge, 1200, 2e-2, 60.0);
  const OrificeFit fit = fit_orifice(record, vessel(Flow::kCharge), {.cracking_ratio = 0.74});
  EXPECT_TRUE(fit.cracking_ratio.held);
  EXPECT_EQ(fit.cracking_ratio.value, 0.74);
  EXPECT_EQ(fit.critical_ratio.at_bound, Bound::low);
  EXPECT_FALSE(fit.critical_ratio.identified);
  EXPECT_EQ(fit.critical_ratio.why_not, "at its lower bound");
  EXPECT_TRUE(std::isnan(fit.critical_ratio.standard_error));
}

TEST(FitOrifice, StopsAtNoBoundThatTheOrificeAsksToPassAndSaysSo) {
  const plant::EllipsePort porous{0.2, 0.0, 1.0, 2.5};
  const VesselRecord record = record_of(porous, Flow::kDischarge, 800, 0.05, 60.0);
  EXPECT_EQ(fit_orifice(record, {.flow_exponent = 1.0}).subsonic_index.at_bound, Bound::high);
  const OrificeFit wide = fit_orifice(record, {.flow_exponent = 1.0}, {.most_subsonic_index = 10.0});
  EXPECT_NEAR(wide.subsonic_index.value, 2.5, 0.05);
}

TEST(FitOrifice, SaysThatHoldingTheShapeHelpsOnlyWhereItDoes) {
  VesselRecord still = record_of({1e-6, 0.3, 1.0, 0.5}, Flow::kCharge, 500, 1e-3, 300.0);
  try {
    fit_orifice(still, {});
    FAIL() << "a vessel at rest was fitted";
  } catch (const ShapeNotSeen& why) {
    FAIL() << why.what();
  } catch (const CannotIdentify&) {
  }
}

TEST(FitOrifice, RefusesAVesselThatDoesNotMove) {
  VesselRecord still = record_of({1e-6, 0.3, 1.0, 0.5}, Flow::kCharge, 500, 1e-3, 300.0);
  EXPECT_THAT([&] { fit_orifice(still, {}); }, ThrowsMessage<CannotIdentify>(HasSubstr("no excitation")));
}

TEST(FitOrifice, RefusesADischargeThatIsCalledACharge) {
  VesselRecord record = record_of(kMedium, Flow::kDischarge, 800, 1e-3, 300.0);
  record.flow = Flow::kCharge;
  EXPECT_THAT([&] { fit_orifice(record, {}); },
              ThrowsMessage<CannotIdentify>(HasSubstr("in this charge the vessel's pressure falls")));
}

TEST(FitOrifice, RefusesAFlowShapeOfAShortPieceOfTheCurveAndFitsItsRateWhereTheShapeIsHeld) {
  const plant::EllipsePort leak{0.001, 0.4, 1.0, 0.5};
  const VesselRecord record = record_of(leak, Flow::kDischarge, 1000, 0.1, 200.0);
  EXPECT_THAT([&] { fit_orifice(record, {.flow_exponent = 1.0}); },
              ThrowsMessage<ShapeNotSeen>(HasSubstr("do not show a flow shape")));
  const OrificeFit fit = fit_orifice(record, {.flow_exponent = 1.0},
                                     {.cracking_ratio = 1.0, .critical_ratio = 0.4, .subsonic_index = 0.5});
  EXPECT_NEAR(fit.choked_rate_1_s.value, 0.001, 4.0 * fit.choked_rate_1_s.standard_error);
  EXPECT_LT(fit.choked_rate_1_s.standard_error, 1e-6);
}

TEST(FitOrifice, NamesAnOptionThatIsOutOfRange) {
  const VesselRecord record = record_of(kMedium, Flow::kCharge, 100, 1e-3);
  EXPECT_THAT([&] { fit_orifice(record, {}, {.subsonic_index = -1.0}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("fit_orifice subsonic_index: -1")));
  EXPECT_THAT([&] { fit_orifice(record, {}, {.moving_average_rows = 0}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("fit_orifice moving_average_rows: 0")));
  EXPECT_THAT([&] { fit_orifice(record, {}, {.moving_average_rows = 95}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("100 rows, expected 115 or more")));
}

// An independent second route to the rate fit's minimum: Ceres, automatic derivatives, (6) written out.
struct RateError {
  double vessel_Pa, far_Pa, rate_Pa_s, cracking;
  template <class T>
  bool operator()(const T* z, T* error) const {
    const double ratio = std::min(vessel_Pa, far_Pa) / std::max(vessel_Pa, far_Pa);
    T shape(1.0);
    if (ratio >= cracking) {
      shape = T(0.0);
    } else if (z[1] < ratio) {
      const T xi = (ratio - z[1]) / (cracking - z[1]);
      shape = ceres::pow(1.0 - xi * xi, z[2]);
    }
    const double forward = vessel_Pa < far_Pa ? 1.0 : -1.0;  // a charge; backward by noise alone
    *error = (z[0] * forward * std::max(vessel_Pa, far_Pa) * shape - rate_Pa_s) * 1e-5;
    return true;
  }
};

TEST(FitOrifice, RateFitEndsNoHigherThanCeresAndInTheSamePointInsideTheBounds) {
  for (const plant::EllipsePort& port :
       {kMedium, plant::EllipsePort{0.5, 0.0, 0.8, 1.0}, {8.0, 0.5, 1.0, 0.45}}) {
    const VesselRecord record = record_of(port, Flow::kCharge, 1500, 4e-3 / port.choked_kg_s_Pa, 200.0);
    const OrificeFit fit = fit_orifice(record, {}, {.pressure_fit = false});

    const RateRecord rates = differentiated(moving_average(record, 10));
    double z[3] = {port.choked_kg_s_Pa, 0.3, 0.6};
    ceres::Problem problem;
    for (std::size_t i = 0; i < rates.rate_Pa_s.size(); ++i) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<RateError, 1, 3>(new RateError{
              rates.at.vessel_Pa[i], rates.at.far_Pa[i], rates.rate_Pa_s[i], fit.cracking_ratio.value}),
          nullptr, z);
    }
    for (int i = 0; i < 3; ++i) problem.SetParameterLowerBound(z, i, i == 2 ? 1e-3 : 0.0);
    problem.SetParameterUpperBound(z, 1, 0.528);
    problem.SetParameterUpperBound(z, 2, 1.0);
    ceres::Solver::Options options;
    options.max_num_iterations = 500;
    options.function_tolerance = 1e-14;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    double ours[3] = {fit.choked_rate_1_s.value, fit.critical_ratio.value, fit.subsonic_index.value};
    const double ceres_found[3] = {z[0], z[1], z[2]};
    std::copy_n(ours, 3, z);
    double cost = 0.0;
    problem.Evaluate({}, &cost, nullptr, nullptr, nullptr);
    EXPECT_LE(cost, summary.final_cost * (1.0 + 1e-9)) << "k " << port.choked_kg_s_Pa;
    EXPECT_NEAR(ours[0] / ceres_found[0], 1.0, 0.006) << "k " << port.choked_kg_s_Pa;
    if (port.cracking_ratio == kMedium.cracking_ratio) {  // inside the bounds Ceres ends in the same point
      EXPECT_NEAR(ours[0] / ceres_found[0], 1.0, 1e-5);
      EXPECT_NEAR(ours[1], ceres_found[1], 1e-4);
      EXPECT_NEAR(ours[2], ceres_found[2], 1e-4);
    }
  }
}

}  // namespace
}  // namespace plenum::host::identify::orifice
