// Models and states at random, each shown to the core in fixed point and in double.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <span>

#include "tests/equivalence/core.hpp"
#include "tests/firmware/control/random_admissible.hpp"
#include "tests/firmware/control/random_subject.hpp"

namespace equivalence {

/// A state, and what is asked of it: what a command does, and which one takes it to a target.
struct Asked {
  const Core& fixed;
  const Core& exact;
  double span_kPa;  ///< from ambient to supply
  State from;
  double command_V;
  double target_kPa;
};

/// What an error of a tick that ends at `end_kPa` is to be compared with: the span, or the way where the tick goes farther.
inline double reach_kPa(const Asked& asked, const Prediction& exact) {
  return std::max({asked.span_kPa, std::fabs(exact.end_kPa - asked.from.pressure_kPa),
                   std::fabs(exact.mean_kPa - asked.from.pressure_kPa)});
}

/// Every other state has the supply that its model states.
template <class Random>
float draw_supply(Random& random) {
  std::uniform_real_distribution<float> supply(0.5F, 1.3F);
  return random() % 2 != 0 ? 1.0F : supply(random);
}

/// `visit(const Asked&)` of so many states of so many models of all that an image may carry. The chamber, with a grey box's dead volume,
/// has 1 mL to 10 L, and changes by half in a tick at most.
template <class Visit>
void for_each_admissible_state(plenum::config::ModelKind kind, unsigned seed, int models, int states,
                               Visit&& visit) {
  constexpr float kMostSpeed_mL_s = 1500.0F, kTick_s = 0.01F;
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> share(0.0F, 1.0F);
  for (int i = 0; i < models; ++i) {
    const plenum::config::ModelParameters drawn = plenum::control::testing::draw_admissible(random, kind);
    const std::span parameters(drawn.value.data(), drawn.count);
    const auto fixed = core_in_fixed(static_cast<std::uint16_t>(kind), parameters);
    const auto exact = core_in_double(static_cast<std::uint16_t>(kind), parameters);
    const auto [supply_kPa, ambient_kPa] = plenum::config::supply_of(drawn);
    const float span_kPa = supply_kPa - ambient_kPa;
    const float dead_mL =
        kind == plenum::config::ModelKind::greybox ? parameters[plenum::config::kDeadVolume] : 0.0F;
    for (int k = 0; k < states; ++k) {
      const float chamber_mL = std::pow(10.0F, 4.0F * share(random));
      const float speed_mL_s =
          std::clamp((share(random) - 0.5F) * chamber_mL / kTick_s, -kMostSpeed_mL_s, kMostSpeed_mL_s);
      const float pressure_kPa = ambient_kPa + span_kPa * share(random);
      const float target_kPa =
          std::clamp(pressure_kPa + 0.1F * span_kPa * (2.0F * share(random) - 1.0F), ambient_kPa, supply_kPa);
      visit(Asked{.fixed = *fixed,
                  .exact = *exact,
                  .span_kPa = static_cast<double>(span_kPa),
                  .from = {.pressure_kPa = static_cast<double>(pressure_kPa),
                           .volume_mL = static_cast<double>(chamber_mL - dead_mL),
                           .volume_rate_mL_s = static_cast<double>(speed_mL_s),
                           .supply = static_cast<double>(draw_supply(random))},
                  .command_V = static_cast<double>(10.0F * share(random)),
                  .target_kPa = static_cast<double>(target_kPa)});
    }
  }
}

/// `visit(const Asked&)` of so many states of so many models of valves and chambers as they are built. All numbers are floats, which every
/// scalar holds to 2^-32.
template <class Visit>
void for_each_state(plenum::config::ModelKind kind, unsigned seed, int models, int states, Visit&& visit) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> volts(0.0F, 10.0F), share(0.0F, 1.0F);
  for (int i = 0; i < models; ++i) {
    const plenum::control::testing::Subject drawn = plenum::control::testing::draw_subject(random, kind);
    const std::span parameters(drawn.model.value.data(), drawn.model.count);
    const auto fixed = core_in_fixed(static_cast<std::uint16_t>(kind), parameters);
    const auto exact = core_in_double(static_cast<std::uint16_t>(kind), parameters);
    const float span_kPa = drawn.supply_kPa - drawn.ambient_kPa;
    for (int k = 0; k < states; ++k) {
      const float supply = draw_supply(random), supply_kPa = supply * drawn.supply_kPa;
      const float pressure_kPa = drawn.ambient_kPa + (supply_kPa - drawn.ambient_kPa) * share(random);
      const float target_kPa = std::clamp(pressure_kPa + 0.1F * span_kPa * (2.0F * share(random) - 1.0F),
                                          drawn.ambient_kPa, supply_kPa);
      visit(Asked{.fixed = *fixed,
                  .exact = *exact,
                  .span_kPa = static_cast<double>(span_kPa),
                  .from = {.pressure_kPa = static_cast<double>(pressure_kPa),
                           .volume_mL = static_cast<double>(drawn.volume_mL),
                           .volume_rate_mL_s = static_cast<double>(drawn.volume_rate_mL_s),
                           .supply = static_cast<double>(supply)},
                  .command_V = static_cast<double>(volts(random)),
                  .target_kPa = static_cast<double>(target_kPa)});
    }
  }
}

/// Whether at both commands a volt moves the pressure by a kPa a tick or more, or the two end farther apart than a prediction may err.
/// Elsewhere commands far apart are one to the chamber.
inline bool commands_matter(const Asked& asked, double one_V, double other_V) {
  constexpr double kLeastSlope_kPa_V = 1.0, kAside_V = 1e-3;
  const auto slope_kPa_V = [&](double command_V) {
    return (asked.exact.step(asked.from, command_V + kAside_V).end_kPa -
            asked.exact.step(asked.from, command_V - kAside_V).end_kPa) /
           (2 * kAside_V);
  };
  const double apart_kPa =
      asked.exact.step(asked.from, one_V).end_kPa - asked.exact.step(asked.from, other_V).end_kPa;
  return std::fabs(apart_kPa) > 2e-4 * asked.span_kPa ||
         std::min(std::fabs(slope_kPa_V(one_V)), std::fabs(slope_kPa_V(other_V))) >= kLeastSlope_kPa_V;
}

}  // namespace equivalence
