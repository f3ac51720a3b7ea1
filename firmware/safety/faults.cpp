#include "firmware/safety/faults.hpp"

#include <bit>

namespace plenum::safety {
namespace {

constexpr std::uint8_t kComm = error_bit::kGeneric | error_bit::kCommunication;
constexpr std::uint8_t kOwn = error_bit::kGeneric | error_bit::kManufacturer;
constexpr std::uint8_t kProfile = error_bit::kGeneric | error_bit::kProfile;
constexpr std::uint8_t kVoltage = error_bit::kGeneric | error_bit::kVoltage;

// Codes FFxx are the board's own; the others are of CiA 301 and the fluid power profile.
// clang-format off
constexpr std::array<FaultSpec, kFaults> kFaultSpecs = {{
    {Fault::emergency_stop, "emergency stop", 0x9000, error_bit::kGeneric, Reaction::safe, Scope::board, Clears::by_reset,
     "emergency stop circuit is open: button, door, its cable"},
    {Fault::hardware, "hardware", 0x5000, error_bit::kGeneric, Reaction::safe, Scope::board, Clears::by_reset,
     "an output or converter refused a write: valve supply, device of the board's configuration"},
    {Fault::over_pressure, "over-pressure", 0x8302, kProfile, Reaction::vent, Scope::chamber, Clears::by_reset,
     "over_pressure_kPa, supply regulator, pressure sensor calibration"},
    {Fault::memory_upset, "memory upset", 0xFF09, kOwn, Reaction::safe, Scope::board, Clears::by_reset,
     "start the board again, or write the settings and upload the models anew; if it comes back, the board's memory"},
    {Fault::configuration_refused, "configuration refused", 0x6320, kProfile, Reaction::safe, Scope::board, Clears::by_reset,
     "board.toml: plenumd's journal says what is wrong in it; mend it and start plenumd again"},
    {Fault::tick_overrun, "tick overrun", 0xFF01, kOwn, Reaction::safe, Scope::board, Clears::by_reset,
     "overrun_limit_ticks, load of the processor, priority of the loop"},
    {Fault::pressure_not_finite, "pressure not finite", 0xFF04, kOwn, Reaction::safe, Scope::chamber, Clears::by_reset,
     "pressure converter's driver, pressure_gain_kPa_per_V"},
    {Fault::pressure_out_of_range, "pressure sensor out of range", 0xFF05, kOwn, Reaction::safe, Scope::chamber, Clears::by_reset,
     "pressure sensor's cable (wire break, short), pressure_valid_low_V, pressure_valid_high_V, end of the converter's range"},
    {Fault::pressure_stale, "pressure stale", 0xFF03, kOwn, Reaction::safe, Scope::chamber, Clears::by_reset,
     "converter stopped, stale_limit_ticks"},
    {Fault::pressure_stuck, "pressure sensor stuck", 0xFF0A, kOwn, Reaction::safe, Scope::chamber, Clears::by_reset,
     "pressure sensor and its converter, stuck_ticks: the reading does not change while the valve moves"},
    {Fault::position_not_finite, "position not finite", 0xFF07, kOwn, Reaction::safe, Scope::chamber, Clears::by_reset,
     "position converter's driver, volume_gain_mL_per_V"},
    {Fault::position_out_of_range, "position sensor out of range", 0xFF08, kOwn, Reaction::safe, Scope::chamber, Clears::by_reset,
     "position sensor's cable (wire break, short), position_valid_low_V, position_valid_high_V"},
    {Fault::position_stale, "position stale", 0xFF06, kOwn, Reaction::safe, Scope::chamber, Clears::by_reset,
     "converter stopped, stale_limit_ticks"},
    {Fault::no_model, "no valid model", 0x6300, kProfile, Reaction::safe, Scope::chamber, Clears::by_reset,
     "upload and commit a model, or select the excitation mode (6043h)"},
    {Fault::stored_set_lost, "stored set damaged", 0x6300, kProfile, Reaction::safe, Scope::board, Clears::by_reset,
     "compare models and settings with what was stored last (2130h), store again"},
    {Fault::bus_off, "bus-off", 0x8140, kComm, Reaction::safe, Scope::board, Clears::by_reset,
     "CAN cable, termination, bit rate"},
    {Fault::heartbeat_lost, "heartbeat lost", 0x8130, kComm, Reaction::safe, Scope::board, Clears::by_reset,
     "master, heartbeat consumer time (1016h)"},
    {Fault::setpoint_timeout, "set-point timeout", 0x8250, kComm, Reaction::safe, Scope::board, Clears::by_reset,
     "master's set-point PDOs, setpoint_watchdog_ticks, RPDO event timer (1400h:5)"},
    {Fault::supply_low, "supply low", 0x3412, kVoltage, Reaction::hold, Scope::board, Clears::by_reset,
     "compressor, supply valve, supply_low_kPa"},
    {Fault::model_residual, "model residual", 0xFF02, kOwn, Reaction::hold, Scope::chamber, Clears::by_reset,
     "model of another chamber or valve, residual_alarm_kPa, leak, supply pressure of the model"},
    {Fault::store_failing, "stored set cannot be written", 0x6300, kProfile, Reaction::none, Scope::board, Clears::by_itself,
     "medium of the parameter store: full, read-only, worn out"},
    {Fault::can_overrun, "CAN overrun", 0x8110, kComm, Reaction::none, Scope::board, Clears::by_itself,
     "bus load, queue length"},
    {Fault::can_passive, "CAN error passive", 0x8120, kComm, Reaction::none, Scope::board, Clears::by_itself,
     "CAN cable, termination, bit rate"},
    {Fault::model_drift, "model drift", 0xFF0B, kOwn, Reaction::none, Scope::chamber, Clears::by_itself,
     "log of the chamber (2301h), diagnosed: what has changed of valve, supply, hose or sensor; drift_alarm_ratio"},
    {Fault::control_deviation, "control deviation", 0xFF0C, kOwn, Reaction::none, Scope::chamber, Clears::by_itself,
     "a set point that the valve cannot follow, supply, leak, valve; deviation_low_kPa, deviation_high_kPa, deviation_delay_ms"},
    {Fault::pdo_short, "PDO too short", 0x8210, kComm, Reaction::none, Scope::board, Clears::by_itself,
     "mapping of the RPDO (1600h..) here and in the master: a PDO shorter than it changes nothing"},
    {Fault::sync_refused, "SYNC that 1019h does not allow", 0x8240, kComm, Reaction::none, Scope::board, Clears::by_itself,
     "1019h here and in the master: with it a SYNC counts, and one that does not changes nothing"},
    {Fault::pdo_long, "PDO longer than mapped", 0x8220, kComm, Reaction::none, Scope::board, Clears::by_itself,
     "mapping of the RPDO (1600h..) here and in the master: of a PDO longer than it the beginning counts"},
}};
// clang-format on

constexpr bool in_order() {
  for (std::size_t i = 0; i < kFaults; ++i) {
    if (static_cast<std::size_t>(kFaultSpecs[i].fault) != i) return false;
  }
  return true;
}
static_assert(in_order(), "spec() looks a fault up by its number");

template <typename Predicate>
constexpr FaultSet all_where(Predicate predicate) {
  FaultSet set = 0;
  for (const FaultSpec& row : kFaultSpecs) set |= predicate(row) ? only(row.fault) : FaultSet{0};
  return set;
}

constexpr FaultSet kLatched = all_where([](const FaultSpec& row) { return row.clears == Clears::by_reset; });
constexpr FaultSet kVenting = all_where([](const FaultSpec& row) { return row.reaction == Reaction::vent; });

}  // namespace

std::span<const FaultSpec, kFaults> fault_table() noexcept {
  return kFaultSpecs;
}

const FaultSpec& spec(Fault fault) noexcept {
  return kFaultSpecs[static_cast<std::size_t>(fault)];
}

FaultSet clearing_by_themselves() noexcept {
  return kAllFaults & ~kLatched;
}

FaultSet FaultRegister::next(const config::Twice<FaultSet>& standing, FaultSet causes, Recent& recent,
                             bool reset) const noexcept {
  if (reset) {
    recent = {.now = causes & ~kLatched};
    return causes;
  }
  if (ticks_ == 0) recent = {.before = recent.now};
  recent.now |= causes & ~kLatched;
  return causes | ((standing | standing.second()) & kLatched) |
         ((recent.now | recent.before) & kAllFaults & ~kLatched);
}

FaultReport FaultRegister::step(const ChamberFaults& chamber_causes, FaultSet board_causes,
                                bool reset) noexcept {
  FaultSet causes = board_causes;
  for (const FaultSet of_chamber : chamber_causes) causes |= of_chamber;
  const FaultSet upset = (causes & ~kAllFaults) != 0 ? only(Fault::memory_upset) : FaultSet{0};
  ticks_ = ticks_ + 1U < kFlicker_ticks ? static_cast<std::uint8_t>(ticks_ + 1) : std::uint8_t{0};
  board_ = next(board_, (board_causes & kAllFaults) | upset, recent_.back(), reset);
  FaultSet anywhere = board_;
  for (std::size_t c = 0; c < config::kChambers; ++c) {
    chamber_[c] = next(chamber_[c], chamber_causes[c] & kAllFaults, recent_[c], reset);
    anywhere |= chamber_[c];
  }
  FaultReport report;
  if (anywhere == 0) return report;

  report.any = true;
  for (FaultSet rest = anywhere; rest != 0; rest &= rest - 1) {
    const FaultSpec& row = kFaultSpecs[static_cast<std::size_t>(std::countr_zero(rest))];
    report.error_register |= row.error_register;
    if (row.reaction > report.reaction) report.reaction = row.reaction;
  }
  const FaultSpec& first = kFaultSpecs[static_cast<std::size_t>(std::countr_zero(anywhere))];
  report.fault = first.fault;
  report.code = first.code;
  if (!holds(board_, first.fault)) {
    std::uint8_t c = 0;
    while (!holds(chamber_[c], first.fault)) ++c;  // ends: the fault stands somewhere
    report.chamber = static_cast<std::uint8_t>(c + 1);
  }
  return report;
}

bool FaultRegister::intact() const noexcept {
  bool intact = board_.intact();
  for (const auto& chamber : chamber_) intact = intact && chamber.intact();
  return intact;
}

bool FaultRegister::must_vent(std::size_t chamber) const noexcept {
  return (chamber_[chamber] & kVenting) != 0;
}

}  // namespace plenum::safety
