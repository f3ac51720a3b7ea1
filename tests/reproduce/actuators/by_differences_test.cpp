#include "host-sim/reproduce/actuators/by_differences.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plenum::host::reproduce::actuators {
namespace {

Variables of(double first, double second) {
  Variables z(2);
  z << first, second;
  return z;
}

// y = exp(a x) + b through its own points.
Eigen::VectorXd errors(const Variables& z) {
  Eigen::VectorXd e(20);
  for (Eigen::Index i = 0; i < e.size(); ++i) {
    const double x = 0.1 * static_cast<double>(i);
    e[i] = std::exp(z[0] * x) + z[1] - (std::exp(-0.7 * x) + 0.3);
  }
  return e;
}

TEST(LeastSquares, FindsTheCurveThatMadeThePoints) {
  const Variables found = least_squares(errors, of(0.5, -1.0), of(-5.0, -5.0), of(5.0, 5.0));
  EXPECT_NEAR(found[0], -0.7, 1e-6);
  EXPECT_NEAR(found[1], 0.3, 1e-6);
}

TEST(LeastSquares, StaysWithinItsBox) {
  const Variables found = least_squares(errors, of(0.5, -1.0), of(-0.5, -5.0), of(5.0, 5.0));
  EXPECT_NEAR(found[0], -0.5, 1e-9);
  // What is left is linear: the mean of the rest.
  double rest = 0.0;
  for (int i = 0; i < 20; ++i) rest += std::exp(-0.07 * i) + 0.3 - std::exp(-0.05 * i);
  EXPECT_NEAR(found[1], rest / 20.0, 1e-6);
}

}  // namespace
}  // namespace plenum::host::reproduce::actuators
