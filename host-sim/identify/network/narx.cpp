#include "host-sim/identify/network/narx.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

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

Scaled scaled_cases(const Recording& recording, const Orders& orders) {
  const std::size_t length = recording.outputs.size();
  if (recording.inputs.size() != length) {
    throw std::invalid_argument(fmt::format("recording: {} inputs and {} outputs, expected as many of each",
                                            recording.inputs.size(), length));
  }
  if (orders.outputs == 0 || orders.inputs == 0)
    throw std::invalid_argument("orders: 0, expected 1 or more of outputs and of inputs");
  const std::size_t terms = orders.outputs + orders.inputs;
  const std::size_t past = orders.most();
  if (length < past + terms + 1) {
    throw CannotIdentify(
        fmt::format("recording: {} rows, expected at least {} for these orders", length, past + terms + 1));
  }
  Scaled scaled{{}, scaling_of(recording.outputs, "output"), scaling_of(recording.inputs, "input")};
  const auto rows = static_cast<Eigen::Index>(length - past);
  scaled.cases.inputs.resize(rows, static_cast<Eigen::Index>(terms));
  scaled.cases.outputs.resize(rows);
  const auto y = [&](std::size_t k) {
    return (recording.outputs[k] - scaled.output.mean) / scaled.output.deviation;
  };
  const auto u = [&](std::size_t k) {
    return (recording.inputs[k] - scaled.input.mean) / scaled.input.deviation;
  };
  for (std::size_t k = past; k < length; ++k) {
    const auto row = static_cast<Eigen::Index>(k - past);
    scaled.cases.outputs[row] = y(k);
    for (std::size_t i = 1; i <= orders.outputs; ++i)
      scaled.cases.inputs(row, static_cast<Eigen::Index>(i - 1)) = y(k - i);
    for (std::size_t i = 1; i <= orders.inputs; ++i)
      scaled.cases.inputs(row, static_cast<Eigen::Index>(orders.outputs + i - 1)) = u(k - i);
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

NarxFit fit_narx(const Recording& recording, const Orders& orders, Eigen::Index hidden, Activation activation,
                 std::uint64_t seed, const TrainingOptions& options,
                 const std::function<void(double)>& progress) {
  const Scaled scaled = scaled_cases(recording, orders);
  const Network start = Network::random(scaled.cases.inputs.cols(), hidden, activation, seed);
  Training training = train(start, scaled.cases, options, progress);
  return {{orders, training.network, scaled.output, scaled.input}, training};
}

Arx fit_arx(const Recording& recording, const Orders& orders) {
  const Scaled scaled = scaled_cases(recording, orders);
  Eigen::MatrixXd rows(scaled.cases.inputs.rows(), scaled.cases.inputs.cols() + 1);
  rows << Eigen::VectorXd::Ones(rows.rows()), scaled.cases.inputs;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(rows);
  qr.setThreshold(1e-12);
  if (qr.rank() < rows.cols()) {
    throw CannotIdentify(
        fmt::format("ARX: the rows determine {} of {} coefficients; the input does not excite the rest",
                    qr.rank(), rows.cols()));
  }
  return unscaled(qr.solve(scaled.cases.outputs), orders, scaled.output, scaled.input);
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
