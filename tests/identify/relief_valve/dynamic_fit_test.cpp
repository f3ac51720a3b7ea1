#include "host-sim/identify/relief_valve/dynamic_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/plant/random.hpp"

namespace {

using namespace plenum::host::identify;
using namespace plenum::host::identify::relief_valve;
using namespace plenum::host::plant::relief_valve;

GreyBoxConfig truth(Damping damping = Damping::kConstant) {
  return {.k1_m2_Pa = 4e-12,
          .k3_m2 = -2e-5,
          .lag_s = 0.015,
          .damping = damping,
          .lag_pressure_Pa = 6e6,
          .density_kg_m3 = 865.0};
}

/// The valve itself, driven by a flow that rises and falls.
Transient made_by(const GreyBoxConfig& valve) {
  Transient transient{.step_s = 2e-4};
  for (int k = 0; k < 1000; ++k) {
    const double t = k * transient.step_s;
    transient.flow_m3_s.push_back(5e-4 + 2e-4 * std::sin(60.0 * t) + 1e-4 * std::sin(170.0 * t));
    transient.pressure_Pa.push_back(1.0);
  }
  transient.pressure_Pa = predict_pressure(valve, transient);
  return transient;
}

Transient at_rest() {
  Transient transient = made_by(truth());
  std::fill(transient.flow_m3_s.begin(), transient.flow_m3_s.end(), 5e-4);
  transient.pressure_Pa = predict_pressure(truth(), transient);
  return transient;
}

std::string reason(const auto& attempt) {
  try {
    attempt();
  } catch (const CannotIdentify& error) {
    return error.what();
  }
  return "nothing thrown";
}

TEST(DynamicFit, AlgebraicEquationsGiveBackTheirValve) {
  for (const Damping damping : {Damping::kConstant, Damping::kOverPressure}) {
    const std::vector<Transient> transients{made_by(truth(damping))};
    const GreyBoxConfig found = fit_algebraic(transients, 865.0, damping);
    const double lag =
        damping == Damping::kConstant ? found.lag_s : found.lag_s * found.lag_pressure_Pa / 6e6;
    EXPECT_NEAR(found.k1_m2_Pa, 4e-12, 2e-2 * 4e-12);
    EXPECT_NEAR(-found.k3_m2 / found.k1_m2_Pa, 5e6, 2e-2 * 5e6);
    EXPECT_NEAR(lag, 0.015, 2e-2 * 0.015) << "s";
  }
}

TEST(DynamicFit, ErrorOfTheLagIsItsScatterOverManyRecordings) {
  constexpr int kRecordings = 60;  // tells a deviation to 9 %
  const Transient exact = made_by(truth());
  plenum::host::plant::Random random(9);
  double squares = 0.0;
  double told_s = 0.0;
  for (int i = 0; i < kRecordings; ++i) {
    std::vector<Transient> noisy{exact};
    for (double& P : noisy[0].pressure_Pa) P += 2e4 * random.gaussian();
    const GreyBoxConfig found = fit_lag(noisy, truth(), 1e-3, 0.2).valve;
    squares += std::pow(found.lag_s - truth().lag_s, 2);
    told_s += lag_error_s(noisy, found) / kRecordings;
  }
  EXPECT_NEAR(told_s / std::sqrt(squares / kRecordings), 1.0, 0.3);
}

TEST(DynamicFit, LagOfAValveAtRestHasNoEnd) {
  const std::vector<Transient> still{at_rest()};
  EXPECT_GT(lag_error_s(still, truth()), truth().lag_s);
}

TEST(DynamicFit, FreeRunFindsTheValveFromAnother) {
  GreyBoxConfig start = truth();
  start.k1_m2_Pa *= 1.5;
  start.k3_m2 *= 1.4;
  start.lag_s *= 0.4;
  const std::vector<Transient> transients{made_by(truth())};
  const DynamicFit fit = fit_free_run(transients, start);
  EXPECT_NEAR(fit.valve.k1_m2_Pa, 4e-12, 1e-4 * 4e-12);
  EXPECT_NEAR(fit.valve.lag_s, 0.015, 1e-4 * 0.015) << "s";
  EXPECT_NEAR(-fit.valve.k3_m2 / fit.valve.k1_m2_Pa, 5e6, 1e-4 * 5e6) << "Pa";
}

TEST(DynamicFit, LagAloneIsFoundBetweenItsBounds) {
  GreyBoxConfig start = truth();
  start.lag_s = 1.0;
  const std::vector<Transient> transients{made_by(truth())};
  const DynamicFit fit = fit_lag(transients, start, 1e-5, 1.0);
  EXPECT_NEAR(fit.valve.lag_s, 0.015, 1e-4 * 0.015) << "s";
}

TEST(DynamicFit, ValveAtRestDeterminesNothing) {
  const std::vector<Transient> transients{at_rest()};
  EXPECT_NE(
      reason([&] { fit_algebraic(transients, 865.0); }).find("expected a transient, not a valve at rest"),
      std::string::npos);
}

TEST(DynamicFit, LagBeyondItsBoundIsRefused) {
  const std::vector<Transient> transients{made_by(truth())};
  EXPECT_NE(reason([&] { fit_lag(transients, truth(), 0.05, 1.0); }).find("at a bound, 0.05 s"),
            std::string::npos);
  EXPECT_NE(reason([&] { fit_lag({}, truth(), 1e-3, 1.0); }).find("no transient"), std::string::npos);
}

}  // namespace
