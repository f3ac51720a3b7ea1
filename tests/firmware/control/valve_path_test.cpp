// The valve between a command and its act: closed forms, and the inverse against the path itself.
#include "firmware/control/valve_path.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/firmware/scalars.hpp"

namespace plenum::control {
namespace {

ValvePath path_of(const ValvePath::Config& config, float at_V = 5) {
  ValvePath path;
  path.configure(config);
  path.reset(at_V);
  return path;
}

TEST(ValvePath, APromptValveIsTheCommandToTheBit) {
  ValvePath path = path_of({.dead_ticks = 0.3F});
  std::mt19937 random(1);
  std::uniform_real_distribution<float> command(0, 10);
  for (int i = 0; i < 100; ++i) {
    const float u = command(random);
    EXPECT_EQ(path.command_for(u), u);
    EXPECT_EQ(path.sent(u), u);
  }
  EXPECT_EQ(path.delay_ticks(), 0.3F);
}

TEST(ValvePath, ALagGoesItsShareOfTheWayInATick) {
  ValvePath path = path_of({.lag_ticks = 2});
  double left = 1;
  for (int i = 0; i < 8; ++i) {
    left *= std::exp(-0.5);
    EXPECT_NEAR(real(path.sent(6)), 6 - left, 2e-6) << "V after tick " << i + 1;
  }
}

TEST(ValvePath, ALagIsLateByTheAreaThatItLosesWithinTheTick) {
  // over one tick from 0 towards the command that takes it to 1 at the end
  for (const double lag : {0.1, 0.5, 1.0, 2.0, 4.0}) {
    const double command = 1.0 / (1.0 - std::exp(-1.0 / lag));
    double missing = 0;
    constexpr int kSteps = 100'000;
    for (int i = 0; i < kSteps; ++i)
      missing += (1.0 - command * (1.0 - std::exp(-(i + 0.5) / kSteps / lag))) / kSteps;
    const ValvePath path = path_of({.dead_ticks = 2, .lag_ticks = static_cast<float>(lag)});
    EXPECT_NEAR(real(path.delay_ticks()), 2 + missing, 1e-5) << "ticks, lag " << lag;
  }
}

TEST(ValvePath, PlayHoldsTheSpoolUntilTheCommandHasCrossedItsWidth) {
  ValvePath path = path_of({.play_V = 0.4F});
  EXPECT_FLOAT_EQ(static_cast<float>(path.sent(5.1F)), 5.0F);
  EXPECT_FLOAT_EQ(static_cast<float>(path.sent(5.5F)), 5.3F);
  EXPECT_FLOAT_EQ(static_cast<float>(path.sent(5.2F)), 5.3F) << "within the play";
  EXPECT_FLOAT_EQ(static_cast<float>(path.sent(4.9F)), 5.1F);
}

TEST(ValvePath, TheCommandForAPlacePutsTheSpoolThere) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> unit(0, 1), place(3, 7);
  for (int trial = 0; trial < 200; ++trial) {
    ValvePath path = path_of({.dead_ticks = 3, .lag_ticks = 4 * unit(random), .play_V = 1.5F * unit(random)});
    for (int i = 0; i < 20; ++i) {
      const float wanted = place(random);
      ASSERT_NEAR(real(path.sent(path.command_for(wanted))), wanted, 2e-5F) << "trial " << trial;
    }
  }
}

TEST(ValvePath, ASpoolThatStaysAsksForNoOtherCommand) {
  ValvePath path = path_of({.play_V = 0.4F});
  path.sent(6);
  const Scalar place = path.sent(5.9F);
  EXPECT_EQ(path.command_for(place), 5.9F);
}

TEST(ValvePath, ADelayBeyondTheRegulatorsSightIsHeldToIt) {
  EXPECT_EQ(path_of({.dead_ticks = 40}).delay_ticks(), ValvePath::kMostDelay_ticks);
}

}  // namespace
}  // namespace plenum::control
