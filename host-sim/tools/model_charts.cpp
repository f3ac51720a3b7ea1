#include "host-sim/tools/model_charts.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <utility>

#include "host-sim/identify/free_run.hpp"

namespace plenum::host::tools {
namespace {

using identify::Bound;
using identify::ParameterFit;
using report::Curve;
using report::Ink;
using report::LineChart;
using report::Stroke;
using report::XyChart;

constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
constexpr int kCurvePoints = 200;

/// s or r over the command, of each model.
template <class Value>
std::vector<Curve> over_command(const std::vector<ModelCurve>& models, CommandRange range, Value value) {
  std::vector<Curve> curves;
  for (const ModelCurve& of : models) {
    Curve curve{of.name, {}, {}};
    for (int i = 0; i <= kCurvePoints; ++i) {
      const double command_V = range.low_V + (range.high_V - range.low_V) * i / kCurvePoints;
      curve.x.push_back(command_V);
      curve.y.push_back(value(identify::steady_and_rate(of.model, command_V, of.volume_mL, 0.0)));
    }
    curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::vector<double> scaled(std::vector<double> values, double factor) {
  for (double& value : values) value *= factor;
  return values;
}

double to_hundredths(double value) {
  return std::round(100.0 * value) / 100.0;
}

double to_three_digits(double value) {
  return std::isfinite(value) ? std::strtod(fmt::format("{:.3g}", value).c_str(), nullptr) : value;
}

LineChart free_run_chart(const identify::Tassa9& model, const trace::Log& log, std::string title,
                         std::string caption) {
  Curve predicted{"predicted, 2 s free runs", {}, {}};
  for (const identify::FreeRun& run : identify::reinitialised_runs(model, log, kFreeRun_s)) {
    predicted.x.push_back(log.time_s[run.start_row]);
    predicted.y.push_back(log.pressure_Pa[run.start_row] / 1e3);
    for (std::size_t i = 0; i < run.pressure_Pa.size(); ++i) {
      predicted.x.push_back(log.time_s[run.start_row + 1 + i]);
      predicted.y.push_back(run.pressure_Pa[i] / 1e3);
    }
    predicted.x.push_back(predicted.x.back());
    predicted.y.push_back(kGap);
  }
  return {.title = std::move(title),
          .caption = std::move(caption),
          .y = {"Pressure", "kPa"},
          .curves = {{"measured", log.time_s, scaled(log.pressure_Pa, 1e-3), Stroke::kSolid, Ink::kNeutral},
                     predicted}};
}

LineChart free_run_error_chart(const identify::Tassa9& model, const trace::Log& log, std::string title,
                               std::string caption) {
  Curve error{"predicted - measured", {log.time_s.front()}, {0.0}};
  for (const identify::FreeRun& run : identify::reinitialised_runs(model, log, kFreeRun_s)) {
    for (std::size_t i = 0; i < run.pressure_Pa.size(); ++i) {
      const std::size_t row = run.start_row + 1 + i;
      error.x.push_back(log.time_s[row]);
      error.y.push_back((run.pressure_Pa[i] - log.pressure_Pa[row]) / 1e3);
    }
  }
  return {.title = std::move(title),
          .caption = std::move(caption),
          .y = {"Error", "kPa"},
          .curves = {std::move(error)}};
}

XyChart steady_chart(const std::vector<ModelCurve>& models, CommandRange range, std::string caption) {
  return {.title = "Where the pressure goes: s(u)",
          .caption = std::move(caption),
          .x = {"Command", "V"},
          .y = {"Steady pressure s", "kPa"},
          .curves = over_command(models, range, [](const auto& at) { return at.steady_kPa; })};
}

XyChart rate_chart(const std::vector<ModelCurve>& models, CommandRange range, std::string caption) {
  return {.title = "How fast it goes there: r(u)",
          .caption = std::move(caption),
          .x = {"Command", "V"},
          .y = {"Rate r", "1/s"},
          .curves = over_command(models, range, [](const auto& at) { return at.rate_per_s; })};
}

std::string parameter_cell(const ParameterFit& of) {
  if (std::isfinite(of.standard_error)) return fmt::format("{:.3g} ± {:.1g}", of.value, of.standard_error);
  const char* mark = of.held                      ? " (held)"
                     : of.at_bound == Bound::low  ? " ↓"
                     : of.at_bound == Bound::high ? " ↑"
                                                  : "";
  return fmt::format("{:.3g}{}", of.value, mark);
}

const char* mark_of(Bound at_bound, bool identifiable) {
  if (at_bound != Bound::none) return bound_in_words(at_bound);
  return identifiable ? "" : "poorly known";
}

const char* mark_of(const ParameterFit& of) {
  return of.held ? "held" : mark_of(of.at_bound, of.identifiable);
}

}  // namespace plenum::host::tools
