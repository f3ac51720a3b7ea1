#include "host-sim/client/capture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>
#include <random>
#include <stdexcept>

#include "firmware/canopen/objects.hpp"
#include "firmware/canopen/process_image.hpp"
#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/borrowed_stream.hpp"

namespace plenum::host::client {
namespace {

using canopen::ControlMode;
namespace object = canopen::object;

constexpr double kCycle_s = 0.01;
constexpr double kSilence_s = 0.5;  ///< without a row of the stream: the board or the bus is gone
constexpr double kRate_Hz = 100.0;  // a time k / 100 is written with two decimals, k * 0.01 with sixteen
constexpr const char* kSomebodys = "somebody regulates it, and would lose it in motion";
constexpr int kSettleCycles = 100;  ///< time that HOLD gets to reach the first reference

/// One that is reported only spoils no row.
bool spoils(const FaultEntry& fault) {
  return fault_specs(fault).empty() || reacts(fault);
}

/// Gathers the rows that the board streams, one a tick, and keeps step with them: the master's cycle is the board's tick,
/// whatever either clock says, and a master that was late by some ticks goes on with the row that it has reached.
class Recorder {
 public:
  Recorder(Session& session, std::uint8_t chambers, const Stream& stream)
      : session_(session),
        mask_(chambers),
        stream_(stream),
        state_pdo_(state_pdo(session)),
        subscription_(session, [this](const Arrival& arrival) {
          look(arrival.frame);
          stream_.accept(arrival.time_s, arrival.frame, [this](const StreamRow& row) { take(row); });
        }) {}

  /// One cycle: what has been queued goes out with the SYNC, and the next tick's row is awaited.
  void cycle() {
    session_.send_sync();
    await_row();
  }

  /// Asks for a state, in which the board has to stay from here on; awaits a tick's row, and forgets what has been recorded so far: the
  /// next cycle begins right after that tick.
  void enter(std::uint16_t state) {
    state_.reset();
    session_.request_state(state);
    await_row();
    rows_.clear();
    state_ = state;
  }
  const std::vector<StreamRow>& rows() const { return rows_; }
  /// The board has told of a fault that takes its outputs from whoever drives them, or that it has left the state: what comes now is
  /// of no use.
  bool is_broken() const { return fault_ || left_for_; }

  /// Throws Refused where the board has left the state that it was to stay in, or where what broke the recording stands or has gone.
  void require_whole() {
    const std::optional<FaultEntry> stands = standing_fault();
    if (stands && spoils(*stands)) {
      throw Refused(fmt::format("node {}: fault {} stands after the run, expected none: see plenum faults",
                                session_.node_id(), fault_text(*stands)));
    }
    if (fault_) {
      throw Refused(fmt::format("node {}: fault {} has ended the run, and is gone: see plenum faults",
                                session_.node_id(), fault_text(*fault_)));
    }
    const std::uint16_t status = session_.status_word();
    if (!left_for_ && !stays(status)) left_for_ = status;
    if (!left_for_) return;
    throw Refused(fmt::format(
        "node {}: has left {} by row {} and is {}, and no fault says why: expected no other master",
        session_.node_id(), state_name(*state_ | canopen::word::kReady, 0), rows_.size(),
        state_name(*left_for_, 0)));
  }

 private:
  /// The identifier under which the board tells its state as soon as it changes, as one that is delivered does by TPDO3; none where that
  /// is mapped otherwise: then it is asked at the end.
  static std::optional<std::uint32_t> state_pdo(Session& session) {
    constexpr std::uint32_t kTpdo3 = 2, kIdentifier = 0x7FF;
    const auto mapping = object::nth(object::kTpdoMapping, kTpdo3);
    const auto cob_id = session.read<std::uint32_t>(object::nth(object::kTpdoCommunication, kTpdo3), 1);
    if ((cob_id & canopen::cob::kInvalid) != 0 || session.read<std::uint8_t>(mapping, 0) == 0) return {};
    if (session.read<std::uint32_t>(mapping, 1) != canopen::mapping_entry(object::kStatusWord, 0, 16))
      return {};
    return cob_id & kIdentifier;
  }

  void look(const CanFrame& frame) {
    if (state_pdo_ && frame.id == *state_pdo_ && !frame.extended && !frame.remote && frame.length >= 2) {
      const auto status = static_cast<std::uint16_t>(canopen::load_le(std::span(frame.data).first<2>()));
      // one that a fault has led there is told by its emergency
      if (!left_for_ && !stays(status) && (status & canopen::word::kReady) != 0) left_for_ = status;
    }
    const auto emergency = decode_emergency(frame);
    if (!emergency || emergency->node_id != session_.node_id() || emergency->code == 0) return;
    const FaultEntry fault{emergency->code, emergency->chamber};
    if (!fault_ && spoils(fault)) fault_ = fault;
  }

  bool stays(std::uint16_t status) const {
    return !state_ || (status & canopen::word::kStateMask) == *state_;
  }

  /// What the board says now; that which it told of where it no longer answers.
  std::optional<FaultEntry> standing_fault() {
    try {
      return read_fault(session_);
    } catch (const Timeout&) {
      if (!fault_) throw;
      return fault_;
    }
  }

  void await_row() {
    const std::size_t before = rows_.size();
    if (session_.listen_until([&] { return rows_.size() != before || is_broken(); }, kSilence_s)) return;
    throw Timeout(fmt::format("node {}: no row of the stream came for {} s, expected one each {} s",
                              session_.node_id(), kSilence_s, kCycle_s));
  }

  void take(const StreamRow& row) {
    if (row.chambers != mask_) {
      throw ProtocolError(
          fmt::format("node {}: row {} of the capture holds chambers {:02X}h, expected {:02X}h: frames were "
                      "lost on the bus",
                      session_.node_id(), rows_.size(), row.chambers, mask_));
    }
    rows_.push_back(row);
  }

  Session& session_;
  std::uint8_t mask_;
  Stream stream_;
  std::vector<StreamRow> rows_;
  std::optional<std::uint32_t> state_pdo_;
  std::optional<std::uint16_t> state_;     ///< of 6041h, that it is to stay in
  std::optional<std::uint16_t> left_for_;  ///< 6041h once it did not
  std::optional<FaultEntry> fault_;
  Subscription subscription_;
};

/// The valves while they are driven: DISABLED and in the mode of before afterwards, whatever ends it.
class Drive {
 public:
  Drive(Session& session, ControlMode mode)
      : session_(session),
        before_(static_cast<ControlMode>(session.read<std::int8_t>(object::kControlMode, 0))) {
    if (before_ == ControlMode::excitation)
      before_ = ControlMode::pressure_closed_loop;  // somebody's, cut short
    set_mode(mode);
  }
  ~Drive() {
    if (ended_) return;
    try {
      session_.write(object::kControlWord, 0, canopen::word::kDisabled);
      session_.listen(2.0 * kCycle_s);  // a mode is not taken from a board that is ACTIVE
      set_mode(before_);
    } catch (const std::exception&) {  // the bus may be what failed: the first reason is the one to tell
    }
  }
  Drive(const Drive&) = delete;
  Drive& operator=(const Drive&) = delete;

  void end() {
    session_.disable();
    set_mode(before_);
    ended_ = true;
  }

 private:
  void set_mode(ControlMode mode) { session_.write(object::kControlMode, 0, static_cast<std::int8_t>(mode)); }

  Session& session_;
  ControlMode before_;
  bool ended_ = false;
};

/// What HOLD, and a fault, lead each chamber to.
std::vector<Setting> hold_setpoints(unsigned chambers) {
  std::vector<Setting> objects;
  for (unsigned c = 0; c < chambers; ++c) {
    objects.push_back(
        {{object::of_module(object::kHoldSetpoint, c), 1}, canopen::DataType::integer16, "Hold set point"});
  }
  return objects;
}

std::uint8_t mask_of(unsigned chambers) {
  return static_cast<std::uint8_t>((1U << chambers) - 1U);
}

/// What Session::configure_setpoints() and follow() write.
bool is_of_setpoints(const SettingId& id) {
  const auto in = [&id](std::uint32_t first) { return id.index >= first && id.index < first + 4; };
  return in(object::kRpdoCommunication) || in(object::kRpdoMapping) || id.index == object::kPreviewTicks;
}

void require_chambers(unsigned chambers) {
  if (chambers < 1 || chambers > kChambers) {
    throw std::invalid_argument(fmt::format("{} chambers, expected 1 to {}", chambers, kChambers));
  }
}

/// Refuses pressures above a limit, once they have been below it: air from before may take its time to leave.
class Ceiling {
 public:
  explicit Ceiling(const FollowOptions& options) : options_(options) {}
  void look(const StreamRow& row) {
    for (std::size_t c = 0; c < options_.chambers; ++c) {
      const double actual_Pa = row.sample[c].actual_Pa;
      been_below_[c] = been_below_[c] || actual_Pa <= options_.highest_Pa;
      if (!been_below_[c] || actual_Pa <= options_.highest_Pa) continue;
      throw Refused(
          fmt::format("chamber {}: {:.6g} kPa, expected at most {:.6g} kPa: regulation goes so far beyond "
                      "its references where the model lacks "
                      "a delay of valve or sensor, say, which plenum diagnose names",
                      c + 1, 1e-3 * actual_Pa, 1e-3 * options_.highest_Pa));
    }
  }

 private:
  const FollowOptions& options_;
  std::array<bool, kChambers> been_below_{};
};

/// Of kChamberSettings.
enum class Limit : std::uint8_t {
  pressure_low_kPa = 9,
  pressure_high_kPa = 10,
  command_low_V = 13,
  command_high_V = 14,
  null_V = 15
};

/// The board would not move a valve within such limits.
void require_excitable(Session& session, const CaptureOptions& options) {
  for (unsigned c = 0; c < options.chambers; ++c) {
    const auto of = [&](Limit limit) {
      return static_cast<double>(
          session.read<float>(object::nth(object::kChamberSettings, c), static_cast<std::uint8_t>(limit)));
    };
    const double least_kPa = of(Limit::pressure_low_kPa), most_kPa = of(Limit::pressure_high_kPa);
    const double low_kPa = 1e-3 * options.pressure_low_Pa, high_kPa = 1e-3 * options.pressure_high_Pa;
    if (std::max(low_kPa, least_kPa) >= std::min(high_kPa, most_kPa)) {
      throw std::invalid_argument(
          fmt::format("node {}: chamber {}: pressures from {:g} to {:g} kPa, expected some of {:g} to {:g} "
                      "kPa, absolute, which its settings allow",
                      session.node_id(), c + 1, low_kPa, high_kPa, least_kPa, most_kPa));
    }
    const double null_V = of(Limit::null_V);
    const double low_V = std::max(static_cast<double>(options.command_low_V), of(Limit::command_low_V));
    const double high_V = std::min(static_cast<double>(options.command_high_V), of(Limit::command_high_V));
    if (low_V < null_V && null_V < high_V) continue;
    throw std::invalid_argument(
        fmt::format("node {}: chamber {}: commands from {:g} to {:g} V, expected some on both sides of its "
                    "null, {:g} V, and within {:g} to {:g} V, which its settings allow",
                    session.node_id(), c + 1, options.command_low_V, options.command_high_V, null_V,
                    of(Limit::command_low_V), of(Limit::command_high_V)));
  }
}

/// `count` rows, or as many as there are, after the first `lead`.
std::vector<CapturedRow> rows_of(const Recorder& recorder, std::size_t lead, std::size_t count) {
  const std::size_t recorded = recorder.rows().size();
  std::vector<CapturedRow> rows(recorded < lead ? 0 : std::min(count, recorded - lead));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    rows[k].time_s = static_cast<double>(k) / kRate_Hz;
    rows[k].bus_time_s = recorder.rows()[lead + k].time_s;
    rows[k].sample = recorder.rows()[lead + k].sample;
    rows[k].supply_Pa = recorder.rows()[lead + k].supply_Pa;
  }
  return rows;
}

/// With the references that they followed.
std::vector<CapturedRow> rows_of(const Recorder& recorder, std::size_t lead,
                                 std::span<const std::vector<double>> reference_Pa) {
  std::vector<CapturedRow> rows = rows_of(recorder, lead, reference_Pa.front().size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    for (std::size_t c = 0; c < reference_Pa.size(); ++c) rows[k].reference_Pa[c] = reference_Pa[c][k];
  }
  return rows;
}

/// Sees that what is recorded is not lost with the exception that ends the recording.
class Rescue {
 public:
  Rescue(std::vector<CapturedRow>* so_far, std::function<std::vector<CapturedRow>()> rows)
      : so_far_(so_far), rows_(std::move(rows)) {}
  ~Rescue() {
    if (so_far_ != nullptr && std::uncaught_exceptions() > before_) *so_far_ = rows_();
  }
  Rescue(const Rescue&) = delete;
  Rescue& operator=(const Rescue&) = delete;

 private:
  std::vector<CapturedRow>* so_far_;
  std::function<std::vector<CapturedRow>()> rows_;
  int before_ = std::uncaught_exceptions();
};

bool asked(const Stopped& stopped) {
  return stopped && stopped();
}

/// Runs cycles until `count` rows are there, or it is stopped, or a fault has broken it; `before(row)` queues what goes out with the SYNC before that row.
void record(Recorder& recorder, std::size_t count, const std::function<void(std::size_t)>& before,
            const Progress& progress, const Stopped& stopped) {
  constexpr std::size_t kTell = 100;  // rows
  for (std::size_t told = 0; recorder.rows().size() < count && !recorder.is_broken() && !asked(stopped);) {
    before(recorder.rows().size());
    recorder.cycle();
    if (!progress || recorder.rows().size() < told) continue;
    told = recorder.rows().size() + kTell;
    progress(std::min(1.0, static_cast<double>(recorder.rows().size()) / static_cast<double>(count)));
  }
}

}  // namespace

void require_none_left_out(Session& session, unsigned chambers) {
  std::vector<unsigned> left_out;
  for (unsigned c = chambers; c < kChambers; ++c) {
    if (is_in_use(session, c)) left_out.push_back(c + 1);
  }
  if (left_out.empty()) return;
  throw std::invalid_argument(fmt::format(
      "node {}: the first {} chambers are asked for, but {} {} in use and would be driven, too: "
      "expected all that are in use, or 0 in 2410h + c:1 of the others",
      session.node_id(), chambers, fmt::join(left_out, ", "), left_out.size() == 1 ? "is" : "are"));
}

std::vector<CapturedRow> capture(Session& session, const CaptureOptions& options, const Progress& progress) {
  require_chambers(options.chambers);
  require_at_rest(session, kSomebodys);
  require_no_stream(session);
  require_none_left_out(session, options.chambers);
  require_excitable(session, options);
  session.nmt(canopen::NmtCommand::enter_pre_operational);
  const std::uint8_t mask = mask_of(options.chambers);
  BorrowedStream borrowed(
      session,
      {.chambers = mask, .supply = watches_supply(session), .largest_volume_m3 = options.largest_volume_m3});
  for (unsigned c = 0; c < options.chambers; ++c) {
    const auto excitation = object::nth(object::kExcitation, c);
    session.write(excitation, 1, options.seed);
    session.write(excitation, 2, options.command_low_V);
    session.write(excitation, 3, options.command_high_V);
    session.write(excitation, 4, static_cast<float>(options.pressure_low_Pa));
    session.write(excitation, 5, static_cast<float>(options.pressure_high_Pa));
  }
  Drive drive(session, ControlMode::excitation);
  session.learn_sync();
  std::vector<CapturedRow> rows;
  {
    Recorder recorder(session, mask, borrowed.stream());
    session.nmt(canopen::NmtCommand::start);
    session.request_state(canopen::word::kDisabled);
    session.request_state(canopen::word::kHold);
    recorder.enter(canopen::word::kActive);
    const auto count = static_cast<std::size_t>(std::lround(options.seconds / kCycle_s));
    const Rescue rescue(options.so_far, [&] { return rows_of(recorder, 0, count); });
    record(
        recorder, count, [](std::size_t) {}, progress, options.stopped);
    recorder.require_whole();
    rows = rows_of(recorder, 0, count);
  }
  drive.end();
  borrowed.give_back();
  return rows;
}

std::vector<CapturedRow> follow(Session& session, std::span<const std::vector<double>> reference_Pa,
                                const FollowOptions& options, const Progress& progress) {
  require_chambers(options.chambers);
  if (reference_Pa.size() != options.chambers) {
    throw std::invalid_argument(fmt::format("{} references for {} chambers, expected one each",
                                            reference_Pa.size(), options.chambers));
  }
  const std::size_t count = reference_Pa.front().size();
  for (const std::vector<double>& reference : reference_Pa) {
    if (reference.size() != count || count == 0) {
      throw std::invalid_argument(fmt::format(
          "a reference of {} rows beside one of {}, expected one length above 0", reference.size(), count));
    }
  }
  require_at_rest(session, kSomebodys);
  require_no_stream(session);
  require_none_left_out(session, options.chambers);
  session.nmt(canopen::NmtCommand::enter_pre_operational);
  const std::uint8_t mask = mask_of(options.chambers);
  BorrowedSettings setpoints(session, is_of_setpoints);
  BorrowedStream borrowed(
      session,
      {.chambers = mask, .supply = watches_supply(session), .largest_volume_m3 = options.largest_volume_m3});
  session.configure_setpoints(SetpointFormat::millibar);
  session.write(object::kPreviewTicks, 0, options.preview_ticks);
  const std::vector<Setting> hold = hold_setpoints(options.chambers);
  BorrowedSettings borrowed_hold(session, hold);
  Drive drive(session,
              options.open_loop ? ControlMode::pressure_open_loop : ControlMode::pressure_closed_loop);
  session.learn_sync();
  std::array<double, kChambers> setpoint_Pa{};  // 0: of chambers not in use, require_none_left_out()
  const auto send_row = [&](std::size_t row) {
    for (std::size_t c = 0; c < options.chambers; ++c)
      setpoint_Pa[c] = reference_Pa[c][std::min(row, count - 1)];
    session.send_setpoints(setpoint_Pa);
  };
  constexpr double kPaPerMbar = 100.0;
  for (std::size_t c = 0; c < hold.size(); ++c) {
    const auto mbar = static_cast<std::int16_t>(std::lround(reference_Pa[c].front() / kPaPerMbar));
    session.write(hold[c].id.index, hold[c].id.sub, mbar);
  }
  std::vector<CapturedRow> rows;
  {
    Recorder recorder(session, mask, borrowed.stream());
    session.nmt(canopen::NmtCommand::start);
    session.request_state(canopen::word::kDisabled);
    recorder.enter(canopen::word::kHold);
    for (int k = 0; k < kSettleCycles && !recorder.is_broken() && !asked(options.stopped); ++k) {
      send_row(0);
      recorder.cycle();
    }
    recorder.require_whole();
    if (!asked(options.stopped)) {
      recorder.enter(canopen::word::kActive);
      // A set point of preview N is the reference N ticks after its own; without preview it is met at its tick's
      // end.
      const std::size_t ahead = std::max<std::size_t>(options.preview_ticks, 1);
      // The set points of rows 1 to `ahead` - 1 have to be on their way before row 0.
      const std::size_t lead = ahead - 1;
      const Rescue rescue(options.so_far, [&] { return rows_of(recorder, lead, reference_Pa); });
      Ceiling ceiling(options);
      record(
          recorder, lead + count,
          [&](std::size_t row) {
            if (row > 0) ceiling.look(recorder.rows().back());
            send_row(row + ahead - lead);
          },
          progress, options.stopped);
      recorder.require_whole();
      rows = rows_of(recorder, lead, reference_Pa);
    }
  }
  drive.end();
  borrowed_hold.give_back();
  borrowed.give_back();
  setpoints.give_back();
  return rows;
}

std::vector<std::vector<double>> random_references(unsigned chambers, double seconds, double low_Pa,
                                                   double high_Pa, std::uint32_t seed) {
  require_chambers(chambers);
  const auto count = static_cast<std::size_t>(std::lround(seconds / kCycle_s));
  std::mt19937 bits(seed);  // its sequence is the standard's; a distribution's is not
  const auto unit = [&bits] { return static_cast<double>(bits()) / 4294967296.0; };
  std::vector<std::vector<double>> references(chambers);
  for (std::vector<double>& reference : references) {
    double now_Pa = 0.5 * (low_Pa + high_Pa);
    double goal_Pa = now_Pa;
    double step_Pa = 0.0;
    for (std::size_t left = 0; reference.size() < count; --left) {
      if (left == 0) {
        goal_Pa = low_Pa + (high_Pa - low_Pa) * unit();
        step_Pa = 0.1e6 * std::pow(100.0, unit()) * kCycle_s;
        left = 10 + static_cast<std::size_t>(60.0 * unit());
      }
      now_Pa = std::clamp(goal_Pa, now_Pa - step_Pa, now_Pa + step_Pa);
      reference.push_back(now_Pa);
    }
  }
  return references;
}

}  // namespace plenum::host::client
