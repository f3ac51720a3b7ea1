// That the range of Q31.32 suffices: for every admissible parameter set of the 9-parameter model and its repaired form.
//
// A tick is taken in three, as the core takes it: what the command does to the valve, what the motion does to the rates, and what
// the pressure makes of both. The first two need one box, the whole one. From one to the next two closed forms are handed on that
// intervals lose: x/sqrt(x^2 + 1) lies within -1 and 1, and k is above 0 (config::validate()). In the third the exponent's two
// parts, r = (a + c5 v')/(1 + c6 v), are split until it is known to a factor; all else stays whole.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <ostream>
#include <random>
#include <span>
#include <string_view>
#include <vector>

#include "firmware/config/model_image.hpp"
#include "firmware/control/pressure_model.hpp"
#include "host-sim/rounding/core_box.hpp"
#include "tests/equivalence/core.hpp"
#include "tests/firmware/control/random_subject.hpp"

namespace ranges {
namespace {

using plenum::config::ModelKind;
using rounding::Bounds;
using rounding::Box;
using rounding::Shares;

/// What a number of Q31.32 can be.
constexpr double kRange = 2147483648.0;

Bounds point(float value) {
  return {static_cast<double>(value), static_cast<double>(value)};
}
std::vector<Bounds> points(std::span<const float> values) {
  std::vector<Bounds> of;
  std::transform(values.begin(), values.end(), std::back_inserter(of), point);
  return of;
}

std::vector<Bounds> admissible(ModelKind kind) {
  std::vector<Bounds> bounds;
  for (const plenum::config::ParameterSpec& one : plenum::config::parameter_schema(kind))
    bounds.push_back({static_cast<double>(one.low), static_cast<double>(one.high)});
  return bounds;
}

/// [0, nearest], and from there on by a factor each.
std::vector<Bounds> by_factors(double nearest, double farthest) {
  constexpr double kFactor = 1.5;
  std::vector<Bounds> parts{{0.0, nearest}};
  while (parts.back().high < farthest)
    parts.push_back({parts.back().high, std::min(farthest, parts.back().high * kFactor)});
  return parts;
}

/// Two and a half times the largest supply; a cubic metre; what a cylinder of a litre does in a second and more.
constexpr Bounds kPressure_kPa{0, 5000}, kVolume_mL{0, 1e6}, kSpeed_mL_s{-1500, 1500}, kCommand_V{0, 10};

struct Kind {
  ModelKind kind;
  const char* name;
  Bounds Shares::*gain;   ///< of its moving(): c7 h/(1 + c6 v)
  Bounds Shares::*moved;  ///< c5 v' h/(1 + c6 v)
};
std::ostream& operator<<(std::ostream& out, const Kind& kind) {
  return out << kind.name;
}

class Ranges : public ::testing::TestWithParam<Kind> {
 protected:
  std::unique_ptr<rounding::CoreModel> all() const {
    return rounding::core_model(GetParam().name, admissible(GetParam().kind));
  }
};

/// s within ambient and supply, and what rounding adds to g; k above 0.
Shares tightened(Shares open, const std::vector<Bounds>& sets) {
  const Bounds &ambient_kPa = sets[sets.size() - 2],
               &supply_kPa = sets[sets.size() - 3];  // a dead time follows
  const double margin_kPa = supply_kPa.high * 0x1p-26;
  open.first = {std::max(open.first.low, ambient_kPa.low - margin_kPa),
                std::min(open.first.high, supply_kPa.high + margin_kPa)};
  open.second.low = std::max(open.second.low, 0.0);
  return open;
}

TEST_P(Ranges, OfATickAreHeldByFixedPointForEveryAdmissibleParameterSet) {
  const auto [kind, name, gain, moved] = GetParam();
  const auto model = all();
  const Shares whole_open = model->opening(kCommand_V);
  EXPECT_LT(whole_open.largest, kRange);
  const Shares whole_moves = model->moving(kVolume_mL, kSpeed_mL_s);
  EXPECT_LT(whole_moves.largest, kRange);
  EXPECT_GT(whole_moves.largest, kRange / 10)
      << "there is no bit to spare: the scale of TickPerVolume uses them";

  Shares open = tightened(whole_open, admissible(kind)), moves = whole_moves;
  double largest = 0;
  const Bounds of_moved = whole_moves.*moved;
  ASSERT_EQ(of_moved.low, -of_moved.high);
  for (const Bounds& of_gain : by_factors(1e-3, (whole_moves.*gain).high)) {
    for (const Bounds& opening_V : by_factors(1e-3, open.second.high)) {
      for (const Bounds& size : by_factors(0.01, of_moved.high)) {
        for (const Bounds& part : {size, Bounds{-size.high, -size.low}}) {
          moves.*gain = of_gain;
          moves.*moved = part;
          Shares at = open;
          at.second = opening_V;
          largest = std::max(largest, model->step(kPressure_kPa, at, moves).largest);
        }
      }
    }
  }
  EXPECT_LT(largest, kRange);
  EXPECT_GT(largest, kPressure_kPa.high) << "they were not looked at";
}

TEST_P(Ranges, AreLeftAtASpeedBeyondAnyChambers) {
  EXPECT_GT(all()->moving(kVolume_mL, {-15000, 15000}).largest, kRange) << "the test above can fail";
}

// Slopes by the command, which the inverse's search makes products of: each has one limited product, or two, of which one takes a
// factor of up to 2 more; of tassa9 one that needs no limit. Of two slopes of either sign the search takes the difference, too.
TEST_P(Ranges, OfSlopesByTheCommandAreHeldByFixedPoint) {
  const double steepest_kPa_V = std::ldexp(1.0, plenum::control::kSteepest);
  constexpr double kWidest_V = 2.5;  // neighbours in the table of commands lie nearer
  const auto schema = plenum::config::parameter_schema(GetParam().kind);
  const auto most = [&](std::string_view name) {
    const auto one =
        std::find_if(schema.begin(), schema.end(), [&](const auto& of) { return of.name == name; });
    return static_cast<double>(one->high);
  };
  // of g(c2 u + c3 u^3): c2 + 3 c3 u^2 over at least (1 + (c3 u^3)^2)^(3/2), which is below 3 times the cube root of c3
  const double steady_kPa_V =
      0.5 * most("supply_kPa") * (most("c2_per_V") + 3 * std::cbrt(most("c3_per_V3")));
  const double by_steady_kPa_V = GetParam().kind == ModelKind::tassa9 ? steady_kPa_V : steepest_kPa_V;
  const double slope_kPa_V = by_steady_kPa_V + steepest_kPa_V * (1 + most("c8"));
  EXPECT_LT(slope_kPa_V * kWidest_V, kRange);
  EXPECT_LT(slope_kPa_V * 2, kRange);
}

// What is handed on from the opening to the step, of sets as they may be.
TEST_P(Ranges, OfAnOpeningAreTighterThanIntervalsTell) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> volts(0.0F, 10.0F);
  const Shares open = tightened(all()->opening(kCommand_V), admissible(GetParam().kind));
  for (int i = 0; i < 3000; ++i) {
    const auto drawn = plenum::control::testing::draw_subject(random, GetParam().kind);
    const Shares at =
        rounding::core_model(GetParam().name, points({drawn.model.value.data(), drawn.model.count}))
            ->opening(point(volts(random)));
    ASSERT_GE(at.first.low, open.first.low);
    ASSERT_LE(at.first.high, open.first.high);
    ASSERT_GT(at.second.low, open.second.low);
    ASSERT_LE(at.second.high, open.second.high);
  }
}

// The instrument itself: what the core computes in double lies within what it computes for a box, in one and in three.
TEST_P(Ranges, HoldWhatTheCoreComputes) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> volts(0.0F, 10.0F);
  for (int i = 0; i < 3000; ++i) {
    const auto drawn = plenum::control::testing::draw_subject(random, GetParam().kind);
    const std::span parameters(drawn.model.value.data(), drawn.model.count);
    const float command_V = volts(random);
    const equivalence::Prediction exact =
        equivalence::core_in_double(static_cast<std::uint16_t>(GetParam().kind), parameters)
            ->step({.pressure_kPa = static_cast<double>(drawn.pressure_kPa),
                    .volume_mL = static_cast<double>(drawn.volume_mL),
                    .volume_rate_mL_s = static_cast<double>(drawn.volume_rate_mL_s)},
                   static_cast<double>(command_V));
    const auto model = rounding::core_model(GetParam().name, points(parameters));
    const Box box{.pressure_kPa = point(drawn.pressure_kPa),
                  .command_V = point(command_V),
                  .volume_mL = point(drawn.volume_mL),
                  .speed_mL_s = point(drawn.volume_rate_mL_s)};
    for (const rounding::Tick& found :
         {model->tick(box), model->step(box.pressure_kPa, model->opening(box.command_V),
                                        model->moving(box.volume_mL, box.speed_mL_s))}) {
      const double apart_kPa = found.error_kPa + 1e-9;  // series of its own, and the rounding of doubles
      ASSERT_GE(exact.end_kPa, found.end_kPa.low - apart_kPa);
      ASSERT_LE(exact.end_kPa, found.end_kPa.high + apart_kPa);
      ASSERT_GE(exact.mean_kPa, found.mean_kPa.low - apart_kPa);
      ASSERT_LE(exact.mean_kPa, found.mean_kPa.high + apart_kPa);
      ASSERT_LT(found.end_kPa.high - found.end_kPa.low, 1e-6) << "of points, an interval is as good as one";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Ranges,
                         ::testing::Values(Kind{ModelKind::tassa9, "tassa9", &Shares::second, &Shares::third},
                                           Kind{ModelKind::tassa9r, "tassa9r", &Shares::first,
                                                &Shares::second}),
                         ::testing::PrintToStringParamName());

}  // namespace
}  // namespace ranges
