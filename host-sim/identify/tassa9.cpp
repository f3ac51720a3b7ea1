#include "host-sim/identify/tassa9.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace plenum::host::identify {
namespace {

/// (exp(x) - 1)/x, 1 at 0.
double mean_growth(double x) {
  return x == 0.0 ? 1.0 : std::expm1(x) / x;
}

double exponent(double rate_per_s, double time_s, double period_s) {
  return std::clamp(rate_per_s * period_s, kLeastExponent, kGreatestExponent) * (time_s / period_s);
}

/// a + c5 v' of the repaired form, off its pole.
double off_pole(double sum, double a) {
  return std::copysign(std::max(std::abs(sum), kPole * a), sum);
}

}  // namespace

std::string_view kind_of(Form form) {
  return form == Form::published ? "tassa9" : "tassa9r";
}

Form form_of(std::string_view kind) {
  for (const Form form : {Form::published, Form::repaired})
    if (kind == kind_of(form)) return form;
  throw std::invalid_argument(fmt::format("a model of kind '{}', expected tassa9 or tassa9r", kind));
}

std::vector<double> Tassa9::image() const {
  std::vector<double> values;
  for (std::size_t i = 0; i < kFree; ++i)
    if (has_parameter(form, i)) values.push_back(c[i]);
  values.insert(values.end(), {c_gamma_V, supply_kPa, ambient_kPa, dead_time_s});
  return values;
}

Tassa9 Tassa9::from_image(std::span<const double> values, Form form) {
  Tassa9 model;
  model.form = form;
  const std::size_t expected = model.image().size();
  if (values.size() != expected && values.size() + 1 != expected) {
    throw std::invalid_argument(
        fmt::format("{} parameters, expected {} or {}", values.size(), expected - 1, expected));
  }
  std::size_t taken = 0;
  for (std::size_t i = 0; i < kFree; ++i) model.c[i] = has_parameter(form, i) ? values[taken++] : 0.0;
  model.c_gamma_V = values[taken++];
  model.supply_kPa = values[taken++];
  model.ambient_kPa = values[taken++];
  if (taken < values.size()) model.dead_time_s = values[taken];
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
  const double s0 = c_b + c_s * g, a = c7 * k, sum = a + c5 * volume_rate_mL_s;
  if (model.form == Form::published) return {s0 + c4 * volume_rate_mL_s, sum / (1.0 + c6 * volume_mL)};
  const double apart = off_pole(sum, a);
  return {a * s0 / apart, apart / (1.0 + c6 * volume_mL)};
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
