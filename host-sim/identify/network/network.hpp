// A feed-forward network of two layers.
//
//   yhat(phi, theta) = W_0 + sum_j W_j f(w_j0 + sum_i w_ji phi_i),   f(x) = x or tanh(x)
//
// phi inputs, W_j and w_ji weights, W_0 and w_j0 biases, theta all of them; no units: scale the inputs
// before. tanh is the sigmoid of range -1 to 1. With linear hidden units the network is one linear map of its
// inputs, whatever their number; linear_map() is that map.
// Range: at least one input and one hidden unit. Source: "Mathematical and Intelligent Modeling of
// Electropneumatic Servo Actuator Systems", Fig. 4 and 5.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace plenum::host::identify::network {

enum class Activation { kLinear, kSigmoid };

class Network {
 public:
  /// All weights 0. Throws std::invalid_argument when a count is not above 0.
  Network(Eigen::Index inputs, Eigen::Index hidden, Activation activation);

  /// The same with weights drawn from `seed`: small enough that no sigmoid saturates on inputs of order one.
  static Network random(Eigen::Index inputs, Eigen::Index hidden, Activation activation, std::uint64_t seed);

  Eigen::Index inputs() const { return inputs_; }
  Eigen::Index hidden() const { return hidden_; }
  Activation activation() const { return activation_; }

  /// theta: row j of the hidden layer (w_j0, w_j1 .. ) after row j - 1, then W_0, W_1 .. W_hidden.
  const Eigen::VectorXd& weights() const { return weights_; }
  /// Throws std::invalid_argument when the length differs.
  void set_weights(const Eigen::VectorXd& weights);

  /// yhat for `phi` of inputs() values.
  double output(const Eigen::VectorXd& phi) const;

  /// yhat, and its derivatives by theta into `gradient`, as long as weights().
  double output(const Eigen::VectorXd& phi, Eigen::Ref<Eigen::VectorXd> gradient) const;

  /// W_0 + sum_j W_j w_j0, then sum_j W_j w_ji: the map of linear hidden units. Throws std::invalid_argument
  /// for sigmoids.
  Eigen::VectorXd linear_map() const;

 private:
  Eigen::Index inputs_;
  Eigen::Index hidden_;
  Activation activation_;
  Eigen::VectorXd weights_;
};

}  // namespace plenum::host::identify::network
