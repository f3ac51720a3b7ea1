// Effects as a rig's description names them.
#include "host-sim/effects/chamber_effects.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

namespace plenum::host::effects {
namespace {

/// What `action` throws, as a text; empty when it does not.
template <class Action>
std::string refusal(Action&& action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

TEST(ChamberEffects, FiguresStandWhereTheCatalogueSaysAndTheRestVanishes) {
  const ChamberEffects effects = chamber_effects(
      {{"spool_lag", {{"natural_frequency_Hz", 20.0}}}, {"sensor_bias", {{"gain_error", 0.01}}}});
  EXPECT_EQ(effects.on, 1U << kIdSpoolLag | 1U << kIdSensorBias);
  Figures expected = neutral_figures();
  expected[kFirstFigure[kIdSpoolLag]] = 1.0 / 20.0;
  expected[kFirstFigure[kIdSensorBias] + 1] = 0.01;
  EXPECT_EQ(effects.figures, expected);
}

TEST(ChamberEffects, ARigMaySayTheBoundsThatAreTold) {
  for (const Effect* effect : catalogue()) {
    for (const Parameter& p : effect->parameters) {
      for (const double bound : {p.of_any_size().low, p.of_any_size().high}) {
        if (!std::isfinite(bound)) continue;
        char told[32];
        std::snprintf(told, sizeof told, "%g", bound);
        EXPECT_EQ(refusal([&] {
                    chamber_effects(
                        {{std::string(effect->id), {{std::string(p.name), std::strtod(told, nullptr)}}}});
                  }),
                  "");
      }
    }
  }
}

TEST(ChamberEffects, RefusalSaysWhatThereIs) {
  using ::testing::AllOf;
  using ::testing::HasSubstr;
  EXPECT_THAT(refusal([] {
                chamber_effects({{"spool", {}}});
              }),
              AllOf(HasSubstr("'spool'"), HasSubstr("spool_lag, dead_time"), HasSubstr("sensor_bias")));
  EXPECT_THAT(refusal([] {
                chamber_effects({{"spool_lag", {{"f", 10.0}}}});
              }),
              AllOf(HasSubstr("spool_lag"), HasSubstr("'f'"), HasSubstr("natural_frequency_Hz, damping")));
  EXPECT_THAT(refusal([] {
                chamber_effects({{"dead_time", {{"delay_s", 0.5}}}});
              }),
              AllOf(HasSubstr("delay_s = 0.5"), HasSubstr("0.08")));
}

}  // namespace
}  // namespace plenum::host::effects
