// Random admissible parameter sets of the 9-parameter model, and the model once more in double precision.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace plenum::control::testing {

struct RandomChamber {
  std::array<float, 12> parameters;
  float volume_mL;
  float volume_rate_mL_s;
  float pressure_kPa;
};

/// Spans the admissible set: widths of the steady-state curve from millivolts to volts, rates from one per
/// minute to one per millisecond, tilt up to 0.98, volume rates that reverse the sign of r.
template <class Random>
RandomChamber random_chamber(Random& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto log_between = [&](double low, double high) { return low * std::pow(high / low, unit(random)); };
  const auto between = [&](double low, double high) { return low + (high - low) * unit(random); };
  RandomChamber chamber{};
  const double c1 = between(2, 8);
  const double reach = std::max(c1, 10 - c1);
  const double c2 = log_between(0.01, 30);
  const double c3 = unit(random) < 0.2 ? -std::min(0.999, c2 / (3 * reach * reach) * unit(random)) * 0.999
                                       : log_between(1e-3, 100);
  const double gamma = unit(random) < 0.5 ? 0.1 : log_between(0.01, 1);
  const double c8 = between(-0.98, 0.98);
  const double c9 = gamma * (1 - std::sqrt(1 - c8 * c8)) * 1.0001 + log_between(1e-4, 0.3);
  const double volume = between(1, 1000);
  const double c6 = log_between(1e-4, 1);
  const double c7 = log_between(0.02, 1000) * (1 + c6 * volume);  // rate at one volt: 0.02 to 1000 per second
  const double rate = between(-1, 1) * log_between(1, 2000);
  // c5 v' against the opening term, and c4 v' in kPa
  const double c5 = unit(random) < 0.5 ? 0 : c7 * between(0, 1) / 2000 * log_between(0.01, 1);
  const double c4 = between(-0.2, 0.2);
  const double supply = between(300, 1000);
  const double ambient = between(80, 105);
  const std::array<double, 12> values = {c1, c2, c3, c4, c5, c6, c7, c8, c9, gamma, supply, ambient};
  for (std::size_t i = 0; i < values.size(); ++i) chamber.parameters[i] = static_cast<float>(values[i]);
  chamber.volume_mL = static_cast<float>(volume);
  chamber.volume_rate_mL_s = static_cast<float>(rate);
  chamber.pressure_kPa = static_cast<float>(between(ambient, supply));
  return chamber;
}

struct Reference {
  double steady_kPa;
  double rate_per_s;
};

/// s and r of (10c) and (10e), written from the paper in double; r > 0 as (6) asks: where (10e) is negative,
/// 0.
inline Reference reference(const RandomChamber& chamber, double command_V) {
  std::array<double, 12> c{};
  for (std::size_t i = 0; i < c.size(); ++i) c[i] = static_cast<double>(chamber.parameters[i]);
  const double u = command_V - c[0];
  const double v = static_cast<double>(chamber.volume_mL);
  const double v_dot = static_cast<double>(chamber.volume_rate_mL_s);
  const double x = c[1] * u + c[2] * u * u * u;
  const double s = (c[10] + c[11]) / 2 + (c[10] - c[11]) / 2 * (x / std::sqrt(x * x + 1)) + c[3] * v_dot;
  const double k = std::sqrt(u * u + c[9] * c[9]) - c[9] + c[8] + c[7] * u;
  return {s, std::max((c[6] * k + c[4] * v_dot) / (1 + c[5] * v), 0.0)};
}

}  // namespace plenum::control::testing
