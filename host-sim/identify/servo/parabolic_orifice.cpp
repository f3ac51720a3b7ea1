#include "host-sim/identify/servo/parabolic_orifice.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/plant/servo/orifice_constants.hpp"

namespace plenum::host::identify::servo {
namespace {

/// q [kg/s/m2].
double of_one_square_metre(const Port& port, double pressure_Pa) {
  const double upstream = port.inlet ? port.supply_Pa : std::max(pressure_Pa, port.ambient_Pa);
  const double downstream = port.inlet ? std::min(pressure_Pa, port.supply_Pa) : port.ambient_Pa;
  constexpr double kTemperature_K = 293.15;
  return plant::servo::orifice_flow_kg_s(plant::servo::kPrintedForAir, 1.4, 1.0, upstream, downstream,
                                         kTemperature_K);
}

}  // namespace

double ParabolicOrifice::flow_kg_s(double command_V, double pressure_Pa) const {
  return (area_m2[0] + command_V * (area_m2[1] + command_V * area_m2[2])) *
         of_one_square_metre(port, pressure_Pa);
}

ParabolicOrificeFit fit_parabolic_orifice(std::span<const FlowSample> samples, const Port& port) {
  require_finite(samples);
  double largest_V = 0.0;
  for (const FlowSample& s : samples) largest_V = std::max(largest_V, std::abs(s.command_V));
  const auto rows = static_cast<Eigen::Index>(samples.size());
  Eigen::MatrixX3d X(rows, 3);
  Eigen::VectorXd y(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const FlowSample& s = samples[static_cast<std::size_t>(i)];
    const double q = of_one_square_metre(port, s.pressure_Pa);
    const double u = largest_V > 0.0 ? s.command_V / largest_V : 0.0;
    X.row(i) << q, q * u, q * u * u;
    y[i] = s.flow_kg_s;
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixX3d> qr(X);
  if (rows < 3 || qr.rank() < 3) {
    throw CannotIdentify(fmt::format(
        "orifice flow: {} samples determine {} of 3 areas, expected three commands or more with a "
        "pressure drop",
        rows, rows == 0 ? 0 : qr.rank()));
  }
  const Eigen::Vector3d scaled = qr.solve(y);
  ParabolicOrificeFit fit;
  fit.orifice = {port, {scaled[0], scaled[1] / largest_V, scaled[2] / (largest_V * largest_V)}};
  std::vector<double> predicted;
  for (const FlowSample& s : samples) predicted.push_back(fit.orifice.flow_kg_s(s.command_V, s.pressure_Pa));
  static_cast<FlowError&>(fit) = flow_error(samples, predicted);
  return fit;
}

}  // namespace plenum::host::identify::servo
