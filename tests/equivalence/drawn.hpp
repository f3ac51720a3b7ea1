// Models and states at random, for the comparison of scalars.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "firmware/config/model_image.hpp"
#include "tests/equivalence/core.hpp"
#include "tests/firmware/control/admissible.hpp"
#include "tests/firmware/control/random_greybox.hpp"
#include "tests/firmware/scalars.hpp"

namespace equivalence {

struct Drawn {
  std::uint16_t kind;
  std::vector<float> parameters;
  State state;
  double ambient_kPa, supply_kPa;
};

inline Drawn draw(std::mt19937& random, plenum::config::ModelKind kind) {
  using namespace plenum;
  constexpr std::size_t kC4 = 3;
  Drawn drawn{.kind = static_cast<std::uint16_t>(kind),
              .parameters = {},
              .state = {},
              .ambient_kPa = 0,
              .supply_kPa = 0};
  if (kind == config::ModelKind::greybox) {
    const control::testing::GreyboxCase made = control::testing::random_case(random);
    drawn.parameters.assign(made.set.begin(), made.set.end());
    drawn.state = {static_cast<double>(made.pressure_kPa), real(made.motion.volume_mL),
                   real(made.motion.volume_rate_mL_s)};
  } else {
    const control::testing::RandomChamber made = control::testing::random_chamber(random);
    drawn.parameters.assign(made.parameters.begin(), made.parameters.end());
    if (kind == config::ModelKind::tassa9r) drawn.parameters.erase(drawn.parameters.begin() + kC4);
    drawn.state = {static_cast<double>(made.pressure_kPa), static_cast<double>(made.volume_mL),
                   static_cast<double>(made.volume_rate_mL_s)};
  }
  drawn.supply_kPa = static_cast<double>(drawn.parameters[drawn.parameters.size() - 2]);
  drawn.ambient_kPa = static_cast<double>(drawn.parameters.back());
  return drawn;
}

/// How the pressure at a tick's end changes with the command [kPa/V], by a central difference.
inline double slope_kPa_V(const Core& core, const State& from, double command_V) {
  constexpr double kAside_V = 1e-3;
  return (core.step(from, command_V + kAside_V).end_kPa - core.step(from, command_V - kAside_V).end_kPa) /
         (2 * kAside_V);
}

}  // namespace equivalence
