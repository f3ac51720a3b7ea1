#include "host-sim/identify/relief_valve/dynamic_fit.hpp"

#include <ceres/ceres.h>
#include <fmt/core.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/plant/refuse.hpp"

namespace plenum::host::identify::relief_valve {
namespace {

using plant::relief_valve::Damping;
using plant::relief_valve::GreyBoxConfig;

// Columns of unit length nearer to dependent than this leave parameters to the rounding of the samples.
constexpr double kRankThreshold = 1e-6;
constexpr double kLagLow_s = 1e-6;
constexpr double kLagHigh_s = 1e3;

std::size_t rows_of(std::span<const Transient> transients) {
  if (transients.empty()) throw CannotIdentify("dynamic fit: no transient");
  std::size_t rows = 0;
  for (const Transient& transient : transients) {
    validate(transient);
    rows += transient.pressure_Pa.size();
  }
  return rows;
}

double mean_pressure_Pa(std::span<const Transient> transients) {
  double sum = 0.0;
  std::size_t rows = 0;
  for (const Transient& transient : transients) {
    sum = std::accumulate(transient.pressure_Pa.begin(), transient.pressure_Pa.end(), sum);
    rows += transient.pressure_Pa.size();
  }
  return sum / static_cast<double>(rows);
}

double index_of(std::span<const Transient> transients, const GreyBoxConfig& valve) {
  double sum = 0.0;
  for (const Transient& transient : transients) sum += performance_index(valve, transient);
  return sum;
}

/// The weighted errors whose squares sum up to (4.5), in MPa sqrt(s).
struct FreeRunErrors {
  std::span<const Transient> transients;
  GreyBoxConfig base;
  int* evaluations;

  static GreyBoxConfig valve_of(GreyBoxConfig base, const double* z) {
    base.k1_m2_Pa = std::exp(z[0]);
    base.k3_m2 = -base.k1_m2_Pa * z[1] * 1e6;
    base.lag_s = std::exp(z[2]);
    return base;
  }

  bool operator()(const double* z, double* errors) const {
    ++*evaluations;
    if (z[1] < 0.0 || z[2] < std::log(kLagLow_s) || z[2] > std::log(kLagHigh_s)) return false;
    const GreyBoxConfig valve = valve_of(base, z);
    try {
      for (const Transient& transient : transients) {
        const std::vector<double> P = predict_pressure(valve, transient);
        for (std::size_t k = 0; k < P.size(); ++k) {
          const bool end = k == 0 || k + 1 == P.size();
          *errors++ =
              (P[k] - transient.pressure_Pa[k]) * 1e-6 * std::sqrt((end ? 0.5 : 1.0) * transient.step_s);
        }
      }
    } catch (const std::runtime_error&) {
      return false;  // the model has no solution there: Ceres takes a shorter step
    }
    return true;
  }
};

}  // namespace

GreyBoxConfig fit_algebraic(std::span<const Transient> transients, double density_kg_m3, Damping damping) {
  plant::require_above("dynamic fit density_kg_m3", density_kg_m3, 0.0);
  const auto rows = static_cast<Eigen::Index>(rows_of(transients));
  const double mean_Pa = mean_pressure_Pa(transients);
  Eigen::MatrixX3d A(rows, 3);
  Eigen::VectorXd B(rows);
  Eigen::Index row = 0;
  for (const Transient& transient : transients) {
    const std::vector<double> dP = parabolic_rate(transient.pressure_Pa, transient.step_s);
    const std::vector<double> dQ = parabolic_rate(transient.flow_m3_s, transient.step_s);
    for (std::size_t k = 0; k < dP.size(); ++k, ++row) {
      const double P = transient.pressure_Pa[k];
      const double a = plant::relief_valve::opening_m2(transient.flow_m3_s[k], P, density_kg_m3);
      const double opening_rate = a * (dQ[k] / transient.flow_m3_s[k] - 0.5 * dP[k] / P);
      A.row(row) << P, -opening_rate * (damping == Damping::kOverPressure ? mean_Pa / P : 1.0), 1.0;
      B(row) = a;
    }
  }
  const Eigen::Vector3d length = A.colwise().norm().cwiseMax(std::numeric_limits<double>::min());
  const Eigen::MatrixX3d scaled = A * length.cwiseInverse().asDiagonal();
  Eigen::ColPivHouseholderQR<Eigen::MatrixX3d> qr(scaled);
  qr.setThreshold(kRankThreshold);
  if (qr.rank() < 3)
    throw CannotIdentify(fmt::format(
        "algebraic fit: the samples determine {} of 3 parameters; expected a transient, not a valve at rest",
        qr.rank()));
  const Eigen::Vector3d k = Eigen::Vector3d(qr.solve(B)).cwiseQuotient(length);
  if (k(0) <= 0.0 || k(1) <= 0.0 || k(2) > 0.0)
    throw CannotIdentify(
        fmt::format("algebraic fit: k1 = {:.3g} m2/Pa, lag = {:.3g} s, k3 = {:.3g} m2; expected k1 and lag "
                    "above 0 and k3 "
                    "not above 0",
                    k(0), k(1), k(2)));
  GreyBoxConfig valve{
      .k1_m2_Pa = k(0), .k3_m2 = k(2), .lag_s = k(1), .damping = damping, .density_kg_m3 = density_kg_m3};
  if (damping == Damping::kOverPressure) valve.lag_pressure_Pa = mean_Pa;
  return valve;
}

DynamicFit fit_free_run(std::span<const Transient> transients, const GreyBoxConfig& start) {
  validate(start);
  plant::require_above("dynamic fit start lag_s", start.lag_s, 0.0);
  const std::size_t rows = rows_of(transients);
  DynamicFit fit;
  double z[3] = {std::log(start.k1_m2_Pa), -start.k3_m2 / start.k1_m2_Pa * 1e-6, std::log(start.lag_s)};
  ceres::NumericDiffOptions steps;
  steps.relative_step_size = 1e-5;
  ceres::Problem problem;
  problem.AddResidualBlock(
      new ceres::NumericDiffCostFunction<FreeRunErrors, ceres::CENTRAL, ceres::DYNAMIC, 3>(
          new FreeRunErrors{transients, start, &fit.evaluations}, ceres::TAKE_OWNERSHIP,
          static_cast<int>(rows), steps),
      nullptr, z);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-10;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (summary.termination_type != ceres::CONVERGENCE)
    throw CannotIdentify("free-run fit: " + summary.message);
  fit.valve = FreeRunErrors::valve_of(start, z);
  if (fit.valve.lag_s < 2.0 * kLagLow_s || fit.valve.lag_s > 0.5 * kLagHigh_s)
    throw CannotIdentify(
        fmt::format("free-run fit: the lag runs to its bound, {:.3g} s; expected transients that show it",
                    fit.valve.lag_s));
  fit.performance_index_Pa2_s = index_of(transients, fit.valve);
  return fit;
}

double lag_error_s(std::span<const Transient> transients, const GreyBoxConfig& valve) {
  validate(valve);
  plant::require_above("lag error lag_s", valve.lag_s, 0.0);
  const std::size_t rows = rows_of(transients);
  constexpr double kStep = 1e-4;  // of the lag
  GreyBoxConfig longer = valve;
  GreyBoxConfig shorter = valve;
  longer.lag_s *= 1.0 + kStep;
  shorter.lag_s *= 1.0 - kStep;
  double errors = 0.0;
  double slopes = 0.0;
  for (const Transient& transient : transients) {
    const std::vector<double> P = predict_pressure(valve, transient);
    const std::vector<double> above = predict_pressure(longer, transient);
    const std::vector<double> below = predict_pressure(shorter, transient);
    for (std::size_t k = 0; k < P.size(); ++k) {
      errors += std::pow(transient.pressure_Pa[k] - P[k], 2);
      slopes += std::pow((above[k] - below[k]) / (2.0 * kStep * valve.lag_s), 2);
    }
  }
  if (!(slopes > 0.0)) return std::numeric_limits<double>::infinity();
  return std::sqrt(errors / static_cast<double>(rows - 1) / slopes);
}

DynamicFit fit_lag(std::span<const Transient> transients, const GreyBoxConfig& valve, double low_s,
                   double high_s) {
  plant::require_above("lag fit low_s", low_s, 0.0);
  plant::require_above("lag fit high_s", high_s, low_s);
  rows_of(transients);
  DynamicFit fit{.valve = valve};
  const auto index = [&](double log_lag) {
    ++fit.evaluations;
    GreyBoxConfig at = valve;
    at.lag_s = std::exp(log_lag);
    return index_of(transients, at);
  };
  // A look along the range, then golden section about its least.
  constexpr int kLooks = 25;
  const double low = std::log(low_s);
  const double width = (std::log(high_s) - low) / (kLooks - 1);
  int best = 0;
  double least = std::numeric_limits<double>::max();
  for (int i = 0; i < kLooks; ++i) {
    const double at = index(low + width * i);
    if (at < least) {
      least = at;
      best = i;
    }
  }
  if (best == 0 || best == kLooks - 1)
    throw CannotIdentify(
        fmt::format("lag fit: the least error is at a bound, {:.3g} s; expected transients that show the lag",
                    std::exp(low + width * best)));
  constexpr double kGolden = 1.0 / std::numbers::phi;
  double a = low + width * (best - 1);
  double b = low + width * (best + 1);
  double c = b - kGolden * (b - a);
  double d = a + kGolden * (b - a);
  double at_c = index(c);
  double at_d = index(d);
  while (b - a > 1e-4) {
    if (at_c < at_d) {
      b = d;
      d = c;
      at_d = at_c;
      c = b - kGolden * (b - a);
      at_c = index(c);
    } else {
      a = c;
      c = d;
      at_c = at_d;
      d = a + kGolden * (b - a);
      at_d = index(d);
    }
  }
  fit.valve.lag_s = std::exp(0.5 * (a + b));
  fit.performance_index_Pa2_s = index_of(transients, fit.valve);
  return fit;
}

}  // namespace plenum::host::identify::relief_valve
