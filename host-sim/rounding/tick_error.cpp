#include "host-sim/rounding/tick_error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <queue>
#include <stdexcept>
#include <vector>

#include "firmware/config/limits.hpp"
#include "firmware/config/model_image.hpp"
#include "host-sim/rounding/core_box.hpp"
#include "host-sim/rounding/greybox_error.hpp"

namespace plenum::host::rounding {
namespace {

using ::rounding::Bounds;
using ::rounding::CoreModel;

constexpr Bounds kCommand_V{0, 10}, kVolume_mL{1, 1e4}, kShareOfVolume{-0.5, 0.5};
constexpr double kMostSpeed_mL_s = 1500;
constexpr double kRange = 0x1p31;
/// The bound may exceed what is had at the middle of its part by this factor...
constexpr double kNear = 1.1;
/// ...or has been split so often.
constexpr int kMostSplits = 3000;

/// Pressure, command, volume, and the share of the volume that a tick brings.
using Part = std::array<Bounds, 4>;
enum : std::size_t { pressure, command, volume, share };

::rounding::Box box_of(const Part& part) {
  const auto speed_mL_s = [](double of, double volume_mL) {
    return std::clamp(of * volume_mL / static_cast<double>(config::kTick_s), -kMostSpeed_mL_s,
                      kMostSpeed_mL_s);
  };
  const Bounds& gone = part[share];
  const Bounds& mL = part[volume];
  return {.pressure_kPa = part[pressure],
          .command_V = part[command],
          .volume_mL = mL,
          .speed_mL_s = {speed_mL_s(gone.low, gone.low < 0 ? mL.high : mL.low),
                         speed_mL_s(gone.high, gone.high > 0 ? mL.high : mL.low)}};
}

/// Volumes by their logarithm.
double middle(const Part& part, std::size_t axis) {
  const Bounds& of = part[axis];
  return axis == volume ? std::sqrt(of.low * of.high) : 0.5 * (of.low + of.high);
}

double error_kPa(const CoreModel& model, const Part& part) {
  const ::rounding::Tick tick = model.tick(box_of(part));
  return tick.largest < kRange ? tick.error_kPa : std::numeric_limits<double>::infinity();
}

double error_at_middle_kPa(const CoreModel& model, const Part& part) {
  Part point;
  for (std::size_t axis = 0; axis < part.size(); ++axis)
    point[axis] = {middle(part, axis), middle(part, axis)};
  return error_kPa(model, point);
}

struct Bounded {
  Part part;
  double error_kPa;
  bool operator<(const Bounded& other) const { return error_kPa < other.error_kPa; }
};

/// The two halves along the axis where the worse of them is least bad.
std::array<Bounded, 2> halves(const CoreModel& model, const Part& part) {
  std::array<Bounded, 2> best{};
  double best_kPa = std::numeric_limits<double>::infinity();
  double best_sum_kPa = best_kPa;
  for (std::size_t axis = 0; axis < part.size(); ++axis) {
    Part low = part, high = part;
    low[axis].high = high[axis].low = middle(part, axis);
    const double of_low = error_kPa(model, low), of_high = error_kPa(model, high);
    const double worse = std::max(of_low, of_high), sum = of_low + of_high;
    if (axis > 0 && (worse > best_kPa || (worse == best_kPa && sum >= best_sum_kPa))) continue;
    best = {Bounded{low, of_low}, Bounded{high, of_high}};
    best_kPa = worse;
    best_sum_kPa = sum;
  }
  return best;
}

}  // namespace

std::optional<double> tick_error_kPa(std::string_view kind, std::span<const double> parameters) {
  const std::vector<float> as_uploaded(parameters.begin(), parameters.end());
  if (kind == "greybox") {
    if (as_uploaded.size() < config::required_count(config::ModelKind::greybox))
      throw std::invalid_argument("too few parameters");
    return ::rounding::greybox_tick_error_kPa(::rounding::greybox_in_fixed(as_uploaded),
                                              ::rounding::greybox_in_double(as_uploaded));
  }
  std::vector<Bounds> at_a_point;
  for (const float parameter : as_uploaded) {
    const auto value = static_cast<double>(parameter);
    at_a_point.push_back({value, value});
  }
  const auto core = ::rounding::core_model(kind, at_a_point);
  if (core == nullptr) return std::nullopt;

  const Bounds pressure_kPa{at_a_point[core->parameters() - 1].low, at_a_point[core->parameters() - 2].low};
  const Part whole{pressure_kPa, kCommand_V, kVolume_mL, kShareOfVolume};
  std::priority_queue<Bounded> parts;
  parts.push({whole, error_kPa(*core, whole)});
  for (int i = 0; i < kMostSplits; ++i) {
    const Bounded worst = parts.top();
    if (worst.error_kPa <= kNear * error_at_middle_kPa(*core, worst.part)) break;
    parts.pop();
    for (const Bounded& half : halves(*core, worst.part)) parts.push(half);
  }
  return parts.top().error_kPa;
}

}  // namespace plenum::host::rounding
