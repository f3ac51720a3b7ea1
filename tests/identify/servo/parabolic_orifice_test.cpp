#include "host-sim/identify/servo/parabolic_orifice.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify::servo {
namespace {

// Choked and subsonic flow of air through a nozzle of 1 m2 at 293.15 K, from the isentropic relation.
double nozzle_kg_s(double upstream_Pa, double downstream_Pa) {
  const double ratio = std::fmax(downstream_Pa / upstream_Pa, std::pow(2.0 / 2.4, 3.5));
  return upstream_Pa *
         std::sqrt(7.0 / (287.05 * 293.15) * (std::pow(ratio, 2.0 / 1.4) - std::pow(ratio, 2.4 / 1.4)));
}

double area_m2(double u) {
  return 1e-6 * (0.3 - 0.4 * u + 0.2 * u * u);
}

std::vector<FlowSample> bench(bool inlet) {
  std::vector<FlowSample> samples;
  for (double u = 5.0; u <= 10.0; u += 1.0) {
    for (double P = 1e5; P <= 7e5; P += 5e4)
      samples.push_back({u, P, area_m2(u) * (inlet ? nozzle_kg_s(7e5, P) : nozzle_kg_s(P, 1e5))});
  }
  return samples;
}

TEST(ParabolicOrifice, FindsTheAreasOfANozzleOnEitherSideOfTheChamber) {
  for (const bool inlet : {true, false}) {
    const ParabolicOrificeFit fit = fit_parabolic_orifice(bench(inlet), {inlet, 7e5, 1e5});
    for (double u = 5.0; u <= 10.0; u += 0.5) {
      const auto& A = fit.orifice.area_m2;
      EXPECT_NEAR((A[0] + u * (A[1] + u * A[2])) / area_m2(u), 1.0, 2e-4)
          << u;  // (3) is printed to five digits
    }
    EXPECT_LT(fit.largest_kg_s, 2e-4 * fit.full_scale_kg_s);
    EXPECT_EQ(fit.wrong_way, 0u);
  }
}

TEST(ParabolicOrifice, HasNoFlowWhereTheChamberIsBeyondTheOtherSide) {
  const ParabolicOrifice inlet{{true, 7e5, 1e5}, {1e-6, 0.0, 0.0}};
  EXPECT_EQ(inlet.flow_kg_s(5.0, 7.2e5), 0.0);
  const ParabolicOrifice exhaust{{false, 7e5, 1e5}, {1e-6, 0.0, 0.0}};
  EXPECT_EQ(exhaust.flow_kg_s(5.0, 0.9e5), 0.0);
}

TEST(ParabolicOrifice, SaysWhenTwoCommandsAreTooFew) {
  std::vector<FlowSample> samples = bench(true);
  for (FlowSample& s : samples) s.command_V = s.command_V > 7.0 ? 8.0 : 6.0;
  try {
    fit_parabolic_orifice(samples, {});
    FAIL() << "two commands were accepted for a parabola";
  } catch (const CannotIdentify& e) {
    EXPECT_NE(std::string(e.what()).find("2 of 3"), std::string::npos) << e.what();
  }
  EXPECT_THROW(fit_parabolic_orifice({}, {}), CannotIdentify);
  samples[3].pressure_Pa = std::nan("");
  EXPECT_THROW(fit_parabolic_orifice(samples, {}), std::invalid_argument);
}

TEST(FlowError, CountsWhatWouldFlowTheWrongWay) {
  const std::vector<FlowSample> samples{{5, 1e5, 1.0}, {5, 2e5, 0.0}, {5, 3e5, 0.5}, {5, 4e5, 0.0}};
  const FlowError error = flow_error(samples, std::vector<double>{1.0, 0.02, -0.5, 0.005});
  EXPECT_EQ(error.wrong_way, 2u);
  EXPECT_EQ(error.full_scale_kg_s, 1.0);
  EXPECT_EQ(error.largest_kg_s, 1.0);
  EXPECT_DOUBLE_EQ(error.rms_kg_s, std::sqrt((0.02 * 0.02 + 1.0 + 0.005 * 0.005) / 4.0));
}

}  // namespace
}  // namespace plenum::host::identify::servo
