// Models whose parameters lie at their bounds, in a chamber that jumps about: what is admissible is safe to have in force.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "tests/firmware/board/bench.hpp"
#include "tests/firmware/control/random_subject.hpp"

namespace plenum {
namespace {

using config::ModelKind;

class ChamberBounds : public ::testing::TestWithParam<ModelKind> {};

/// Of a random admissible model some parameters, or all, go to an end of their range.
config::ModelParameters at_bounds(std::mt19937& random, ModelKind kind) {
  config::ModelParameters model = control::testing::draw_subject(random, kind).model;
  const auto schema = config::parameter_schema(kind);
  std::uniform_int_distribution<std::size_t> any(0, schema.size() - 1);
  for (std::size_t left = 1 + any(random) / 2; left > 0; --left) {
    const std::size_t i = any(random);
    model.value[i] = random() % 2 == 0 ? schema[i].low : schema[i].high;
  }
  return model;
}

TEST_P(ChamberBounds, OfItsModelLeaveTheCommandWithinTheInstallersRangeAndEveryValueANumber) {
  constexpr int kSets = 1000, kTicks = 40;
  std::mt19937 random(11);
  std::uniform_real_distribution<float> volts(1.0F, 8.0F), position_V(0.0F, 10.0F);
  constexpr std::array kSetpoints_Pa{-3e38F, 0.0F, 1e5F, 3e5F, 6e5F, 3e38F};
  int admissible = 0;
  for (int i = 0; i < kSets; ++i) {
    const config::ModelParameters model = at_bounds(random, GetParam());
    if (!config::validate(model)) continue;
    ++admissible;
    const Settings settings = bench_settings();
    ChamberLoop loop;
    loop.configure(settings.chamber[0], settings.regulator);
    loop.take_over(model);
    canopen::ChamberImage image;
    for (int tick = 0; tick < kTicks; ++tick) {
      loop.measure({.pressure = {volts(random), true}, .position = {position_V(random), true}}, true, true);
      image.setpoint_Pa = numeric::Scalar(kSetpoints_Pa[random() % kSetpoints_Pa.size()]);
      const float command_V = loop.command({.drive = safety::Drive::active,
                                            .commanded = true,
                                            .preview_ticks = static_cast<std::uint8_t>(random() % 9)},
                                           image);
      ASSERT_TRUE(command_V >= settings.chamber[0].command_low_V &&
                  command_V <= settings.chamber[0].command_high_V)
          << command_V << " V, set " << i << ", tick " << tick;
      for (const float value :
           std::initializer_list<float>{image.actual_Pa, image.demand_Pa, image.volume_m3,
                                        image.feedforward_V, image.feedback_V, image.residual_Pa})
        ASSERT_TRUE(std::isfinite(value)) << "set " << i << ", tick " << tick;
      if (tick <= int{config::kMostPreview_ticks})
        continue;  // until the first set point is due it stays at the pressure
      ASSERT_GE(image.demand_Pa, 999.0F * settings.chamber[0].pressure_low_kPa)
          << "6390h tells what is followed";
      ASSERT_LE(image.demand_Pa, 1001.0F * settings.chamber[0].pressure_high_kPa);
    }
  }
  EXPECT_GT(admissible, kSets / 20) << "sets that were tried";
}

INSTANTIATE_TEST_SUITE_P(Kinds, ChamberBounds,
                         ::testing::Values(ModelKind::tassa9, ModelKind::tassa9r, ModelKind::greybox),
                         [](const auto& of) {
                           return of.param == ModelKind::tassa9    ? "tassa9"
                                  : of.param == ModelKind::tassa9r ? "tassa9r"
                                                                   : "greybox";
                         });

}  // namespace
}  // namespace plenum
