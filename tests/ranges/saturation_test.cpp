// What the bounds of this room say, tried out: no number of a tick or of its inverse is cut off in fixed point, whatever admissible
// parameter set a chamber has.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ostream>
#include <random>

#include "firmware/config/greybox_parameters.hpp"
#include "firmware/config/model_image.hpp"
#include "tests/equivalence/core.hpp"
#include "tests/firmware/control/random_admissible.hpp"

namespace ranges {
namespace {

using plenum::config::ModelKind;
using plenum::config::ModelParameters;

struct Kind {
  ModelKind kind;
  const char* name;
};
std::ostream& operator<<(std::ostream& out, const Kind& kind) {
  return out << kind.name;
}

class Saturations : public ::testing::TestWithParam<Kind> {
 protected:
  double share() { return share_(random_); }
  bool one_in(int n) { return share() * n < 1; }

  /// A chamber of up to a cubic metre that moves by up to 1.5 L/s, at up to 5 MPa.
  equivalence::State state(const ModelParameters& set) {
    const bool greybox = set.kind == ModelKind::greybox;
    const double dead_mL = greybox ? static_cast<double>(set.value[plenum::config::kDeadVolume]) : 0;
    return {.pressure_kPa = 5000 * std::pow(share(), 2),
            .volume_mL = std::max(std::pow(10.0, 6 * share()) - dead_mL, 0.0),
            .volume_rate_mL_s = 1500 * (2 * share() - 1) * (one_in(2) ? 1 : 0.01),
            .supply = greybox && one_in(2) ? 0.2 + 1.8 * share() : 1};
  }

  std::mt19937 random_{3};

 private:
  std::uniform_real_distribution<double> share_{0.0, 1.0};
};

TEST_P(Saturations, AreNoneInATickNorInItsInverse) {
  constexpr int kSets = 5000, kStates = 20;
  constexpr double kAtABound = 0.4;
  for (int i = 0; i < kSets; ++i) {
    const ModelParameters set =
        plenum::control::testing::draw_admissible(random_, GetParam().kind, kAtABound);
    const auto core =
        equivalence::core_in_fixed(static_cast<std::uint16_t>(set.kind), {set.value.data(), set.count});
    for (int k = 0; k < kStates; ++k) {
      const equivalence::State from = state(set);
      const double command_V = 10 * share();
      const std::uint32_t before = core->saturations();
      core->step(from, command_V);
      ASSERT_EQ(core->saturations(), before)
          << "a step of set " << i << " from " << from.pressure_kPa << " kPa";
      core->inverse(from, 10 + 1990 * share(), command_V);
      ASSERT_EQ(core->saturations(), before)
          << "the inverse of set " << i << " from " << from.pressure_kPa << " kPa";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Saturations,
                         ::testing::Values(Kind{ModelKind::tassa9, "tassa9"},
                                           Kind{ModelKind::tassa9r, "tassa9r"},
                                           Kind{ModelKind::greybox, "greybox"}),
                         ::testing::PrintToStringParamName());

}  // namespace
}  // namespace ranges
