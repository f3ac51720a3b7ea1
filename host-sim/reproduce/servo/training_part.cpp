#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host-sim/identify/network/narx.hpp"
#include "host-sim/reproduce/samples.hpp"
#include "host-sim/reproduce/servo/parts.hpp"
#include "host-sim/reproduce/servo/simulated_servo.hpp"

namespace plenum::host::reproduce::servo {
namespace {

using namespace identify::network;

constexpr Orders kThird{3, 3};

// A network that another of the same shape should find again.
double criterion_left() {
  const Network teacher = Network::random(3, 2, Activation::kSigmoid, 21);
  const Eigen::Index rows = 300;
  Cases cases{Eigen::MatrixXd(rows, 3), Eigen::VectorXd(rows)};
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double t = 0.1 * static_cast<double>(i);
    cases.inputs.row(i) << std::sin(t), std::cos(1.7 * t), std::sin(0.6 * t + 1.0);
    cases.outputs[i] = teacher.output(cases.inputs.row(i).transpose());
  }
  TrainingOptions options;
  options.most_iterations = 2000;
  double best = HUGE_VAL;
  for (std::uint64_t seed = 1; seed <= 5; ++seed)
    best = std::min(best, train(Network::random(3, 2, Activation::kSigmoid, seed), cases, options).criterion);
  return best;
}

double gradient_error(const Cases& cases) {
  Network network = Network::random(cases.inputs.cols(), 4, Activation::kSigmoid, 5);
  const Eigen::VectorXd G = criterion_gradient(network, cases);
  const Eigen::VectorXd theta = network.weights();
  const double h = 1e-5;
  double worst = 0.0;
  for (Eigen::Index i = 0; i < theta.size(); ++i) {
    Eigen::VectorXd moved = theta;
    moved[i] += h;
    network.set_weights(moved);
    const double up = criterion(network, cases);
    moved[i] -= 2.0 * h;
    network.set_weights(moved);
    worst = greater_of(worst, std::abs(G[i] - (up - criterion(network, cases)) / (2.0 * h)));
  }
  return worst / G.lpNorm<Eigen::Infinity>();
}

Cases some_cases() {
  Cases cases{Eigen::MatrixXd(200, 4), Eigen::VectorXd(200)};
  for (Eigen::Index i = 0; i < 200; ++i) {
    const double t = 0.13 * static_cast<double>(i);
    cases.inputs.row(i) << std::sin(t), std::sin(2.1 * t), std::cos(0.7 * t), std::cos(3.3 * t);
    cases.outputs[i] = std::tanh(std::sin(t) + 0.5 * std::cos(0.7 * t)) + 0.2 * std::sin(5.0 * t);
  }
  return cases;
}

}  // namespace

Part training_part() {
  const identify::servo::ServoRecord record = recorded(simulated_servo(), 20.0, 1);
  const Recording recording{record.commands_V, record.positions_m};
  const Arx squares = fit_arx({recording}, kThird);
  TrainingOptions options;
  options.most_iterations = 1000;
  options.fall_tolerance = 0.0;
  const NarxFit linear = fit_narx({recording}, kThird, 3, Activation::kLinear, 1, options);
  const Arx weights = arx_of(linear.model);
  const auto largest = [](const std::vector<double>& a, const std::vector<double>& b) {
    double difference = 0.0;
    double size = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      difference = greater_of(difference, std::abs(a[i] - b[i]));
      size = greater_of(size, std::abs(b[i]));
    }
    return difference / size;
  };
  const std::vector<double> by_network = free_run(linear.model, record.commands_V, record.positions_m);
  const std::vector<double> by_arx = free_run(weights, record.commands_V, record.positions_m);

  Part part;
  part.title = "(29), (30), Fig. 4: Levenberg-Marquardt and the ARX model in the weights";
  part.text = fmt::format(
      "(30) is printed without its right-hand side, -G. The third-order ARX model is read off the weights of "
      "a network of three linear hidden "
      "units trained on 20 s of a simulated servo: y(k) = {:.4f} y(k-1) {:+.4f} y(k-2) {:+.4f} y(k-3) + "
      "({:.3f} u(k-1) {:+.3f} u(k-2) {:+.3f} "
      "u(k-3)) um/V {:+.3f} mm.",
      weights.outputs[0], weights.outputs[1], weights.outputs[2], 1e6 * weights.inputs[0],
      1e6 * weights.inputs[1], 1e6 * weights.inputs[2], 1e3 * weights.constant);
  part.findings.push_back({.item = "(29), (30)",
                           .quantity = "G against finite differences of V_N, largest relative difference",
                           .paper = 0.0,
                           .ours = gradient_error(some_cases()),
                           .tolerance = 1e-6});
  part.findings.push_back({.item = "(29)",
                           .quantity = "V_N left on data of a network of the same shape, best of five starts",
                           .paper = 0.0,
                           .ours = criterion_left(),
                           .tolerance = 1e-12});
  part.findings.push_back({.item = "Fig. 4",
                           .quantity = "order of the ARX model in the weights",
                           .paper = 3,
                           .ours = static_cast<double>(weights.outputs.size()),
                           .source = Source::kSetToPaper});
  part.findings.push_back({.item = "Fig. 4",
                           .quantity = "a of the ARX model from the weights against least squares, relative",
                           .paper = 0.0,
                           .ours = largest(weights.outputs, squares.outputs),
                           .tolerance = 1e-6});
  part.findings.push_back({.item = "Fig. 4",
                           .quantity = "b of the ARX model from the weights against least squares, relative",
                           .paper = 0.0,
                           .ours = largest(weights.inputs, squares.inputs),
                           .tolerance = 1e-6});
  part.findings.push_back({.item = "Fig. 4",
                           .quantity = "free run of the network against that of its ARX model, relative",
                           .paper = 0.0,
                           .ours = largest(by_network, by_arx),
                           .tolerance = 1e-6});
  return part;
}

}  // namespace plenum::host::reproduce::servo
