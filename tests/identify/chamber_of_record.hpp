// Logs made without the code under test: equation (6) integrated by the classical Runge-Kutta method, s and r
// written out again from the paper, the tick mean as a second state.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>

#include "host-sim/trace/log.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::identify {

struct Recording {
  std::array<double, 9> c{5.02, 0.9, 1.6, -0.08, 0.9, 0.6, 600.0, 0.15, 0.12};
  double c_gamma_V = 0.1;
  double supply_kPa = 620.0;
  double ambient_kPa = 101.325;
  double average_s = 0.01;  ///< the whole tick, or 0
  double noise_kPa = 0.0;
  double dead_time_s =
      0.0;  ///< of the valve, whole steps of 0.5 ms; before the first row its command was held
  std::size_t rows = 2000;
  unsigned seed = 1;
  std::function<double(double)> volume_mL = [](double) { return 120.0; };
  std::function<double(double)> command_V = {};  ///< by the time; none: random steps
  bool repaired =
      false;  ///< the form of firmware/control/README.md: the moving volume takes c5 v' p, c4 is not there
  bool volume_held_in_tick = false;  ///< v and v' of mid-tick act all tick long, as the model has it
};

inline trace::Log record(const Recording& r) {
  constexpr double h = 0.01;
  constexpr int kSteps = 20;
  std::mt19937_64 random(r.seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::uniform_real_distribution<double> command(3.5, 6.5);
  std::uniform_int_distribution<int> hold(3, 30);
  const auto rate = [&](double t) { return (r.volume_mL(t + 1e-4) - r.volume_mL(t - 1e-4)) / 2e-4; };
  trace::Log log;
  log.period_s = h;
  log.pressure_average_s = r.average_s;
  double p = 250.0, sample = p, u = 5.0;
  int left = 0;
  for (std::size_t k = 0; k < r.rows; ++k) {
    const double t = static_cast<double>(k) * h;
    if (left-- <= 0) {
      u = command(random);
      left = hold(random);
    }
    if (r.command_V) u = r.command_V(t);
    // What keeps a chamber off its ends, as a recorder's pressure limits do: there every command looks alike.
    if (p > 560.0) u = std::min(u, 4.9);
    if (p < 140.0) u = std::max(u, 5.1);
    log.time_s.push_back(t);
    log.command_V.push_back(u);
    log.volume_m3.push_back(1e-6 * r.volume_mL(t));
    log.pressure_Pa.push_back(1e3 * (sample + r.noise_kPa * noise(random)));
    double acting_V = u;
    const auto slope = [&](double pressure, double at) {
      const double when = r.volume_held_in_tick ? t + 0.5 * h : at;
      const double v = r.volume_mL(when), w = rate(when), x = acting_V - r.c[0];
      const double y = r.c[1] * x + r.c[2] * std::pow(x, 3);
      const double s = (r.supply_kPa + r.ambient_kPa) / 2 +
                       (r.supply_kPa - r.ambient_kPa) / 2 * y / std::sqrt(y * y + 1) + r.c[3] * w;
      const double opening = std::sqrt(x * x + r.c_gamma_V * r.c_gamma_V) - r.c_gamma_V + r.c[8] + r.c[7] * x;
      const double moved = r.c[4] * w;
      const double drives = r.repaired ? r.c[6] * opening * (s - pressure) - moved * pressure
                                       : (s - pressure) * (r.c[6] * opening + moved);
      return drives / (1 + r.c[5] * v);
    };
    const double d = h / kSteps;
    double integral = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      const double at = t + i * d;
      const double sent_ticks_ago = std::ceil((r.dead_time_s - i * d) / h - 1e-9);
      acting_V = log.command_V[k - std::min(k, static_cast<std::size_t>(std::max(sent_ticks_ago, 0.0)))];
      const double k1 = slope(p, at), k2 = slope(p + d / 2 * k1, at + d / 2),
                   k3 = slope(p + d / 2 * k2, at + d / 2), k4 = slope(p + d * k3, at + d);
      // The integral of p over the step, by the same method on the augmented system.
      integral += d * p + d * d / 6 * (k1 + k2 + k3);
      p += d / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    sample = r.average_s > 0.0 ? integral / h : p;
  }
  return log;
}

/// A chamber at rest that goes to the supply by 10 V and to ambient by 0 V, `turned`: the other way round, a fifth of its way a tick
/// and 60 kPa at most; nothing between these two commands is ever seen.
inline trace::Log of_two_commands(bool turned, unsigned seed = 1) {
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<int> dwell(3, 40);
  const Recording r;
  trace::Log log;
  log.period_s = log.pressure_average_s = 0.01;
  double p_kPa = 250.0, u_V = 0.0;
  for (int k = 0, left = 0; k < 2000; ++k) {
    if (left-- == 0) {
      u_V = 10.0 - u_V;
      left = dwell(random);
    }
    log.time_s.push_back(0.01 * k);
    log.command_V.push_back(u_V);
    log.volume_m3.push_back(1e-4);
    log.pressure_Pa.push_back(1e3 * p_kPa);
    const double away_kPa = ((u_V > 5.0) != turned ? r.supply_kPa : r.ambient_kPa) - p_kPa;
    p_kPa += std::clamp(0.2 * away_kPa, -60.0, 60.0);
  }
  return log;
}

inline trace::RigDescription rig_of(const Recording& r) {
  trace::RigDescription rig;
  rig.supply.pressure_Pa = 1e3 * r.supply_kPa;
  rig.ambient.pressure_Pa = 1e3 * r.ambient_kPa;
  return rig;
}

inline double moving_volume_mL(double t) {
  return 120.0 + 30.0 * std::sin(4.0 * t) + 10.0 * std::sin(9.0 * t + 1.0);
}

}  // namespace plenum::host::identify
