#include "host-sim/identify/profile.hpp"

#include <algorithm>
#include <exception>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/free_run.hpp"
#include "host-sim/identify/ticks.hpp"

namespace plenum::host::identify {
namespace {

constexpr double kFinest_ticks = 0.02;

/// Error of the next tick [kPa] by dead time [s].
using ByDeadTime = std::function<double(double)>;

/// Of whole ticks the best [s].
double best_whole_ticks_s(const ByDeadTime& error_kPa, double tick_s) {
  double best_s = 0.0, best_kPa = std::numeric_limits<double>::infinity();
  for (int ticks = 0; ticks * tick_s <= trace::kLongestDeadTime_s * (1.0 + 1e-9); ++ticks) {
    const double found_kPa = error_kPa(ticks * tick_s);
    if (!(found_kPa < best_kPa)) continue;
    best_s = ticks * tick_s;
    best_kPa = found_kPa;
  }
  return best_s;
}

/// The golden section of what lies a tick to both sides of `near_s`.
double refined_s(const ByDeadTime& error_kPa, double near_s, double tick_s) {
  constexpr double kInner = 2.0 - std::numbers::phi;  // from either end, of the whole
  double low_s = std::max(0.0, near_s - tick_s),
         high_s = std::min(trace::kLongestDeadTime_s, near_s + tick_s);
  double left_s = low_s + kInner * (high_s - low_s), right_s = high_s - kInner * (high_s - low_s);
  double left_kPa = error_kPa(left_s), right_kPa = error_kPa(right_s);
  while (high_s - low_s > kFinest_ticks * tick_s) {
    if (left_kPa < right_kPa) {
      high_s = right_s;
      right_s = left_s;
      right_kPa = left_kPa;
      left_s = low_s + kInner * (high_s - low_s);
      left_kPa = error_kPa(left_s);
    } else {
      low_s = left_s;
      left_s = right_s;
      left_kPa = right_kPa;
      right_s = high_s - kInner * (high_s - low_s);
      right_kPa = error_kPa(right_s);
    }
  }
  // the ends are no inner points: a valve without any dead time has it at the lower one
  double best_s = left_kPa < right_kPa ? left_s : right_s, best_kPa = std::min(left_kPa, right_kPa);
  for (const double end_s : {low_s, high_s}) {
    const double found_kPa = error_kPa(end_s);
    if (!(found_kPa < best_kPa)) continue;
    best_s = end_s;
    best_kPa = found_kPa;
  }
  return best_s;
}

Tassa9Fit best_of_widths(const std::vector<trace::Log>& logs, const trace::RigDescription& rig,
                         const FitOptions& options) {
  std::optional<Tassa9Fit> best;
  std::exception_ptr first_reason;
  for (const double width_V : kKinkWidths_V) {
    FitOptions tried = options;
    tried.c_gamma_V = width_V;
    try {
      Tassa9Fit fit = fit_tassa9(logs, rig, tried);
      if (!best || fit.rms_free_run_kPa < best->rms_free_run_kPa) best = std::move(fit);
    } catch (const CannotIdentify&) {
      if (!first_reason) first_reason = std::current_exception();
    }
  }
  if (!best) std::rethrow_exception(first_reason);
  return *std::move(best);
}

}  // namespace

Tassa9Fit fit_tassa9_profiled(const std::vector<trace::Log>& logs, const trace::RigDescription& rig,
                              const FitOptions& options, const Profiled& profiled) {
  FitOptions at = options;
  if (profiled.kink_width) at.c_gamma_V = kKinkWidths_V.front();
  const ByDeadTime one_step_kPa = [&](double dead_time_s) {
    FitOptions tried = at;
    tried.dead_time_s = dead_time_s;
    tried.refine_free_run = false;
    try {
      return next_tick_rms_kPa(fit_tassa9(logs, rig, tried).model, lay_out(logs, dead_time_s));
    } catch (const CannotIdentify&) {
      return std::numeric_limits<double>::infinity();
    }
  };
  const double tick_s = lay_out(logs).period_s;
  if (profiled.dead_time) at.dead_time_s = best_whole_ticks_s(one_step_kPa, tick_s);
  if (profiled.kink_width) {
    Tassa9Fit best = best_of_widths(logs, rig, at);
    if (!profiled.dead_time) return best;
    at.c_gamma_V = best.model.c_gamma_V;
  }
  if (profiled.dead_time) at.dead_time_s = refined_s(one_step_kPa, at.dead_time_s, tick_s);
  return fit_tassa9(logs, rig, at);
}

}  // namespace plenum::host::identify
