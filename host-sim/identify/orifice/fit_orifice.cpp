#include "host-sim/identify/orifice/fit_orifice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "host-sim/identify/orifice/bounded_squares.hpp"
#include "host-sim/identify/orifice/filter.hpp"
#include "host-sim/identify/orifice/vessel_run.hpp"
#include "host-sim/plant/refuse.hpp"

namespace plenum::host::identify::orifice {
namespace {

// The variables of both fits: ln k [k in 1/s], b, beta, a, p_0 [bar].
enum Variable : std::size_t { kLogRate, kCritical, kIndex, kCracking, kStart, kVariables };

constexpr double kBar_Pa = 1e5;
constexpr std::size_t kLeastRows = 20;
constexpr double kLeastMove = 10.0;      // of the vessel, in standard deviations of its noise
constexpr double kBelowCracking = 0.95;  // b stays below this share of a: (6) needs b < a
constexpr double kReached = 0.99;     // of the greatest ratio recorded: flow ceased no earlier, noise aside
constexpr double kLeastSpan = 0.02;   // of the ratio: over less, every flow shape is a straight line
constexpr double kLeastIndex = 1e-3;  // (6) is no function of pressure at beta = 0
constexpr double kKnownTo = 0.25;     // standard error against its scale
constexpr double kRateTolerance = 1e-12;     // the paper's; of the sum of squares
constexpr double kPressureTolerance = 1e-6;  // of a thousand rows: a thirtieth of a standard error
// Flow shapes to start from: nearly elliptic as an ISO orifice, and nearly parabolic as the paper's small
// openings.
constexpr std::array<std::pair<double, double>, 2> kStartShapes = {{{0.4, 0.5}, {0.05, 0.9}}};

plant::EllipsePort port_of(const double* z) {
  return {std::exp(z[kLogRate]), z[kCritical], z[kCracking], z[kIndex]};
}

double mean_of_tenth(const std::vector<double>& x, bool last) {
  const std::size_t n = std::max<std::size_t>(x.size() / 10, 1);
  const std::size_t from = last ? x.size() - n : 0;
  double sum = 0.0;
  for (std::size_t i = from; i < from + n; ++i) sum += x[i];
  return sum / static_cast<double>(n);
}

void require_motion(const VesselRecord& record) {
  const double moved_Pa = mean_of_tenth(record.vessel_Pa, true) - mean_of_tenth(record.vessel_Pa, false);
  const double forward_Pa = record.flow == Flow::kCharge ? moved_Pa : -moved_Pa;
  const double noise = noise_deviation(record.vessel_Pa);
  const char* what = record.flow == Flow::kCharge ? "charge" : "discharge";
  if (std::abs(forward_Pa) <= kLeastMove * noise)
    throw CannotIdentify(
        fmt::format("fit_orifice: no excitation: in this {} the vessel moves by {:.3g} kPa "
                    "with noise of {:.3g} kPa, less than {} times",
                    what, std::abs(forward_Pa) / 1e3, noise / 1e3, kLeastMove));
  if (forward_Pa < 0.0)
    throw CannotIdentify(fmt::format("fit_orifice: in this {} the vessel's pressure {} by {:.3g} kPa", what,
                                     moved_Pa < 0.0 ? "falls" : "rises", std::abs(moved_Pa) / 1e3));
}

void validate(const OrificeFitOptions& options) {
  plant::require_within("fit_orifice moving_average_rows", static_cast<double>(options.moving_average_rows),
                        1, 1e6);
  plant::require_within("fit_orifice most_critical_ratio", options.most_critical_ratio, 1e-6, 0.95);
  plant::require_within("fit_orifice most_subsonic_index", options.most_subsonic_index, 2.0 * kLeastIndex,
                        100.0);
  plant::require_above("fit_orifice most_area_m2", options.most_area_m2, 0.0);
  if (options.critical_ratio)
    plant::require_within("fit_orifice critical_ratio", *options.critical_ratio, 0.0, 0.99);
  if (options.subsonic_index)
    plant::require_within("fit_orifice subsonic_index", *options.subsonic_index, kLeastIndex, 100.0);
  if (options.cracking_ratio)
    plant::require_within("fit_orifice cracking_ratio", *options.cracking_ratio,
                          options.critical_ratio.value_or(0.0) + 1e-3, 1.0);
}

struct Span {
  double least = std::numeric_limits<double>::infinity();
  double greatest = 0.0;
};

Span ratios(const VesselRecord& record) {
  Span span;
  for (std::size_t i = 0; i < record.time_s.size(); ++i) {
    const double ratio = pressure_ratio(record, i);
    span.least = std::min(span.least, ratio);
    span.greatest = std::max(span.greatest, ratio);
  }
  return span;
}

bool shape_held(const OrificeFitOptions& options) {
  return options.critical_ratio && options.subsonic_index && options.cracking_ratio;
}

void require_span(const Span& span, const OrificeFitOptions& options) {
  if (shape_held(options) || span.greatest - span.least >= kLeastSpan) return;
  throw ShapeNotSeen(fmt::format(
      "fit_orifice: pressure ratios from {:.4f} to {:.4f} do not show a flow shape; hold critical_ratio, "
      "subsonic_index and cracking_ratio, or record more of the curve",
      span.least, span.greatest));
}

struct Setting {
  const VesselRecord& record;
  RateRecord rates;
  BoundedSquares box;  // bounds and steps; errors differ by fit
};

Setting setting_of(const VesselRecord& record, const Vessel& vessel, const OrificeFitOptions& options) {
  const VesselRecord filtered =
      moving_average(record, std::min(options.moving_average_rows, record.time_s.size()));
  Setting setting{record, differentiated(filtered), {}};
  const double cracking = options.cracking_ratio.value_or(std::min(ratios(filtered).greatest, 1.0));
  const double most_critical = std::min(options.most_critical_ratio, kBelowCracking * cracking);
  const std::optional<double> rate_of_area = choked_rate_of_area_1_s_m2(vessel);
  const double most_log_rate = std::log(rate_of_area ? *rate_of_area * options.most_area_m2 : 1e4);
  setting.box.low = {-30.0, 0.0, kLeastIndex, cracking, record.vessel_Pa.front() / kBar_Pa};
  setting.box.high = {most_log_rate, most_critical, options.most_subsonic_index, cracking,
                      record.vessel_Pa.front() / kBar_Pa};
  setting.box.step = {1e-5, 1e-5, 1e-5, 1e-6, 1e-4};
  if (options.critical_ratio) {
    if (*options.critical_ratio >= cracking)
      throw std::invalid_argument(
          fmt::format("fit_orifice critical_ratio: {}, expected below the cracking ratio {:.4g}",
                      *options.critical_ratio, cracking));
    setting.box.low[kCritical] = setting.box.high[kCritical] = *options.critical_ratio;
  }
  if (options.subsonic_index) setting.box.low[kIndex] = setting.box.high[kIndex] = *options.subsonic_index;
  return setting;
}

// k by linear least squares for a given shape, as a start.
double rate_for_shape(const RateRecord& rates, const plant::EllipsePort& unit) {
  double with = 0.0;
  double square = 0.0;
  for (std::size_t i = 0; i < rates.rate_Pa_s.size(); ++i) {
    const double g = vessel_rate(unit, rates.at.flow, rates.at.vessel_Pa[i], rates.at.far_Pa[i]).rate_Pa_s;
    with += g * rates.rate_Pa_s[i];
    square += g * g;
  }
  if (!(with > 0.0))
    throw CannotIdentify(
        "fit_orifice: the pressure's rate of change does not follow a flow down the pressure difference");
  return with / square;
}

SquaresMinimum fit_rates(const Setting& setting) {
  const RateRecord& rates = setting.rates;
  double square = 0.0;
  for (const double rate : rates.rate_Pa_s) square += rate * rate;
  const double unit = std::sqrt(square / static_cast<double>(rates.rate_Pa_s.size()));
  BoundedSquares problem = setting.box;
  problem.rows = static_cast<int>(rates.rate_Pa_s.size());
  problem.at = [&rates, unit](const double* z, double* errors) {
    const plant::EllipsePort port = port_of(z);
    for (std::size_t i = 0; i < rates.rate_Pa_s.size(); ++i) {
      const Rate model = vessel_rate(port, rates.at.flow, rates.at.vessel_Pa[i], rates.at.far_Pa[i]);
      errors[i] = (model.rate_Pa_s - rates.rate_Pa_s[i]) / unit;
    }
  };
  SquaresMinimum best;
  best.squares = std::numeric_limits<double>::infinity();
  for (const auto& [critical, index] : kStartShapes) {
    std::vector<double> start = {0.0, critical, index, problem.low[kCracking], problem.low[kStart]};
    for (std::size_t i = kCritical; i < kVariables; ++i)
      start[i] = std::clamp(start[i], problem.low[i], problem.high[i]);
    start[kLogRate] = std::log(rate_for_shape(rates, port_of(start.data())));
    const SquaresMinimum minimum = minimise(problem, start, kRateTolerance);
    if (minimum.squares < best.squares) best = minimum;
  }
  return best;
}

SquaresMinimum fit_pressures(const Setting& setting, bool fit_cracking_ratio,
                             const std::vector<double>& start) {
  BoundedSquares problem = setting.box;
  problem.low[kStart] = 0.5 * start[kStart];
  problem.high[kStart] = 1.5 * start[kStart];
  if (fit_cracking_ratio) {
    problem.low[kCracking] = std::max(kReached * start[kCracking], problem.high[kCritical] / kBelowCracking);
    problem.high[kCracking] = 1.0;
  }
  const VesselRecord& record = setting.record;
  problem.rows = static_cast<int>(record.time_s.size());
  problem.at = [&record](const double* z, double* errors) {
    const std::vector<double> run = free_run(port_of(z), record, z[kStart] * kBar_Pa);
    for (std::size_t i = 0; i < run.size(); ++i) errors[i] = (run[i] - record.vessel_Pa[i]) / kBar_Pa;
  };
  return minimise(problem, start, kPressureTolerance);
}

OrificeParameter parameter(const SquaresMinimum& minimum, Variable which, bool held, double scale) {
  OrificeParameter p;
  p.value = minimum.variables[which];
  p.held = held;
  p.at_bound = minimum.at_bound[which];
  p.standard_error = held ? std::numeric_limits<double>::quiet_NaN() : minimum.standard_errors[which];
  p.identified = !held && p.at_bound == Bound::none && p.standard_error < kKnownTo * scale;
  if (held)
    p.why_not = "held";
  else if (p.at_bound != Bound::none)
    p.why_not = bound_in_words(p.at_bound);
  else if (!p.identified)
    p.why_not = "the record's pressure ratios do not fix it";
  return p;
}

void require_rate(const OrificeParameter& log_rate, const Span& span, const OrificeFitOptions& options) {
  if (log_rate.identified) return;
  const std::string why =
      fmt::format("fit_orifice: the choked rate is not fixed by pressure ratios from {:.3f} to {:.3f} ({})",
                  span.least, span.greatest, log_rate.why_not);
  if (log_rate.at_bound != Bound::none || shape_held(options)) throw CannotIdentify(why);
  throw ShapeNotSeen(why + "; hold critical_ratio and subsonic_index, or record more of the curve");
}

OrificeParameter times(OrificeParameter log_value, double factor) {
  log_value.value = factor * std::exp(log_value.value);
  log_value.standard_error *= log_value.value;
  return log_value;
}

}  // namespace

OrificeFitOptions held_at_thin_plate(OrificeFitOptions options) {
  options.cracking_ratio = 1.0;
  options.critical_ratio = 0.528;
  options.subsonic_index = 0.5;
  return options;
}

OrificeFit fit_orifice(const VesselRecord& record, const Vessel& vessel, const OrificeFitOptions& options) {
  validate(record, std::max(kLeastRows, options.moving_average_rows + kLeastRows));
  validate(options);
  const std::optional<double> rate_of_area = choked_rate_of_area_1_s_m2(vessel);
  require_motion(record);
  const Span span = ratios(record);
  require_span(span, options);

  const Setting setting = setting_of(record, vessel, options);
  SquaresMinimum minimum = fit_rates(setting);
  const int first_iterations = minimum.iterations;
  const bool move_cracking = options.pressure_fit && !options.cracking_ratio;
  if (options.pressure_fit) {
    minimum = fit_pressures(setting, move_cracking, minimum.variables);
    minimum.iterations += first_iterations;
  }

  OrificeFit fit;
  fit.least_ratio = span.least;
  fit.greatest_ratio = span.greatest;
  const OrificeParameter log_rate = parameter(minimum, kLogRate, false, 1.0);
  require_rate(log_rate, span, options);
  fit.choked_rate_1_s = times(log_rate, 1.0);
  if (rate_of_area) fit.area_m2 = times(log_rate, 1.0 / *rate_of_area);
  fit.critical_ratio =
      parameter(minimum, kCritical, options.critical_ratio.has_value(), options.most_critical_ratio);
  fit.subsonic_index =
      parameter(minimum, kIndex, options.subsonic_index.has_value(), minimum.variables[kIndex]);
  fit.cracking_ratio = parameter(minimum, kCracking, !move_cracking, 1.0 - minimum.variables[kCritical]);
  fit.start_Pa = minimum.variables[kStart] * kBar_Pa;
  fit.iterations = minimum.iterations;
  fit.converged = minimum.converged;
  fit.stop = minimum.stop;

  const std::vector<double> run = free_run(fit.port_1_s(), record, fit.start_Pa);
  fit.mean_absolute_error_Pa = mean_absolute_error(run, record.vessel_Pa);
  double square = 0.0;
  for (std::size_t i = 0; i < run.size(); ++i)
    square += (run[i] - record.vessel_Pa[i]) * (run[i] - record.vessel_Pa[i]);
  fit.rms_error_Pa = std::sqrt(square / static_cast<double>(run.size()));
  return fit;
}

}  // namespace plenum::host::identify::orifice
