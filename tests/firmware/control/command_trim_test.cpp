// The learned valve curve against valves whose fault is known.
#include "firmware/control/command_trim.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/firmware/scalars.hpp"

namespace plenum::control {
namespace {

CommandTrim trim_with(CommandTrim::Config config) {
  CommandTrim trim;
  trim.configure(config);
  return trim;
}

// The valve answers to u what the model answers to u - fault(u); each step takes off a third of what is still
// wrong.
void teach(CommandTrim& trim, double (*fault_V)(double), int ticks) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> command(3.0F, 7.0F);
  for (int i = 0; i < ticks; ++i) {
    const float model_V = command(random);
    const double wrong_V = fault_V(static_cast<double>(model_V)) - static_cast<double>(trim.at(model_V));
    trim.move(trim.place(model_V), 0.33F * static_cast<float>(wrong_V));
  }
}

TEST(CommandTrim, LearnsAValveThatIsOffByAConstant) {
  CommandTrim trim = trim_with({});
  teach(
      trim, [](double) { return 0.2; }, 3'000);
  for (float u = 3.0F; u <= 7.0F; u += 0.13F) EXPECT_NEAR(real(trim.at(u)), 0.2, 2e-3) << "at " << u << " V";
}

TEST(CommandTrim, LearnsADifferentFaultAtEachEnd) {
  CommandTrim trim = trim_with({});
  teach(
      trim, [](double u) { return 0.1 * (u - 5.0); }, 5'000);
  for (float u = 3.0F; u <= 7.0F; u += 0.13F)
    EXPECT_NEAR(real(trim.at(u)), 0.1F * (u - 5.0F), 2e-3) << "at " << u << " V";
}

TEST(CommandTrim, BelievesNoMoreThanItsLimit) {
  CommandTrim trim = trim_with({.limit_V = 0.5F});
  teach(
      trim, [](double) { return 3.0; }, 3'000);
  for (float u = 0.0F; u <= 10.0F; u += 0.1F)
    EXPECT_LE(std::abs(real(trim.at(u))), 0.5) << "at " << u << " V";
}

TEST(CommandTrim, ItsSlopeIsBoundedAndReachesOverCommandsNeverTaught) {
  CommandTrim trim = trim_with({});
  for (int i = 0; i < 500; ++i) trim.move(trim.place(5.6F), 0.05F);  // taught at one command only
  for (float u = 3.0F; u < 7.0F; u += 0.01F) {
    const double slope = real(trim.at(u + 0.01F) - trim.at(u)) / 0.01;
    EXPECT_LE(slope, 1.0 + 1e-3) << "V/V at " << u << " V";
    EXPECT_GE(slope, -0.5 - 1e-3) << "V/V at " << u << " V";
  }
  EXPECT_GT(trim.at(5.6F), 0.9F);
  EXPECT_GT(trim.at(5.1F), 0.3F);
}

TEST(CommandTrim, ReachIsTheShareOfAUnitStepThatArrives) {
  CommandTrim trim = trim_with({});
  for (float u = 3.0F; u <= 7.0F; u += 0.037F) {
    trim.reset();
    const CommandTrim::Place place = trim.place(u);
    trim.move(place, 0.01F);
    EXPECT_NEAR(real(trim.at(u)), real(0.01F * CommandTrim::reach(place)), 1e-6) << "at " << u << " V";
  }
}

}  // namespace
}  // namespace plenum::control
