#include "host-sim/reproduce/actuators/curve_figures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace plenum::host::reproduce::actuators {
namespace {

// d/du of U^3 + a U is a at the null and a + 3 * 2^2 at 3 and 7 V.
TEST(CurveFigures, SlopeAtTheNullOfACubicIsThatOfItsLine) {
  const auto cubic = [](double u) { return (u - 5.0) * (u - 5.0) * (u - 5.0) + 1.2 * (u - 5.0); };
  EXPECT_NEAR(slope_at_null_over_steepest(cubic, 5.0), 1.2 / 13.2, 1e-6);
}

TEST(CurveFigures, SigmoidWithoutAKinkIsSteepestAtItsNull) {
  const auto tanh = [](double u) { return std::tanh(u - 5.0003); };  // between two points of the grid
  EXPECT_EQ(slope_at_null_over_steepest(tanh, 5.0003), 1.0);
}

TEST(CurveFigures, MeanExplainsNothingAndTheTruthExplainsAll) {
  const std::vector<double> truth{1.0, 2.0, 6.0};
  EXPECT_EQ(explained_percent(truth, truth), 100.0);
  EXPECT_EQ(explained_percent({3.0, 3.0, 3.0}, truth), 0.0);
}

}  // namespace
}  // namespace plenum::host::reproduce::actuators
