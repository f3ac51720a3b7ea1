// The bound of a parameter set against what the core in fixed point is off from the core in double.
#include "host-sim/rounding/tick_error.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

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
  std::uniform_real_distribution<double> share(0.0, 1.0),
      pressure_kPa(static_cast<double>(drawn.ambient_kPa), static_cast<double>(drawn.supply_kPa));
  double found = 0;
  for (int i = 0; i < states; ++i) {
    const double volume_mL = std::pow(10.0, 4 * share(random));
    const equivalence::State from{
        .pressure_kPa = pressure_kPa(random),
        .volume_mL = volume_mL,
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

TEST_P(OfKind, IsNotIdle) {
  std::mt19937 random(12);
  std::vector<double> ratio, percent_of_span;
  for (int i = 0; i < 61; ++i) {
    const control::testing::Subject drawn = control::testing::draw_subject(random, GetParam().kind);
    const double bound_kPa = *tick_error_kPa(GetParam().name, parameters_of(drawn));
    ratio.push_back(bound_kPa / found_kPa(drawn, 3000, random));
    percent_of_span.push_back(100 * bound_kPa / static_cast<double>(drawn.supply_kPa - drawn.ambient_kPa));
  }
  const auto share = [](std::vector<double>& of, double part) {
    const auto at = of.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(of.size()));
    std::nth_element(of.begin(), at, of.end());
    return *at;
  };
  RecordProperty("median_over_found", std::to_string(share(ratio, 0.5)));
  EXPECT_LT(share(ratio, 0.5), 10) << "of the largest difference in 3000 states";
  EXPECT_LT(share(percent_of_span, 0.9), 0.02)
      << "nine in ten random sets stay within the claim of tests/equivalence";
}

INSTANTIATE_TEST_SUITE_P(TickError, OfKind,
                         ::testing::Values(Kind{"tassa9", ModelKind::tassa9},
                                           Kind{"tassa9r", ModelKind::tassa9r}),
                         [](const auto& of) { return std::string(of.param.name); });

TEST(TickError, IsNoneOfAGreyBox) {
  EXPECT_FALSE(tick_error_kPa("greybox", std::vector<double>(27, 1.0)));
}

TEST(TickError, OfAnotherNumberOfParametersIsRefused) {
  EXPECT_THROW(static_cast<void>(tick_error_kPa("tassa9", std::vector<double>(11, 1.0))),
               std::invalid_argument);
}

}  // namespace
}  // namespace plenum::host::rounding
