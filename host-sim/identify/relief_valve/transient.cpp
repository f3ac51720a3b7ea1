#include "host-sim/identify/relief_valve/transient.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host-sim/identify/relief_valve/greater_of.hpp"
#include "host-sim/plant/refuse.hpp"

namespace plenum::host::identify::relief_valve {

using plant::relief_valve::GreyBoxConfig;
using plant::relief_valve::GreyBoxValve;
using plant::relief_valve::StaticGreyBox;

void validate(const Transient& transient) {
  plant::require_above("transient step_s", transient.step_s, 0.0);
  const std::size_t rows = transient.pressure_Pa.size();
  if (rows < 3) throw std::invalid_argument(fmt::format("transient: {} samples, expected at least 3", rows));
  if (transient.flow_m3_s.size() != rows)
    throw std::invalid_argument(fmt::format("transient flow_m3_s: {} samples, expected {} as of pressure_Pa",
                                            transient.flow_m3_s.size(), rows));
  for (std::size_t k = 0; k < rows; ++k) {
    plant::require_above(fmt::format("transient pressure_Pa sample {}", k), transient.pressure_Pa[k], 0.0);
    plant::require_above(fmt::format("transient flow_m3_s sample {}", k), transient.flow_m3_s[k], 0.0);
  }
}

std::vector<double> parabolic_rate(const std::vector<double>& y, double step_s) {
  const std::size_t n = y.size();
  if (n < 3) throw std::invalid_argument(fmt::format("parabolic rate: {} samples, expected at least 3", n));
  std::vector<double> rate;
  rate.reserve(n);
  const double per = 0.5 / step_s;
  rate.push_back(per * (-3.0 * y[0] + 4.0 * y[1] - y[2]));
  for (std::size_t k = 1; k + 1 < n; ++k) rate.push_back(per * (y[k + 1] - y[k - 1]));
  rate.push_back(per * (3.0 * y[n - 1] - 4.0 * y[n - 2] + y[n - 3]));
  return rate;
}

std::vector<double> predict_pressure(const GreyBoxConfig& config, const Transient& transient) {
  validate(transient);
  const std::vector<double>& Q = transient.flow_m3_s;
  const StaticGreyBox at_rest{config.k1_m2_Pa, 0.0, config.k3_m2, config.density_kg_m3};
  GreyBoxValve valve(config, plant::relief_valve::pressure_Pa(at_rest, Q[0]));
  std::vector<double> P(Q.size());
  P[0] = valve.pressure_Pa(Q[0]);
  for (std::size_t k = 1; k < Q.size(); ++k) {
    valve.drive_flow(Q[k - 1], Q[k], transient.step_s);
    P[k] = valve.pressure_Pa(Q[k]);
  }
  return P;
}

double performance_index(const GreyBoxConfig& valve, const Transient& transient) {
  const std::vector<double> P = predict_pressure(valve, transient);
  const auto square = [&](std::size_t k) { return std::pow(transient.pressure_Pa[k] - P[k], 2); };
  double sum = 0.0;
  for (std::size_t k = 1; k < P.size(); ++k) sum += 0.5 * (square(k - 1) + square(k));
  return sum * transient.step_s;
}

PredictionError prediction_error(const std::vector<double>& predicted_Pa, const Transient& transient) {
  if (predicted_Pa.size() != transient.pressure_Pa.size())
    throw std::invalid_argument(fmt::format("prediction: {} samples, expected {} as of the transient",
                                            predicted_Pa.size(), transient.pressure_Pa.size()));
  PredictionError error;
  const std::size_t rows = predicted_Pa.size();
  const std::size_t tail = std::max<std::size_t>(1, rows / 10);
  for (std::size_t k = 0; k < rows; ++k) {
    const double part = (predicted_Pa[k] - transient.pressure_Pa[k]) / transient.pressure_Pa[k];
    error.worst = greater_of(error.worst, std::abs(part));
    if (k + tail >= rows) error.final += part / static_cast<double>(tail);
  }
  return error;
}

}  // namespace plenum::host::identify::relief_valve
