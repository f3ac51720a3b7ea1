#include "tests/safety/fault_matrix.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <stdexcept>
#include <vector>

#include "host-sim/plant/random.hpp"
#include "tests/safety/machine.hpp"

namespace plenum::safety_case {
namespace {

namespace object = canopen::object;
using host::client::Emergency;
using host::plant::Random;
using safety::State;

/// What the board is doing.
enum class Work : std::uint8_t { hold, closed_loop, open_loop, excitation };
constexpr std::array kWorkNames = {"holds", "regulates", "runs in open loop", "excites"};

/// What the outputs must do.
enum class Reaction : std::uint8_t { none, hold, safe, vent };

struct Scene {
  Machine& machine;
  std::size_t chamber;
  Random& random;
};
using Act = std::function<void(const Scene&)>;

constexpr std::array<std::size_t, kChambers> kEach = {0, 1, 2, 3, 4, 5, 6, 7};

constexpr std::uint8_t kGeneric = 0x01;
constexpr std::uint8_t kVoltage = 0x05;
constexpr std::uint8_t kCommunication = 0x11;
constexpr std::uint8_t kProfile = 0x21;
constexpr std::uint8_t kOwn = 0x81;

enum Scope : bool { kBoard = false, kChamber = true };

/// What the documents say of a fault.
struct Documented {
  const char* name;
  std::uint16_t code;  ///< 0: the board has no name for it, and works on
  std::uint8_t error_register;
  Reaction reaction;
  Scope scope;
  int ticks;  ///< the tick in which it is visible, from its cause on: by the defaults of the settings
};
struct Traits {
  bool only_active = false;      ///< no cause while the board holds, or rests, or vents
  bool needs_model = false;      ///< not in the excitation mode
  bool blinds = false;           ///< the chamber's pressure is not seen
  bool off_the_bus = false;      ///< no message leaves
  bool needs_start = false;      ///< has left the node pre-operational (1029h)
  bool within = false;           ///< visible in that tick at the latest, if the valve has moved by then
  std::uint16_t later_code = 0;  ///< a more urgent fault that the same cause may lead to
  Act spoil = {};                ///< done ahead of the start: a fault that the start finds
};
struct Row {
  Documented is;
  Act cause;  ///< done ahead of each tick
  Act cure;
  Traits traits = {};
};

void force(const Scene& of, std::size_t channel, float mean_V, bool fresh = true) {
  of.machine.readings.forced[channel] = ports::AnalogReading{mean_V, fresh};
}
void force_pressure(const Scene& of, float mean_V, bool fresh = true) {
  force(of, of.chamber, mean_V, fresh);
}
void force_position(const Scene& of, float mean_V, bool fresh = true) {
  force(of, kChambers + of.chamber, mean_V, fresh);
}
void free_readings(const Scene& of) {
  of.machine.readings.forced.fill(std::nullopt);
}
void set_supply(const Scene& of, double supply_Pa) {
  for (auto& plant : of.machine.plant) plant.set_supply_Pa(supply_Pa);
}
void upload_all(const Scene& of) {
  std::vector<host::client::ModelUpload> uploads;
  for (std::uint8_t c = 0; c < kChambers; ++c) uploads.push_back({c, models(config::ModelKind::greybox)[c]});
  of.machine.session.upload_models(uploads);
}
void store_in_vain(const Scene& of) {
  if (of.machine.store.refuses) return;
  of.machine.store.refuses = true;
  const auto c = static_cast<std::uint8_t>(of.chamber);
  const host::client::ModelUpload again{c, models(config::ModelKind::greybox)[c]};
  of.machine.session.upload_models({&again, 1}, host::client::Doubted::force);
  of.machine.storing = true;
}
void forget_a_model(const Scene& of) {
  Images images = models(config::ModelKind::greybox);
  images[of.chamber].clear();
  of.machine.store = config::PowerCutMedium();
  keep_set(of.machine.store, images);
}
/// One bit, in the first model of whichever slot holds the set.
void damage_store(const Scene& of) {
  config::Slots slots = of.machine.store.durable;
  const auto at = static_cast<std::size_t>(of.random.uniform(60.0, 160.0));
  const unsigned bit = 1U << static_cast<unsigned>(of.random.uniform(0.0, 8.0));
  for (config::Bytes& slot : slots) slot[at] = static_cast<std::uint8_t>(slot[at] ^ bit);
  of.machine.store = config::PowerCutMedium(slots);
}
float no_number(Random& random) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const double draw = random.uniform();
  return draw < 0.34 ? std::numeric_limits<float>::quiet_NaN() : draw < 0.67 ? kInf : -kInf;
}

// Ticks: stale_limit_ticks 3, stuck_ticks 10, over_pressure_ticks 2, residual_ticks 50, overrun_limit_ticks 3, supply_ticks 20,
// setpoint_watchdog_ticks 10. The answer to a write is known in the tick after; what the node sees, too.
// clang-format off
const std::vector<Row>& table() {
  static const std::vector<Row> rows = {
      {{"pressure sensor gone", 0xFF03, kOwn, Reaction::safe, kChamber, 3},
       [](const Scene& s) { force_pressure(s, 0.0F, false); }, free_readings, {.blinds = true}},
      {{"pressure not finite", 0xFF04, kOwn, Reaction::safe, kChamber, 1},
       [](const Scene& s) { force_pressure(s, no_number(s.random)); }, free_readings, {.blinds = true}},
      {{"pressure sensor's wire broken", 0xFF05, kOwn, Reaction::safe, kChamber, 1},
       [](const Scene& s) { force_pressure(s, 0.0F); }, free_readings, {.blinds = true}},
      {{"pressure sensor shorted to its supply", 0xFF05, kOwn, Reaction::safe, kChamber, 1},
       [](const Scene& s) { force_pressure(s, 10.0F); }, free_readings, {.blinds = true, .later_code = 0x8302}},
      {{"pressure sensor erratic within its range", 0xFF02, kOwn, Reaction::hold, kChamber, 50},
       [](const Scene& s) { force_pressure(s, s.machine.ticks % 2 == 0 ? 0.5F : 5.5F); }, free_readings,
       {.needs_model = true, .blinds = true, .later_code = 0x8302}},
      {{"pressure sensor stuck", 0xFF0A, kOwn, Reaction::safe, kChamber, 300},
       [](const Scene& s) { force_pressure(s, s.machine.readings.last[s.chamber].mean_V); }, free_readings,
       {.only_active = true, .blinds = true, .within = true, .later_code = 0x8302}},
      {{"position sensor gone", 0xFF06, kOwn, Reaction::safe, kChamber, 3},
       [](const Scene& s) { force_position(s, 0.0F, false); }, free_readings},
      {{"position not finite", 0xFF07, kOwn, Reaction::safe, kChamber, 1},
       [](const Scene& s) { force_position(s, no_number(s.random)); }, free_readings},
      {{"position sensor's wire broken", 0xFF08, kOwn, Reaction::safe, kChamber, 1},
       [](const Scene& s) { force_position(s, 0.0F); }, free_readings},
      {{"position sensor shorted to its supply", 0xFF08, kOwn, Reaction::safe, kChamber, 1},
       [](const Scene& s) { force_position(s, 10.0F); }, free_readings},
      {{"position sensor stuck", 0, 0, Reaction::none, kChamber, 1},
       [](const Scene& s) { force_position(s, s.machine.readings.last[kChambers + s.chamber].mean_V); }, free_readings},
      {{"valve stuck open", 0x8302, kProfile, Reaction::vent, kChamber, 2},
       [](const Scene& s) { s.machine.jam(s.chamber, 7.0); }, [](const Scene& s) { s.machine.free_spool(s.chamber); }},
      // as fast as a chamber fills in the board's reach
      {{"valve stuck open until it vents", 0x8302, kProfile, Reaction::vent, kChamber, 2},
       [](const Scene& s) { s.machine.jam(s.chamber, 7.0, Machine::Stuck::until_vented); },
       [](const Scene& s) { s.machine.free_spool(s.chamber); }, {.only_active = true}},
      {{"output refused", 0x5000, kGeneric, Reaction::safe, kBoard, 2},
       [](const Scene& s) { s.machine.analog_out.refuses = true; },
       [](const Scene& s) { s.machine.analog_out.refuses = false; }},
      {{"emergency stop", 0x9000, kGeneric, Reaction::safe, kBoard, 1},
       [](const Scene& s) { s.machine.digital.inputs.emergency_stop = true; },
       [](const Scene& s) { s.machine.digital.inputs.emergency_stop = false; }},
      {{"tick overrun", 0xFF01, kOwn, Reaction::safe, kBoard, 3},
       [](const Scene& s) { s.machine.overrun = Overrun::fault; },
       [](const Scene& s) { s.machine.overrun = Overrun::none; }},
      {{"late ticks that are only counted", 0, 0, Reaction::none, kBoard, 1},
       [](const Scene& s) { s.machine.overrun = Overrun::counted; },
       [](const Scene& s) { s.machine.overrun = Overrun::none; }},
      {{"supply lost", 0x3412, kVoltage, Reaction::hold, kBoard, 20},
       [](const Scene& s) { set_supply(s, 450e3); }, [](const Scene& s) { set_supply(s, 700e3); }},
      {{"supply too high", 0, 0, Reaction::none, kBoard, 1},
       [](const Scene& s) { set_supply(s, 900e3); }, [](const Scene& s) { set_supply(s, 700e3); }},
      {{"supply sensor gone", 0x3412, kVoltage, Reaction::hold, kBoard, 20},
       [](const Scene& s) { force(s, kSupplyChannel, 7.0F, false); }, free_readings},
      {{"supply's wire broken", 0x3412, kVoltage, Reaction::hold, kBoard, 20},
       [](const Scene& s) { force(s, kSupplyChannel, 0.0F); }, free_readings},
      {{"supply not a number", 0x3412, kVoltage, Reaction::hold, kBoard, 20},
       [](const Scene& s) { force(s, kSupplyChannel, std::numeric_limits<float>::quiet_NaN()); }, free_readings},
      {{"bus-off", 0x8140, kCommunication, Reaction::safe, kBoard, 1},
       [](const Scene& s) { s.machine.can.state_now = ports::CanState::bus_off; },
       [](const Scene& s) { s.machine.can.state_now = ports::CanState::error_active; },
       {.off_the_bus = true, .needs_start = true}},
      {{"set points lost", 0x8250, kCommunication, Reaction::safe, kBoard, 10},
       [](const Scene& s) { s.machine.setpoints = false; }, [](const Scene& s) { s.machine.setpoints = true; },
       {.only_active = true, .needs_model = true}},
      {{"SYNC lost", 0x8250, kCommunication, Reaction::safe, kBoard, 10},
       [](const Scene& s) { s.machine.syncs = false; }, [](const Scene& s) { s.machine.syncs = true; },
       {.only_active = true}},
      // 100 ms of silence, which the node knows at the end of the tenth tick, and the controller in the next
      {{"heartbeat lost", 0x8130, kCommunication, Reaction::safe, kBoard, 11},
       [](const Scene& s) { s.machine.heartbeats = false; }, [](const Scene& s) { s.machine.heartbeats = true; },
       {.needs_start = true}},
      {{"CAN error passive", 0x8120, kCommunication, Reaction::none, kBoard, 1},
       [](const Scene& s) { s.machine.can.state_now = ports::CanState::error_passive; },
       [](const Scene& s) { s.machine.can.state_now = ports::CanState::error_active; }},
      {{"CAN overrun", 0x8110, kCommunication, Reaction::none, kBoard, 1},
       [](const Scene& s) { ++s.machine.can.lost_frames; }, [](const Scene&) {}},
      // what the node has heard, the controller knows in the next tick
      {{"PDO too short", 0x8210, kCommunication, Reaction::none, kBoard, 2},
       [](const Scene& s) { s.machine.put(0x400 + Machine::kNode, {1}); },
       [](const Scene& s) { s.machine.run(1001); }},
      {{"PDO longer than mapped", 0x8220, kCommunication, Reaction::none, kBoard, 2},
       [](const Scene& s) {
         const std::uint16_t word = s.machine.image().control_word;
         s.machine.put(0x400 + Machine::kNode,
                       {static_cast<std::uint8_t>(word), static_cast<std::uint8_t>(word >> 8U), 0});
       },
       [](const Scene& s) { s.machine.run(1001); }},
      {{"SYNC that 1019h does not allow", 0x8240, kCommunication, Reaction::none, kBoard, 2},
       [](const Scene& s) { s.machine.put(0x80, {1, 2}); }, [](const Scene& s) { s.machine.run(1001); }},
      // three attempts of two ticks each
      {{"parameter store refuses", 0x6300, kProfile, Reaction::none, kBoard, 7}, store_in_vain,
       [](const Scene& s) {
         s.machine.store.refuses = false;
         s.machine.run(100);  // pieces of a set
       }},
      {{"no model", 0x6300, kProfile, Reaction::safe, kChamber, 1},
       [](const Scene&) {}, upload_all, {.only_active = true, .needs_model = true, .spoil = forget_a_model}},
      {{"stored set damaged", 0x6300, kProfile, Reaction::safe, kBoard, 1},
       [](const Scene&) {}, upload_all, {.only_active = true, .needs_model = true, .spoil = damage_store}},
  };
  return rows;
}
// clang-format on

const Row& row_at(std::uint64_t seed) {
  return table()[seed % table().size()];
}

/// One run; throws Lost where a claim does not hold.
class Run {
 public:
  explicit Run(std::uint64_t seed)
      : row_(row_at(seed)),
        random_(seed),
        work_(draw_work()),
        safe_output_(random_.uniform() < 0.5 ? config::SafeOutput::null : config::SafeOutput::vent),
        chamber_(static_cast<std::size_t>(random_.uniform(0.0, kChambers))),
        kind_(draw_kind()),
        machine_(models(kind_), safe_output_, seed) {}

  void play() {
    if (row_.traits.spoil) {
      start_spoilt();
    } else {
      begin_work();
      if (!wait_for_fault()) return;
    }
    if (row_.is.code == 0) return outlast();
    check_bus();
    if (row_.is.reaction == Reaction::none) return end_with_cause();
    stand_while_caused();
    stand_without_cause();
    recover();
  }

  std::string scene() const {
    return fmt::format("{}: chamber {}, model {}, {}, safe output {}", row_.is.name, chamber_ + 1,
                       static_cast<int>(kind_), kWorkNames[static_cast<std::size_t>(work_)],
                       safe_output_ == config::SafeOutput::null ? "null" : "vent");
  }

 private:
  Work draw_work() {
    std::vector<Work> possible = {Work::closed_loop, Work::open_loop};
    if (!row_.traits.only_active) possible.push_back(Work::hold);
    if (!row_.traits.needs_model) possible.push_back(Work::excitation);
    return possible[static_cast<std::size_t>(random_.uniform(0.0, static_cast<double>(possible.size())))];
  }
  /// In open loop the grey box alone: with the formulas a volume that moves takes the feedforward over the limit by itself.
  config::ModelKind draw_kind() {
    constexpr std::array kKinds = {config::ModelKind::greybox, config::ModelKind::tassa9r,
                                   config::ModelKind::tassa9};
    if (work_ == Work::open_loop) return config::ModelKind::greybox;
    return kKinds[static_cast<std::size_t>(random_.uniform(0.0, kKinds.size()))];
  }
  int some(int low, int high) { return low + static_cast<int>(random_.uniform(0.0, high - low + 1.0)); }
  std::uint16_t working_word() const { return work_ == Work::hold ? 0x3 : 0x7; }
  State working_state() const { return work_ == Work::hold ? State::hold : State::active; }

  void expect(bool holds, const std::string& claim) const {
    if (!machine_.violation().empty()) throw std::runtime_error(machine_.violation());
    if (holds) return;
    throw std::runtime_error(fmt::format("tick {}: expected {}; found {}, error {:04X}h of chamber {}",
                                         machine_.ticks, claim, safety::describe(machine_.state()),
                                         machine_.image().error_code, machine_.image().fault_chamber));
  }

  void begin_work() {
    machine_.start(work_ == Work::excitation  ? canopen::ControlMode::excitation
                   : work_ == Work::open_loop ? canopen::ControlMode::pressure_open_loop
                                              : canopen::ControlMode::pressure_closed_loop);
    machine_.climb({0x1, 0x3, working_word()});
    for (int left = some(20, 120); left > 0; --left) {
      machine_.tick();
      expect(machine_.state() == working_state() && machine_.image().error_code == 0, "work without a fault");
    }
    machine_.take_emergencies();
  }

  void tick_with_cause() {
    row_.cause({machine_, chamber_, random_});
    machine_.unseen[chamber_] = row_.traits.blinds;
    machine_.tick();
    lowest_V_ = std::min(lowest_V_, machine_.analog_out.asked_V[chamber_]);
    highest_V_ = std::max(highest_V_, machine_.analog_out.asked_V[chamber_]);
  }
  /// Since the fault began: over an eighth of its range.
  bool valve_moved() const {
    const config::ChamberSettings& its = machine_.settings.chamber[chamber_];
    return highest_V_ - lowest_V_ > (its.command_high_V - its.command_low_V) / 8.0F;
  }

  bool code_shown() const {
    const std::uint16_t code = machine_.image().error_code;
    return code == row_.is.code || (row_.traits.later_code != 0 && code == row_.traits.later_code);
  }
  bool reacts() const {
    for (std::size_t c = 0; c < kChambers; ++c) {
      const config::ChamberSettings& its = machine_.settings.chamber[c];
      const float command_V = machine_.analog_out.asked_V[c];
      const bool must_vent = (machine_.image().must_vent >> c & 1U) != 0;
      const bool regulated = command_V >= its.command_low_V && command_V <= its.command_high_V;
      const bool holds = row_.is.reaction == Reaction::hold && work_ != Work::excitation;
      if (holds ? !regulated : command_V != (must_vent ? its.vent_V : machine_.safe_V(c))) return false;
    }
    if (row_.is.reaction == Reaction::vent &&
        machine_.analog_out.asked_V[chamber_] != machine_.settings.chamber[chamber_].vent_V)
      return false;
    const bool powerless = row_.is.code == 0x5000 || row_.is.code == 0x9000;
    return machine_.digital.outputs.valve_power != powerless && machine_.digital.outputs.fault_lamp;
  }

  /// Claim 1. Returns false where the fault need not be told.
  bool wait_for_fault() {
    if (row_.is.reaction == Reaction::vent) {
      // until the chamber has reached its limit: the fault is visible when its true pressure has
      const double limit_kPa = static_cast<double>(machine_.settings.chamber[chamber_].over_pressure_kPa);
      for (int left = 200; left > 0 && machine_.pressure_kPa(chamber_) <= limit_kPa; --left)
        tick_with_cause();
      expect(machine_.pressure_kPa(chamber_) > limit_kPa, "a chamber above its limit");
    }
    for (int i = 1; i < row_.is.ticks && row_.is.reaction != Reaction::vent; ++i) {
      tick_with_cause();
      if (row_.traits.within && code_shown()) break;
      expect(machine_.image().error_code == 0 && machine_.state() == working_state(),
             "no fault before its time");
    }
    if (row_.traits.within && !valve_moved()) return false;
    // at the moment of the over-pressure: 2 ticks that it must last, and half a tick in which the mean is behind
    for (int left = row_.is.reaction == Reaction::vent ? 4 : 2; left > 0 && !code_shown(); --left)
      tick_with_cause();
    expect(code_shown(), fmt::format("error {:04X}h", row_.is.code));
    if (row_.is.reaction != Reaction::none) expect(reacts(), "its reaction in the tick in which it is told");
    return true;
  }

  /// Claim 2.
  void check_bus() {
    const unsigned chamber = row_.is.scope == kChamber ? static_cast<unsigned>(chamber_) + 1U : 0U;
    expect(machine_.image().fault_chamber == chamber, fmt::format("fault of chamber {}", chamber));
    expect((machine_.image().error_register & row_.is.error_register) == row_.is.error_register,
           fmt::format("error register {:02X}h", row_.is.error_register));
    if (row_.traits.off_the_bus) return;
    const std::vector<Emergency> sent = machine_.take_emergencies();
    const auto of_this = [&](const Emergency& one) {
      return one.code == row_.is.code && one.chamber == chamber &&
             one.error_register == row_.is.error_register;
    };
    const auto of_others = std::count_if(sent.begin(), sent.end(), std::not_fn(of_this));
    expect(
        !sent.empty() && of_this(sent.front()) && of_this(sent.back()) &&
            sent.size() == static_cast<std::size_t>(of_others == 0 ? 1 : of_others + 2),
        "one emergency message, of this fault, and where others have risen with it once more behind theirs");
    expect(machine_.session.read<std::uint16_t>(object::kErrorCode, 0) == row_.is.code, "604Eh on the bus");
    expect(machine_.session.read<std::uint8_t>(object::kErrorRegister, 0) == row_.is.error_register,
           "1001h on the bus");
    expect(machine_.session.read<std::uint32_t>(object::kErrorHistoryIndex, 1) ==
               (row_.is.code | chamber << 16U),
           "1003h:1 on the bus");
  }

  void expect_standing() const {
    expect(code_shown() && (machine_.image().status_word & 0x8) == 0, "the fault to stand");
    expect(reacts(), "its reaction to last");
  }

  void stand_while_caused() {
    for (int left = some(3, 25); left > 0; --left) {
      tick_with_cause();
      expect_standing();
    }
    if (row_.traits.only_active) return;  // DISABLED would end the cause
    for (const std::uint16_t word : Words{0x1, 0x9, 0x1}) {
      machine_.control(word);
      for (int i = 0; i < 2; ++i) {
        tick_with_cause();
        expect(code_shown() && (machine_.image().status_word & 0x8) == 0, "no reset while the cause lasts");
      }
    }
  }

  /// Claim 4, first half.
  void stand_without_cause() {
    row_.cure({machine_, chamber_, random_});
    machine_.unseen[chamber_] = false;
    if (row_.traits.needs_start) machine_.put(0, {1, Machine::kNode});
    constexpr std::array<std::uint16_t, 7> kWords = {0x0, 0x1, 0x3, 0x7, 0xF, 0x7, 0x5};
    for (int i = some(1, 6); i > 0; --i) {
      machine_.control(kWords[static_cast<std::size_t>(some(0, kWords.size() - 1))]);
      for (int k = some(1, 6); k > 0; --k) {
        machine_.tick();
        expect(code_shown() && (machine_.image().status_word & 0x8) == 0,
               "the fault to stand without its cause");
        const bool moves = machine_.state() == State::active || machine_.state() == State::hold;
        expect(!moves, "no motion before a reset");
      }
    }
  }

  /// Claim 4, second half.
  void recover() {
    machine_.control(0x1);
    // what is vented goes below the admissible references, and on to where open loop may start
    const auto above = [this](std::size_t c) {
      const bool vented = (machine_.image().must_vent >> c & 1U) != 0;
      return machine_.pressure_kPa(c) > (vented ? 300.0 : 480.0);
    };
    machine_.run(2);  // in which a model is still judged by what a sensor showed before its cure
    int rest = 300;
    do machine_.tick();
    while (--rest > 0 && std::any_of(kEach.begin(), kEach.end(), above));
    machine_.control(0x9);
    for (int i = 0; i < 2; ++i) {
      machine_.tick();
      expect(machine_.state() != State::active && machine_.state() != State::hold,
             "no motion by a reset alone");
    }
    expect(machine_.state() == State::disabled && machine_.image().error_code == 0,
           "DISABLED after the reset");
    machine_.climb({0x1, 0x3, working_word()});
    for (int left = 30; left > 0; --left) {
      machine_.tick();
      expect(machine_.state() == working_state() && machine_.image().error_code == 0, "work after the reset");
    }
  }

  /// Claim 1, of what the start finds: it is told when the board is asked to regulate, or before, and nothing moves.
  void start_spoilt() {
    row_.traits.spoil({machine_, chamber_, random_});
    machine_.start(canopen::ControlMode::pressure_closed_loop);
    for (const std::uint16_t word : Words{0x1, 0x3}) {
      if (code_shown()) break;
      machine_.control(word);
      machine_.tick();
    }
    expect(code_shown() && reacts(), "a fault, and safe outputs");
  }

  /// A fault that the board has no name for: claim 3 is all there is.
  void outlast() {
    for (int left = some(30, 100); left > 0; --left) {
      tick_with_cause();
      expect(machine_.state() == working_state() && machine_.image().error_code == 0, "work");
    }
  }

  /// Claim 5.
  void end_with_cause() {
    for (int left = some(3, 25); left > 0; --left) {
      tick_with_cause();
      expect(code_shown() && machine_.state() == working_state(), "a report, and work");
    }
    row_.cure({machine_, chamber_, random_});
    machine_.run(2 * safety::FaultRegister::kFlicker_ticks);
    expect(machine_.image().error_code == 0 && machine_.state() == working_state(),
           "the report to end soon after its cause");
  }

  const Row& row_;
  Random random_;
  Work work_;
  config::SafeOutput safe_output_;
  std::size_t chamber_;
  config::ModelKind kind_;
  Machine machine_;
  float lowest_V_ = std::numeric_limits<float>::infinity();  ///< commands since the fault began
  float highest_V_ = -lowest_V_;
};

}  // namespace

std::size_t rows() {
  return table().size();
}

std::string row_of(std::uint64_t seed) {
  return row_at(seed).is.name;
}

std::string lost_in_run(std::uint64_t seed) {
  Run run(seed);
  try {
    run.play();
  } catch (const std::exception& lost) {
    return fmt::format("seed {}: {}: {}", seed, run.scene(), lost.what());
  }
  return {};
}

}  // namespace plenum::safety_case
