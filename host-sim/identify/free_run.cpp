#include "host-sim/identify/free_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify {
namespace {

/// A tick of a log, by the one or two commands that act in it.
class ActingTick {
 public:
  ActingTick(const Tassa9& model, const Ticks& ticks, std::size_t row) : ticks_(ticks) {
    const auto by = [&](double command_V) {
      return steady_and_rate(model, command_V, ticks.volume_mL[row], ticks.volume_rate_mL_s[row]);
    };
    late_ = by(ticks.late_V[row]);
    early_ = ticks.early > 0.0 ? by(ticks.early_V[row]) : late_;
  }

  Step step(double pressure_kPa) const {
    const auto [early_s, late_s, late_average_s] = parts_of_tick();
    const double average_s = ticks_.average_s;
    if (early_s == 0.0) return identify::step(late_, pressure_kPa, late_s, average_s);
    const Step first = identify::step(early_, pressure_kPa, early_s, average_s - late_average_s);
    const Step second = identify::step(late_, first.end_kPa, late_s, late_average_s);
    const double share = average_s > 0.0 ? late_average_s / average_s : 1.0;
    return {second.end_kPa, share * second.mean_kPa + (1.0 - share) * first.mean_kPa};
  }

  /// step() solved for the end. With s and s' of the early and the late part, x = end - s' (the late part begins with x/E), of the
  /// share w of the averaging time in it the mean m x/E, and in the early part u (mean - s) = end - s as in end_from_mean():
  ///   mean = w (s' + m x/E) + (1 - w) (s + (s' + x/E - s)/u)
  /// The start does not enter: however fast the chamber, what has faded of it is not asked for.
  double end_from_mean(double mean_kPa) const {
    const Parts parts = parts_of_tick();
    const double late_average_s = parts.late_average_s, early_average_s = ticks_.average_s - late_average_s;
    if (early_average_s == 0.0) return identify::end_from_mean(late_, mean_kPa, parts.late_s, late_average_s);
    const double w = late_average_s / ticks_.average_s, s = early_.steady_kPa, s_late = late_.steady_kPa;
    const Step left = identify::step({0.0, late_.rate_per_s}, 1.0, parts.late_s, late_average_s);
    const double E = left.end_kPa, m = left.mean_kPa;
    const double u = identify::end_from_mean({0.0, early_.rate_per_s}, 1.0, parts.early_s, early_average_s);
    const double above = u * (mean_kPa - w * s_late - (1.0 - w) * s) - (1.0 - w) * (s_late - s);
    return s_late + E * above / (w * m * u + 1.0 - w);
  }

 private:
  struct Parts {
    double early_s, late_s, late_average_s;
  };
  Parts parts_of_tick() const {
    const double early_s = ticks_.early * ticks_.period_s, late_s = ticks_.period_s - early_s;
    return {early_s, late_s, std::min(ticks_.average_s, late_s)};
  }

  const Ticks& ticks_;
  SteadyAndRate early_{}, late_{};
};

std::size_t rows_of(double every_s, double period_s) {
  return static_cast<std::size_t>(std::max(1.0, std::round(every_s / period_s)));
}

std::vector<FreeRun> runs(const Tassa9& model, const Ticks& ticks, double every_s) {
  const std::size_t length = rows_of(every_s, ticks.period_s);
  std::vector<FreeRun> all;
  for (std::size_t start = 0; start + 1 < ticks.size(); start += length) {
    FreeRun run{start, predict_free_run_kPa(model, ticks, start, std::min(length, ticks.size() - 1 - start))};
    for (double& pressure : run.pressure_Pa) pressure *= 1e3;
    all.push_back(std::move(run));
  }
  return all;
}

}  // namespace

std::vector<double> predict_free_run_kPa(const Tassa9& model, const Ticks& ticks, std::size_t start_row,
                                         std::size_t rows) {
  // The first row of a log has no tick before it: its sample is taken as it stands.
  double pressure_kPa = ticks.pressure_kPa[start_row];
  if (start_row > 0) {
    pressure_kPa = ActingTick(model, ticks, start_row - 1).end_from_mean(pressure_kPa);
  }
  std::vector<double> predicted;
  predicted.reserve(rows);
  for (std::size_t row = start_row; row < start_row + rows; ++row) {
    const Step next = ActingTick(model, ticks, row).step(pressure_kPa);
    predicted.push_back(next.mean_kPa);
    pressure_kPa = next.end_kPa;
  }
  return predicted;
}

std::vector<double> predict_free_run(const Tassa9& model, const trace::Log& log, std::size_t start_row,
                                     std::size_t rows) {
  if (start_row + rows >= log.size()) {
    throw CannotIdentify(fmt::format("free run of rows {} to {}, expected a log of more than {} rows",
                                     start_row, start_row + rows, log.size()));
  }
  std::vector<double> predicted =
      predict_free_run_kPa(model, lay_out({log}, model.dead_time_s), start_row, rows);
  for (double& pressure : predicted) pressure *= 1e3;
  return predicted;
}

std::vector<FreeRun> reinitialised_runs(const Tassa9& model, const trace::Log& log, double every_s) {
  return runs(model, lay_out({log}, model.dead_time_s), every_s);
}

double free_run_rms_kPa(const Tassa9& model, const trace::Log& log, double every_s) {
  double square = 0.0;
  for (const FreeRun& run : reinitialised_runs(model, log, every_s)) {
    for (std::size_t i = 0; i < run.pressure_Pa.size(); ++i) {
      const double error_kPa = 1e-3 * (run.pressure_Pa[i] - log.pressure_Pa[run.start_row + 1 + i]);
      square += error_kPa * error_kPa;
    }
  }
  return std::sqrt(square / static_cast<double>(log.size() - 1));
}

double next_tick_rms_kPa(const Tassa9& model, const Ticks& ticks, std::size_t from_row) {
  double square = 0.0;
  std::size_t rows = 0;
  for (std::size_t log = 0; log + 1 < ticks.begin.size(); ++log) {
    // of the first row it is not known which pressure its tick begins with
    for (std::size_t row = ticks.begin[log] + from_row; row + 1 < ticks.begin[log + 1]; ++row) {
      const double start_kPa = ActingTick(model, ticks, row - 1).end_from_mean(ticks.pressure_kPa[row]);
      const double error_kPa =
          ActingTick(model, ticks, row).step(start_kPa).mean_kPa - ticks.pressure_kPa[row + 1];
      square += error_kPa * error_kPa;
      ++rows;
    }
  }
  return std::sqrt(square / static_cast<double>(rows));
}

double held_start_rms_kPa(const trace::Log& log, double every_s) {
  const std::size_t length = rows_of(every_s, log.period_s);
  double square = 0.0;
  for (std::size_t row = 1; row < log.size(); ++row) {
    const std::size_t start = (row - 1) / length * length;
    const double error_kPa = 1e-3 * (log.pressure_Pa[start] - log.pressure_Pa[row]);
    square += error_kPa * error_kPa;
  }
  return std::sqrt(square / static_cast<double>(log.size() - 1));
}

double held_mean_rms_kPa(const trace::Log& log) {
  double mean_Pa = 0.0;
  for (const double p : log.pressure_Pa) mean_Pa += p / static_cast<double>(log.size());
  double square = 0.0;
  for (const double p : log.pressure_Pa) square += 1e-6 * (p - mean_Pa) * (p - mean_Pa);
  return std::sqrt(square / static_cast<double>(log.size()));
}

Drift drift(const Ticks& ticks, double span_kPa, const Predictor& predict, const DriftRuns& runs) {
  const std::size_t horizon = rows_of(runs.horizon_s, ticks.period_s);
  const std::size_t to_row = std::min(runs.to_row, ticks.size());
  const std::size_t rows = to_row > runs.from_row ? to_row - runs.from_row : 0;
  if (runs.starts < 2 || rows < horizon + runs.starts) {
    throw CannotIdentify(
        fmt::format("drift of {} starts over {} s: {} rows, expected at least 2 starts and {} rows",
                    runs.starts, runs.horizon_s, rows, horizon + runs.starts));
  }
  const double to_percent = 100.0 / span_kPa;
  const auto n = static_cast<double>(runs.starts);
  std::vector<double> sum(horizon, 0.0);
  std::vector<double> square(horizon, 0.0);
  for (std::size_t i = 0; i < runs.starts; ++i) {
    const std::size_t start = runs.from_row + i * (rows - 1 - horizon) / (runs.starts - 1);
    const std::vector<double> predicted = predict(start, horizon);
    for (std::size_t k = 0; k < horizon; ++k) {
      const double error = to_percent * (predicted[k] - ticks.pressure_kPa[start + 1 + k]);
      sum[k] += error;
      square[k] += error * error;
    }
  }
  Drift drift;
  for (std::size_t k = 0; k < horizon; ++k) {
    const double mean = sum[k] / n;
    drift.time_s.push_back(static_cast<double>(k + 1) * ticks.period_s);
    drift.mean_percent.push_back(mean);
    drift.std_percent.push_back(std::sqrt(std::max(0.0, square[k] - n * mean * mean) / (n - 1.0)));
  }
  drift.worst_std_percent = *std::max_element(drift.std_percent.begin(), drift.std_percent.end());
  return drift;
}

Drift drift(const trace::Log& log, const Tassa9& model, std::size_t starts, double horizon_s) {
  const Ticks ticks = lay_out({log}, model.dead_time_s);
  return drift(ticks, model.supply_kPa - model.ambient_kPa,
               [&](std::size_t start_row, std::size_t rows) {
                 return predict_free_run_kPa(model, ticks, start_row, rows);
               },
               {.starts = starts, .horizon_s = horizon_s});
}

}  // namespace plenum::host::identify
