// What more than one page shows of a model: charts of its predictions, of s(u) and r(u), and its parameters.
#pragma once

#include <string>
#include <vector>

#include "host-sim/identify/fit.hpp"
#include "host-sim/identify/tassa9.hpp"
#include "host-sim/report/chart.hpp"
#include "host-sim/trace/log.hpp"

namespace plenum::host::tools {

/// Between re-initialised runs, as in Fig. 12.
inline constexpr double kFreeRun_s = 2.0;

double mean(const std::vector<double>& values);
std::vector<double> scaled(std::vector<double> values, double factor);
double to_hundredths(double value);
/// Rounded to three significant digits.
double to_three_digits(double value);

/// Fig. 12: measured pressure, and predictions of 2 s that each start from it.
report::LineChart free_run_chart(const identify::Tassa9& model, const trace::Log& log, std::string title,
                                 std::string caption);
/// What that prediction errs by, predicted minus measured.
report::LineChart free_run_error_chart(const identify::Tassa9& model, const trace::Log& log,
                                       std::string title, std::string caption);

/// One curve of s or r at a volume at rest.
struct ModelCurve {
  std::string name;
  identify::Tassa9 model;
  double volume_mL;
};
struct CommandRange {
  double low_V;
  double high_V;
};
report::XyChart steady_chart(const std::vector<ModelCurve>& models, CommandRange range, std::string caption);
report::XyChart rate_chart(const std::vector<ModelCurve>& models, CommandRange range, std::string caption);

/// Value and standard error; where there is none, a mark for the bound or for a parameter that was held.
std::string parameter_cell(const identify::ParameterFit& of);
/// In words why a parameter is not known; empty where it is.
const char* mark_of(identify::Bound at_bound, bool identifiable);
const char* mark_of(const identify::ParameterFit& of);

}  // namespace plenum::host::tools
