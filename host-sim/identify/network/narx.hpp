// ARX and NARX models: the next output from past outputs and inputs, linear or by a network.
//
//   Y(k) = f(Y(k-1), .. Y(k-n), U(k-1), .. U(k-m))                                (30), second of that number
//   linear f:  y(k) = c + sum_i a_i y(k-i) + sum_i b_i u(k-i)                              ARX
//
// Y, y output, U, u input, in any units; n, m orders. A NARX network of linear hidden units is an ARX model,
// whose coefficients follow from its weights (arx_of). Inputs and outputs are scaled to mean 0 and deviation
// 1 of the training data, so that weights of order one fit.
// Training is on one step ahead from measured pasts. Score by free_run(): the model fed with its own outputs.
// Source: "Mathematical and Intelligent Modeling of Electropneumatic Servo Actuator Systems", Fig. 4, Fig. 5,
// (29), (30).
#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "host-sim/identify/network/network.hpp"
#include "host-sim/identify/network/train.hpp"

namespace plenum::host::identify::network {

struct Orders {
  std::size_t outputs = 3;  ///< n
  std::size_t inputs = 3;   ///< m
  std::size_t most() const { return outputs > inputs ? outputs : inputs; }
};

struct Arx {
  std::vector<double> outputs;  ///< a_1 .. a_n
  std::vector<double> inputs;   ///< b_1 .. b_m
  double constant = 0.0;        ///< c
};

/// value = mean + deviation * scaled
struct Scaling {
  double mean = 0.0;
  double deviation = 1.0;
};

struct Narx {
  Orders orders;
  Network network;  ///< of scaled y(k-1) .. y(k-n), u(k-1) .. u(k-m) to scaled y(k)
  Scaling output;
  Scaling input;
};

struct NarxFit {
  Narx model;
  Training training;
};

/// One recording: u and y of equal length at one sampling period.
struct Recording {
  std::span<const double> inputs;
  std::span<const double> outputs;
};

/// The network with `hidden` units trained one step ahead on all recordings, whose rows do not meet. Throws
/// std::invalid_argument when lengths differ, CannotIdentify when the input or the output does not move or there are
/// too few rows.
NarxFit fit_narx(const std::vector<Recording>& recordings, const Orders& orders, Eigen::Index hidden,
                 Activation activation, std::uint64_t seed, const TrainingOptions& options = {},
                 const std::function<void(double)>& progress = {});

/// ARX by linear least squares on the same rows. Throws as fit_narx, and CannotIdentify when the rows do not
/// determine the coefficients.
Arx fit_arx(const std::vector<Recording>& recordings, const Orders& orders);

/// Standard errors of what fit_arx() finds in the same rows. The errors of the equation are taken as white: noise of
/// the measured past biases the fit beyond them.
struct ArxError {
  std::vector<double> outputs;  ///< of a_1 .. a_n
  std::vector<double> inputs;   ///< of b_1 .. b_m
  double constant = 0.0;
  double static_gain = 0.0;
  double slowest_time_constant = 0.0;  ///< [samples]
  double input_F = 0.0;  ///< F statistic of b_1 = .. = b_m = 0: about 1 where the input tells nothing
};

/// Throws as fit_arx, and CannotIdentify when there are no more rows than coefficients.
ArxError arx_error(const std::vector<Recording>& recordings, const Orders& orders);

/// Output over input at rest, sum b_i / (1 - sum a_i).
double static_gain(const Arx& model);

/// -1/ln|z| of the pole that is farthest out [samples]; below 0 for one outside the unit circle.
double slowest_time_constant(const Arx& model);

/// The ARX coefficients in the weights of a network of linear hidden units; std::invalid_argument for
/// sigmoids.
Arx arx_of(const Narx& model);

/// Poles of an ARX model: roots of z^n - a_1 z^(n-1) - .. - a_n.
Eigen::VectorXcd poles(const Arx& model);

/// Outputs of the model fed with its own; the first orders.most() are `start` (at least that many). As long
/// as `inputs`; a run that leaves all bounds goes on as infinite or NaN.
std::vector<double> free_run(const Narx& model, std::span<const double> inputs,
                             std::span<const double> start);
std::vector<double> free_run(const Arx& model, std::span<const double> inputs, std::span<const double> start);

/// 100 (1 - |y - yhat| / |y - mean y|) [%]: 100 exact, 0 as good as the mean, below 0 worse. -infinity for a
/// prediction that is not finite.
double fit_percent(std::span<const double> measured, std::span<const double> predicted);

}  // namespace plenum::host::identify::network
