#include "host-sim/identify/regulator_valve/branch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <stdexcept>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify::regulator_valve {
namespace {

using plant::regulator_valve::Recording;

constexpr double kLead_s = 0.1;  // of the first plateau, so that a branch begins at rest

double mean(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

struct Line {
  double slope_Pa_m;
  double screw_at_m;  // where it meets the pressure asked for
};

Line line_through(const std::vector<Plateau>& points, double pressure_Pa) {
  double x = 0.0;
  double p = 0.0;
  for (const Plateau& point : points) {
    x += point.screw_m / static_cast<double>(points.size());
    p += point.settled_Pa / static_cast<double>(points.size());
  }
  double xx = 0.0;
  double xp = 0.0;
  for (const Plateau& point : points) {
    xx += (point.screw_m - x) * (point.screw_m - x);
    xp += (point.screw_m - x) * (point.settled_Pa - p);
  }
  const double slope_Pa_m = xp / xx;
  return {slope_Pa_m, x + (pressure_Pa - p) / slope_Pa_m};
}

// In time order: those reached by a turn in `direction` that settled within the range.
std::vector<Plateau> plateaus_within(const Recording& recording, Direction direction,
                                     const PressureRange& range) {
  const std::vector<Plateau> all = plateaus(recording);
  std::vector<Plateau> within;
  for (std::size_t i = 1; i < all.size(); ++i) {
    const bool rising = all[i].screw_m > all[i - 1].screw_m;
    if (rising != (direction == Direction::kRising)) continue;
    if (all[i].settled_Pa >= range.low_Pa && all[i].settled_Pa <= range.high_Pa) within.push_back(all[i]);
  }
  if (within.size() < 2) {
    throw CannotIdentify(fmt::format(
        "{} branch: {} plateaus between {:.6g} and {:.6g} Pa, expected at least 2",
        direction == Direction::kRising ? "rising" : "falling", within.size(), range.low_Pa, range.high_Pa));
  }
  return within;
}

void require_sample_time(const char* of, double sample_s) {
  if (!std::isfinite(sample_s) || !(sample_s > 0.0))
    throw std::invalid_argument(fmt::format("{}: sample_s = {}, expected above 0", of, sample_s));
}

}  // namespace

void validate(const Branch& branch) {
  if (branch.screw_m.size() != branch.pressure_Pa.size()) {
    throw std::invalid_argument(fmt::format("branch: {} screw positions and {} pressures, expected as many",
                                            branch.screw_m.size(), branch.pressure_Pa.size()));
  }
  for (std::size_t k = 0; k < branch.screw_m.size(); ++k) {
    if (!std::isfinite(branch.screw_m[k]) || !std::isfinite(branch.pressure_Pa[k]))
      throw std::invalid_argument(fmt::format("branch: sample {} is not finite", k));
  }
  require_sample_time("branch", branch.sample_s);
}

std::vector<Plateau> plateaus(const Recording& recording) {
  const std::size_t samples = recording.screw_m.size();
  if (samples == 0 || recording.pressure_Pa.size() != samples) {
    throw std::invalid_argument(
        fmt::format("recording: {} screw positions and {} pressures, expected as many and some", samples,
                    recording.pressure_Pa.size()));
  }
  std::vector<Plateau> found;
  for (std::size_t first = 0; first < samples;) {
    std::size_t end = first + 1;
    while (end < samples && recording.screw_m[end] == recording.screw_m[first]) ++end;
    const std::size_t quarter = std::max<std::size_t>(1, (end - first) / 4);
    found.push_back({.first = first,
                     .end = end,
                     .screw_m = recording.screw_m[first],
                     .settled_Pa = mean(std::span(recording.pressure_Pa).subspan(end - quarter, quarter))});
    first = end;
  }
  return found;
}

Branch zero_mean(const Recording& recording, std::size_t first, std::size_t end) {
  if (first >= end || end > recording.screw_m.size() || end > recording.pressure_Pa.size()) {
    throw std::invalid_argument(fmt::format("zero_mean: samples {} to {} of {}, expected some of them", first,
                                            end, recording.screw_m.size()));
  }
  const auto screw = std::span(recording.screw_m).subspan(first, end - first);
  const auto pressure = std::span(recording.pressure_Pa).subspan(first, end - first);
  Branch branch{.sample_s = recording.sample_s,
                .first = first,
                .mean_screw_m = mean(screw),
                .mean_pressure_Pa = mean(pressure),
                .screw_m = {screw.begin(), screw.end()},
                .pressure_Pa = {pressure.begin(), pressure.end()}};
  for (double& x : branch.screw_m) x -= branch.mean_screw_m;
  for (double& p : branch.pressure_Pa) p -= branch.mean_pressure_Pa;
  return branch;
}

Branch branch_of(const Recording& recording, Direction direction, const PressureRange& range) {
  require_sample_time("recording", recording.sample_s);
  const std::vector<Plateau> within = plateaus_within(recording, direction, range);
  const auto lead = static_cast<std::size_t>(std::lround(kLead_s / recording.sample_s));
  const Plateau& start = within.front();
  return zero_mean(recording, std::max(start.first, start.end - std::min(start.end, lead)),
                   within.back().end);
}

DeadBand measure_dead_band(const Recording& recording, const PressureRange& range) {
  const double middle_Pa = 0.5 * (range.low_Pa + range.high_Pa);
  const Line rising = line_through(plateaus_within(recording, Direction::kRising, range), middle_Pa);
  const Line falling = line_through(plateaus_within(recording, Direction::kFalling, range), middle_Pa);
  return {.width_m = rising.screw_at_m - falling.screw_at_m,
          .rising_start_m = rising.screw_at_m - middle_Pa / rising.slope_Pa_m,
          .rising_slope_Pa_m = rising.slope_Pa_m,
          .falling_slope_Pa_m = falling.slope_Pa_m};
}

}  // namespace plenum::host::identify::regulator_valve
