#include "host-sim/client/references.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include "firmware/canopen/objects.hpp"

namespace plenum::host::client {
namespace {

constexpr double kCycle_s = 0.01;
constexpr std::size_t kRandomSines = 12;
constexpr double kSettled = 0.01;  ///< of span
constexpr double kStep = 0.05;     ///< of span

/// tau y' = r - y of a reference r that goes straight from one tick to the next.
class LaggingSensor {
 public:
  LaggingSensor(double at_Pa, double lag_s)
      : shown_Pa_(at_Pa), lag_s_(lag_s), left_(lag_s > 0.0 ? std::exp(-kCycle_s / lag_s) : 0.0) {}

  /// Its mean over a tick.
  double mean_Pa(double from_Pa, double to_Pa) {
    const double behind_Pa = lag_s_ / kCycle_s * (to_Pa - from_Pa);
    const double shown_Pa = to_Pa - behind_Pa + (shown_Pa_ - from_Pa + behind_Pa) * left_;
    const double mean_Pa = 0.5 * (from_Pa + to_Pa) - lag_s_ / kCycle_s * (shown_Pa - shown_Pa_);
    shown_Pa_ = shown_Pa;
    return mean_Pa;
  }

 private:
  double shown_Pa_;
  double lag_s_;
  double left_;
};

void require_frequency(const ReferenceShape& shape) {
  if (!(shape.frequency_Hz > 0.0 && shape.frequency_Hz < 50.0)) {
    throw std::invalid_argument(
        fmt::format("reference at {:g} Hz, expected above 0 and below 50 Hz", shape.frequency_Hz));
  }
}

/// A trapezoid of period 1 between -1 and 1, rising in the first quarter.
double trapezoid(double cycles) {
  const double at = 4.0 * (cycles - std::floor(cycles));
  return std::clamp(at, 0.0, 1.0) * 2.0 - 1.0 - 2.0 * std::clamp(at - 2.0, 0.0, 1.0);
}

/// A sum of sines that a valve can follow: nothing above the given frequency.
class BandLimited {
 public:
  BandLimited(double highest_Hz, std::mt19937& bits) : highest_Hz_(highest_Hz) {
    for (double& phase : phase_rad_)
      phase = 2.0 * std::numbers::pi * static_cast<double>(bits()) / 4294967296.0;
  }
  double at(double time_s) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < kRandomSines; ++i) {
      const double share = static_cast<double>(i) / (kRandomSines - 1);
      const double frequency_Hz = highest_Hz_ * (0.1 + 0.9 * share);
      sum += 0.15 * std::sin(2.0 * std::numbers::pi * frequency_Hz * time_s + phase_rad_[i]);
    }
    return std::clamp(sum, -1.0, 1.0);
  }

 private:
  double highest_Hz_;
  std::array<double, kRandomSines> phase_rad_{};
};

}  // namespace

std::vector<std::vector<double>> references(const ReferenceShape& shape, unsigned chambers, double seconds) {
  require_frequency(shape);
  const auto count = static_cast<std::size_t>(std::lround(seconds / kCycle_s));
  std::mt19937 bits(shape.seed);  // its sequence is the standard's; a distribution's is not
  std::vector<std::vector<double>> result(chambers);
  for (unsigned chamber = 0; chamber < chambers; ++chamber) {
    const BandLimited random(shape.frequency_Hz, bits);
    for (std::size_t k = 0; k < count; ++k) {
      const double time_s = kCycle_s * static_cast<double>(k);
      const double cycles = shape.frequency_Hz * time_s;
      double unit = 0.0;
      switch (shape.kind) {
        case ReferenceKind::sine:
          unit = std::sin(2.0 * std::numbers::pi * cycles);
          break;
        case ReferenceKind::steps: {
          const double phase = cycles + 1.0 - 0.1 * static_cast<double>(chamber);
          unit = phase - std::floor(phase) < 0.5 ? -1.0 : 1.0;
          break;
        }
        case ReferenceKind::trapezoid:
          unit = trapezoid(cycles);
          break;
        case ReferenceKind::random:
          unit = random.at(time_s);
          break;
      }
      result[chamber].push_back(shape.mean_Pa + shape.amplitude_Pa * unit);
    }
  }
  return result;
}

void require_within_limits(Session& session, std::span<const std::vector<double>> references_Pa) {
  constexpr double kPascal_per_mbar = 100.0;
  constexpr double kRounded_Pa = kPascal_per_mbar / 2;  // a limit is shown in whole millibar
  for (std::size_t c = 0; c < references_Pa.size(); ++c) {
    if (references_Pa[c].empty()) continue;
    const auto limit_Pa = [&](std::uint16_t object) {
      return kPascal_per_mbar * session.read<std::int16_t>(canopen::object::of_module(object, c), 1);
    };
    const double low_Pa = limit_Pa(canopen::object::kLowerLimit),
                 high_Pa = limit_Pa(canopen::object::kUpperLimit);
    const auto [least, most] = std::minmax_element(references_Pa[c].begin(), references_Pa[c].end());
    if (*least >= low_Pa - kRounded_Pa && *most <= high_Pa + kRounded_Pa) continue;
    throw std::invalid_argument(
        fmt::format("node {}: chamber {}: reference from {:g} to {:g} kPa, expected within {:g} to {:g} kPa, "
                    "the limits of "
                    "its set point (63A1h, 63A0h), to which the board would clip it",
                    session.node_id(), c + 1, *least / 1e3, *most / 1e3, low_Pa / 1e3, high_Pa / 1e3));
  }
}

Tracking tracking(std::span<const CapturedRow> rows, std::size_t chamber, double span_Pa,
                  double sensor_lag_s) {
  if (rows.size() < kOnsetRows + 2) {
    throw std::invalid_argument(
        fmt::format("{} rows, expected at least {} to judge tracking", rows.size(), kOnsetRows + 2));
  }
  const auto reference = [&](std::size_t k) { return rows[k].reference_Pa[chamber]; };
  const auto pressure = [&](std::size_t k) { return rows[k].sample[chamber].actual_Pa; };
  Tracking result;
  LaggingSensor sensor(reference(0), sensor_lag_s);
  double sum = 0.0;
  for (std::size_t k = 1; k < rows.size(); ++k) {
    const double error_Pa = pressure(k) - sensor.mean_Pa(reference(k - 1), reference(k));
    if (k < kOnsetRows) continue;
    sum += error_Pa * error_Pa;
    result.worst_Pa = std::max(result.worst_Pa, std::abs(error_Pa));
  }
  result.rmse_Pa = std::sqrt(sum / static_cast<double>(rows.size() - kOnsetRows));

  bool all_settled = true;
  double settling_s = 0.0;
  for (std::size_t k = kOnsetRows; k < rows.size(); ++k) {
    const double step_Pa = reference(k) - reference(k - 1);
    if (std::abs(step_Pa) <= kStep * span_Pa || reference(k - 1) != reference(k - 2)) continue;
    std::size_t end = k + 1;
    while (end < rows.size() && reference(end) == reference(k)) ++end;
    if (end == k + 1 && end < rows.size()) continue;  // no rest after it: a fast sine
    if (end < rows.size()) {
      end -= std::min(end - k - 1, kPreviewRows);
    } else if (end - k < kOnsetRows) {
      break;  // the record ends before this step could show
    }
    if (std::isnan(result.overshoot_Pa)) result.overshoot_Pa = 0.0;
    std::size_t settled = k;
    bool crossed = false;
    for (std::size_t i = k + 1; i < end; ++i) {
      const double beyond_Pa = std::copysign(1.0, step_Pa) * (pressure(i) - reference(k));
      crossed = crossed || beyond_Pa >= 0.0;
      if (crossed) result.overshoot_Pa = std::max(result.overshoot_Pa, beyond_Pa);
      if (std::abs(beyond_Pa) > kSettled * span_Pa) settled = i + 1;
    }
    all_settled = all_settled && settled < end;
    settling_s = std::max(settling_s, kCycle_s * static_cast<double>(settled - k));
  }
  if (!std::isnan(result.overshoot_Pa) && all_settled) result.settling_s = settling_s;
  return result;
}

}  // namespace plenum::host::client
