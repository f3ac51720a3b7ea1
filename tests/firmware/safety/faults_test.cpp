#include "firmware/safety/faults.hpp"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <map>
#include <set>
#include <string>

namespace plenum::safety {
namespace {

ChamberFaults at_chamber(std::size_t chamber, FaultSet causes) {
  ChamberFaults faults{};
  faults[chamber] = causes;
  return faults;
}

FaultReport raise(FaultRegister& faults, Fault fault, std::size_t chamber = 0) {
  const bool on_board = spec(fault).scope == Scope::board;
  return faults.step(on_board ? ChamberFaults{} : at_chamber(chamber, only(fault)),
                     on_board ? only(fault) : 0, false);
}

// The codes that the bus contract fixes, written a second time.
TEST(FaultTable, HasTheEmergencyCodesOfTheBusContract) {
  const std::map<Fault, std::uint16_t> fixed = {{Fault::can_overrun, 0x8110},
                                                {Fault::can_passive, 0x8120},
                                                {Fault::pdo_short, 0x8210},
                                                {Fault::sync_refused, 0x8240},
                                                {Fault::pdo_long, 0x8220},
                                                {Fault::heartbeat_lost, 0x8130},
                                                {Fault::bus_off, 0x8140},
                                                {Fault::setpoint_timeout, 0x8250},
                                                {Fault::over_pressure, 0x8302},
                                                {Fault::supply_low, 0x3412},
                                                {Fault::no_model, 0x6300},
                                                {Fault::hardware, 0x5000},
                                                {Fault::stored_set_lost, 0x6300},
                                                {Fault::store_failing, 0x6300},
                                                {Fault::configuration_refused, 0x6320}};
  for (const auto& [fault, code] : fixed) EXPECT_EQ(spec(fault).code, code) << spec(fault).name;
}

TEST(FaultTable, GivesEachFaultItsOwnCodeNameAndSomethingToBlame) {
  std::set<std::uint16_t> codes;
  std::set<std::string> names;
  for (const FaultSpec& row : fault_table()) {
    // 6300h is the data set: a chamber's own, or, with chamber 0, the board's stored one
    const bool stored_set = row.fault == Fault::stored_set_lost || row.fault == Fault::store_failing;
    EXPECT_TRUE(codes.insert(row.code).second || (stored_set && row.scope == Scope::board)) << row.name;
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_FALSE(std::string(row.blame).empty()) << row.name;
    EXPECT_NE(row.error_register & error_bit::kGeneric, 0) << row.name << ": CiA 301 sets bit 0 on any error";
    EXPECT_EQ(&spec(row.fault), &row);
  }
  EXPECT_EQ(codes.count(0), 0U) << "0000h means no error";
}

// Otherwise a fault could end regulation and then be gone without anybody having reset it.
TEST(FaultTable, LetsOnlyFaultsWithoutReactionClearThemselves) {
  for (const FaultSpec& row : fault_table()) {
    EXPECT_EQ(row.clears == Clears::by_itself, row.reaction == Reaction::none) << row.name;
  }
}

TEST(FaultRegister, ReportsNothingWhenNothingStands) {
  FaultRegister faults;
  const FaultReport report = faults.step({}, 0, false);
  EXPECT_FALSE(report.any);
  EXPECT_EQ(report.code, 0);
  EXPECT_EQ(report.error_register, 0);
  EXPECT_EQ(report.chamber, 0);
  EXPECT_EQ(report.reaction, Reaction::none);
}

TEST(FaultRegister, WalksEveryRowOfTheTable) {
  for (const FaultSpec& row : fault_table()) {
    SCOPED_TRACE(row.name);
    FaultRegister faults;
    const FaultReport raised = raise(faults, row.fault, 5);
    EXPECT_TRUE(raised.any);
    EXPECT_EQ(raised.fault, row.fault);
    EXPECT_EQ(raised.code, row.code);
    EXPECT_EQ(raised.error_register, row.error_register);
    EXPECT_EQ(raised.reaction, row.reaction);
    EXPECT_EQ(raised.chamber, row.scope == Scope::board ? 0 : 6);

    FaultReport cause_gone;
    for (int t = 1; t <= 2 * FaultRegister::kFlicker_ticks; ++t) {
      cause_gone = faults.step({}, 0, false);
      EXPECT_TRUE(cause_gone.any || t > FaultRegister::kFlicker_ticks) << "tick " << t;
    }
    EXPECT_EQ(cause_gone.any, row.clears == Clears::by_reset);

    const FaultReport reset_too_early = [&] {
      raise(faults, row.fault, 5);
      const bool on_board = row.scope == Scope::board;
      return faults.step(on_board ? ChamberFaults{} : at_chamber(5, only(row.fault)),
                         on_board ? only(row.fault) : 0, true);
    }();
    EXPECT_TRUE(reset_too_early.any);
    EXPECT_FALSE(faults.step({}, 0, true).any);
  }
}

// Otherwise each return of it would be an emergency message, and wash what happened before out of 1003h.
TEST(FaultRegister, TakesAWarningThatFlickersForOne) {
  FaultRegister faults;
  for (int t = 0; t < 1000; ++t) {
    const bool is_there = t % 90 == 0;
    const FaultSet causes = is_there ? only(Fault::control_deviation) : FaultSet{0};
    EXPECT_TRUE(faults.step(at_chamber(3, causes), 0, false).any) << "tick " << t;
    EXPECT_EQ(faults.standing(3), only(Fault::control_deviation));
    EXPECT_EQ(faults.standing(2), 0U);
  }
}

TEST(FaultRegister, ReportsTheMostUrgentFaultAndTheBitsOfAll) {
  FaultRegister faults;
  faults.step({}, only(Fault::setpoint_timeout), false);
  FaultReport report = faults.step(at_chamber(3, only(Fault::over_pressure)), 0, false);
  EXPECT_EQ(report.code, 0x8302);
  EXPECT_EQ(report.chamber, 4);
  EXPECT_EQ(report.error_register,
            spec(Fault::over_pressure).error_register | spec(Fault::setpoint_timeout).error_register);
  EXPECT_EQ(report.reaction, Reaction::vent);
}

TEST(FaultRegister, TakesTheSeverestReactionNotTheMostUrgentOne) {
  FaultRegister faults;
  const FaultReport report =
      faults.step(at_chamber(0, only(Fault::over_pressure)), only(Fault::emergency_stop), false);
  EXPECT_EQ(report.fault, Fault::emergency_stop);
  EXPECT_EQ(report.reaction, Reaction::vent);
}

TEST(FaultRegister, NamesTheFirstOfSeveralChambersWithTheSameFault) {
  FaultRegister faults;
  faults.step(at_chamber(6, only(Fault::pressure_stale)), 0, false);
  EXPECT_EQ(faults.step(at_chamber(2, only(Fault::pressure_stale)), 0, false).chamber, 3);
}

TEST(FaultRegister, ForgetsNoFaultWhenABitFlipsInIt) {
  FaultRegister whole;
  ChamberFaults causes{};
  for (FaultSet& of_chamber : causes) of_chamber = only(Fault::pressure_stale);
  whole.step(causes, only(Fault::emergency_stop), false);
  for (std::size_t bit = 0; bit < 8 * sizeof(FaultRegister); ++bit) {
    auto bytes = std::bit_cast<std::array<unsigned char, sizeof(FaultRegister)>>(whole);
    bytes[bit / 8] = static_cast<unsigned char>(bytes[bit / 8] ^ 1U << bit % 8);
    auto flipped = std::bit_cast<FaultRegister>(bytes);
    flipped.step({}, 0, false);
    EXPECT_TRUE(holds(flipped.standing_on_board(), Fault::emergency_stop)) << "bit " << bit;
    for (std::size_t c = 0; c < config::kChambers; ++c)
      EXPECT_TRUE(holds(flipped.standing(c), Fault::pressure_stale)) << "bit " << bit;
  }
}

TEST(FaultRegister, VentsOnlyTheChamberThatIsOverPressure) {
  FaultRegister faults;
  raise(faults, Fault::over_pressure, 4);
  raise(faults, Fault::pressure_stale, 1);
  for (std::size_t c = 0; c < config::kChambers; ++c)
    EXPECT_EQ(faults.must_vent(c), c == 4) << "chamber " << c;
  faults.step({}, 0, true);
  EXPECT_FALSE(faults.must_vent(4));
}

TEST(FaultRegister, TakesABitThatIsNoFaultsForAnUpsetOfTheMemory) {
  for (unsigned bit = kFaults; bit < 32; ++bit) {
    for (const bool on_board : {true, false}) {
      FaultRegister faults;
      const FaultSet causes = FaultSet{1} << bit;
      const FaultReport report =
          faults.step(on_board ? ChamberFaults{} : at_chamber(3, causes), on_board ? causes : 0, false);
      EXPECT_EQ(report.fault, Fault::memory_upset) << bit;
      EXPECT_EQ(report.code, spec(Fault::memory_upset).code) << bit;
      EXPECT_EQ(report.reaction, spec(Fault::memory_upset).reaction) << bit;
      EXPECT_EQ(report.error_register, spec(Fault::memory_upset).error_register) << bit;
      EXPECT_EQ(report.chamber, 0) << bit;
    }
  }
}

}  // namespace
}  // namespace plenum::safety
