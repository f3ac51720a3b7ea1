// The reference: preview, ramp and limits.
#include "firmware/control/reference_shaper.hpp"

#include <gtest/gtest.h>

#include <utility>

#include "tests/firmware/scalars.hpp"

namespace plenum::control {
namespace {

ReferenceShaper shaper_at(float pressure_kPa, ReferenceShaper::Config config = {}) {
  ReferenceShaper shaper;
  shaper.configure(config);
  shaper.reset(pressure_kPa);
  return shaper;
}

TEST(ReferenceShaper, WithoutPreviewTheSetPointIsWantedAtThisTicksEnd) {
  ReferenceShaper shaper = shaper_at(200);
  EXPECT_EQ(shaper.step(300, 0, 2).kPa[1], 300);
  const ReferenceShaper::Reference second = shaper.step(310, 0, 2);
  EXPECT_EQ(second.kPa[0], 300);
  EXPECT_EQ(second.kPa[1], 310);
  EXPECT_EQ(second.kPa[2], 310);
}

TEST(ReferenceShaper, WithPreviewASetPointIsMetThatManyTicksLater) {
  ReferenceShaper shaper = shaper_at(200);
  // Tick k takes the set point 201 + k; with a preview of 2 it is the reference at the start of tick k + 2.
  for (int tick = 0; tick < 10; ++tick) {
    const ReferenceShaper::Reference reference = shaper.step(static_cast<float>(201 + tick), 2, 2);
    if (tick < 2) continue;
    EXPECT_EQ(reference.kPa[0], static_cast<float>(201 + tick - 2)) << "tick " << tick;
    EXPECT_EQ(reference.kPa[1], static_cast<float>(201 + tick - 1)) << "tick " << tick;
    EXPECT_EQ(reference.kPa[2], static_cast<float>(201 + tick)) << "tick " << tick;
  }
}

TEST(ReferenceShaper, LooksAsFarAheadAsItIsAskedAndHoldsTheLastThatItKnows) {
  ReferenceShaper shaper = shaper_at(200);
  for (int tick = 0; tick < 10; ++tick) {
    const ReferenceShaper::Reference& reference = shaper.step(static_cast<float>(200 + tick), 5, 8);
    if (tick < 5) continue;
    for (int ahead = 0; ahead <= 8; ++ahead) {
      EXPECT_EQ(reference.kPa[static_cast<std::size_t>(ahead)],
                static_cast<float>(200 + tick - 5 + std::min(ahead, 5)))
          << "tick " << tick << ", " << ahead << " ahead";
    }
    EXPECT_EQ(reference.at(2, 0.25F), static_cast<float>(200 + tick - 3) + 0.25F);
  }
}

TEST(ReferenceShaper, RampsAtItsRateAndNoFaster) {
  ReferenceShaper shaper =
      shaper_at(200, {.low_kPa = 100, .high_kPa = 700, .rise_kPa_s = 500, .fall_kPa_s = 500});
  for (int tick = 1; tick <= 20; ++tick) {
    EXPECT_NEAR(real(shaper.step(300, 0, 2).kPa[1]),
                std::min(200.0F + 5.0F * static_cast<float>(tick), 300.0F), 1e-3F);
  }
  EXPECT_EQ(shaper.step(300, 0, 2).kPa[1], 300);
}

TEST(ReferenceShaper, RisesAndFallsAtRatesOfTheirOwn) {
  ReferenceShaper shaper =
      shaper_at(300, {.low_kPa = 100, .high_kPa = 700, .rise_kPa_s = 500, .fall_kPa_s = 200});
  for (int tick = 1; tick <= 20; ++tick)
    EXPECT_NEAR(real(shaper.step(400, 0, 2).kPa[1]), 300.0F + 5.0F * static_cast<float>(tick), 1e-3F);
  for (int tick = 1; tick <= 50; ++tick)
    EXPECT_NEAR(real(shaper.step(300, 0, 2).kPa[1]), 400.0F - 2.0F * static_cast<float>(tick), 1e-3F);
  EXPECT_EQ(shaper.step(300, 0, 2).kPa[1], 300);
}

TEST(ReferenceShaper, TellsThatARampRunsUntilTheReferenceIsWhereItsSetPointWantsIt) {
  ReferenceShaper shaper =
      shaper_at(300, {.low_kPa = 100, .high_kPa = 700, .rise_kPa_s = 1000, .fall_kPa_s = 1000});
  for (int tick = 1; tick <= 8; ++tick) {
    shaper.step(350, 0, 2);
    if (tick == 5) continue;  // there, but for a rounding
    EXPECT_EQ(shaper.ramp_runs(), tick < 5) << "50 kPa at 10 kPa a tick, tick " << tick;
  }
}

TEST(ReferenceShaper, TellsOfNoRampWhereASetPointOfLaterIsKnown) {
  ReferenceShaper shaper = shaper_at(300);
  for (int tick = 0; tick < 20; ++tick) {
    shaper.step(static_cast<float>(300 + tick), 4, 6);
    EXPECT_FALSE(shaper.ramp_runs()) << "tick " << tick;
  }
}

TEST(ReferenceShaper, TellsASetPointThatItCutsOff) {
  ReferenceShaper shaper = shaper_at(200, {.low_kPa = 120, .high_kPa = 600});
  for (const auto& [setpoint_kPa, touched] :
       {std::pair{600.0F, false}, {600.5F, true}, {120.0F, false}, {119.5F, true}, {0.0F, false}}) {
    shaper.step(setpoint_kPa, 0, 2);
    EXPECT_EQ(shaper.limit_touched(), touched) << setpoint_kPa << " kPa; 0 stands for none";
  }
}

TEST(ReferenceShaper, LimitsTheSetPoint) {
  ReferenceShaper shaper =
      shaper_at(200, {.low_kPa = 120, .high_kPa = 600, .rise_kPa_s = 1e6F, .fall_kPa_s = 1e6F});
  EXPECT_EQ(shaper.step(5000, 0, 2).kPa[1], 600);
  EXPECT_EQ(shaper.step(0, 0, 2).kPa[1], 120);
}

TEST(ReferenceShaper, MoreTicksThanItRemembersCountAsThoseItRemembers) {
  ReferenceShaper shaper = shaper_at(200);
  Scalar last = 0;
  for (int tick = 0; tick < 30; ++tick) last = shaper.step(static_cast<float>(300 + tick), 200, 2).kPa[1];
  EXPECT_EQ(last, static_cast<float>(300 + 29 - static_cast<int>(ReferenceShaper::kMaxPreview) + 1));
}

}  // namespace
}  // namespace plenum::control
