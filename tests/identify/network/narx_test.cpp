#include "host-sim/identify/network/narx.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/plant/random.hpp"

namespace plenum::host::identify::network {
namespace {

const Arx kTruth{{1.9, -1.25, 0.3}, {0.02, 0.05, -0.01}, 0.4};

struct Data {
  std::vector<double> u;
  std::vector<double> y;
  Recording recording() const { return {u, y}; }
};

Data recorded(std::size_t length, double noise, std::uint64_t seed) {
  plant::Random random(seed);
  Data data;
  double level = 5.0;
  for (std::size_t k = 0; k < length; ++k) {
    if (random.uniform() < 0.1) level = random.uniform(2.0, 8.0);
    data.u.push_back(level);
  }
  const std::vector<double> start(3, 0.0);
  data.y = free_run(kTruth, data.u, start);
  for (double& y : data.y) y += noise * random.gaussian();
  return data;
}

TEST(Arx, LeastSquaresFindsTheCoefficientsThatMadeTheData) {
  const Data data = recorded(400, 0.0, 1);
  const Arx fit = fit_arx({data.recording()}, {3, 3});
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(fit.outputs[i], kTruth.outputs[i], 1e-8);
    EXPECT_NEAR(fit.inputs[i], kTruth.inputs[i], 1e-8);
  }
  EXPECT_NEAR(fit.constant, kTruth.constant, 1e-7);
}

TEST(Arx, WeightsOfALinearNetworkGiveTheLeastSquaresModel) {
  const Data data = recorded(500, 0.02, 2);
  const Arx squares = fit_arx({data.recording()}, {3, 3});
  TrainingOptions options;
  options.most_iterations = 2000;
  options.fall_tolerance = 0.0;
  const NarxFit fit = fit_narx({data.recording()}, {3, 3}, 2, Activation::kLinear, 3, options);
  const Arx arx = arx_of(fit.model);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(arx.outputs[i], squares.outputs[i], 1e-7) << fit.training.stop;
    EXPECT_NEAR(arx.inputs[i], squares.inputs[i], 1e-7);
  }
  EXPECT_NEAR(arx.constant, squares.constant, 1e-6);
}

TEST(Arx, FreeRunOfTheNetworkIsThatOfItsCoefficients) {
  const Data data = recorded(300, 0.02, 4);
  const NarxFit fit = fit_narx({data.recording()}, {3, 3}, 2, Activation::kLinear, 5);
  const std::vector<double> by_weights = free_run(fit.model, data.u, data.y);
  const std::vector<double> by_coefficients = free_run(arx_of(fit.model), data.u, data.y);
  for (std::size_t k = 0; k < data.y.size(); ++k) EXPECT_NEAR(by_weights[k], by_coefficients[k], 1e-8);
}

TEST(Arx, PolesAreTheRootsOfItsPolynomial) {
  const double a = 0.9;
  const double b = 0.5;
  const double c = -0.2;  // (z - a)(z - b)(z - c)
  const Arx arx{{a + b + c, -(a * b + b * c + a * c), a * b * c}, {1.0}, 0.0};
  Eigen::VectorXcd roots = poles(arx);
  std::sort(roots.data(), roots.data() + 3, [](auto p, auto q) { return p.real() < q.real(); });
  EXPECT_NEAR(std::abs(roots[0] - c) + std::abs(roots[1] - b) + std::abs(roots[2] - a), 0.0, 1e-12);
}

TEST(Arx, GainAndSlowestTimeConstantFollowFromPolesAndGainThatMadeIt) {
  const double T = 7.0;  // samples; beside it a pair that has died away before
  const double z = std::exp(-1.0 / T);
  const double re = 0.5;
  const double squared = 0.41;  // (z - 0.5)^2 + 0.4^2
  const Arx arx{{z + 2.0 * re, -(squared + 2.0 * re * z), squared * z}, {0.3, 0.2}, 5.0};
  EXPECT_NEAR(slowest_time_constant(arx), T, 1e-9);
  EXPECT_NEAR(static_gain(arx), 0.5 / ((1.0 - z) * (1.0 - 2.0 * re + squared)), 1e-9);
  EXPECT_LT(slowest_time_constant({{1.1}, {1.0}, 0.0}), 0.0);
}

const Arx kDriven{{1.9, -1.25, 0.3}, {0.2, 0.5, -0.1}, 0.4};

// y(k) = arx + e(k), e white: what least squares is made for.
Data driven(std::size_t length, double deviation, bool by_input, plant::Random& random, double start = 0.0) {
  Data data{{}, {start, start, start}};
  double level = 5.0;
  for (std::size_t k = 0; k < length; ++k) {
    if (random.uniform() < 0.3) level = random.uniform(2.0, 8.0);
    data.u.push_back(level);
    if (k < 3) continue;
    double y = kDriven.constant + deviation * random.gaussian();
    for (std::size_t i = 1; i <= 3; ++i)
      y += kDriven.outputs[i - 1] * data.y[k - i] + (by_input ? kDriven.inputs[i - 1] * data.u[k - i] : 0.0);
    data.y.push_back(y);
  }
  return data;
}

TEST(Arx, StandardErrorsAreHowFarFitsOfManyRecordingsScatter) {
  constexpr int kRuns = 400;
  plant::Random random(11);
  std::vector<double> scatter(9, 0.0);
  std::vector<double> stated(9, 0.0);
  for (int run = 0; run < kRuns; ++run) {
    const Data data = driven(1500, 0.5, true, random);
    const Arx fit = fit_arx({data.recording()}, {3, 3});
    const ArxError error = arx_error({data.recording()}, {3, 3});
    for (std::size_t i = 0; i < 3; ++i) {
      scatter[i] += std::pow(fit.outputs[i] - kDriven.outputs[i], 2) / kRuns;
      scatter[3 + i] += std::pow(fit.inputs[i] - kDriven.inputs[i], 2) / kRuns;
      stated[i] += std::pow(error.outputs[i], 2) / kRuns;
      stated[3 + i] += std::pow(error.inputs[i], 2) / kRuns;
    }
    scatter[6] += std::pow(fit.constant - kDriven.constant, 2) / kRuns;
    stated[6] += std::pow(error.constant, 2) / kRuns;
    scatter[7] += std::pow(static_gain(fit) - static_gain(kDriven), 2) / kRuns;
    stated[7] += std::pow(error.static_gain, 2) / kRuns;
    scatter[8] += std::pow(slowest_time_constant(fit) - slowest_time_constant(kDriven), 2) / kRuns;
    stated[8] += std::pow(error.slowest_time_constant, 2) / kRuns;
  }
  // a deviation from 400 runs is known to 1/sqrt(800) = 3.5 %
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(std::sqrt(stated[i] / scatter[i]), 1.0, 0.14) << i;
}

TEST(Arx, AnInputThatDrivesNothingHasAnFOfAboutOne) {
  constexpr int kRuns = 200;
  plant::Random random(12);
  double F = 0.0;
  for (int run = 0; run < kRuns; ++run)
    F += arx_error({driven(300, 0.5, false, random).recording()}, {3, 3}).input_F / kRuns;
  EXPECT_NEAR(F, 1.0, 0.25);  // deviation of F(3, 290): 0.83, of the mean: 0.06
  EXPECT_GT(arx_error({driven(300, 0.5, true, random).recording()}, {3, 3}).input_F, 100.0);
}

TEST(Arx, RowsOfTwoRecordingsDoNotMeet) {
  plant::Random random(13);
  const Data low = driven(200, 0.0, true, random);
  const Data high =
      driven(200, 0.0, true, random, 300.0);  // a row across the joint would follow no ARX equation
  const Arx fit = fit_arx({low.recording(), high.recording()}, {3, 3});
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(fit.outputs[i], kDriven.outputs[i], 1e-8);
    EXPECT_NEAR(fit.inputs[i], kDriven.inputs[i], 1e-8);
  }
}

TEST(Narx, LearnsANonlinearRecursionInFreeRun) {
  const auto make = [](std::uint64_t seed) {
    plant::Random random(seed);
    Data data;
    double level = 0.0;
    double y = 0.0;
    for (int k = 0; k < 600; ++k) {
      if (k % 8 == 0) level = random.uniform(-1.0, 1.0);
      data.u.push_back(level);
      data.y.push_back(y);
      y = 0.8 * std::tanh(1.2 * y) + 0.4 * level * level * level;
    }
    return data;
  };
  const Data training = make(1);
  const Data unseen = make(2);
  TrainingOptions options;
  options.most_iterations = 400;
  const NarxFit fit = fit_narx({training.recording()}, {1, 1}, 10, Activation::kSigmoid, 7, options);
  EXPECT_GT(fit_percent(unseen.y, free_run(fit.model, unseen.u, unseen.y)), 99.0);
  EXPECT_LT(fit_percent(unseen.y, free_run(fit_arx({training.recording()}, {1, 1}), unseen.u, unseen.y)),
            90.0);
}

TEST(FitPercent, IsOneHundredExactAndZeroForTheMean) {
  const std::vector<double> y{1.0, 2.0, 3.0, 6.0};
  EXPECT_DOUBLE_EQ(fit_percent(y, y), 100.0);
  EXPECT_DOUBLE_EQ(fit_percent(y, std::vector<double>(4, 3.0)), 0.0);
  EXPECT_EQ(fit_percent(y, std::vector<double>{1.0, 2.0, std::nan(""), 6.0}), -HUGE_VAL);
}

TEST(Narx, SaysWhatCannotBeLearnt) {
  const std::vector<double> still(100, 5.0);
  Data data = recorded(100, 0.01, 6);
  try {
    fit_narx({{still, data.y}}, {3, 3}, 2, Activation::kLinear, 1);
    FAIL() << "an input at rest was accepted";
  } catch (const CannotIdentify& e) {
    EXPECT_NE(std::string(e.what()).find("input"), std::string::npos) << e.what();
  }
  std::vector<double> ramp(100);
  for (std::size_t k = 0; k < 100; ++k) ramp[k] = 0.1 * static_cast<double>(k);
  EXPECT_THROW(fit_arx({{ramp, data.y}}, {3, 3}),
               CannotIdentify);  // u(k-1), u(k-2), u(k-3) depend on each other
  const std::span<const double> u(data.u);
  const std::span<const double> y(data.y);
  try {
    fit_arx({{u.first(9), y.first(9)}}, {3, 3});
    FAIL() << "six cases for seven coefficients were accepted";
  } catch (const CannotIdentify& e) {
    EXPECT_NE(std::string(e.what()).find("9 rows, expected at least 10"), std::string::npos) << e.what();
  }
  EXPECT_THROW(arx_error({{u.first(10), y.first(10)}}, {3, 3}), CannotIdentify);
  EXPECT_THROW(fit_arx({{std::span<const double>(still).first(50), data.y}}, {3, 3}), std::invalid_argument);
}

}  // namespace
}  // namespace plenum::host::identify::network
