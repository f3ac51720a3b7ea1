// A random admissible model of any kind, with a chamber that may have it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>

#include "firmware/config/model_image.hpp"
#include "tests/firmware/control/admissible.hpp"
#include "tests/firmware/control/random_greybox.hpp"

namespace plenum::control::testing {

/// A model, and a chamber that may have it.
struct Subject {
  config::ModelParameters model;
  float ambient_kPa, supply_kPa;
  float pressure_kPa, volume_mL, volume_rate_mL_s;
};

template <class Random>
Subject draw_formula(Random& random, config::ModelKind kind) {
  constexpr std::size_t kC4 = 3;
  const RandomChamber chamber = random_chamber(random);
  Subject subject{{},
                  chamber.parameters[11],
                  chamber.parameters[10],
                  chamber.pressure_kPa,
                  chamber.volume_mL,
                  chamber.volume_rate_mL_s};
  for (std::size_t i = 0; i < chamber.parameters.size(); ++i) {
    if (kind == config::ModelKind::tassa9r && i == kC4) continue;
    subject.model.value[subject.model.count++] = chamber.parameters[i];
  }
  return subject;
}

template <class Random>
Subject draw_greybox(Random& random) {
  const GreyboxCase chamber = random_case(random);
  Subject subject{{},
                  chamber.set[config::kAmbient],
                  chamber.set[config::kSupply],
                  chamber.pressure_kPa,
                  static_cast<float>(chamber.motion.volume_mL),
                  static_cast<float>(chamber.motion.volume_rate_mL_s)};
  subject.model.count = config::kGreyboxParameters;
  std::copy(chamber.set.begin(), chamber.set.end(), subject.model.value.begin());
  return subject;
}

/// `kind`: any but none.
template <class Random>
Subject draw_subject(Random& random, config::ModelKind kind) {
  Subject subject = kind == config::ModelKind::greybox ? draw_greybox(random) : draw_formula(random, kind);
  subject.model.kind = kind;
  return subject;
}

/// None for a name that no kind has.
inline config::ModelKind kind_named(std::string_view name) {
  return name == "tassa9"    ? config::ModelKind::tassa9
         : name == "tassa9r" ? config::ModelKind::tassa9r
         : name == "greybox" ? config::ModelKind::greybox
                             : config::ModelKind::none;
}

}  // namespace plenum::control::testing
