#include "host-sim/identify/relief_valve/transient.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace {

using namespace plenum::host::identify::relief_valve;
using plenum::host::plant::relief_valve::GreyBoxConfig;

const GreyBoxConfig kValve{.k1_m2_Pa = 1e-12, .k3_m2 = -5e-6, .lag_s = 0.02, .density_kg_m3 = 865.0};

TEST(ParabolicRate, IsExactForAParabola) {
  std::vector<double> y;
  for (int k = 0; k < 7; ++k) y.push_back(3.0 - 2.0 * k + 0.5 * k * k);
  const std::vector<double> rate = parabolic_rate(y, 0.1);
  for (int k = 0; k < 7; ++k)
    EXPECT_NEAR(rate[static_cast<std::size_t>(k)], (-2.0 + k) / 0.1, 1e-12) << "sample " << k;
}

TEST(PredictPressure, IsConstantAtRestAndReproducesItself) {
  Transient transient{.step_s = 1e-3,
                      .pressure_Pa = std::vector<double>(20, 6e6),
                      .flow_m3_s = std::vector<double>(20, 1e-4)};
  const std::vector<double> P = predict_pressure(kValve, transient);
  for (const double p : P) EXPECT_NEAR(p, P[0], 1.0);
  transient.pressure_Pa = P;
  EXPECT_EQ(performance_index(kValve, transient), 0.0);
}

TEST(PredictionError, IsTheLargestShareAndTheMeanAtTheEnd) {
  Transient transient{.step_s = 1e-3,
                      .pressure_Pa = std::vector<double>(20, 100.0),
                      .flow_m3_s = std::vector<double>(20, 1.0)};
  std::vector<double> predicted(20, 100.0);
  predicted[4] = 88.0;
  predicted[18] = predicted[19] = 103.0;
  const PredictionError error = prediction_error(predicted, transient);
  EXPECT_DOUBLE_EQ(error.worst, 0.12);
  EXPECT_DOUBLE_EQ(error.final, 0.03);
}

TEST(PredictionError, KeepsWhatIsNoNumber) {
  const Transient transient{.step_s = 1e-3,
                            .pressure_Pa = std::vector<double>(20, 100.0),
                            .flow_m3_s = std::vector<double>(20, 1.0)};
  std::vector<double> predicted(20, 101.0);
  predicted[4] = std::nan("");
  EXPECT_TRUE(std::isnan(prediction_error(predicted, transient).worst));
}

TEST(Transient, IsRefusedNamingTheSample) {
  Transient transient{.step_s = 1e-3, .pressure_Pa = {1.0, 1.0, -1.0}, .flow_m3_s = {1.0, 1.0, 1.0}};
  try {
    validate(transient);
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "transient pressure_Pa sample 2: -1, expected a finite number above 0");
  }
  transient.pressure_Pa.pop_back();
  EXPECT_THROW(validate(transient), std::invalid_argument);
}

}  // namespace
