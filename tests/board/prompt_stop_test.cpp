#include "board/prompt_stop.hpp"

#include <gtest/gtest.h>

#include "tests/firmware/board/bench.hpp"

namespace plenum::board {
namespace {

class PromptStopTest : public testing::Test {
 protected:
  void SetUp() override { stop.write({.valve_power = true, .fault_lamp = true}); }

  FakeDigitalIo lines;
  PromptStop stop{lines};
};

TEST_F(PromptStopTest, AnOpenCircuitTakesTheValvePowerAwayAtOnceAndLeavesTheLamp) {
  lines.inputs.emergency_stop = true;
  stop.look();
  EXPECT_FALSE(lines.outputs.valve_power);
  EXPECT_TRUE(lines.outputs.fault_lamp);
}

TEST_F(PromptStopTest, AStopThatWasOnlyBriefIsReadOnce) {
  lines.inputs.emergency_stop = true;
  stop.look();
  lines.inputs.emergency_stop = false;
  EXPECT_TRUE(stop.read().emergency_stop);
  EXPECT_FALSE(stop.read().emergency_stop);
}

TEST_F(PromptStopTest, ACircuitThatHasClosedAgainTakesNothingAway) {
  stop.look();
  EXPECT_TRUE(lines.outputs.valve_power);
  EXPECT_FALSE(stop.read().emergency_stop);
}

}  // namespace
}  // namespace plenum::board
