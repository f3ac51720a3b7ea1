#include "host-sim/identify/regulator_valve/least_squares.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>
#include <stdexcept>

#include "host-sim/identify/cannot_identify.hpp"
#include "tests/identify/regulator_valve/made_branch.hpp"

namespace plenum::host::identify::regulator_valve {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(LeastSquares, FindsTheModelThatMadeTheDataWithoutNoise) {
  // the steps go up and down alike, but their mean is not that of the answer: take it off after, not before
  Branch branch = made::branch_by(made::known_model(), 2000, 0.0, 3);
  for (double& p : branch.pressure_Pa) p += branch.mean_pressure_Pa;
  for (double& x : branch.screw_m) x += branch.mean_screw_m;
  const DiscreteModel found = fit_least_squares(branch);
  const DiscreteModel truth = made::known_model();
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(found.a[i], truth.a[i], 1e-9) << i;
  EXPECT_NEAR(found.b_Pa_m / truth.b_Pa_m, 1.0, 1e-9);
}

TEST(LeastSquares, IsEq33) {
  const Branch branch = made::branch_by(made::known_model(), 400, 800.0, 5);
  Eigen::MatrixXd Psi(397, 4);
  Eigen::VectorXd Y(397);
  for (Eigen::Index i = 0; i < 397; ++i) {
    const auto k = static_cast<std::size_t>(i + 3);
    Psi.row(i) << -branch.pressure_Pa[k - 1], -branch.pressure_Pa[k - 2], -branch.pressure_Pa[k - 3],
        1e8 * branch.screw_m[k - 1];
    Y[i] = branch.pressure_Pa[k];
  }
  const Eigen::VectorXd Theta = (Psi.transpose() * Psi).inverse() * Psi.transpose() * Y;
  const DiscreteModel found = fit_least_squares(branch);
  for (Eigen::Index i = 0; i < 3; ++i) EXPECT_NEAR(found.a[static_cast<std::size_t>(i)], Theta[i], 1e-9);
  EXPECT_NEAR(found.b_Pa_m / (1e8 * Theta[3]), 1.0, 1e-9);
}

TEST(LeastSquares, NoisePullsTheCoefficientsTowardsTheAverageOfThree) {
  const DiscreteModel quiet = fit_least_squares(made::branch_by(made::known_model(), 20000, 10.0, 5));
  const DiscreteModel noisy = fit_least_squares(made::branch_by(made::known_model(), 20000, 3000.0, 5));
  EXPECT_LT(quiet.a[0], noisy.a[0]);
  EXPECT_NEAR(noisy.a[0], -1.0 / 3.0, 0.15);
  EXPECT_NEAR(noisy.a[1], -1.0 / 3.0, 0.15);
  EXPECT_NEAR(noisy.a[2], -1.0 / 3.0, 0.15);
}

TEST(LeastSquares, SaysWhyItCannot) {
  Branch branch = made::branch_by(made::known_model(), 100, 100.0, 5);
  Branch still = branch;
  still.screw_m.assign(100, 0.0);
  EXPECT_THAT([&] { fit_least_squares(still); },
              ThrowsMessage<CannotIdentify>(HasSubstr("the screw never changes")));
  still = branch;
  still.pressure_Pa.assign(100, 0.0);
  EXPECT_THAT([&] { fit_least_squares(still); },
              ThrowsMessage<CannotIdentify>(HasSubstr("the pressure never changes")));
  Branch dependent = branch;
  dependent.pressure_Pa = branch.screw_m;
  EXPECT_THAT([&] { fit_least_squares(dependent); },
              ThrowsMessage<CannotIdentify>(HasSubstr("no excitation")));
  branch.pressure_Pa.resize(7);
  branch.screw_m.resize(7);
  EXPECT_THAT([&] { fit_least_squares(branch); }, ThrowsMessage<CannotIdentify>(HasSubstr("7 samples")));
}

TEST(LeastSquares, RefusesABranchThatIsNone) {
  const Branch branch = made::branch_by(made::known_model(), 100, 100.0, 5);
  Branch wrong = branch;
  wrong.screw_m.pop_back();
  EXPECT_THAT([&] { fit_least_squares(wrong); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("99 screw positions and 100 pressures")));
  wrong = branch;
  wrong.pressure_Pa[40] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT([&] { fit_least_squares(wrong); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("sample 40")));
  wrong = branch;
  wrong.sample_s = 0.0;
  EXPECT_THAT([&] { fit_least_squares(wrong); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("sample_s = 0")));
}

}  // namespace
}  // namespace plenum::host::identify::regulator_valve
