#include "host-sim/identify/network/network.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/network/train.hpp"
#include "host-sim/plant/random.hpp"

namespace plenum::host::identify::network {
namespace {

Eigen::MatrixXd inputs_of(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  plant::Random random(seed);
  Eigen::MatrixXd inputs(rows, columns);
  for (Eigen::Index i = 0; i < rows; ++i)
    for (Eigen::Index j = 0; j < columns; ++j) inputs(i, j) = random.gaussian();
  return inputs;
}

Cases cases_of(const Network& teacher, Eigen::Index rows, std::uint64_t seed) {
  Cases cases{inputs_of(rows, teacher.inputs(), seed), Eigen::VectorXd(rows)};
  for (Eigen::Index i = 0; i < rows; ++i) cases.outputs[i] = teacher.output(cases.inputs.row(i).transpose());
  return cases;
}

TEST(Network, OutputIsTheFormula) {
  Network network(2, 1, Activation::kSigmoid);
  Eigen::VectorXd theta(5);
  theta << 0.1, 0.5, -0.3, 2.0, 3.0;  // w_10, w_11, w_12, W_0, W_1
  network.set_weights(theta);
  const Eigen::Vector2d phi(1.5, 0.4);
  EXPECT_NEAR(network.output(phi), 2.0 + 3.0 * std::tanh(0.1 + 0.75 - 0.12), 1e-15);
}

TEST(Network, GradientAgreesWithFiniteDifferences) {
  for (const Activation activation : {Activation::kLinear, Activation::kSigmoid}) {
    Network network = Network::random(4, 3, activation, 11);
    const Eigen::VectorXd phi = inputs_of(1, 4, 5).row(0).transpose();
    Eigen::VectorXd gradient(network.weights().size());
    EXPECT_DOUBLE_EQ(network.output(phi, gradient), network.output(phi));
    const Eigen::VectorXd theta = network.weights();
    const double h = 1e-6;
    for (Eigen::Index i = 0; i < theta.size(); ++i) {
      Eigen::VectorXd moved = theta;
      moved[i] += h;
      network.set_weights(moved);
      const double up = network.output(phi);
      moved[i] -= 2.0 * h;
      network.set_weights(moved);
      EXPECT_NEAR(gradient[i], (up - network.output(phi)) / (2.0 * h), 1e-8) << "weight " << i;
    }
  }
}

TEST(Training, GradientOfTheCriterionAgreesWithFiniteDifferences) {
  const Cases cases = cases_of(Network::random(3, 4, Activation::kSigmoid, 2), 150, 3);
  Network network = Network::random(3, 2, Activation::kSigmoid, 4);
  const Eigen::VectorXd G = criterion_gradient(network, cases);
  const Eigen::VectorXd theta = network.weights();
  const double h = 1e-6;
  for (Eigen::Index i = 0; i < theta.size(); ++i) {
    Eigen::VectorXd moved = theta;
    moved[i] += h;
    network.set_weights(moved);
    const double up = criterion(network, cases);
    moved[i] -= 2.0 * h;
    network.set_weights(moved);
    EXPECT_NEAR(G[i], (up - criterion(network, cases)) / (2.0 * h), 1e-8) << "weight " << i;
  }
}

TEST(Training, ReachesZeroOnDataOfANetworkOfTheSameShape) {
  const Cases cases = cases_of(Network::random(3, 2, Activation::kSigmoid, 21), 300, 22);
  TrainingOptions options;
  options.most_iterations = 2000;
  double best = HUGE_VAL;  // a start may end in a local minimum; one of five does not
  for (std::uint64_t seed = 1; seed <= 5; ++seed)
    best = std::min(best, train(Network::random(3, 2, Activation::kSigmoid, seed), cases, options).criterion);
  EXPECT_LT(best, 1e-18);
}

TEST(Training, LinearNetworkEqualsLeastSquares) {
  Cases cases{inputs_of(200, 4, 7), Eigen::VectorXd(200)};
  plant::Random random(8);
  for (Eigen::Index i = 0; i < 200; ++i)
    cases.outputs[i] = 0.3 - 1.2 * cases.inputs(i, 0) + 0.5 * cases.inputs(i, 3) + 0.4 * random.gaussian();
  Eigen::MatrixXd rows(200, 5);
  rows << Eigen::VectorXd::Ones(200), cases.inputs;
  const Eigen::VectorXd exact = (rows.transpose() * rows).ldlt().solve(rows.transpose() * cases.outputs);
  for (const Eigen::Index hidden : {1, 3}) {
    TrainingOptions options;
    options.most_iterations = 1000;
    options.fall_tolerance = 0.0;
    const Training training = train(Network::random(4, hidden, Activation::kLinear, 9), cases, options);
    EXPECT_LT((training.network.linear_map() - exact).norm(), 1e-9) << training.stop;
  }
}

TEST(Training, NeverRaisesTheCriterion) {
  const Cases cases = cases_of(Network::random(3, 5, Activation::kSigmoid, 31), 200, 32);
  const Network start = Network::random(3, 2, Activation::kSigmoid, 33);
  double last = criterion(start, cases);
  for (int most = 1; most < 40; ++most) {
    TrainingOptions options;
    options.most_iterations = most;
    const double V = train(start, cases, options).criterion;
    EXPECT_LE(V, last) << most << " iterations";
    last = V;
  }
}

TEST(Training, IsRepeatableToTheBitFromASeed) {
  const Cases cases = cases_of(Network::random(3, 5, Activation::kSigmoid, 41), 200, 42);
  const auto once = [&](std::uint64_t seed) {
    return train(Network::random(3, 3, Activation::kSigmoid, seed), cases).network.weights();
  };
  EXPECT_EQ(once(1), once(1));
  EXPECT_NE(once(1), once(2));
}

TEST(Training, RefusesCasesOfAnotherShapeAndSaysSo) {
  const Network network(3, 2, Activation::kSigmoid);
  try {
    train(network, {inputs_of(50, 2, 1), Eigen::VectorXd::Zero(50)});
    FAIL() << "two inputs were accepted for three";
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("50 x 2"), std::string::npos) << e.what();
  }
  EXPECT_THROW(train(network, {inputs_of(5, 3, 1), Eigen::VectorXd::Zero(5)}), CannotIdentify);
  EXPECT_THROW(Network(0, 1, Activation::kLinear), std::invalid_argument);
  EXPECT_THROW(network.linear_map(), std::invalid_argument);
}

}  // namespace
}  // namespace plenum::host::identify::network
