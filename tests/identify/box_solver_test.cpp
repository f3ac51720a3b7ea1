#include "host-sim/identify/box_solver.hpp"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "host-sim/identify/fit.hpp"
#include "tests/identify/chamber_of_record.hpp"

namespace plenum::host::identify {
namespace {

TEST(QuadraticInBox, MeetsTheConditionsOfAMinimumOnRandomProblems) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit;
  for (int trial = 0; trial < 2000; ++trial) {
    Eigen::Matrix<double, kFree, kFree> A;
    Vector9 g, low, high;
    for (double& a : A.reshaped()) a = normal(random);
    for (Eigen::Index i = 0; i < 9; ++i) {
      g[i] = 3.0 * normal(random);
      low[i] = unit(random) < 0.3 ? 0.0 : -unit(random);
      high[i] = unit(random) < 0.3 ? 0.0 : unit(random);
    }
    const Eigen::Matrix<double, kFree, kFree> H =
        A * A.transpose() + 0.01 * Eigen::Matrix<double, kFree, kFree>::Identity();
    const Vector9 d = quadratic_in_box(H, g, low, high);
    const Vector9 slope = g + H * d;
    for (Eigen::Index i = 0; i < 9; ++i) {
      ASSERT_GE(d[i], low[i]) << "trial " << trial;
      ASSERT_LE(d[i], high[i]) << "trial " << trial;
      if (low[i] == high[i]) continue;
      const double tolerance = 1e-8 * (1.0 + g.norm());
      if (d[i] == low[i]) {
        EXPECT_GE(slope[i], -tolerance) << "trial " << trial << " variable " << i;
      } else if (d[i] == high[i]) {
        EXPECT_LE(slope[i], tolerance) << "trial " << trial << " variable " << i;
      } else {
        EXPECT_NEAR(slope[i], 0.0, tolerance) << "trial " << trial << " variable " << i;
      }
    }
  }
}

/// The one-step error of an instant sample, for Ceres to differentiate by itself: the paper's formula once
/// more.
struct PaperError {
  double u, v, w, p, next;

  template <typename T>
  bool operator()(const T* c, T* error) const {
    using std::exp;
    using std::sqrt;
    const T x = u - c[0];
    const T y = c[1] * x + c[2] * x * x * x;
    const T s = 360.6625 + 259.3375 * y / sqrt(y * y + 1.0) + c[3] * w;
    const T r = (c[6] * (sqrt(x * x + 0.01) - 0.1 + c[8] + c[7] * x) + c[4] * w) / (1.0 + c[5] * v);
    error[0] = s + (p - s) * exp(-0.01 * r) - next;
    return true;
  }
};

TEST(BoxSolver, EndsWhereCeresEndsWithAutomaticDerivatives) {
  Recording recording;
  recording.volume_mL = moving_volume_mL;
  recording.average_s = 0.0;
  recording.noise_kPa = 1.0;
  recording.rows = 1500;
  const trace::Log log = record(recording);
  const Ticks ticks = lay_out({log});

  std::array<double, 9> c = recording.c;
  ceres::Problem problem;
  for (std::size_t i = 1; i + 1 < ticks.size(); ++i) {
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PaperError, 1, 9>(new PaperError{
                                 ticks.command_V[i], ticks.volume_mL[i], ticks.volume_rate_mL_s[i],
                                 ticks.pressure_kPa[i], ticks.pressure_kPa[i + 1]}),
                             nullptr, c.data());
  }
  ceres::Solver::Options ceres_options;
  ceres_options.linear_solver_type = ceres::DENSE_QR;
  ceres_options.max_num_iterations = 300;
  ceres_options.function_tolerance = 1e-14;
  ceres_options.parameter_tolerance = 1e-12;
  ceres_options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options, &problem, &summary);

  FitOptions options;
  options.refine_free_run = false;
  const Tassa9Fit fit = fit_tassa9({log}, rig_of(recording), options);
  // The first error of this fit is that of the second tick, as in the problem above.
  EXPECT_NEAR(fit.cost_kPa2 / summary.final_cost, 1.0, 1e-8);
  for (std::size_t i = 0; i < kFree; ++i) {
    EXPECT_NEAR(fit.model.c[i], c[i], 1e-2 * fit.parameters[i].standard_error) << "c" << i + 1;
  }
}

}  // namespace
}  // namespace plenum::host::identify
