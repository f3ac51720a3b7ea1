// That the range of Q31.32 suffices: for every admissible parameter set of the 9-parameter model.
//
// In one box g(x) = x/sqrt(x^2 + 1) comes out as if both x were different numbers. So the box is split along what x is made of,
// c2, c3 and the command, until each x is known to a factor; all others stay whole. c1 enters by u - c1 alone: its ends do.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "firmware/config/model_image.hpp"
#include "host-sim/rounding/core_box.hpp"
#include "tests/equivalence/core.hpp"
#include "tests/firmware/control/random_subject.hpp"

namespace ranges {
namespace {

using plenum::config::ModelKind;
using rounding::Bounds;
using rounding::Box;

/// What a number of Q31.32 can be.
constexpr double kRange = 2147483648.0;

enum : std::size_t { c1, c2, c3 };

std::vector<Bounds> admissible() {
  std::vector<Bounds> bounds;
  for (const plenum::config::ParameterSpec& one : plenum::config::parameter_schema(ModelKind::tassa9))
    bounds.push_back({static_cast<double>(one.low), static_cast<double>(one.high)});
  return bounds;
}

/// [0, nearest], and from there on by a factor each.
std::vector<Bounds> by_factors(double nearest, double farthest, double factor) {
  std::vector<Bounds> parts{{0.0, nearest}};
  while (parts.back().high < farthest)
    parts.push_back({parts.back().high, std::min(farthest, parts.back().high * factor)});
  return parts;
}

/// Two and a half times the largest supply; a cubic metre; what a cylinder of a litre does in a second and more.
constexpr Bounds kPressure_kPa{0, 5000}, kVolume_mL{0, 1e6}, kSpeed_mL_s{-1500, 1500};

double largest(const Bounds& speed_mL_s) {
  constexpr double kFactor = 1.5;
  std::vector<Bounds> box = admissible();
  const std::vector<Bounds> distances_V = by_factors(0.01, 8.0, kFactor);
  const std::vector<Bounds> of_c2 = by_factors(box[c2].low, box[c2].high, kFactor);
  const std::vector<Bounds> of_c3 = by_factors(1e-4, box[c3].high, kFactor);
  double found = 0;
  for (const double end_V : {box[c1].low, box[c1].high}) {
    const double sign = end_V < 5 ? 1 : -1;
    const double reach_V = std::max(end_V, 10 - end_V);
    for (const Bounds& distance_V : distances_V) {
      const double near_V = end_V + sign * distance_V.low, far_V = end_V + sign * distance_V.high;
      const Box states{.pressure_kPa = kPressure_kPa,
                       .command_V = {std::min(near_V, far_V), std::max(near_V, far_V)},
                       .volume_mL = kVolume_mL,
                       .speed_mL_s = speed_mL_s};
      for (std::size_t i = 1; i < of_c2.size(); ++i) {
        const auto visit = [&](const Bounds& c3_part) {
          std::vector<Bounds> part = box;
          part[c1] = {end_V, end_V};
          part[c2] = of_c2[i];
          part[c3] = c3_part;
          found = std::max(found, rounding::core_model("tassa9", part)->tick(states).largest);
        };
        for (const Bounds& c3_part : of_c3) visit(c3_part);
        // config::validate(): the argument of g rises over the command range
        visit({std::max(box[c3].low, -of_c2[i].high / (3 * reach_V * reach_V)), 0.0});
      }
    }
  }
  return found;
}

TEST(Ranges, OfATickAreHeldByFixedPointForEveryAdmissibleParameterSet) {
  const double found = largest(kSpeed_mL_s);
  EXPECT_LT(found, kRange);
  EXPECT_GT(found, kRange / 10) << "there is no bit to spare: the scale of TickPerVolume uses them";
}

TEST(Ranges, AreLeftAtASpeedBeyondAnyChambers) {
  EXPECT_GT(largest({-15000, 15000}), kRange) << "the test above can fail";
}

// The instrument itself: what the core computes in double lies within what it computes for a box.
TEST(Ranges, HoldWhatTheCoreComputes) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> volts(0.0F, 10.0F);
  const auto point = [](float value) {
    return Bounds{static_cast<double>(value), static_cast<double>(value)};
  };
  for (int i = 0; i < 3000; ++i) {
    const plenum::control::testing::Subject drawn =
        plenum::control::testing::draw_subject(random, ModelKind::tassa9);
    const std::span parameters(drawn.model.value.data(), drawn.model.count);
    const float command_V = volts(random);
    const equivalence::Prediction exact =
        equivalence::core_in_double(static_cast<std::uint16_t>(ModelKind::tassa9), parameters)
            ->step({.pressure_kPa = static_cast<double>(drawn.pressure_kPa),
                    .volume_mL = static_cast<double>(drawn.volume_mL),
                    .volume_rate_mL_s = static_cast<double>(drawn.volume_rate_mL_s)},
                   static_cast<double>(command_V));
    std::vector<Bounds> points;
    std::transform(parameters.begin(), parameters.end(), std::back_inserter(points), point);
    const rounding::Tick found = rounding::core_model("tassa9", points)
                                     ->tick({.pressure_kPa = point(drawn.pressure_kPa),
                                             .command_V = point(command_V),
                                             .volume_mL = point(drawn.volume_mL),
                                             .speed_mL_s = point(drawn.volume_rate_mL_s)});
    const double apart_kPa = found.error_kPa + 1e-9;  // series of its own, and the rounding of doubles
    ASSERT_GE(exact.end_kPa, found.end_kPa.low - apart_kPa);
    ASSERT_LE(exact.end_kPa, found.end_kPa.high + apart_kPa);
    ASSERT_GE(exact.mean_kPa, found.mean_kPa.low - apart_kPa);
    ASSERT_LE(exact.mean_kPa, found.mean_kPa.high + apart_kPa);
    ASSERT_LT(found.end_kPa.high - found.end_kPa.low, 1e-6) << "of points, an interval is as good as one";
  }
}

}  // namespace
}  // namespace ranges
