// Effects as a rig's description names them.
#include "host-sim/effects/chamber_effects.hpp"

#include <gmock/gmock.h>

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
