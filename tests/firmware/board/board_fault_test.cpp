// Every fault of the board, from its cause to its cure, through the drivers and the bus.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <functional>
#include <limits>
#include <ostream>

#include "firmware/safety/faults.hpp"
#include "tests/firmware/board/bench.hpp"

namespace plenum {
namespace {

using safety::Fault;
using safety::Reaction;
using safety::State;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
namespace object = canopen::object;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();

struct Injection {
  const char* name;
  Fault fault;
  int chamber;  ///< + 1; 0: the board
  int ticks;    ///< the fault stands in this tick after its cause, not before
  std::function<void(Bench&)> cause;
  std::function<void(Bench&)> cure;
  bool only_while_active = false;  ///< DISABLED ends the cause
};
std::ostream& operator<<(std::ostream& out, const Injection& injection) {
  return out << injection.name;
}

/// A communication error has left the node pre-operational (1029h).
void start_again(Bench& bench) {
  bench.put(0, {1, 0});
}

// Limits as in ChamberSettings and BoardSettings.
const std::vector<Injection> kInjections = {
    {"PressureStale", Fault::pressure_stale, 3, 3, [](Bench& b) { force(b, 2, 0.0F, false); }, free_inputs},
    {"PositionStale", Fault::position_stale, 3, 3, [](Bench& b) { force(b, 10, 0.0F, false); }, free_inputs},
    {"PressureNan", Fault::pressure_not_finite, 1, 1, [](Bench& b) { force(b, 0, kNaN); }, free_inputs},
    {"PressureInfinite", Fault::pressure_not_finite, 8, 1, [](Bench& b) { force(b, 7, -kInf); }, free_inputs},
    {"PositionNan", Fault::position_not_finite, 8, 1, [](Bench& b) { force(b, 15, kNaN); }, free_inputs},
    {"PressureWireBreak", Fault::pressure_out_of_range, 5, 1, [](Bench& b) { force(b, 4, 0.0F); },
     free_inputs},
    {"PositionWireBreak", Fault::position_out_of_range, 5, 1, [](Bench& b) { force(b, 12, -0.5F); },
     free_inputs},
    {"OverPressure", Fault::over_pressure, 2, 2, [](Bench& b) { force(b, 1, 7.5F); }, free_inputs},
    {"SetpointsLost", Fault::setpoint_timeout, 0, 10, [](Bench& b) { b.streaming = false; },
     [](Bench& b) { b.streaming = true; }, true},
    {"TickOverrun", Fault::tick_overrun, 0, 3, [](Bench& b) { b.late = true; },
     [](Bench& b) { b.late = false; }},
    {"EmergencyStop", Fault::emergency_stop, 0, 1, [](Bench& b) { b.digital.inputs.emergency_stop = true; },
     [](Bench& b) { b.digital.inputs.emergency_stop = false; }},
    {"SupplyLow", Fault::supply_low, 0, 20, [](Bench& b) { force(b, 16, 4.9F); }, free_inputs},
    {"SupplySensorNan", Fault::supply_low, 0, 20, [](Bench& b) { force(b, 16, kNaN); }, free_inputs},
    {"SupplySensorStale", Fault::supply_low, 0, 20, [](Bench& b) { force(b, 16, 6.2F, false); }, free_inputs},
    // the answer to a tick's write is known in the next one
    {"OutputRefused", Fault::hardware, 0, 2, [](Bench& b) { b.analog_out.refuses = true; },
     [](Bench& b) { b.analog_out.refuses = false; }},
    {"BusOff", Fault::bus_off, 0, 1, [](Bench& b) { b.can.state_now = ports::CanState::bus_off; },
     [](Bench& b) {
       b.can.state_now = ports::CanState::error_active;
       start_again(b);
     }},
    // more than 30 ms after the heartbeat, which the controller learns of in the tick after
    {"HeartbeatLost", Fault::heartbeat_lost, 0, 5,
     [](Bench& b) {
       b.session.write(0x1016, 1, std::uint32_t{2U << 16 | 30U});
       b.put(0x702, {5});
     },
     [](Bench& b) {
       b.session.write(0x1016, 1, std::uint32_t{0});
       start_again(b);
     }},
};

class EachFault : public ::testing::TestWithParam<std::tuple<Injection, config::SafeOutput>> {
 protected:
  static Settings settings() {
    Settings settings = bench_settings();
    for (auto& chamber : settings.chamber) chamber.safe_output = std::get<1>(GetParam());
    return settings;
  }
  EachFault() : bench(settings()) {
    bench.go_active(300.0);
    for (std::size_t c = 0; c < kChambers; ++c) {
      bench.session.write(object::of_module(object::kHoldSetpoint, c), 1, std::int16_t{2500});
    }
    bench.run(3);
    bench.take();
  }

  /// What the fault's reaction makes of the outputs in the tick at hand.
  void expect_reaction() {
    const float safe_V = std::get<1>(GetParam()) == config::SafeOutput::vent ? 2.5F : 5.0F;
    for (std::size_t c = 0; c < kChambers; ++c) {
      const float command_V = bench.analog_out.asked_V[c];
      const bool vents = spec.reaction == Reaction::vent && injection.chamber == static_cast<int>(c) + 1;
      if (spec.reaction == Reaction::hold) {
        EXPECT_GE(command_V, 3.0F) << "chamber " << c;
        EXPECT_LE(command_V, 7.0F) << "chamber " << c;
      } else {
        EXPECT_EQ(command_V, vents ? 2.5F : safe_V) << "chamber " << c;
      }
    }
  }

  const Injection& injection = std::get<0>(GetParam());
  const safety::FaultSpec& spec = safety::spec(injection.fault);
  Bench bench;
};

TEST_P(EachFault, StandsEverywhereInTheSameTickAndOnlyAResetLeadsBackToDisabled) {
  injection.cause(bench);
  for (int i = 1; i < injection.ticks; ++i) {
    bench.tick();
    ASSERT_EQ(bench.image().error_code, 0) << "tick " << i << " after the cause";
    ASSERT_EQ(bench.state(), State::active) << "tick " << i << " after the cause";
    ASSERT_THAT(bench.take_emergencies(), IsEmpty()) << "tick " << i << " after the cause";
  }
  bench.tick();

  // one tick, one story
  EXPECT_EQ(bench.state(), State::fault_reaction);
  EXPECT_EQ(bench.image().status_word, 0x7);
  EXPECT_EQ(bench.image().error_code, spec.code);
  EXPECT_EQ(bench.image().error_register, spec.error_register);
  EXPECT_EQ(int{bench.image().fault_chamber}, injection.chamber);
  EXPECT_TRUE(bench.digital.outputs.fault_lamp);
  // an output that takes no value holds its last one: what is left is the power
  EXPECT_EQ(bench.digital.outputs.valve_power,
            injection.fault != Fault::emergency_stop && injection.fault != Fault::hardware);
  expect_reaction();
  const std::uint32_t history = spec.code | static_cast<std::uint32_t>(injection.chamber) << 16;
  const bool on_the_bus = injection.fault != Fault::bus_off;
  if (on_the_bus) {
    const auto emergencies = bench.take_emergencies();
    ASSERT_EQ(emergencies.size(), 1U);
    EXPECT_EQ(emergencies[0].code, spec.code);
    EXPECT_EQ(emergencies[0].error_register, spec.error_register);
    EXPECT_EQ(int{emergencies[0].chamber}, injection.chamber);
    const int tick = bench.ticks;
    EXPECT_EQ(bench.session.read<std::uint16_t>(object::kStatusWord, 0), 0x7);
    EXPECT_EQ(bench.session.read<std::uint16_t>(object::kErrorCode, 0), spec.code);
    EXPECT_EQ(bench.session.read<std::uint8_t>(object::kErrorRegister, 0), spec.error_register);
    EXPECT_EQ(bench.session.read<std::uint32_t>(object::kErrorHistoryIndex, 1), history);
    ASSERT_EQ(bench.ticks, tick) << "the answers took a tick";
  }

  bench.tick();
  EXPECT_EQ(bench.state(), spec.reaction == Reaction::hold ? State::fault_hold : State::fault_disabled);
  for (int i = 0; i < 30; ++i) {
    expect_reaction();
    bench.tick();
  }
  if (spec.reaction == Reaction::hold) {
    bench.run(100);
    for (const Chamber& chamber : bench.chamber) EXPECT_NEAR(chamber.pressure_kPa, 250.0, 0.1);
  }

  // a reset while the cause stands changes nothing
  for (const std::uint16_t word : Words{0x1, 0x9, 0x1}) {
    bench.control(word);
    bench.run(2);
  }
  if (injection.only_while_active) {
    EXPECT_EQ(bench.state(), State::disabled);
    return;
  }
  EXPECT_EQ(bench.image().error_code, spec.code);
  EXPECT_EQ(bench.image().status_word & 0x8, 0);

  // its end alone neither; nor does a reset that would start the machine
  injection.cure(bench);
  bench.streaming = true;
  for (const std::uint16_t word : Words{0x7, 0xF, 0x7}) {
    bench.control(word);
    for (int i = 0; i < 15; ++i) {
      bench.tick();
      ASSERT_EQ(bench.image().error_code, spec.code) << "control word " << word;
      ASSERT_EQ(bench.image().status_word & 0x8, 0);
    }
  }

  for (const std::uint16_t word : Words{0x1, 0x9}) {
    bench.control(word);
    for (int i = 0; i < 3; ++i) {
      bench.tick();
      ASSERT_NE(bench.state(), State::active);
      ASSERT_NE(bench.state(), State::hold);
    }
  }
  EXPECT_EQ(bench.state(), State::disabled);
  EXPECT_EQ(bench.image().error_code, 0);
  EXPECT_EQ(bench.image().error_register, 0);
  EXPECT_FALSE(bench.digital.outputs.fault_lamp);
  EXPECT_TRUE(bench.digital.outputs.valve_power);
  std::vector<std::uint32_t> entries{history};
  // a node that has left OPERATIONAL takes no set points
  if (injection.fault == Fault::bus_off || injection.fault == Fault::heartbeat_lost)
    entries.insert(entries.begin(), safety::spec(Fault::setpoint_timeout).code);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    EXPECT_EQ(bench.session.read<std::uint32_t>(object::kErrorHistoryIndex, static_cast<std::uint8_t>(i + 1)),
              entries[i]);
  }

  bench.climb();
  EXPECT_EQ(bench.state(), State::active);
  bench.run(150);
  EXPECT_NEAR(bench.chamber[4].pressure_kPa, 300.0, 0.1);
  EXPECT_EQ(bench.image().error_code, 0);
}

INSTANTIATE_TEST_SUITE_P(Board, EachFault,
                         ::testing::Combine(::testing::ValuesIn(kInjections),
                                            ::testing::Values(config::SafeOutput::null,
                                                              config::SafeOutput::vent)),
                         [](const auto& instance) {
                           return std::string(std::get<0>(instance.param).name) +
                                  (std::get<1>(instance.param) == config::SafeOutput::vent ? "Vents"
                                                                                           : "Shuts");
                         });

TEST(BoardFault, NoModelRefusesToRegulateAndNamesTheChamber) {
  Bench bench;
  Bench::Images images = Bench::images_of(100);
  images[5].clear();
  images[7].clear();
  bench.store_models(images);
  bench.board.start();
  bench.put(0, {1, 0});
  bench.streaming = true;
  bench.control(1);
  bench.run(2);
  EXPECT_EQ(bench.state(), State::disabled);
  bench.take();
  bench.control(7);
  bench.tick();
  EXPECT_EQ(bench.state(), State::fault_disabled);
  EXPECT_EQ(bench.image().error_code, 0x6300);
  EXPECT_EQ(bench.image().fault_chamber, 6);
  EXPECT_THAT(bench.analog_out.held_V, Each(5.0F));
  std::vector<unsigned> told;
  for (const auto& emergency : bench.take_emergencies()) {
    EXPECT_EQ(emergency.code, 0x6300);
    told.push_back(emergency.chamber);
  }
  EXPECT_THAT(told, ElementsAre(6, 8, 6)) << "each, and the most urgent behind the others";

  bench.session.upload_models(std::vector<host::client::ModelUpload>{{5, image_of(kValve)},  //
                                                                     {7, image_of(kValve)}});
  bench.run(3);
  EXPECT_EQ(bench.image().error_code, 0x6300) << "cleared without a reset";
  bench.session.reset_fault();
  bench.climb();
  EXPECT_EQ(bench.state(), State::active);
}

TEST(BoardFault, ExcitationModeIsNotLeftWhileActiveAndWithoutModelsStopsTheValvesInThatTick) {
  Bench bench;
  bench.board.start();
  bench.session.write(object::kControlMode, 0, std::int8_t{-1});
  bench.put(0, {1, 0});
  bench.climb();
  EXPECT_EQ(bench.state(), State::active);
  bench.run(20);
  EXPECT_THROW(bench.session.write(object::kControlMode, 0, std::int8_t{4}), host::client::SdoAbort);
  bench.control(0x3);
  bench.tick();
  EXPECT_EQ(bench.image().error_code, 0);
  bench.session.write(object::kControlMode, 0, std::int8_t{4});
  bench.tick();
  EXPECT_EQ(bench.image().error_code, 0x6300);
  EXPECT_THAT(bench.analog_out.held_V, Each(5.0F));
}

TEST(BoardFault, HoldingReactionShutsTheValvesInTheExcitationMode) {
  Bench bench;
  bench.board.start();
  bench.session.write(object::kControlMode, 0, std::int8_t{-1});
  bench.put(0, {1, 0});
  bench.climb();
  bench.run(20);
  force(bench, 16, 1.0F);
  bench.run(20);
  EXPECT_EQ(bench.image().error_code, 0x3412);
  EXPECT_THAT(bench.analog_out.held_V, Each(5.0F));
}

TEST(BoardFault, ExcitationNeedsNoSetPoints) {
  Bench bench;
  bench.board.start();
  bench.session.write(object::kControlMode, 0, std::int8_t{-1});
  bench.put(0, {1, 0});
  bench.climb();
  bench.streaming = false;
  for (int tick = 0; tick < 300; ++tick) {
    bench.put(0x80, {});  // SYNC alone
    bench.run(1);
  }
  EXPECT_EQ(bench.state(), State::active);
  EXPECT_EQ(bench.image().error_code, 0);
}

TEST(BoardFault, ExcitationEndsWithTheMastersSync) {
  Bench bench;
  bench.board.start();
  bench.session.write(object::kControlMode, 0, std::int8_t{-1});
  bench.put(0, {1, 0});
  bench.climb();
  bench.streaming = false;
  bench.run(20);
  EXPECT_EQ(bench.image().error_code, 0x8250);
  EXPECT_THAT(bench.analog_out.held_V, Each(5.0F)) << "V: the safe output of every chamber";
}

TEST(BoardFault, AConfigurationThatStandsInForARefusedOneIsToldOnTheBusAndNothingCanBeCommanded) {
  Settings settings = bench_settings();
  settings.configuration_refused = true;
  Bench bench(settings);
  bench.store_models();
  bench.board.start();
  bench.put(0, {1, 0});
  bench.tick();
  bench.tick();
  EXPECT_THAT(bench.take_emergencies(),
              testing::Contains(testing::Field(&host::client::Emergency::code, 0x6320)));
  bench.streaming = true;
  for (const auto mode : {canopen::ControlMode::excitation, canopen::ControlMode::pressure_open_loop,
                          canopen::ControlMode::pressure_closed_loop}) {
    bench.session.write(object::kControlMode, 0, static_cast<std::int8_t>(mode));
    for (const std::uint16_t word : Words{0x0, 0x1, 0x9, 0x1, 0x3, 0xB, 0x7, 0xF, 0x8, 0x0, 0x9, 0x3, 0x7}) {
      bench.control(word);
      for (int i = 0; i < 5; ++i) {
        bench.tick();
        EXPECT_EQ(bench.session.read<std::uint16_t>(object::kErrorCode, 0), 0x6320) << "word " << word;
        EXPECT_THAT(bench.state(), testing::AnyOf(State::fault_init, State::fault_disabled))
            << "word " << word;
        EXPECT_THAT(bench.analog_out.held_V, Each(5.0F))
            << "V: the safe output of every chamber, word " << word;
        EXPECT_FALSE(bench.digital.outputs.valve_power) << "word " << word;
      }
    }
  }
  bench.reset(canopen::NmtCommand::reset_node);
  EXPECT_EQ(bench.session.read<std::uint16_t>(object::kErrorCode, 0), 0x6320) << "after a reset of the node";
}

TEST(BoardFault, NothingThatATpdoSaidBeforeABusOffIsSaidAfterIt) {
  for (const std::uint8_t error_behaviour :
       {std::uint8_t{0}, std::uint8_t{1}}) {  // pre-operational, operational as before
    Bench bench;
    bench.go_active(300.0);
    bench.session.write(0x1029, 1, error_behaviour);
    bench.can.from_board.clear();
    bench.can.room = 0;  // nobody takes a frame: one stands before the driver, others behind it
    bench.run(3);
    bench.can.state_now = ports::CanState::bus_off;
    bench.run(1000);
    bench.can.room = SIZE_MAX;
    bench.can.state_now = ports::CanState::error_active;
    bench.streaming = false;
    bench.tick();
    int states = 0;
    for (const ports::CanFrame& frame : bench.can.from_board) {
      EXPECT_FALSE(frame.id == 0x185 || frame.id == 0x285) << "an actual value, without a SYNC";
      if (frame.id != 0x385) continue;
      ++states;
      EXPECT_EQ(frame.data[0], bench.image().status_word & 0xFFU);
    }
    EXPECT_EQ(states, error_behaviour == 0 ? 0 : 1) << "the state as it is now";
  }
}

TEST(BoardFault, LostFramesAreReportedOnceAndStopNothing) {
  Bench bench;
  bench.go_active(300.0);
  bench.can.lost_frames += 3;
  bench.tick();
  EXPECT_EQ(bench.image().error_code, 0x8110);
  EXPECT_EQ(bench.image().error_register, 0x11);
  EXPECT_EQ(bench.state(), State::active);
  bench.can.lost_frames += 1;
  bench.run(2 * safety::FaultRegister::kFlicker_ticks);
  EXPECT_EQ(bench.image().error_code, 0) << "the count stands still: nothing more was lost";
  const auto emergencies = bench.take_emergencies();
  ASSERT_EQ(emergencies.size(), 2U);
  EXPECT_EQ(emergencies[0].code, 0x8110);
  EXPECT_EQ(emergencies[1].code, 0);
}

TEST(BoardFault, ChamberThatMustVentVentsWhateverTheDrive) {
  const Settings settings = bench_settings();
  ChamberLoop loop;
  loop.configure(settings.chamber[0], settings.regulator);
  config::ModelParameters parameters;
  ASSERT_TRUE(config::decode(image_of(kValve), parameters));
  loop.take_over(parameters);
  canopen::ChamberImage image;
  for (const auto drive :
       {safety::Drive::vent, safety::Drive::safe, safety::Drive::hold, safety::Drive::active}) {
    loop.measure({.pressure = {3.0F, true}, .position = {4.0F, true}}, true, true);
    EXPECT_EQ(loop.command({.drive = drive, .must_vent = true}, image), 2.5F);
  }
}

TEST(BoardFault, AValveWhoseOutputRefusesHasNoPowerInThatVeryTick) {
  Bench bench;
  bench.analog_out.refuses = true;
  bench.tick();
  EXPECT_FALSE(bench.digital.outputs.valve_power) << "the first tick";
  bench.run(5);
  EXPECT_FALSE(bench.digital.outputs.valve_power);

  Bench later;
  later.go_active(300.0);
  later.run(20);
  ASSERT_TRUE(later.digital.outputs.valve_power);
  later.analog_out.refuses = true;
  later.tick();
  EXPECT_FALSE(later.digital.outputs.valve_power);
}

TEST(BoardFault, EmergencyStopTakesThePowerOffTheValvesWithinItsTick) {
  Bench bench;
  bench.go_active(300.0);
  bench.digital.inputs.emergency_stop = true;
  bench.tick();
  EXPECT_FALSE(bench.digital.outputs.valve_power);
}

TEST(BoardFault, PowerThatAnEmergencyStopHasTakenComesBackByAResetNotByItself) {
  Bench bench;
  bench.go_active(300.0);
  bench.digital.inputs.emergency_stop = true;
  bench.tick();
  bench.digital.inputs.emergency_stop = false;
  for (int tick = 0; tick < 100; ++tick) {
    bench.tick();
    ASSERT_FALSE(bench.digital.outputs.valve_power) << "tick " << tick << " after the circuit closed";
  }
  for (const std::uint16_t word : Words{0x1, 0x9}) {
    bench.control(word);
    bench.tick();
  }
  EXPECT_EQ(bench.image().error_code, 0);
  EXPECT_TRUE(bench.digital.outputs.valve_power);
}

TEST(BoardFault, AFlagInWhichBitsHaveFlippedIsItsOwnFaultAndNoOther) {
  struct Told {
    canopen::Flag canopen::ProcessImage::*flag;
    Fault fault;
  };
  for (const auto& [flag, fault] : {Told{&canopen::ProcessImage::heartbeat_lost, Fault::heartbeat_lost},
                                    Told{&canopen::ProcessImage::pdo_short, Fault::pdo_short},
                                    Told{&canopen::ProcessImage::pdo_long, Fault::pdo_long},
                                    Told{&canopen::ProcessImage::sync_misfits, Fault::sync_refused}}) {
    for (unsigned byte = 1; byte < 256; ++byte) {
      Bench bench;
      bench.tick();
      auto& image = const_cast<canopen::ProcessImage&>(bench.image());
      image.*flag = std::bit_cast<canopen::Flag>(static_cast<std::uint8_t>(byte));
      bench.tick();
      ASSERT_EQ(bench.image().error_code, safety::spec(fault).code)
          << safety::spec(fault).name << ", " << byte;
    }
  }
}

}  // namespace
}  // namespace plenum
