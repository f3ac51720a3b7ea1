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
  bench.session.write<std::int16_t>(object::of_module(object::kUpperLimit, 2), 1, 3500);
  regulate(bench, 500.0);
  ASSERT_EQ(bench.state(), safety::State::active);
  EXPECT_EQ(bench.image().chamber[2].demand_Pa, 350'000.0F);
  EXPECT_NEAR(bench.chamber[2].pressure_kPa, 350.0, 0.5) << "kPa, after 1.5 s";
  EXPECT_EQ(bench.image().chamber[3].demand_Pa, 500'000.0F) << "the others follow the set point";
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
  EXPECT_EQ(bench.image().chamber[0].demand_Pa, 300'000.0F);
}

TEST(SettingsOnTheBus, LeaveTheOutputsOfAStandingBoardAlone) {
  Bench bench;
  wake(bench);
  const std::vector<float> before_V = bench.analog_out.held_V;
  bench.session.write<float>(object::kChamberSettings, 12, 500.0F);  // the ramp
  bench.run(1);
  EXPECT_EQ(bench.analog_out.held_V, before_V);
}

// 4 s for 10 bar up, 8 s down: 2.5 and 1.25 kPa a tick.
TEST(Cia408, RampsUpAndDownAtTheTimesThatAreWritten) {
  Bench bench;
  wake(bench);
  for (const unsigned c : {1U, 4U}) {
    bench.session.write<std::int8_t>(object::of_module(0x63B0, c), 0, 2);
    bench.session.write<std::uint16_t>(object::of_module(0x63B1, c), 1, 4000);
    bench.session.write<std::uint16_t>(object::of_module(0x63B4, c), 1, 8000);
  }
  regulate(bench, 300.0);
  ASSERT_EQ(bench.state(), safety::State::active);
  EXPECT_EQ(bench.image().status_word, 0xF);
  const auto follow = [&](double target_kPa, float step_kPa, int ticks) {
    bench.setpoint_kPa = target_kPa;
    float before_kPa = bench.image().chamber[4].demand_Pa / 1000.0F;
    for (int tick = 1; tick <= ticks; ++tick) {
      bench.tick();
      const float demand_kPa = bench.image().chamber[4].demand_Pa / 1000.0F;
      ASSERT_NEAR(demand_kPa - before_kPa, step_kPa, 1e-3) << "tick " << tick;
      if (tick < ticks) {
        ASSERT_EQ(bench.image().status_word, 0x20F) << "tick " << tick;
      }
      EXPECT_EQ(bench.image().chamber[0].regulation, 0) << "who has no ramp";
      before_kPa = demand_kPa;
    }
    bench.run(1);
    EXPECT_EQ(bench.image().status_word, 0xF) << "there";
  };
  follow(350.0, 2.5F, 20);
  follow(300.0, -1.25F, 40);
  EXPECT_NEAR(bench.chamber[4].pressure_kPa, 300.0, 0.5);
}

TEST(Cia408, ShowsASetPointBeyondTheLimits) {
  Bench bench;
  wake(bench);
  bench.session.write<std::int16_t>(object::of_module(object::kUpperLimit, 2), 1, 3500);
  regulate(bench, 350.0);
  EXPECT_EQ(bench.image().status_word, 0xF);
  bench.setpoint_kPa = 351.0;
  bench.run(2);
  EXPECT_EQ(bench.image().status_word, 0x40F);
  EXPECT_EQ(bench.image().chamber[2].regulation, canopen::regulation::kLimitTouched);
  EXPECT_EQ(bench.image().chamber[3].regulation, 0);
  bench.control(0x3);
  bench.run(2);
  EXPECT_EQ(bench.image().status_word, 0xB) << "a hold set point that was never written touches none";
}

TEST(Cia408, WarnsWhileThePressureIsOffItsBandAndRegulatesOn) {
  Bench bench;
  wake(bench);
  bench.session.write<std::uint16_t>(object::of_module(0x63D2, 3), 1, 200);
  bench.session.write<std::int16_t>(object::of_module(0x63D3, 3), 1, 100);
  bench.session.write<std::int8_t>(object::of_module(0x63D1, 3), 0, 1);
  regulate(bench, 300.0);
  ASSERT_EQ(bench.image().status_word, 0xF);
  // a sensor at 285 kPa, 15 below the set point, that has noise
  const auto run = [&](float pressure_V, int ticks) {
    for (int tick = 0; tick < ticks; ++tick) {
      bench.forced[3] = ports::AnalogReading{pressure_V + (tick % 2 == 0 ? 0.0F : 1e-5F), true};
      bench.tick();
    }
  };
  run(2.85F, 19);
  EXPECT_EQ(bench.image().status_word, 0xF);
  run(2.85F, 2);
  EXPECT_EQ(bench.image().status_word, 0x80F) << "after 200 ms; READY: a warning, no fault's reaction";
  EXPECT_NEAR(bench.image().chamber[3].deviation_Pa, 15e3, 10.0) << "63D0h, Pa";
  EXPECT_EQ(bench.image().error_code, 0xFF0C);
  EXPECT_EQ(bench.image().fault_chamber, 4);
  EXPECT_EQ(bench.state(), safety::State::active);
  run(2.95F, 2);
  EXPECT_EQ(bench.image().status_word, 0xF);
  EXPECT_EQ(bench.image().error_code, 0xFF0C) << "for a while, in which it may come again";
  run(2.95F, 2 * safety::FaultRegister::kFlicker_ticks);
  EXPECT_EQ(bench.image().error_code, 0);
}

TEST(Cia408, SaysWhenEveryChamberThatWatchesForItIsOnTarget) {
  Bench bench;
  wake(bench);
  for (const unsigned c : {0U, 5U}) {
    bench.session.write<std::int8_t>(object::of_module(0x63F0, c), 0, 1);
    bench.session.write<std::int16_t>(object::of_module(0x63F2, c), 1, 20);
  }
  regulate(bench, 300.0);
  EXPECT_EQ(bench.image().status_word, 0x10F);
  bench.forced[5] = ports::AnalogReading{2.9F, true};
  bench.run(2);
  EXPECT_EQ(bench.image().status_word, 0xF) << "one of two";
  EXPECT_EQ(bench.image().chamber[0].regulation, canopen::regulation::kOnTarget);
  bench.forced[5].reset();
  bench.run(50);
  EXPECT_EQ(bench.image().status_word, 0x10F);
  bench.setpoint_kPa = 500.0;
  bench.run(2);
  EXPECT_EQ(bench.image().status_word, 0xF) << "a new target, out of reach within a tick";
  bench.run(50);
  EXPECT_EQ(bench.image().status_word, 0x10F);
  bench.control(0x1);
  bench.run(2);
  EXPECT_EQ(bench.image().status_word, 0x9) << "at rest there is none";
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

TEST(ExcitationOnTheBus, HasARangeOfItsOwnInEachChamber) {
  Bench bench;
  bench.board.start();
  bench.session.write(object::kControlMode, 0, std::int8_t{-1});
  const std::uint16_t of_fourth = object::nth(object::kExcitation, 3);
  bench.session.write<float>(of_fourth, 2, 4.5F);
  bench.session.write<float>(of_fourth, 3, 5.5F);
  EXPECT_EQ(bench.session.read<float>(object::kExcitation, 2), 3.0F) << "that of the first is its own";
  bench.put(0, {1, 0});
  bench.climb();
  std::array<float, kChambers> low_V{}, high_V{};
  low_V.fill(10.0F);
  for (int t = 0; t < 500; ++t) {
    bench.run(1);
    for (std::size_t c = 0; c < kChambers; ++c) {
      low_V[c] = std::min(low_V[c], bench.analog_out.held_V[c]);
      high_V[c] = std::max(high_V[c], bench.analog_out.held_V[c]);
    }
  }
  EXPECT_GE(low_V[3], 4.5F);
  EXPECT_LE(high_V[3], 5.5F);
  for (const std::size_t other : {2U, 4U}) {
    EXPECT_LT(low_V[other], 4.0F) << other;
    EXPECT_GT(high_V[other], 6.0F) << other;
  }
}

}  // namespace
}  // namespace plenum
