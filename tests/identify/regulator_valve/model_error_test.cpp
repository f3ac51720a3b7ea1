#include "host-sim/identify/regulator_valve/model_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "host-sim/identify/regulator_valve/least_squares.hpp"
#include "host-sim/identify/regulator_valve/swarm_fit.hpp"
#include "tests/identify/regulator_valve/made_branch.hpp"

namespace plenum::host::identify::regulator_valve {
namespace {

/// Standard deviation of what many seeds found.
double scatter(const std::vector<double>& found) {
  double mean = 0.0;
  for (const double x : found) mean += x / static_cast<double>(found.size());
  double squares = 0.0;
  for (const double x : found) squares += (x - mean) * (x - mean);
  return std::sqrt(squares / static_cast<double>(found.size() - 1));
}

// Errors of the equation, not of the sensor: then (33) has no bias, and its covariance is exact for long records.
TEST(ModelError, OneStepErrorIsTheScatterOfLeastSquaresOverManyRecordings) {
  const DiscreteModel truth = made::known_model();
  std::vector<double> gains;
  std::vector<double> firsts;
  ModelError told{};
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Branch branch = made::branch_by(truth, 2000, 0.0, 7);  // the same screw each time
    plant::Random random(seed);
    for (std::size_t k = 3; k < branch.pressure_Pa.size(); ++k) {
      const auto& p = branch.pressure_Pa;
      branch.pressure_Pa[k] = truth.b_Pa_m * branch.screw_m[k - 1] - truth.a[0] * p[k - 1] -
                              truth.a[1] * p[k - 2] - truth.a[2] * p[k - 3] + 500.0 * random.gaussian();
    }
    const DiscreteModel found = fit_least_squares(branch);
    gains.push_back(found.static_gain_Pa_m());
    firsts.push_back(found.a[0]);
    told = one_step_error(found, branch);
  }
  // 200 recordings tell a deviation to 5 %
  EXPECT_NEAR(told.static_gain_Pa_m / scatter(gains), 1.0, 0.2);
  EXPECT_NEAR(told.coefficient(0) / scatter(firsts), 1.0, 0.2);
}

// Noise of the sensor alone: the free run at the truth has white errors, and the scatter of a linearised fit about the
// truth is found by the normal equations of differenced runs, a second way to the same covariance.
TEST(ModelError, FreeRunErrorIsThatOfTheRunsDifferences) {
  const DiscreteModel truth = made::known_model();
  const Branch branch = made::branch_by(truth, 1500, 400.0, 3);
  const std::vector<double> run = free_run(truth, branch.screw_m, branch.pressure_Pa);
  Eigen::MatrixXd J(static_cast<Eigen::Index>(run.size()), 4);
  double squares = 0.0;
  for (Eigen::Index i = 0; i < 4; ++i) {
    DiscreteModel above = truth;
    DiscreteModel below = truth;
    const double step = i == 3 ? 1e-5 * truth.b_Pa_m : 1e-6;
    (i == 3 ? above.b_Pa_m : above.a[static_cast<std::size_t>(i)]) += step;
    (i == 3 ? below.b_Pa_m : below.a[static_cast<std::size_t>(i)]) -= step;
    const std::vector<double> high = free_run(above, branch.screw_m, branch.pressure_Pa);
    const std::vector<double> low = free_run(below, branch.screw_m, branch.pressure_Pa);
    for (std::size_t k = 0; k < run.size(); ++k)
      J(static_cast<Eigen::Index>(k), i) = (high[k] - low[k]) / (2.0 * step);
  }
  for (std::size_t k = 0; k < run.size(); ++k) squares += std::pow(branch.pressure_Pa[k] - run[k], 2);
  const Eigen::Matrix4d expected =
      squares / static_cast<double>(run.size() - 3 - 4) * (J.transpose() * J).inverse();
  const ModelError told = free_run_error(truth, branch);
  for (Eigen::Index i = 0; i < 4; ++i)
    EXPECT_NEAR(told.coefficient(i) / std::sqrt(expected(i, i)), 1.0, 1e-3) << i;
}

// gain = b / (1 + a_1 + a_2 + a_3), by hand.
TEST(ModelError, StaticGainHasTheErrorOfItsQuotient) {
  const DiscreteModel truth = made::known_model();
  const Branch branch = made::branch_by(truth, 1500, 400.0, 3);
  const ModelError told = free_run_error(truth, branch);
  const double r = truth.residue();
  const double over_a = -truth.b_Pa_m / (r * r);
  const Eigen::Vector4d slope(over_a, over_a, over_a, 1.0 / r);
  EXPECT_NEAR(told.static_gain_Pa_m / std::sqrt(slope.dot(told.covariance * slope)), 1.0, 1e-4);
}

// tau = -t_s / ln z of the slowest pole, real here; dz/da_i = -z^(3-i) / (3 z^2 + 2 a_1 z + a_2), by hand.
TEST(ModelError, TimeConstantHasTheErrorOfItsPole) {
  const DiscreteModel truth = made::known_model();
  const ModelError told = free_run_error(truth, made::branch_by(truth, 1500, 400.0, 3));
  const double z = 0.95;  // of made::known_model()
  const double bend = 3.0 * z * z + 2.0 * truth.a[0] * z + truth.a[1];
  const double over_z = truth.sample_s / (z * std::log(z) * std::log(z));
  const Eigen::Vector4d slope = over_z / bend * Eigen::Vector4d(-z * z, -z, -1.0, 0.0);
  EXPECT_NEAR(told.slowest_time_constant_s / std::sqrt(slope.dot(told.covariance * slope)), 1.0, 1e-4);
}

TEST(ModelError, WhatTheBranchDoesNotMoveIsUnknown) {
  Branch still = made::branch_by(made::known_model(), 100, 0.0, 1);
  for (double& x : still.screw_m) x = 0.0;
  for (double& p : still.pressure_Pa) p = 0.0;
  const ModelError told = free_run_error(made::known_model(), still);
  EXPECT_TRUE(std::isinf(told.static_gain_Pa_m));
  EXPECT_TRUE(std::isinf(told.slowest_time_constant_s));
}

TEST(ModelError, ShortBranchIsRefused) {
  const Branch branch = made::branch_by(made::known_model(), 7, 0.0, 1);
  EXPECT_THROW(free_run_error(made::known_model(), branch), std::invalid_argument);
}

// With both models exact, an error of one coefficient moves each internal parameter as its own difference does.
TEST(ModelError, InternalParametersTakeTheErrorOfTheCoefficients) {
  const plant::regulator_valve::ValveConfig valve = plant::regulator_valve::bench_valve();
  const DiscreteModel rising = discretise(linear_pressurisation(valve), 0.0005);
  const DiscreteModel falling = discretise(linear_exhaustion(valve, 4.2e5), 0.0005);
  ModelError none{};
  none.covariance.setZero();
  ModelError gain = none;
  gain.covariance(3, 3) = std::pow(0.01 * rising.b_Pa_m, 2);  // 1 % of b, and so of c_1: A_d and k_1 by (28)
  const InternalParameters is = internal_parameters(rising, falling);
  const InternalParameters error = internal_parameter_errors(rising, gain, falling, none);
  EXPECT_NEAR(error.diaphragm_area_m2 / is.diaphragm_area_m2, 0.01, 1e-6);
  EXPECT_NEAR(error.inlet_width_m / is.inlet_width_m, 0.01, 1e-6);
  EXPECT_EQ(error.plunger_mass_kg, 0.0);
  EXPECT_EQ(error.spool_spring_N_m, 0.0);
}

}  // namespace
}  // namespace plenum::host::identify::regulator_valve
