// The bound of a parameter set against what the core in fixed point is off from the core in double.
#include "host-sim/rounding/tick_error.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "host-sim/rounding/greybox_tables.hpp"
#include "tests/equivalence/core.hpp"
#include "tests/firmware/control/random_subject.hpp"

namespace plenum::host::rounding {
namespace {

using config::ModelKind;

struct Kind {
  const char* name;
  ModelKind kind;
};

class OfKind : public ::testing::TestWithParam<Kind> {};

std::vector<double> parameters_of(const control::testing::Subject& drawn) {
  return {drawn.model.value.begin(), drawn.model.value.begin() + drawn.model.count};
}

/// The largest difference in so many states of the box that tick_error_kPa() states.
double found_kPa(const control::testing::Subject& drawn, int states, std::mt19937& random) {
  const std::span parameters(drawn.model.value.data(), drawn.model.count);
  const auto fixed = equivalence::core_in_fixed(static_cast<std::uint16_t>(drawn.model.kind), parameters);
  const auto exact = equivalence::core_in_double(static_cast<std::uint16_t>(drawn.model.kind), parameters);
  // a grey box's volumes count with the dead one, which is there at the end of any stroke
  const double dead_mL = drawn.model.kind == ModelKind::greybox
                             ? static_cast<double>(drawn.model.value[config::kDeadVolume])
                             : 0.0;
  std::uniform_real_distribution<double> share(0.0, 1.0),
      pressure_kPa(static_cast<double>(drawn.ambient_kPa), static_cast<double>(drawn.supply_kPa));
  double found = 0;
  for (int i = 0; i < states; ++i) {
    const double volume_mL = std::max(dead_mL, std::pow(10.0, 4 * share(random)));
    const equivalence::State from{
        .pressure_kPa = pressure_kPa(random),
        .volume_mL = volume_mL - dead_mL,
        .volume_rate_mL_s = std::clamp((share(random) - 0.5) * volume_mL / 0.01, -1500.0, 1500.0)};
    const double command_V = 10 * share(random);
    const equivalence::Prediction got = fixed->step(from, command_V), want = exact->step(from, command_V);
    found = std::max({found, std::fabs(got.end_kPa - want.end_kPa), std::fabs(got.mean_kPa - want.mean_kPa)});
  }
  return found;
}

TEST_P(OfKind, IsNeverExceeded) {
  std::mt19937 random(11);
  for (int i = 0; i < 300; ++i) {
    const control::testing::Subject drawn = control::testing::draw_subject(random, GetParam().kind);
    const auto bound_kPa = tick_error_kPa(GetParam().name, parameters_of(drawn));
    ASSERT_TRUE(bound_kPa);
    ASSERT_GE(*bound_kPa, found_kPa(drawn, 100, random));
  }
}

/// At `part` of the ordered values, which may be infinite.
double quantile(std::vector<double>& of, double part) {
  const auto at = of.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(of.size()));
  std::nth_element(of.begin(), at, of.end());
  return *at;
}

/// Median over the largest difference in 3000 states. A grey box is bounded for all volumes by the least one, and for all of its ways at
/// once.
double idle(ModelKind kind) {
  return kind == ModelKind::greybox ? 60 : 10;
}

TEST_P(OfKind, IsNotIdle) {
  std::mt19937 random(12);
  std::vector<double> ratio, percent_of_span;
  for (int i = 0; i < 61; ++i) {
    const control::testing::Subject drawn = control::testing::draw_subject(random, GetParam().kind);
    const double bound_kPa = *tick_error_kPa(GetParam().name, parameters_of(drawn));
    ratio.push_back(bound_kPa / found_kPa(drawn, 3000, random));
    percent_of_span.push_back(100 * bound_kPa / static_cast<double>(drawn.supply_kPa - drawn.ambient_kPa));
  }
  RecordProperty("median_over_found", std::to_string(quantile(ratio, 0.5)));
  EXPECT_LT(quantile(ratio, 0.5), idle(GetParam().kind));
  EXPECT_LT(quantile(percent_of_span, 0.9), 0.02);  // the claim of tests/equivalence
}

INSTANTIATE_TEST_SUITE_P(TickError, OfKind,
                         ::testing::Values(Kind{"tassa9", ModelKind::tassa9},
                                           Kind{"tassa9r", ModelKind::tassa9r},
                                           Kind{"greybox", ModelKind::greybox}),
                         [](const auto& of) { return std::string(of.param.name); });

/// Where rounding can make the board go another way than exact numbers: from within some ulps of every corner of f, with the port
/// shut that would move the pressure and with it open, in the least volume.
TEST(TickError, OfAGreyBoxHoldsWhereTheBoardGoesAnotherWay) {
  std::mt19937 random(13);
  std::uniform_int_distribution<int> ulps(-4, 4);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  for (int i = 0; i < 60; ++i) {
    const control::testing::Subject drawn = control::testing::draw_subject(random, ModelKind::greybox);
    const std::span parameters(drawn.model.value.data(), drawn.model.count);
    const double bound_kPa = *tick_error_kPa("greybox", parameters_of(drawn));
    const auto dead_mL = static_cast<double>(drawn.model.value[config::kDeadVolume]);
    const auto kind = static_cast<std::uint16_t>(ModelKind::greybox);
    const auto fixed = equivalence::core_in_fixed(kind, parameters),
               exact = equivalence::core_in_double(kind, parameters);
    const auto tables = ::rounding::greybox_in_fixed(parameters);
    std::vector<double> corners_kPa = tables.inlet.corner_kPa;
    corners_kPa.insert(corners_kPa.end(), tables.exhaust.corner_kPa.begin(), tables.exhaust.corner_kPa.end());
    for (const double corner_kPa : corners_kPa) {
      if (corner_kPa < static_cast<double>(drawn.ambient_kPa) ||
          corner_kPa > static_cast<double>(drawn.supply_kPa))
        continue;
      for (int k = 0; k < 20; ++k) {
        const double volume_mL = std::max(1.0, dead_mL) * std::pow(10.0, 1.5 * share(random) * share(random));
        const equivalence::State from{
            .pressure_kPa = corner_kPa + std::ldexp(ulps(random), -32),
            .volume_mL = volume_mL - dead_mL,
            .volume_rate_mL_s =
                k % 4 == 0 ? 0.0 : std::clamp((share(random) - 0.5) * volume_mL / 0.01, -1500.0, 1500.0)};
        const double command_V = 10 * share(random);
        const equivalence::Prediction got = fixed->step(from, command_V), want = exact->step(from, command_V);
        ASSERT_LE(std::fabs(got.end_kPa - want.end_kPa), bound_kPa)
            << corner_kPa << " kPa, " << command_V << " V";
        ASSERT_LE(std::fabs(got.mean_kPa - want.mean_kPa), bound_kPa)
            << corner_kPa << " kPa, " << command_V << " V";
      }
    }
  }
}

TEST(TickError, IsNoneOfAKindThatIsNone) {
  EXPECT_FALSE(tick_error_kPa("spline", std::vector<double>(27, 1.0)));
}

TEST(TickError, OfAnotherNumberOfParametersIsRefused) {
  EXPECT_THROW(static_cast<void>(tick_error_kPa("tassa9", std::vector<double>(11, 1.0))),
               std::invalid_argument);
  EXPECT_THROW(static_cast<void>(tick_error_kPa("greybox", std::vector<double>(26, 1.0))),
               std::invalid_argument);
}

}  // namespace
}  // namespace plenum::host::rounding
