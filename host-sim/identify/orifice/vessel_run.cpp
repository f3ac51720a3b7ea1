#include "host-sim/identify/orifice/vessel_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace plenum::host::identify::orifice {
namespace {

constexpr double kRatioOfAStep = 0.01;
constexpr int kMostSteps = 100;  // of one row

double phi_1(double z) {
  return std::abs(z) < 1e-8 ? 1.0 + 0.5 * z : std::expm1(z) / z;
}

// `reached` kept on the side of `ratio` that `p` is on: flow carries the vessel to rest there and not beyond.
double short_of(double ratio, Flow flow, double far_Pa, double p, double reached) {
  const double rest_Pa = flow == Flow::kCharge ? ratio * far_Pa : far_Pa / ratio;
  if (flow == Flow::kCharge) return p < rest_Pa ? std::min(reached, rest_Pa) : reached;
  return p > rest_Pa ? std::max(reached, rest_Pa) : reached;
}

double stepped(const plant::EllipsePort& port, Flow flow, double p, double far_Pa, double h) {
  const double a = port.cracking_ratio;
  const double within_chord = a - 0.1 * plant::kLaminarBelow * (a - port.critical_ratio);
  const Rate start = vessel_rate(port, flow, p, far_Pa);
  const double p_m = short_of(within_chord, flow, far_Pa, p,
                              p + 0.5 * h * phi_1(0.5 * h * start.slope_1_s) * start.rate_Pa_s);
  const Rate middle = vessel_rate(port, flow, p_m, far_Pa);
  return short_of(a, flow, far_Pa, p,
                  p + h * phi_1(h * middle.slope_1_s) * (middle.rate_Pa_s + middle.slope_1_s * (p - p_m)));
}

}  // namespace

Rate vessel_rate(const plant::EllipsePort& port_1_s, Flow flow, double vessel_Pa, double far_Pa) {
  if (flow == Flow::kCharge) {
    const plant::Flux flux = port_1_s.flux(far_Pa, vessel_Pa);
    return {flux.flow, flux.by_second};
  }
  const plant::Flux flux = port_1_s.flux(vessel_Pa, far_Pa);
  return {-flux.flow, -flux.by_first};
}

std::vector<double> free_run(const plant::EllipsePort& port_1_s, const VesselRecord& record,
                             double start_Pa) {
  validate(record);
  std::vector<double> run{start_Pa};
  run.reserve(record.time_s.size());
  double p = start_Pa;
  for (std::size_t i = 1; i < record.time_s.size(); ++i) {
    const double far_Pa = 0.5 * (record.far_Pa[i - 1] + record.far_Pa[i]);
    const double moved = std::abs(pressure_ratio(record, i) - pressure_ratio(record, i - 1));
    const int steps = 1 + std::min(static_cast<int>(moved / kRatioOfAStep), kMostSteps - 1);
    const double h = (record.time_s[i] - record.time_s[i - 1]) / steps;
    for (int n = 0; n < steps; ++n) p = stepped(port_1_s, record.flow, p, far_Pa, h);
    run.push_back(p);
  }
  return run;
}

double mean_absolute_error(const std::vector<double>& predicted, const std::vector<double>& recorded) {
  if (predicted.empty() || predicted.size() != recorded.size())
    throw std::invalid_argument(
        fmt::format("mean_absolute_error: {} predicted and {} recorded values, expected as many of each",
                    predicted.size(), recorded.size()));
  double sum = 0.0;
  for (std::size_t i = 0; i < predicted.size(); ++i) sum += std::abs(predicted[i] - recorded[i]);
  return sum / static_cast<double>(predicted.size());
}

}  // namespace plenum::host::identify::orifice
