// The check of an inverse: that it finds the point at which one is wrong, and lets the models pass that the core computes right.
#include "firmware/control/inverse_check.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <string>

#include "firmware/config/model_image.hpp"
#include "firmware/control/any_model.hpp"
#include "tests/firmware/control/random_subject.hpp"
#include "tests/firmware/scalars.hpp"

namespace plenum::control {
namespace {

using Finding = InverseCheck::Finding;

/// The pressure rises by `gain_kPa_V` a volt about 5 V, whatever it is; the inverse may be told to err at one state.
class Ramp final : public PressureModel {
 public:
  Scalar gain_kPa_V = 10;
  Scalar off_kPa = 0;
  Scalar at_kPa = 0, at_mL = 0, at_V = 0;  ///< where it errs

  using PressureModel::inverse;
  using PressureModel::step;
  Opening opening(Scalar command_V) const noexcept override { return {.first = command_V}; }
  Moving moving(const ChamberMotion& motion) const noexcept override { return {.first = motion.volume_mL}; }
  Prediction step(Scalar pressure_kPa, const Opening& open, const Moving&,
                  Scalar ticks) const noexcept override {
    return {.end_kPa = pressure_kPa + gain_kPa_V * (open.first - Scalar(5)) * ticks};
  }
  Inverse inverse(Scalar pressure_kPa, Scalar target_kPa, const Moving& moves,
                  Scalar) const noexcept override {
    const Scalar right_V = Scalar(5) + (target_kPa - pressure_kPa) / gain_kPa_V;
    const bool errs =
        pressure_kPa == at_kPa && moves.first == at_mL && numeric::abs(right_V - at_V) < Scalar(0.01);
    return {.command_V = errs ? right_V + off_kPa / gain_kPa_V : right_V};
  }
};

constexpr InverseCheck::Range kGrid{.pressure_low_kPa = 100.0F,
                                    .pressure_high_kPa = 600.0F,
                                    .volume_low_mL = 50.0F,
                                    .volume_high_mL = 150.0F,
                                    .command_low_V = 3.0F,
                                    .command_high_V = 7.0F,
                                    .span_kPa = 500.0F};

Finding finish(InverseCheck& check, const PressureModel& model, const InverseCheck::Range& grid = kGrid) {
  check.begin(grid);
  Finding found = Finding::running;
  for (std::size_t tick = 0; found == Finding::running && tick < InverseCheck::kPoints; ++tick)
    found = check.step(model);
  return found;
}

TEST(InverseCheck, TakesThreeTicks) {
  InverseCheck check;
  check.begin(kGrid);
  const Ramp model;
  EXPECT_EQ(check.step(model), Finding::running);
  EXPECT_EQ(check.step(model), Finding::running);
  EXPECT_EQ(check.step(model), Finding::passed);
}

TEST(InverseCheck, FindsTheOnePointAtWhichAnInverseErrs) {
  for (const float pressure_kPa : {100.0F, 350.0F, 600.0F}) {
    for (const float volume_mL : {50.0F, 150.0F}) {
      for (const float command_V : {3.0F, 4.0F, 5.0F, 6.0F, 7.0F}) {
        Ramp model;
        model.at_kPa = pressure_kPa;
        model.at_mL = volume_mL;
        model.at_V = command_V;
        InverseCheck check;
        model.off_kPa = 14.9F;  // the tolerance is 3 % of 500 kPa
        EXPECT_EQ(finish(check, model), Finding::passed);
        model.off_kPa = 15.1F;
        ASSERT_EQ(finish(check, model), Finding::inverse_fails)
            << pressure_kPa << " kPa, " << volume_mL << " mL, " << command_V << " V";
        EXPECT_EQ(check.point().pressure_kPa, Scalar(pressure_kPa));
        EXPECT_EQ(check.point().volume_mL, Scalar(volume_mL));
        EXPECT_EQ(check.point().command_V, Scalar(command_V));
        EXPECT_NEAR(real(check.point().wanted_kPa), pressure_kPa + 10.0F * (command_V - 5.0F), 1e-3);
        EXPECT_NEAR(real(check.point().came_kPa - check.point().wanted_kPa), 15.1, 1e-2);
      }
    }
  }
}

TEST(InverseCheck, AsksForAValveThatRaisesAndLowersThePressureByATenThousandthOfTheSpanATick) {
  Ramp model;
  InverseCheck check;
  model.gain_kPa_V = 0.026F;  // 2 V: 0.052 kPa, of 500 kPa
  EXPECT_EQ(finish(check, model), Finding::passed);
  model.gain_kPa_V = 0.024F;
  EXPECT_EQ(finish(check, model), Finding::no_authority);
  EXPECT_EQ(check.point().pressure_kPa, Scalar(350)) << "the middle";
  EXPECT_NEAR(real(check.point().wanted_kPa), 349.95, 1e-3);
  EXPECT_NEAR(real(check.point().came_kPa), 349.952, 1e-3);
  model.gain_kPa_V = 10;
  InverseCheck::Range above = kGrid;
  above.command_low_V = 5.5F;
  EXPECT_EQ(finish(check, model, above), Finding::no_authority) << "nothing lowers it";
  EXPECT_EQ(check.point().command_V, Scalar(5.5F));
  InverseCheck::Range below = kGrid;
  below.command_high_V = 4.5F;
  EXPECT_EQ(finish(check, model, below), Finding::no_authority) << "nothing raises it";
  EXPECT_EQ(check.point().command_V, Scalar(4.5F));
}

TEST(InverseCheck, FindsNoInverseOfARandomAdmissibleModelWrong) {
  for (const auto kind :
       {config::ModelKind::tassa9, config::ModelKind::tassa9r, config::ModelKind::greybox}) {
    std::mt19937 random(6);
    int wrong = 0, powerless = 0;
    constexpr int kSets = 3000;
    for (int i = 0; i < kSets; ++i) {
      const testing::Subject subject = testing::draw_subject(random, kind);
      AnyModel model;
      model.take_over(subject.model, 0, 10);
      InverseCheck check;
      const Finding found = finish(check, *model.in_force(),
                                   {.pressure_low_kPa = subject.ambient_kPa,
                                    .pressure_high_kPa = subject.supply_kPa,
                                    .volume_low_mL = 0.5F * subject.volume_mL,
                                    .volume_high_mL = 2.0F * subject.volume_mL,
                                    .command_low_V = 0.0F,
                                    .command_high_V = 10.0F,
                                    .span_kPa = subject.supply_kPa - subject.ambient_kPa});
      wrong += found == Finding::inverse_fails;
      powerless += found == Finding::no_authority;
    }
    EXPECT_EQ(wrong, 0) << "kind " << static_cast<int>(kind);
    // rates down to one a minute at one volt: these valves are too small for their chambers
    EXPECT_LT(powerless, kSets / 15) << "kind " << static_cast<int>(kind);
  }
}

}  // namespace
}  // namespace plenum::control
