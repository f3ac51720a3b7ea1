#include "host-sim/identify/network/train.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify::network {
namespace {

constexpr double kLeastDamping = 1e-14;
constexpr double kMostDamping = 1e14;
constexpr int kLookBack = 10;

struct Normal {
  Eigen::MatrixXd R;
  Eigen::VectorXd G;
  double criterion = 0.0;
};

Normal normal_equations(const Network& network, const Cases& cases) {
  const Eigen::Index n = network.weights().size();
  const Eigen::Index cases_count = cases.outputs.size();
  constexpr Eigen::Index kBlock = 64;  // rows summed up at once: the product is then a matrix product
  Normal normal{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n), 0.0};
  Eigen::MatrixXd psi(n, kBlock);
  Eigen::VectorXd error(kBlock);
  for (Eigen::Index first = 0; first < cases_count; first += kBlock) {
    const Eigen::Index rows = std::min(kBlock, cases_count - first);
    for (Eigen::Index i = 0; i < rows; ++i) {
      error[i] =
          cases.outputs[first + i] - network.output(cases.inputs.row(first + i).transpose(), psi.col(i));
    }
    normal.R.selfadjointView<Eigen::Lower>().rankUpdate(psi.leftCols(rows));
    normal.G -= psi.leftCols(rows) * error.head(rows);
    normal.criterion += error.head(rows).squaredNorm();
  }
  const double share = 1.0 / static_cast<double>(cases_count);
  normal.R *= share;
  normal.G *= share;
  normal.criterion *= 0.5 * share;
  return normal;
}

void require_shapes(const Network& network, const Cases& cases) {
  if (cases.inputs.cols() != network.inputs() || cases.inputs.rows() != cases.outputs.size()) {
    throw std::invalid_argument(
        fmt::format("training cases: {} x {} inputs and {} outputs, expected N x {} and N",
                    cases.inputs.rows(), cases.inputs.cols(), cases.outputs.size(), network.inputs()));
  }
  if (!cases.inputs.allFinite() || !cases.outputs.allFinite())
    throw std::invalid_argument("training cases: a value is not finite, expected finite numbers");
}

}  // namespace

double criterion(const Network& network, const Cases& cases) {
  require_shapes(network, cases);
  double sum = 0.0;
  for (Eigen::Index t = 0; t < cases.outputs.size(); ++t) {
    const double error = cases.outputs[t] - network.output(cases.inputs.row(t).transpose());
    sum += error * error;
  }
  return 0.5 * sum / static_cast<double>(cases.outputs.size());
}

Eigen::VectorXd criterion_gradient(const Network& network, const Cases& cases) {
  require_shapes(network, cases);
  return normal_equations(network, cases).G;
}

Training train(const Network& start, const Cases& cases, const TrainingOptions& options,
               const std::function<void(double)>& progress) {
  require_shapes(start, cases);
  const Eigen::Index weights = start.weights().size();
  if (cases.outputs.size() < weights) {
    throw CannotIdentify(fmt::format("training: {} cases for {} weights, expected at least as many",
                                     cases.outputs.size(), weights));
  }
  Training training{start, 0.0, 0, "the most iterations were done"};
  Normal normal = normal_equations(start, cases);
  double damping = options.first_damping;
  double before_ten = normal.criterion;
  int taken = 0;
  while (training.iterations < options.most_iterations) {
    if (normal.G.lpNorm<Eigen::Infinity>() <= options.gradient_tolerance) {
      training.stop = "the gradient vanished";
      break;
    }
    if (damping > kMostDamping) {
      training.stop = "no damping finds a descent";
      break;
    }
    ++training.iterations;
    Eigen::MatrixXd damped = normal.R;
    damped.diagonal().array() += damping;
    const Eigen::VectorXd f = damped.selfadjointView<Eigen::Lower>().llt().solve(-normal.G);
    Network tried = training.network;
    tried.set_weights(training.network.weights() + f);
    const double V = f.allFinite() ? criterion(tried, cases) : HUGE_VAL;
    // the quadratic model promises -G.f - f.R f / 2 = (lambda |f|^2 - G.f) / 2
    const double promised = 0.5 * (damping * f.squaredNorm() - normal.G.dot(f));
    const double ratio = (normal.criterion - V) / promised;
    if (ratio > 0.75) damping = std::max(0.5 * damping, kLeastDamping);
    if (!(ratio >= 0.25)) damping *= 2.0;
    if (!(V < normal.criterion)) continue;
    training.network = tried;
    normal = normal_equations(tried, cases);
    if (progress) progress(static_cast<double>(training.iterations) / options.most_iterations);
    if (++taken % kLookBack == 0) {
      if (before_ten - normal.criterion <= options.fall_tolerance * before_ten) {
        training.stop = "the criterion falls no more";
        break;
      }
      before_ten = normal.criterion;
    }
  }
  training.criterion = normal.criterion;
  return training;
}

}  // namespace plenum::host::identify::network
