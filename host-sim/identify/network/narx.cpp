#include "host-sim/identify/network/narx.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <stdexcept>
#include <utility>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify::network {
namespace {

Scaling scaling_of(std::span<const double> values, const char* what) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  const double mean = sum / static_cast<double>(values.size());
  double squares = 0.0;
  for (const double v : values) squares += (v - mean) * (v - mean);
  const double deviation = std::sqrt(squares / static_cast<double>(values.size()));
  if (!std::isfinite(deviation))
    throw std::invalid_argument(
        fmt::format("recording {}: a value is not finite, expected finite numbers", what));
  if (deviation <= 1e-12 * std::abs(mean) || deviation == 0.0)
    throw CannotIdentify(
        fmt::format("recording {}: it does not move, so nothing can be learnt from it", what));
  return {mean, deviation};
}

struct Scaled {
  Cases cases;
  Scaling output;
  Scaling input;
};

Scaled scaled_cases(const std::vector<Recording>& recordings, const Orders& orders) {
  if (orders.outputs == 0 || orders.inputs == 0)
    throw std::invalid_argument("orders: 0, expected 1 or more of outputs and of inputs");
  const std::size_t terms = orders.outputs + orders.inputs;
  const std::size_t past = orders.most();
  std::size_t length = 0;
  std::size_t rows = 0;
  std::vector<double> outputs;
  std::vector<double> inputs;
  for (const Recording& one : recordings) {
    if (one.inputs.size() != one.outputs.size()) {
      throw std::invalid_argument(fmt::format("recording: {} inputs and {} outputs, expected as many of each",
                                              one.inputs.size(), one.outputs.size()));
    }
    length += one.outputs.size();
    rows += one.outputs.size() > past ? one.outputs.size() - past : 0;
    outputs.insert(outputs.end(), one.outputs.begin(), one.outputs.end());
    inputs.insert(inputs.end(), one.inputs.begin(), one.inputs.end());
  }
  if (rows < terms + 1) {
    throw CannotIdentify(fmt::format("recording: {} rows, expected at least {} for these orders", length,
                                     past * recordings.size() + terms + 1));
  }
  Scaled scaled{{}, scaling_of(outputs, "output"), scaling_of(inputs, "input")};
  scaled.cases.inputs.resize(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(terms));
  scaled.cases.outputs.resize(static_cast<Eigen::Index>(rows));
  Eigen::Index row = 0;
  for (const Recording& one : recordings) {
    const auto y = [&](std::size_t k) {
      return (one.outputs[k] - scaled.output.mean) / scaled.output.deviation;
    };
    const auto u = [&](std::size_t k) {
      return (one.inputs[k] - scaled.input.mean) / scaled.input.deviation;
    };
    for (std::size_t k = past; k < one.outputs.size(); ++k, ++row) {
      scaled.cases.outputs[row] = y(k);
      for (std::size_t i = 1; i <= orders.outputs; ++i)
        scaled.cases.inputs(row, static_cast<Eigen::Index>(i - 1)) = y(k - i);
      for (std::size_t i = 1; i <= orders.inputs; ++i)
        scaled.cases.inputs(row, static_cast<Eigen::Index>(orders.outputs + i - 1)) = u(k - i);
    }
  }
  return scaled;
}

// `map`: constant, then the coefficients of the scaled past outputs and inputs.
Arx unscaled(const Eigen::VectorXd& map, const Orders& orders, const Scaling& output, const Scaling& input) {
  Arx arx;
  arx.constant = output.mean + output.deviation * map[0];
  for (std::size_t i = 0; i < orders.outputs; ++i) {
    arx.outputs.push_back(map[static_cast<Eigen::Index>(1 + i)]);
    arx.constant -= arx.outputs.back() * output.mean;
  }
  for (std::size_t i = 0; i < orders.inputs; ++i) {
    arx.inputs.push_back(map[static_cast<Eigen::Index>(1 + orders.outputs + i)] * output.deviation /
                         input.deviation);
    arx.constant -= arx.inputs.back() * input.mean;
  }
  return arx;
}

// Of y(k) = map . (1, past outputs, past inputs), all scaled.
struct LeastSquares {
  Eigen::MatrixXd rows;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr;
  Eigen::VectorXd map;
};

LeastSquares least_squares(const Scaled& scaled) {
  Eigen::MatrixXd rows(scaled.cases.inputs.rows(), scaled.cases.inputs.cols() + 1);
  rows << Eigen::VectorXd::Ones(rows.rows()), scaled.cases.inputs;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(rows);
  qr.setThreshold(1e-12);
  if (qr.rank() < rows.cols()) {
    throw CannotIdentify(
        fmt::format("ARX: the rows determine {} of {} coefficients; the input does not excite the rest",
                    qr.rank(), rows.cols()));
  }
  Eigen::VectorXd map = qr.solve(scaled.cases.outputs);
  return {std::move(rows), std::move(qr), std::move(map)};
}

std::complex<double> slowest_pole(const Arx& model) {
  const Eigen::VectorXcd z = poles(model);
  return *std::max_element(z.begin(), z.end(), [](auto p, auto q) { return std::abs(p) < std::abs(q); });
}

// Derivatives by c, a_1 .. a_n, b_1 .. b_m.
Eigen::VectorXd static_gain_gradient(const Arx& model) {
  const auto n = static_cast<Eigen::Index>(model.outputs.size());
  const auto m = static_cast<Eigen::Index>(model.inputs.size());
  double rest = 1.0;
  for (const double a : model.outputs) rest -= a;
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(1 + n + m);
  gradient.segment(1, n).setConstant(static_gain(model) / rest);
  gradient.tail(m).setConstant(1.0 / rest);
  return gradient;
}

// Of p(z, a) = z^n - a_1 z^(n-1) - .. - a_n = 0 follows dz/da_i = z^(n-i) / (dp/dz); d ln|z| = Re(dz / z).
Eigen::VectorXd time_constant_gradient(const Arx& model) {
  const auto n = static_cast<Eigen::Index>(model.outputs.size());
  const std::complex<double> z = slowest_pole(model);
  std::complex<double> slope = static_cast<double>(n) * std::pow(z, n - 1);
  for (Eigen::Index i = 1; i < n; ++i) {
    slope -=
        model.outputs[static_cast<std::size_t>(i - 1)] * static_cast<double>(n - i) * std::pow(z, n - i - 1);
  }
  const double T = slowest_time_constant(model);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(1 + n + static_cast<Eigen::Index>(model.inputs.size()));
  for (Eigen::Index i = 1; i <= n; ++i) gradient[i] = T * T * std::real(std::pow(z, n - i) / slope / z);
  return gradient;
}

template <class Next>
std::vector<double> run(std::size_t past, std::span<const double> inputs, std::span<const double> start,
                        const Next& next) {
  if (start.size() < past || inputs.size() < past) {
    throw std::invalid_argument(fmt::format("free run: {} inputs and {} outputs to start from, expected {}",
                                            inputs.size(), start.size(), past));
  }
  std::vector<double> y(start.begin(), start.begin() + static_cast<std::ptrdiff_t>(past));
  y.reserve(inputs.size());
  for (std::size_t k = past; k < inputs.size(); ++k) y.push_back(next(y, k));
  return y;
}

}  // namespace

NarxFit fit_narx(const std::vector<Recording>& recordings, const Orders& orders, Eigen::Index hidden,
                 Activation activation, std::uint64_t seed, const TrainingOptions& options,
                 const std::function<void(double)>& progress) {
  const Scaled scaled = scaled_cases(recordings, orders);
  const Network start = Network::random(scaled.cases.inputs.cols(), hidden, activation, seed);
  Training training = train(start, scaled.cases, options, progress);
  return {{orders, training.network, scaled.output, scaled.input}, training};
}

Arx fit_arx(const std::vector<Recording>& recordings, const Orders& orders) {
  const Scaled scaled = scaled_cases(recordings, orders);
  return unscaled(least_squares(scaled).map, orders, scaled.output, scaled.input);
}

ArxError arx_error(const std::vector<Recording>& recordings, const Orders& orders) {
  const Scaled scaled = scaled_cases(recordings, orders);
  const LeastSquares fit = least_squares(scaled);
  const Eigen::Index columns = fit.rows.cols();
  if (fit.rows.rows() == columns) {
    throw CannotIdentify(fmt::format("ARX: {} cases for {} coefficients, expected more to tell their errors",
                                     columns, columns));
  }
  const Arx model = unscaled(fit.map, orders, scaled.output, scaled.input);
  const double variance = (scaled.cases.outputs - fit.rows * fit.map).squaredNorm() /
                          static_cast<double>(fit.rows.rows() - columns);
  // (X^T X)^-1 = root root^T
  const Eigen::MatrixXd root =
      fit.qr.colsPermutation() * Eigen::MatrixXd(fit.qr.matrixR()
                                                     .topLeftCorner(columns, columns)
                                                     .triangularView<Eigen::Upper>()
                                                     .solve(Eigen::MatrixXd::Identity(columns, columns)));
  const auto n = static_cast<Eigen::Index>(orders.outputs);
  const auto m = static_cast<Eigen::Index>(orders.inputs);
  Eigen::MatrixXd spread =
      std::sqrt(variance) * root;  // covariance = spread spread^T; first of scaled columns,
  spread.bottomRows(m) *= scaled.output.deviation / scaled.input.deviation;  // then as unscaled() has it
  spread.row(0) = (scaled.output.deviation * spread.row(0) -
                   scaled.output.mean * spread.middleRows(1, n).colwise().sum() -
                   scaled.input.mean * spread.bottomRows(m).colwise().sum())
                      .eval();
  const auto error_of = [&](const Eigen::VectorXd& gradient) {
    return (spread.transpose() * gradient).norm();
  };

  ArxError error;
  for (Eigen::Index i = 1; i <= n; ++i) error.outputs.push_back(spread.row(i).norm());
  for (Eigen::Index i = n + 1; i < columns; ++i) error.inputs.push_back(spread.row(i).norm());
  error.constant = spread.row(0).norm();
  error.static_gain = error_of(static_gain_gradient(model));
  error.slowest_time_constant = error_of(time_constant_gradient(model));
  const Eigen::VectorXd b = fit.map.tail(m);
  const Eigen::MatrixXd of_inputs = root.bottomRows(m) * root.bottomRows(m).transpose();
  error.input_F = b.dot(of_inputs.llt().solve(b)) / (static_cast<double>(m) * variance);
  return error;
}

double static_gain(const Arx& model) {
  double numerator = 0.0;
  double rest = 1.0;
  for (const double b : model.inputs) numerator += b;
  for (const double a : model.outputs) rest -= a;
  return numerator / rest;
}

double slowest_time_constant(const Arx& model) {
  return -1.0 / std::log(std::abs(slowest_pole(model)));
}

Arx arx_of(const Narx& model) {
  return unscaled(model.network.linear_map(), model.orders, model.output, model.input);
}

Eigen::VectorXcd poles(const Arx& model) {
  const auto n = static_cast<Eigen::Index>(model.outputs.size());
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    companion(0, i) = model.outputs[static_cast<std::size_t>(i)];
    if (i > 0) companion(i, i - 1) = 1.0;
  }
  return companion.eigenvalues();
}

std::vector<double> free_run(const Narx& model, std::span<const double> inputs,
                             std::span<const double> start) {
  const Orders& orders = model.orders;
  Eigen::VectorXd phi(static_cast<Eigen::Index>(orders.outputs + orders.inputs));
  return run(orders.most(), inputs, start, [&](const std::vector<double>& y, std::size_t k) {
    for (std::size_t i = 1; i <= orders.outputs; ++i)
      phi[static_cast<Eigen::Index>(i - 1)] = (y[k - i] - model.output.mean) / model.output.deviation;
    for (std::size_t i = 1; i <= orders.inputs; ++i) {
      phi[static_cast<Eigen::Index>(orders.outputs + i - 1)] =
          (inputs[k - i] - model.input.mean) / model.input.deviation;
    }
    return model.output.mean + model.output.deviation * model.network.output(phi);
  });
}

std::vector<double> free_run(const Arx& model, std::span<const double> inputs,
                             std::span<const double> start) {
  const std::size_t past = std::max(model.outputs.size(), model.inputs.size());
  return run(past, inputs, start, [&](const std::vector<double>& y, std::size_t k) {
    double sum = model.constant;
    for (std::size_t i = 1; i <= model.outputs.size(); ++i) sum += model.outputs[i - 1] * y[k - i];
    for (std::size_t i = 1; i <= model.inputs.size(); ++i) sum += model.inputs[i - 1] * inputs[k - i];
    return sum;
  });
}

double fit_percent(std::span<const double> measured, std::span<const double> predicted) {
  if (measured.size() != predicted.size() || measured.empty())
    throw std::invalid_argument(
        fmt::format("fit: {} measured and {} predicted values, expected as many of each", measured.size(),
                    predicted.size()));
  double mean = 0.0;
  for (const double y : measured) mean += y / static_cast<double>(measured.size());
  double error = 0.0;
  double spread = 0.0;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    error += (measured[i] - predicted[i]) * (measured[i] - predicted[i]);
    spread += (measured[i] - mean) * (measured[i] - mean);
  }
  if (!std::isfinite(error)) return -std::numeric_limits<double>::infinity();
  return 100.0 * (1.0 - std::sqrt(error / spread));
}

}  // namespace plenum::host::identify::network
