#include "host-sim/identify/ticks.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/trace/log_csv.hpp"

namespace plenum::host::identify {
namespace {

constexpr double kmL_per_m3 = 1e6;
constexpr int kDegree = 3;
/// A dead time so near to whole ticks is that: 3 times 0.01 s by 0.01 s may be less than 3, and no part of a tick is left to act in.
constexpr double kWholeTick = 1e-9;
constexpr int kWindow = 2 * static_cast<int>(kHalfWindow);

using Window = Eigen::Matrix<double, 1, kWindow>;

/// Weights on the 2n rows of a window for value and slope [1/tick] of the fitted cubic at `at` ticks from its
/// middle.
struct Weights {
  Window value;
  Window slope;
};

Weights weights_at(double at) {
  Eigen::Matrix<double, kWindow, kDegree + 1> design;
  for (int i = 0; i < kWindow; ++i) {
    const double x = i - 0.5 * (kWindow - 1);
    design.row(i) << 1.0, x, x * x, x * x * x;
  }
  const Eigen::Matrix<double, kDegree + 1, kWindow> solve =
      (design.transpose() * design).ldlt().solve(design.transpose());
  return {Eigen::RowVector4d(1.0, at, at * at, at * at * at) * solve,
          Eigen::RowVector4d(0.0, 1.0, 2.0 * at, 3.0 * at * at) * solve};
}

/// The command of each row, so many rows before it.
std::vector<double> sent_V(const trace::Log& log, std::size_t ago) {
  std::vector<double> sent(log.size());
  for (std::size_t k = 0; k < log.size(); ++k) sent[k] = log.command_V[k - std::min(k, ago)];
  return sent;
}

void append_commands(const trace::Log& log, std::size_t whole_ticks, Ticks& ticks) {
  const std::vector<double> early = sent_V(log, whole_ticks + 1), late = sent_V(log, whole_ticks);
  ticks.early_V.insert(ticks.early_V.end(), early.begin(), early.end());
  ticks.late_V.insert(ticks.late_V.end(), late.begin(), late.end());
  std::transform(
      early.begin(), early.end(), late.begin(), std::back_inserter(ticks.command_V),
      [&](double first_V, double then_V) { return ticks.early * first_V + (1.0 - ticks.early) * then_V; });
}

void append(const trace::Log& log, Ticks& ticks) {
  const std::size_t rows = log.size();
  const Eigen::Map<const Eigen::VectorXd> volume_m3(log.volume_m3.data(), static_cast<Eigen::Index>(rows));
  const Weights centred = weights_at(0.0);
  for (std::size_t k = 0; k < rows; ++k) {
    // The window whose middle is nearest to k + 1/2, and how far from its middle that is.
    const std::size_t first = std::min(k + 1 < kHalfWindow ? 0 : k + 1 - kHalfWindow, rows - kFewestRows);
    const double off = static_cast<double>(k + 1) - static_cast<double>(first + kHalfWindow);
    const Weights weights = off == 0.0 ? centred : weights_at(off);
    const auto window = volume_m3.segment<kWindow>(static_cast<Eigen::Index>(first));
    ticks.volume_mL.push_back(kmL_per_m3 * weights.value.dot(window));
    ticks.volume_rate_mL_s.push_back(kmL_per_m3 * weights.slope.dot(window) / log.period_s);
    ticks.pressure_kPa.push_back(1e-3 * log.pressure_Pa[k]);
  }
}

}  // namespace

Ticks lay_out(const std::vector<trace::Log>& logs, double dead_time_s) {
  if (logs.empty()) throw CannotIdentify("no log to fit");
  Ticks ticks;
  ticks.period_s = logs.front().period_s;
  ticks.average_s = logs.front().pressure_average_s;
  if (!(ticks.average_s >= 0.0 && ticks.average_s <= ticks.period_s * (1.0 + 1e-9))) {
    throw CannotIdentify(fmt::format("pressure averaged over {} s, expected 0 to one tick of {} s",
                                     ticks.average_s, ticks.period_s));
  }
  ticks.average_s = std::min(ticks.average_s, ticks.period_s);
  const double late_ticks = dead_time_s / ticks.period_s, nearest = std::round(late_ticks);
  const bool whole = std::abs(late_ticks - nearest) < kWholeTick;
  const auto whole_ticks = static_cast<std::size_t>(whole ? nearest : late_ticks);
  ticks.early = whole ? 0.0 : late_ticks - static_cast<double>(whole_ticks);
  ticks.unknown = whole_ticks + (whole ? 0 : 1);
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const trace::Log& log = logs[i];
    if (log.size() < kFewestRows) {
      throw CannotIdentify(
          fmt::format("log {}: {} rows, expected at least {}", i + 1, log.size(), kFewestRows));
    }
    if (std::abs(log.period_s - ticks.period_s) > trace::kSameRate * ticks.period_s ||
        std::abs(log.pressure_average_s - ticks.average_s) > trace::kSameRate * ticks.period_s) {
      throw CannotIdentify(fmt::format(
          "log {}: period {} s, averaging {} s, expected {} s and {} s as in log 1 within {:g} %: "
          "fit it alone, or resample it",
          i + 1, log.period_s, log.pressure_average_s, ticks.period_s, ticks.average_s,
          100.0 * trace::kSameRate));
    }
    ticks.begin.push_back(ticks.size());
    append(log, ticks);
    append_commands(log, whole_ticks, ticks);
  }
  ticks.begin.push_back(ticks.size());
  return ticks;
}

}  // namespace plenum::host::identify
