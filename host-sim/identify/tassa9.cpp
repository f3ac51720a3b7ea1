#include "host-sim/identify/tassa9.hpp"

#include <algorithm>
#include <cmath>

namespace plenum::host::identify {
namespace {

/// (exp(x) - 1)/x, 1 at 0.
double mean_growth(double x) {
  return x == 0.0 ? 1.0 : std::expm1(x) / x;
}

double exponent(double rate_per_s, double time_s, double period_s) {
  return std::clamp(rate_per_s * period_s, kLeastExponent, kGreatestExponent) * (time_s / period_s);
}

}  // namespace

std::array<double, kFree + 3> Tassa9::image() const {
  std::array<double, kFree + 3> values{};
  std::copy(c.begin(), c.end(), values.begin());
  values[9] = c_gamma_V;
  values[10] = supply_kPa;
  values[11] = ambient_kPa;
  return values;
}

Tassa9 Tassa9::from_image(const std::array<double, kFree + 3>& values) {
  Tassa9 model;
  std::copy_n(values.begin(), kFree, model.c.begin());
  model.c_gamma_V = values[9];
  model.supply_kPa = values[10];
  model.ambient_kPa = values[11];
  return model;
}

SteadyAndRate steady_and_rate(const Tassa9& model, double command_V, double volume_mL,
                              double volume_rate_mL_s) {
  const auto& [c1, c2, c3, c4, c5, c6, c7, c8, c9] = model.c;
  const double c_b = 0.5 * (model.supply_kPa + model.ambient_kPa);
  const double c_s = 0.5 * (model.supply_kPa - model.ambient_kPa);
  const double U = command_V - c1;
  const double argument = (c2 + c3 * U * U) * U;
  const double g = argument / std::sqrt(argument * argument + 1.0);
  const double k = std::sqrt(U * U + model.c_gamma_V * model.c_gamma_V) - model.c_gamma_V + c9 + c8 * U;
  return {c_b + c_s * g + c4 * volume_rate_mL_s, (c7 * k + c5 * volume_rate_mL_s) / (1.0 + c6 * volume_mL)};
}

SteadyAndRateByParameter by_parameter(const Tassa9& model, double command_V, double volume_mL,
                                      double volume_rate_mL_s) {
  const auto& [c1, c2, c3, c4, c5, c6, c7, c8, c9] = model.c;
  const double c_s = 0.5 * (model.supply_kPa - model.ambient_kPa);
  const double U = command_V - c1;
  const double argument = (c2 + c3 * U * U) * U;
  const double g_slope = c_s / std::pow(argument * argument + 1.0, 1.5);
  const double root = std::sqrt(U * U + model.c_gamma_V * model.c_gamma_V);
  const double k = root - model.c_gamma_V + c9 + c8 * U;
  const double inverse = 1.0 / (1.0 + c6 * volume_mL);
  const double r = (c7 * k + c5 * volume_rate_mL_s) * inverse;
  SteadyAndRateByParameter d{};
  d.steady = {
      -g_slope * (c2 + 3.0 * c3 * U * U), g_slope * U, g_slope * U * U * U, volume_rate_mL_s, 0, 0, 0, 0, 0};
  d.rate = {-c7 * inverse * (U / root + c8),
            0,
            0,
            0,
            volume_rate_mL_s * inverse,
            -r * volume_mL * inverse,
            k * inverse,
            c7 * U * inverse,
            c7 * inverse};
  return d;
}

Step step(const SteadyAndRate& at, double pressure_kPa, double period_s, double average_s) {
  const double s = at.steady_kPa;
  const double end = s + (pressure_kPa - s) * std::exp(-exponent(at.rate_per_s, period_s, period_s));
  return {end, s + (end - s) * mean_growth(exponent(at.rate_per_s, average_s, period_s))};
}

double end_from_mean(const SteadyAndRate& at, double mean_kPa, double period_s, double average_s) {
  const double s = at.steady_kPa;
  return s + (mean_kPa - s) / mean_growth(exponent(at.rate_per_s, average_s, period_s));
}

}  // namespace plenum::host::identify
