#include "firmware/safety/supervisor.hpp"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <queue>
#include <set>
#include <sstream>
#include <string>
#include <tuple>

namespace plenum::safety {
namespace {

constexpr std::uint16_t kD = 0x1, kDH = 0x3, kDHM = 0x7, kR = 0x8;

Supervisor::Input asking(std::uint16_t control_word, Reaction reaction = Reaction::none) {
  return {.control_word = control_word, .ready = true, .model_ready = true, .reaction = reaction};
}

Supervisor brought_to_active() {
  Supervisor supervisor;
  for (int tick = 0; tick < 4; ++tick) supervisor.step(asking(kDHM));
  EXPECT_EQ(supervisor.state(), State::active);
  return supervisor;
}

// The table of the README, letter by letter: state and drive (v vent, s safe, h hold, a active).
// Columns: not_ready, init, disabled, hold, active.
constexpr const char* kExpected = R"(
NOT_READY      none NOT_READY:v INIT:s INIT:s INIT:s INIT:s
NOT_READY      hold NOT_READY:v FAULT_INIT:s FAULT_INIT:s FAULT_INIT:s FAULT_INIT:s
NOT_READY      safe NOT_READY:v FAULT_INIT:s FAULT_INIT:s FAULT_INIT:s FAULT_INIT:s
INIT           none NOT_READY:v INIT:s DISABLED:s DISABLED:s DISABLED:s
INIT           hold NOT_READY:v FAULT_INIT:s FAULT_DISABLED:s FAULT_DISABLED:s FAULT_DISABLED:s
INIT           safe NOT_READY:v FAULT_INIT:s FAULT_DISABLED:s FAULT_DISABLED:s FAULT_DISABLED:s
DISABLED       none NOT_READY:v INIT:s DISABLED:s HOLD:h HOLD:h
DISABLED       hold NOT_READY:v FAULT_INIT:s FAULT_DISABLED:s FAULT_DISABLED:s FAULT_DISABLED:s
DISABLED       safe NOT_READY:v FAULT_INIT:s FAULT_DISABLED:s FAULT_DISABLED:s FAULT_DISABLED:s
HOLD           none NOT_READY:v INIT:s DISABLED:s HOLD:h ACTIVE:a
HOLD           hold NOT_READY:v FAULT_REACTION:s FAULT_REACTION:s FAULT_REACTION:h FAULT_REACTION:h
HOLD           safe NOT_READY:v FAULT_REACTION:s FAULT_REACTION:s FAULT_REACTION:s FAULT_REACTION:s
ACTIVE         none NOT_READY:v INIT:s DISABLED:s HOLD:h ACTIVE:a
ACTIVE         hold NOT_READY:v FAULT_REACTION:s FAULT_REACTION:s FAULT_REACTION:h FAULT_REACTION:h
ACTIVE         safe NOT_READY:v FAULT_REACTION:s FAULT_REACTION:s FAULT_REACTION:s FAULT_REACTION:s
FAULT_REACTION none NOT_READY:v FAULT_INIT:s FAULT_DISABLED:s FAULT_DISABLED:s FAULT_DISABLED:s
FAULT_REACTION hold NOT_READY:v FAULT_INIT:s FAULT_DISABLED:s FAULT_HOLD:h FAULT_HOLD:h
FAULT_REACTION safe NOT_READY:v FAULT_INIT:s FAULT_DISABLED:s FAULT_DISABLED:s FAULT_DISABLED:s
FAULT_HOLD     none NOT_READY:v INIT:s DISABLED:s HOLD:h HOLD:h
FAULT_HOLD     hold NOT_READY:v FAULT_INIT:s FAULT_DISABLED:s FAULT_HOLD:h FAULT_HOLD:h
FAULT_HOLD     safe NOT_READY:v FAULT_INIT:s FAULT_DISABLED:s FAULT_DISABLED:s FAULT_DISABLED:s
FAULT_DISABLED none NOT_READY:v INIT:s DISABLED:s FAULT_DISABLED:s FAULT_DISABLED:s
FAULT_DISABLED hold NOT_READY:v FAULT_INIT:s FAULT_DISABLED:s FAULT_DISABLED:s FAULT_DISABLED:s
FAULT_DISABLED safe NOT_READY:v FAULT_INIT:s FAULT_DISABLED:s FAULT_DISABLED:s FAULT_DISABLED:s
FAULT_INIT     none NOT_READY:v INIT:s DISABLED:s FAULT_DISABLED:s FAULT_DISABLED:s
FAULT_INIT     hold NOT_READY:v FAULT_INIT:s FAULT_DISABLED:s FAULT_DISABLED:s FAULT_DISABLED:s
FAULT_INIT     safe NOT_READY:v FAULT_INIT:s FAULT_DISABLED:s FAULT_DISABLED:s FAULT_DISABLED:s
)";

TEST(SupervisorTable, IsWalkedRowByRow) {
  std::istringstream lines(kExpected);
  const Reaction reactions[] = {Reaction::none, Reaction::hold, Reaction::safe};
  int cells = 0;
  for (std::size_t s = 0; s < kStates; ++s) {
    for (const Reaction reaction : reactions) {
      const State from = static_cast<State>(s);
      std::string name, reaction_name;
      lines >> name >> reaction_name;
      ASSERT_EQ(name, describe(from));
      for (std::size_t d = 0; d < kDemands; ++d) {
        std::string cell;
        lines >> cell;
        const Transition& row = transition(from, reaction, static_cast<Demand>(d));
        EXPECT_EQ(std::string(describe(row.to)) + ":" + "vsha"[static_cast<std::size_t>(row.drive)], cell)
            << name << ", standing " << reaction_name << ", demand " << d;
        ++cells;
      }
    }
  }
  EXPECT_EQ(cells, 135);
}

TEST(SupervisorTable, TreatsVentAsSafe) {
  for (std::size_t s = 0; s < kStates; ++s) {
    for (std::size_t d = 0; d < kDemands; ++d) {
      EXPECT_EQ(&transition(static_cast<State>(s), Reaction::vent, static_cast<Demand>(d)),
                &transition(static_cast<State>(s), Reaction::safe, static_cast<Demand>(d)));
    }
  }
}

// 6041h, bits R M H D, from the bus contract.
TEST(Supervisor, ShowsTheStatusWordOfCia408) {
  EXPECT_EQ(status_word(State::not_ready), 0x0);
  EXPECT_EQ(status_word(State::init), 0x8);
  EXPECT_EQ(status_word(State::disabled), 0x9);
  EXPECT_EQ(status_word(State::hold), 0xB);
  EXPECT_EQ(status_word(State::active), 0xF);
  EXPECT_EQ(status_word(State::fault_reaction), 0x7);
  EXPECT_EQ(status_word(State::fault_hold), 0x3);
  EXPECT_EQ(status_word(State::fault_disabled), 0x1);
  EXPECT_EQ(status_word(State::fault_init), 0x0);
}

TEST(Supervisor, ClimbsOneStateATick) {
  Supervisor supervisor;
  EXPECT_EQ(supervisor.step({.control_word = kDHM}).state, State::not_ready);
  EXPECT_EQ(supervisor.step(asking(kDHM)).state, State::init);
  EXPECT_EQ(supervisor.step(asking(kDHM)).state, State::disabled);
  EXPECT_EQ(supervisor.step(asking(kDHM)).state, State::hold);
  EXPECT_EQ(supervisor.step(asking(kDHM)).state, State::active);
  EXPECT_EQ(supervisor.step(asking(0)).state, State::init);
}

TEST(Supervisor, TakesNoResetWhileMotionIsAsked) {
  Supervisor supervisor = brought_to_active();
  supervisor.step(asking(kDHM, Reaction::safe));
  supervisor.step(asking(kDHM, Reaction::safe));
  ASSERT_EQ(supervisor.state(), State::fault_disabled);
  EXPECT_FALSE(supervisor.accepts_reset(kDHM | kR));
  EXPECT_FALSE(supervisor.accepts_reset(kDH | kR));
  EXPECT_TRUE(supervisor.accepts_reset(kD | kR));
  EXPECT_TRUE(supervisor.accepts_reset(kR));
  EXPECT_TRUE(supervisor.accepts_reset(kD)) << "R has risen and fallen since the tick before";
}

TEST(Supervisor, ReturnsFromFaultHoldToHoldAndNotToActive) {
  Supervisor supervisor = brought_to_active();
  EXPECT_EQ(supervisor.step(asking(kDHM, Reaction::hold)).drive, Drive::hold);
  EXPECT_EQ(supervisor.step(asking(kDHM, Reaction::hold)).state, State::fault_hold);
  EXPECT_FALSE(supervisor.accepts_reset(kDHM | kR));
  ASSERT_TRUE(supervisor.accepts_reset(kDH | kR));
  EXPECT_EQ(supervisor.step(asking(kDH | kR)).state, State::hold);
}

TEST(Supervisor, WithAFlippedBitInItsStateMovesNothingAndAcceptsNoReset) {
  Supervisor holding;
  for (int tick = 0; tick < 3; ++tick) holding.step(asking(kDH));
  Supervisor faulty = brought_to_active();
  for (int tick = 0; tick < 2; ++tick) faulty.step(asking(kDHM, Reaction::safe));
  constexpr std::size_t kStateBytes = sizeof(config::Twice<State>);  // its first member
  for (const Supervisor& whole : {brought_to_active(), holding, faulty}) {
    for (std::size_t bit = 0; bit < 8 * kStateBytes; ++bit) {
      auto bytes = std::bit_cast<std::array<unsigned char, sizeof(Supervisor)>>(whole);
      bytes[bit / 8] = static_cast<unsigned char>(bytes[bit / 8] ^ 1U << bit % 8);
      auto flipped = std::bit_cast<Supervisor>(bytes);
      EXPECT_FALSE(flipped.intact()) << describe(whole.state()) << ", bit " << bit;
      EXPECT_FALSE(flipped.accepts_reset(kD | kR)) << describe(whole.state()) << ", bit " << bit;
      Supervisor beside = flipped;
      const Supervisor::Output out = flipped.step(asking(kDHM));
      EXPECT_EQ(out.state, State::init) << describe(whole.state()) << ", bit " << bit;
      EXPECT_EQ(out.drive, Drive::safe) << describe(whole.state()) << ", bit " << bit;
      EXPECT_EQ(beside.step(asking(kDHM, Reaction::safe)).state, State::fault_init);
      EXPECT_TRUE(flipped.intact());
    }
  }
}

// Explicit-state exploration of supervisor and fault register together: from power-on, every input in every
// reachable state. Four faults stand for the classes: {hold, safe} on the board, {vent, no reaction}.
struct World {
  Supervisor supervisor;
  FaultRegister faults;
};

using Key = std::tuple<State, FaultSet, FaultSet>;
Key key_of(const World& world) {
  return {world.supervisor.state(), world.faults.standing_on_board(), world.faults.standing(2)};
}

const FaultSet kBoardCauses[] = {0, only(Fault::supply_low), only(Fault::emergency_stop),
                                 only(Fault::supply_low) | only(Fault::emergency_stop),
                                 only(Fault::can_passive)};
const FaultSet kChamberCauses[] = {0, only(Fault::over_pressure)};

bool in_fault_state(State state) {
  return state >= State::fault_reaction;
}

TEST(Supervisor, KeepsItsInvariantsInEveryReachableStateUnderEveryInput) {
  std::set<Key> seen;
  std::set<State> states;
  std::queue<World> open;
  open.push({});
  seen.insert(key_of(open.front()));
  int steps = 0;
  while (!open.empty()) {
    const World before = open.front();
    open.pop();
    states.insert(before.supervisor.state());
    for (std::uint16_t word = 0; word < 16; ++word) {
      for (const FaultSet board : kBoardCauses) {
        for (const FaultSet chamber : kChamberCauses) {
          for (const bool ready : {false, true}) {
            for (const bool model_ready : {false, true}) {
              for (const bool risen : {false, true}) {
                World world = before;
                const bool reset = risen && world.supervisor.accepts_reset(word);
                ChamberFaults chambers{};
                chambers[2] = chamber;
                const FaultReport report = world.faults.step(chambers, board, reset);
                const Supervisor::Output out = world.supervisor.step({.control_word = word,
                                                                      .ready = ready,
                                                                      .model_ready = model_ready,
                                                                      .reaction = report.reaction});
                ++steps;

                const State was = before.supervisor.state();
                std::ostringstream at;
                at << describe(was) << " -> " << describe(out.state) << ", control word " << word
                   << ", board causes " << board << ", chamber causes " << chamber << ", ready " << ready
                   << ", model " << model_ready << ", R has risen " << risen;
                SCOPED_TRACE(at.str());

                if (out.drive == Drive::active) {
                  EXPECT_EQ(report.reaction, Reaction::none);
                  EXPECT_TRUE(ready && model_ready);
                  EXPECT_EQ(word & kDHM, kDHM);
                  EXPECT_FALSE(in_fault_state(was)) << "a fault state never leads straight to ACTIVE";
                  EXPECT_FALSE(reset);
                }
                if (out.drive == Drive::hold) {
                  EXPECT_LE(report.reaction, Reaction::hold);
                  EXPECT_TRUE(ready && model_ready);
                  EXPECT_EQ(word & kDH, kDH);
                }
                if (report.reaction >= Reaction::safe) {
                  EXPECT_LE(out.drive, Drive::safe);
                }
                // what the valves get of it: no fault with an output of its own leaves another one reachable
                const bool vents = holds(world.faults.standing(2), Fault::over_pressure);
                EXPECT_EQ(world.faults.must_vent(2), vents);
                if (out.drive <= Drive::safe) {
                  for (const config::SafeOutput safe : {config::SafeOutput::null, config::SafeOutput::vent}) {
                    config::ChamberSettings settings;
                    settings.safe_output = safe;
                    const bool vented = vents || out.drive == Drive::vent || safe == config::SafeOutput::vent;
                    EXPECT_EQ(resting_command_V(settings, out.drive, world.faults.must_vent(2)),
                              vented ? settings.vent_V : settings.null_V);
                  }
                }
                if (report.reaction != Reaction::none && ready) {
                  EXPECT_TRUE(in_fault_state(out.state));
                }
                if (report.reaction == Reaction::none && !in_fault_state(was)) {
                  EXPECT_FALSE(in_fault_state(out.state));
                }
                if (in_fault_state(was) && !in_fault_state(out.state) && ready) {
                  EXPECT_TRUE(reset) << "a fault state is left by a reset only";
                }
                // an edge of R, between two ticks or within one, from rest
                const bool asks_rest = (word & kDH) != kDH;
                const bool asks_hold = (word & kDHM) == kDH;
                EXPECT_EQ(reset, risen && (((was == State::fault_disabled || was == State::fault_init) &&
                                            asks_rest) ||
                                           (was == State::fault_hold && (asks_rest || asks_hold))));
                if (was == State::fault_reaction) {
                  EXPECT_NE(out.state, State::fault_reaction) << "lasts one tick";
                }
                if (!ready) {
                  EXPECT_EQ(out.drive, Drive::vent);
                }
                EXPECT_EQ((out.status_word & kR) != 0,
                          !in_fault_state(out.state) && out.state != State::not_ready);
                if (HasFailure()) return;  // one counterexample says enough
                if (seen.insert(key_of(world)).second) open.push(world);
              }
            }
          }
        }
      }
    }
  }
  EXPECT_EQ(states.size(), kStates) << "every state is reachable";
  EXPECT_GT(steps, 10000);
}

// Every single fault, from ACTIVE, through both register and table: what the outputs do in the tick of its
// appearance.
TEST(Supervisor, LeavesActiveInTheTickOfAnyFaultWithAReaction) {
  for (const FaultSpec& row : fault_table()) {
    SCOPED_TRACE(row.name);
    Supervisor supervisor = brought_to_active();
    FaultRegister faults;
    ChamberFaults chambers{};
    if (row.scope == Scope::chamber) chambers[7] = only(row.fault);
    const FaultReport report = faults.step(chambers, row.scope == Scope::board ? only(row.fault) : 0, false);
    const Drive drive = supervisor.step(asking(kDHM, report.reaction)).drive;
    switch (row.reaction) {
      case Reaction::none:
        EXPECT_EQ(drive, Drive::active);
        break;
      case Reaction::hold:
        EXPECT_EQ(drive, Drive::hold);
        break;
      case Reaction::safe:
      case Reaction::vent:
        EXPECT_EQ(drive, Drive::safe);
        break;
    }
    EXPECT_EQ(faults.must_vent(7), row.reaction == Reaction::vent);
  }
}

TEST(RestingCommand, IsTheSafeOutputUnlessTheChamberMustVent) {
  config::ChamberSettings settings;
  settings.null_V = 5.1F;
  settings.vent_V = 2.0F;
  EXPECT_EQ(resting_command_V(settings, Drive::safe, false), 5.1F);
  EXPECT_EQ(resting_command_V(settings, Drive::safe, true), 2.0F);
  EXPECT_EQ(resting_command_V(settings, Drive::vent, false), 2.0F);
  settings.safe_output = config::SafeOutput::vent;
  EXPECT_EQ(resting_command_V(settings, Drive::safe, false), 2.0F);
  settings.in_use = false;
  EXPECT_EQ(resting_command_V(settings, Drive::vent, false), 5.1F);
  EXPECT_EQ(resting_command_V(settings, Drive::safe, true), 2.0F) << "whatever else is said of it";
}

}  // namespace
}  // namespace plenum::safety
