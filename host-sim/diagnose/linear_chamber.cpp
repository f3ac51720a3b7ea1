#include "host-sim/diagnose/linear_chamber.hpp"

#include <algorithm>
#include <cmath>

namespace plenum::host::diagnose {

namespace {

/// `beyond` its threshold [V]; `threshold_sign`: of what `beyond` gains by the threshold.
Opening opening(double gain, double beyond, double leak, double width, double threshold_sign) {
  const double z = gain * beyond - leak;
  const double root = std::hypot(z, width);
  const double s = 0.5 * (z / root + 1.0);
  return {leak + 0.5 * (root + z),
          s * gain,
          {threshold_sign * s * gain, s * beyond, 1.0 - s, 0.5 * width / root}};
}

}  // namespace

Ports ports_of(const effects::Figures& valve, double command_V) {
  return {opening(valve[effects::kInletGain], command_V - valve[effects::kOpenAbove],
                  valve[effects::kInletLeak], valve[effects::kTransition], -1.0),
          opening(valve[effects::kExhaustGain], valve[effects::kExhaustBelow] - command_V,
                  valve[effects::kExhaustLeak], valve[effects::kTransition], 1.0)};
}

Linear LinearChamber::tick(double pressure, const Inputs& in, const double* volume,
                           const effects::Timing& timing, double stamped_early_s) const {
  const double h = timing.tick_s / timing.steps;
  const double averaged = std::min(timing.average_s / h, static_cast<double>(timing.steps));  // steps
  Linear l;
  std::array<double, kInputs> moved{};  // d p / d input
  double moved_by_pressure = 1.0;
  double p = pressure;
  double sum = 0.0;
  const double risen = averaged > 0.0 ? averaged : 1.0;  // steps over which a reading that is early rises
  Linear rise;                                           // of the readings
  for (int i = 0; i < timing.steps; ++i) {
    std::array<double, kParts> part{};  // of this step, that lies in a part of the tick
    double inlet_m2 = 0.0;
    double exhaust_m2 = 0.0;
    for (int j = 0; j < kParts; ++j) {
      const int from = std::max(i * kParts, j * timing.steps);
      const int to = std::min((i + 1) * kParts, (j + 1) * timing.steps);
      const auto at = static_cast<std::size_t>(j);
      part[at] = static_cast<double>(std::max(to - from, 0)) / kParts;
      inlet_m2 += part[at] * in[kInlet + at];
      exhaust_m2 += part[at] * in[kExhaust + at];
    }
    const double v = std::max(0.5 * (volume[i] + volume[i + 1]) + in[kVolume], 0.05 * volume[i]);
    const double per_mass = kappa_ * RT_ / v;
    const double squeeze = kappa_ * (volume[i + 1] - volume[i]) / (h * v);
    struct Rate {
      plant::Flux inlet, exhaust;
      double f, J;
    };
    const auto rate = [&](double q) {
      Rate r{plate_.flux(in[kSupply], q), plate_.flux(q, in[kBehind]), 0.0, 0.0};
      r.f = per_mass * (inlet_m2 * r.inlet.flow - exhaust_m2 * r.exhaust.flow + in[kFlow]) - squeeze * q;
      r.J = per_mass * (inlet_m2 * r.inlet.by_second - exhaust_m2 * r.exhaust.by_first) - squeeze;
      return r;
    };
    const Rate first = rate(p);
    const double trial = std::max(p + h * effects::exponential(h * first.J).phi_1 * first.f, 1e3);
    const Rate second = rate(trial);
    const double way = trial - p;
    const double chord = std::abs(way) < 0.1 ? first.J : (second.f - first.f) / way;
    const auto z = effects::exponential(std::min(h * chord, 1.0));
    std::array<double, kInputs> by{};  // d f / d input
    for (std::size_t j = 0; j < kParts; ++j) {
      by[kInlet + j] = part[j] * per_mass * 0.5 * (first.inlet.flow + second.inlet.flow);
      by[kExhaust + j] = -part[j] * per_mass * 0.5 * (first.exhaust.flow + second.exhaust.flow);
    }
    by[kSupply] = per_mass * inlet_m2 * 0.5 * (first.inlet.by_first + second.inlet.by_first);
    by[kBehind] = -per_mass * exhaust_m2 * 0.5 * (first.exhaust.by_second + second.exhaust.by_second);
    by[kFlow] = per_mass;
    by[kVolume] = -0.5 * (first.f + second.f) / v;
    // Of this step's end, as much as the sensor averages.
    const double share = averaged - (timing.steps - 1 - i);
    const auto read = [&](double begin, double mean, double end) {
      return effects::last_share(share, begin, mean, end);
    };
    const double rises = std::clamp(risen - (timing.steps - 1 - i), 0.0, 1.0);
    const double next = std::max(p + h * z.phi_1 * first.f, 1e3);
    rise.at.reading += rises * (next - p);
    rise.by_pressure.reading += rises * (z.e - 1.0) * moved_by_pressure;
    sum += read(p, p + h * z.phi_2 * first.f, next);
    l.by_pressure.reading += read(moved_by_pressure, z.phi_1 * moved_by_pressure, z.e * moved_by_pressure);
    moved_by_pressure *= z.e;
    for (std::size_t c = 0; c < kInputs; ++c) {
      const double begin = moved[c];
      moved[c] = z.e * begin + h * z.phi_1 * by[c];
      l.by_input[c].reading += read(begin, z.phi_1 * begin + h * z.phi_2 * by[c], moved[c]);
      rise.by_input[c].reading += rises * (moved[c] - begin);
    }
    p = next;
  }
  l.at.end = p;
  l.by_pressure.end = moved_by_pressure;
  for (std::size_t c = 0; c < kInputs; ++c) l.by_input[c].end = moved[c];
  if (averaged > 0.0) {
    l.at.reading = sum / averaged;
    l.by_pressure.reading /= averaged;
    for (Outcome& o : l.by_input) o.reading /= averaged;
  } else {
    l.at.reading = p;
    l.by_pressure.reading = moved_by_pressure;
    for (std::size_t c = 0; c < kInputs; ++c) l.by_input[c].reading = moved[c];
  }
  l.reading_by_early = rise.at.reading / (risen * h);
  const double early = stamped_early_s / (risen * h);
  l.at.reading += early * rise.at.reading;
  l.by_pressure.reading += early * rise.by_pressure.reading;
  for (std::size_t c = 0; c < kInputs; ++c) l.by_input[c].reading += early * rise.by_input[c].reading;
  return l;
}

}  // namespace plenum::host::diagnose
