// What a setting written over the bus does to the board.
#include <gtest/gtest.h>

#include <algorithm>

#include "firmware/canopen/objects.hpp"
#include "tests/firmware/board/bench.hpp"

namespace plenum {
namespace {

namespace object = canopen::object;

constexpr std::uint8_t kPressureValidLow =
    3;  // sub-indices of 2400h, as config/setting_fields.hpp counts them
constexpr std::uint8_t kOverPressure = 11;
constexpr std::uint8_t kCommandHigh = 14;

/// To INIT, with models.
void wake(Bench& bench) {
  bench.store_models();
  bench.board.start();
  bench.run(2);
}

void regulate(Bench& bench, double target_kPa) {
  bench.setpoint_kPa = target_kPa;
  bench.put(0, {1, 0});
  bench.tick();
  bench.climb();
  bench.run(150);
}

TEST(SettingsOnTheBus, BoundTheReferenceByTheUpperLimit) {
  Bench bench;
  wake(bench);
  bench.session.write<std::int16_t>(object::kUpperLimit + 2 * object::kChamberStride, 1, 3500);
  regulate(bench, 500.0);
  ASSERT_EQ(bench.state(), safety::State::active);
  EXPECT_EQ(bench.image().chamber[2].reference_Pa, 350'000.0F);
  EXPECT_EQ(bench.image().chamber[2].demand_Pa, 350'000.0F);
  EXPECT_NEAR(bench.chamber[2].pressure_kPa, 350.0, 0.5) << "kPa, after 1.5 s";
  EXPECT_EQ(bench.image().chamber[3].reference_Pa, 500'000.0F) << "the others follow the set point";
  EXPECT_EQ(bench.image().chamber[3].demand_Pa, 500'000.0F);
}

TEST(SettingsOnTheBus, BoundTheCommandOfAModelInForce) {
  Bench bench;
  wake(bench);
  bench.session.write<float>(object::kChamberSettings + 1, kCommandHigh, 5.5F);
  bench.setpoint_kPa = 500.0;
  bench.put(0, {1, 0});
  bench.tick();
  bench.streaming = true;
  for (const std::uint16_t word : Words{0x1, 0x3, 0x7}) {
    bench.control(word);
    for (int i = 0; i < 20; ++i) {
      bench.tick();
      EXPECT_LE(bench.analog_out.held_V[1], 5.5F);
    }
  }
  EXPECT_EQ(bench.state(), safety::State::active);
}

TEST(SettingsOnTheBus, WidenTheCommandsOfAModelInForce) {
  Bench bench;
  wake(bench);
  bench.session.write<float>(object::kChamberSettings + 1, kCommandHigh, 9.0F);
  bench.setpoint_kPa = 550.0;
  bench.put(0, {1, 0});
  bench.tick();
  bench.streaming = true;
  float highest_V = 0.0F;
  float others_V = 0.0F;
  for (const std::uint16_t word : Words{0x1, 0x3, 0x7}) {
    bench.control(word);
    for (int i = 0; i < 20; ++i) {
      bench.tick();
      highest_V = std::max(highest_V, bench.analog_out.held_V[1]);
      others_V = std::max(others_V, bench.analog_out.held_V[0]);
    }
  }
  EXPECT_GT(highest_V, 7.5F) << "the model inverts over the new range";
  EXPECT_LE(others_V, 7.0F);
}

TEST(SettingsOnTheBus, MoveTheTripOfOverPressure) {
  Bench bench;
  wake(bench);
  bench.session.write<std::int16_t>(object::kUpperLimit, 1, 2500);
  bench.session.write<float>(object::kChamberSettings, kOverPressure, 260.0F);
  regulate(bench, 200.0);
  ASSERT_EQ(bench.state(), safety::State::active);
  bench.forced[0] = ports::AnalogReading{2.7F, true};  // 270 kPa
  bench.run(3);
  EXPECT_EQ(bench.image().error_code, 0x8302);
  EXPECT_EQ(bench.image().fault_chamber, 1);
}

TEST(SettingsOnTheBus, CorrectASensorWindowThatHoldsTheBoardInFault) {
  Bench bench;
  wake(bench);
  bench.session.write<float>(object::kChamberSettings + 5, kPressureValidLow,
                             2.0F);  // the chamber stands at 1 V
  bench.run(2);
  ASSERT_EQ(bench.state(), safety::State::fault_init);
  EXPECT_EQ(bench.image().error_code, 0xFF05);
  bench.session.write<float>(object::kChamberSettings + 5, kPressureValidLow, 0.2F);
  bench.put(0, {1, 0});  // operational, so that RPDO3 is heard
  bench.control(0x0);
  bench.run(1);
  bench.control(0x8);
  bench.run(2);
  EXPECT_EQ(bench.state(), safety::State::init);
}

TEST(SettingsOnTheBus, AreRefusedWhileTheBoardRegulates) {
  Bench bench;
  wake(bench);
  regulate(bench, 300.0);
  EXPECT_THROW(bench.session.write<std::int16_t>(object::kUpperLimit, 1, 2500), host::client::SdoAbort);
  bench.run(10);
  EXPECT_EQ(bench.image().chamber[0].reference_Pa, 300'000.0F);
}

TEST(SettingsOnTheBus, LeaveTheOutputsOfAStandingBoardAlone) {
  Bench bench;
  wake(bench);
  const std::vector<float> before_V = bench.analog_out.held_V;
  bench.session.write<float>(object::kChamberSettings, 12, 500.0F);  // the ramp
  bench.run(1);
  EXPECT_EQ(bench.analog_out.held_V, before_V);
}

constexpr std::uint8_t kNull = 15;  // sub-indices of 2400h
constexpr std::uint8_t kVent = 16;

/// A chamber under pressure, shut, in INIT.
void rest_under_pressure(Bench& bench) {
  bench.go_active(300.0);
  bench.streaming = false;
  bench.control(0x0);
  bench.run(5);
}

TEST(SettingsOnTheBus, ReachTheOutputOfARestingBoardOnlyWithTheStepToDisabled) {
  Bench bench;
  rest_under_pressure(bench);
  ASSERT_EQ(bench.state(), safety::State::init);
  bench.session.write<float>(object::kChamberSettings, kNull, 6.9F);
  bench.session.write<std::uint8_t>(object::kChamberChoices + 1, 2, 1);  // safe_output: vent
  bench.session.write<float>(object::kChamberSettings + 2, kNull, 5.2F);
  bench.session.write<std::uint8_t>(object::kChamberChoices + 2, 1, 0);  // not in use
  for (int i = 0; i < 50; ++i) {
    bench.tick();
    for (std::size_t c = 0; c < 3; ++c) ASSERT_EQ(bench.analog_out.held_V[c], 5.0F) << "chamber " << c;
  }
  bench.control(0x1);
  bench.run(1);
  EXPECT_EQ(bench.state(), safety::State::disabled);
  EXPECT_EQ(bench.analog_out.held_V[0], 6.9F);
  EXPECT_EQ(bench.analog_out.held_V[1], 2.5F);
  EXPECT_EQ(bench.analog_out.held_V[2], 5.2F);
}

TEST(SettingsOnTheBus, AreRefusedToAChamberThatMustVent) {
  Bench bench;
  bench.go_active(300.0);
  bench.forced[0] = ports::AnalogReading{7.5F, true};  // 750 kPa
  bench.run(4);
  bench.streaming = false;
  bench.control(0x0);
  bench.run(3);
  ASSERT_EQ(bench.state(), safety::State::fault_init);
  EXPECT_THROW(bench.session.write<std::uint8_t>(object::kChamberChoices, 1, 0), host::client::SdoAbort);
  EXPECT_THROW(bench.session.write<float>(object::kChamberSettings, kVent, 5.0F), host::client::SdoAbort);
  EXPECT_THROW(bench.session.write<float>(object::kChamberSettings, kOverPressure, 800.0F),
               host::client::SdoAbort);
  EXPECT_NO_THROW(bench.session.write<float>(object::kChamberSettings + 1, kOverPressure, 650.0F));
  bench.run(3);
  EXPECT_EQ(bench.analog_out.held_V[0], 2.5F) << "vented";
}

}  // namespace
}  // namespace plenum
