#include "host-sim/identify/profile.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/excitation.hpp"
#include "host-sim/identify/free_run.hpp"
#include "host-sim/identify/ticks.hpp"

namespace plenum::host::identify {
namespace {

constexpr double kFinest_ticks = 0.02;
/// Of the squares, in variances of one error: three standard errors.
constexpr double kClearRise = 9.0;
constexpr double kIdentifiable_ticks = 0.25;
constexpr double kRounding = 1e-9;

/// The mean square of the next tick's error by dead time, at what the options hold besides; each is fitted once. A tick of dead time
/// has to be worth the variance of an error: of those that fit alike the shorter, none where the logs show none.
class NextTickSquares {
 public:
  NextTickSquares(const std::vector<trace::Log>& logs, const trace::RigDescription& rig,
                  const FitOptions& options, double tick_s)
      : logs_(logs), rig_(rig), options_(options), tick_s_(tick_s) {
    std::size_t shortest = logs.front().size();
    for (const trace::Log& log : logs) shortest = std::min(shortest, log.size());
    const auto latest = static_cast<std::size_t>(std::ceil(trace::kLongestDeadTime_s / tick_s));
    from_row_ = 1 + std::min(latest, shortest / 2);
    for (const trace::Log& log : logs) freedom_ += static_cast<double>(log.size() - 1 - from_row_);
    freedom_ = std::max(1.0, freedom_ - static_cast<double>(kFree) - 1.0);
  }

  /// [kPa^2]
  double at(double dead_time_s) {
    const auto [found, is_new] = known_.try_emplace(dead_time_s, 0.0);
    if (is_new) {
      options_.dead_time_s = dead_time_s;
      const Ticks ticks = lay_out(logs_, dead_time_s);
      const double rms_kPa =
          next_tick_rms_kPa(least_next_tick_error(ticks, rig_, options_), ticks, from_row_);
      found->second = rms_kPa * rms_kPa * (1.0 + dead_time_s / tick_s_ / freedom_);
    }
    return found->second;
  }

  /// Of those asked for so far the least [s].
  double best_s() const {
    return std::ranges::min_element(known_, {}, [](const auto& one) { return one.second; })->first;
  }

  double least() const { return known_.at(best_s()); }

  /// By how much the sum of squares is above that at best_s(), in variances of an error there.
  double rise(double dead_time_s) {
    const double squares = at(dead_time_s), lowest = least();
    return freedom_ * (squares - lowest) / std::max(lowest, std::numeric_limits<double>::min());
  }

 private:
  const std::vector<trace::Log>& logs_;
  const trace::RigDescription& rig_;
  FitOptions options_;
  double tick_s_;
  /// Of whatever dead time the same rows are compared, those whose commands are known.
  std::size_t from_row_ = 1;
  double freedom_ = 0.0;
  std::map<double, double> known_;
};

std::vector<double> whole_ticks_s(double tick_s) {
  std::vector<double> all;
  for (int ticks = 0; ticks * tick_s <= trace::kLongestDeadTime_s * (1.0 + kRounding); ++ticks) {
    all.push_back(std::min(ticks * tick_s, trace::kLongestDeadTime_s));
  }
  return all;
}

/// At whole ticks by the paper's width, and where `any_width` by the one that is best at the best of these.
NextTickSquares at_whole_ticks(const std::vector<trace::Log>& logs, const trace::RigDescription& rig,
                               FitOptions options, bool any_width, double tick_s) {
  if (any_width) options.c_gamma_V = kKinkWidths_V.front();
  NextTickSquares best(logs, rig, options, tick_s);
  for (const double dead_time_s : whole_ticks_s(tick_s)) best.at(dead_time_s);
  if (!any_width) return best;
  const double near_s = best.best_s();
  std::optional<NextTickSquares> wider;
  for (const double width_V : std::span(kKinkWidths_V).subspan(1)) {
    options.c_gamma_V = width_V;
    NextTickSquares tried(logs, rig, options, tick_s);
    if (tried.at(near_s) < (wider ? wider->least() : best.least())) wider.emplace(std::move(tried));
  }
  return wider ? *std::move(wider) : best;
}

/// Of a form that misses what a moving volume does, lateness makes up for some of it: the valve's is that of the form that follows the
/// logs better.
NextTickSquares by_better_form(const std::vector<trace::Log>& logs, const trace::RigDescription& rig,
                               FitOptions options, bool any_width, double tick_s) {
  NextTickSquares published = at_whole_ticks(logs, rig, options, any_width, tick_s);
  if (options.form != Form::published || !volume_moves(lay_out(logs))) return published;
  options.form = Form::repaired;
  NextTickSquares repaired = at_whole_ticks(logs, rig, options, any_width, tick_s);
  return repaired.least() < published.least() ? repaired : published;
}

/// The golden section of what lies a tick to both sides of `near_s`, these three besides: between whole ticks the fit's mean of two
/// commands may be the worse model by more than the dead time is worth.
void refine(NextTickSquares& squares, double near_s, double tick_s) {
  constexpr double kInner = 2.0 - std::numbers::phi;  // from either end, of the whole
  double low_s = std::max(0.0, near_s - tick_s),
         high_s = std::min(trace::kLongestDeadTime_s, near_s + tick_s);
  for (const double whole_s : {low_s, near_s, high_s}) squares.at(whole_s);
  double left_s = low_s + kInner * (high_s - low_s), right_s = high_s - kInner * (high_s - low_s);
  while (high_s - low_s > kFinest_ticks * tick_s) {
    if (squares.at(left_s) < squares.at(right_s)) {
      high_s = right_s;
      right_s = left_s;
      left_s = low_s + kInner * (high_s - low_s);
    } else {
      low_s = left_s;
      left_s = right_s;
      right_s = high_s - kInner * (high_s - low_s);
    }
  }
}

/// By the parabola through the least and the nearest whole tick at which the squares have clearly risen, the flatter of both sides;
/// infinite where they do not rise.
double standard_error_s(NextTickSquares& squares, double tick_s) {
  const double best_s = squares.best_s();
  const std::vector<double> rising_s = whole_ticks_s(tick_s);
  const std::vector<double> falling_s(rising_s.rbegin(), rising_s.rend());
  const auto along = [&](const std::vector<double>& outward_s, double sign) {
    for (const double whole_s : outward_s) {
      if (sign * (whole_s - best_s) < 0.5 * tick_s) continue;
      const double rise = squares.rise(whole_s);
      if (rise >= kClearRise) return std::abs(whole_s - best_s) / std::sqrt(rise);
    }
    return 0.0;
  };
  const double error_s = std::max(along(rising_s, 1.0), along(falling_s, -1.0));
  return error_s > 0.0 ? error_s : std::numeric_limits<double>::infinity();
}

/// Near the best so far, with what the logs tell of it.
ParameterFit refined(NextTickSquares squares, double tick_s) {
  refine(squares, squares.best_s(), tick_s);
  ParameterFit found;
  found.value = squares.best_s();
  found.standard_error = standard_error_s(squares, tick_s);
  if (trace::kLongestDeadTime_s - found.value < kFinest_ticks * tick_s) {
    found.at_bound = Bound::high;
    found.standard_error = std::numeric_limits<double>::quiet_NaN();
  }
  found.identifiable = found.at_bound == Bound::none && found.standard_error < kIdentifiable_ticks * tick_s;
  return found;
}

/// That the pressure follows the command, however late. Throws CannotIdentify with the reason at the first.
void require_excitation_late(const std::vector<trace::Log>& logs, double tick_s) {
  std::exception_ptr first_reason;
  for (const double dead_time_s : whole_ticks_s(tick_s)) {
    try {
      return require_excitation(lay_out(logs, dead_time_s));
    } catch (const CannotIdentify&) {
      if (!first_reason) first_reason = std::current_exception();
    }
  }
  std::rethrow_exception(first_reason);
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
  std::optional<ParameterFit> dead_time;
  if (profiled.dead_time) {
    const double tick_s = lay_out(logs).period_s;
    require_excitation_late(logs, tick_s);
    dead_time = refined(by_better_form(logs, rig, options, profiled.kink_width, tick_s), tick_s);
    at.dead_time_s = dead_time->value;
  }
  Tassa9Fit fit = profiled.kink_width ? best_of_widths(logs, rig, at) : fit_tassa9(logs, rig, at);
  if (dead_time) fit.dead_time = *dead_time;
  return fit;
}

}  // namespace plenum::host::identify
