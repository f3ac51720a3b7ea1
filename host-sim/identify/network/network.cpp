#include "host-sim/identify/network/network.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "host-sim/plant/random.hpp"

namespace plenum::host::identify::network {

Network::Network(Eigen::Index inputs, Eigen::Index hidden, Activation activation)
    : inputs_(inputs), hidden_(hidden), activation_(activation) {
  if (inputs < 1) throw std::invalid_argument(fmt::format("network inputs: {}, expected 1 or more", inputs));
  if (hidden < 1) throw std::invalid_argument(fmt::format("network hidden: {}, expected 1 or more", hidden));
  weights_ = Eigen::VectorXd::Zero(hidden * (inputs + 1) + hidden + 1);
}

Network Network::random(Eigen::Index inputs, Eigen::Index hidden, Activation activation, std::uint64_t seed) {
  Network network(inputs, hidden, activation);
  plant::Random random(seed);
  const double into = 1.0 / std::sqrt(static_cast<double>(inputs));
  const double out_of = 1.0 / std::sqrt(static_cast<double>(hidden));
  const Eigen::Index first_layer = hidden * (inputs + 1);
  for (Eigen::Index i = 0; i < network.weights_.size(); ++i)
    network.weights_[i] = (i < first_layer ? into : out_of) * random.uniform(-1.0, 1.0);
  return network;
}

void Network::set_weights(const Eigen::VectorXd& weights) {
  if (weights.size() != weights_.size()) {
    throw std::invalid_argument(
        fmt::format("network weights: {} values, expected {}", weights.size(), weights_.size()));
  }
  weights_ = weights;
}

double Network::output(const Eigen::VectorXd& phi) const {
  const Eigen::Index row = inputs_ + 1;
  const Eigen::Index second = hidden_ * row;
  double sum = weights_[second];
  for (Eigen::Index j = 0; j < hidden_; ++j) {
    const double in = weights_[j * row] + weights_.segment(j * row + 1, inputs_).dot(phi);
    sum += weights_[second + 1 + j] * (activation_ == Activation::kSigmoid ? std::tanh(in) : in);
  }
  return sum;
}

double Network::output(const Eigen::VectorXd& phi, Eigen::Ref<Eigen::VectorXd> gradient) const {
  const Eigen::Index row = inputs_ + 1;
  const Eigen::Index second = hidden_ * row;
  gradient[second] = 1.0;
  double sum = weights_[second];
  for (Eigen::Index j = 0; j < hidden_; ++j) {
    const double in = weights_[j * row] + weights_.segment(j * row + 1, inputs_).dot(phi);
    const double W = weights_[second + 1 + j];
    const double f = activation_ == Activation::kSigmoid ? std::tanh(in) : in;
    const double slope = activation_ == Activation::kSigmoid ? 1.0 - f * f : 1.0;
    sum += W * f;
    gradient[second + 1 + j] = f;
    gradient[j * row] = W * slope;
    gradient.segment(j * row + 1, inputs_) = W * slope * phi;
  }
  return sum;
}

Eigen::VectorXd Network::linear_map() const {
  if (activation_ != Activation::kLinear)
    throw std::invalid_argument("network linear_map: the hidden units are sigmoids, expected linear ones");
  const Eigen::Index row = inputs_ + 1;
  const Eigen::Index second = hidden_ * row;
  Eigen::VectorXd map = weights_[second] * Eigen::VectorXd::Unit(row, 0);
  for (Eigen::Index j = 0; j < hidden_; ++j) map += weights_[second + 1 + j] * weights_.segment(j * row, row);
  return map;
}

}  // namespace plenum::host::identify::network
