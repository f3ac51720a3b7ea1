// board.fault_to_safe_ms: from the onset of a fault to safe outputs at the valves, the worst over the fault list, in virtual time.
//
// A board of four chambers regulates to moving references on the simulated rig: the unchanged firmware, plants, converters and
// bus. A fault begins at a moment of the tick (early, in its middle, late), while no output is at its safe value. Safe is the
// tick after which each DAC holds its chamber's safe value, and holds it for the rest of half a second; where the DAC takes no
// writes, the tick that cuts the valves' power. The reading that is not finite is none that the rig's converters can give: it
// comes from the drivers of memory of the tests' board.
//
// Some causes have to last before they count, by settings: each is left at its default. Two figures come of each run:
//
//   fault_to_safe_with_detection_ms   all of it: what a machine's designer has to reckon with
//   fault_to_safe_ms                  without that time: (n - 1) ticks where n have to be bad on end, the whole time-out where
//                                     something has to stay away; its onset is when that came last
//
// Faults whose reaction is to hold (supply low, model residual) or none have no safe output; those that are known before the
// board regulates (no model, stored set lost) have no onset.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/model_bytes.hpp"
#include "host-sim/rig/standard_rigs.hpp"
#include "host-sim/tools/rig_link.hpp"
#include "tests/bench/row.hpp"
#include "tests/firmware/board/bench.hpp"

namespace {

using namespace plenum::host;
using plenum::safety::Fault;

constexpr unsigned kChambers = 4;
constexpr double kTick_ms = 10.0;
constexpr double kTarget_ms = 20.0;
constexpr std::uint16_t kHeartbeat_ms = 100;
constexpr std::uint8_t kMaster = 0x7E;
constexpr std::size_t kPressure = 0;  // channels of the first chamber
constexpr std::size_t kPosition = plenum::config::kChambers;

rig::RigConfig rig_config() {
  rig::RigConfig config = rig::mpye_rig({.chambers = kChambers});
  for (plenum::config::ChamberSettings& chamber : config.board.front().settings.chamber) {
    chamber.residual_ticks = 0;            // the model is another valve's
    chamber.position_valid_high_V = 9.9F;  // within what the converter can read
  }
  return config;
}

/// A board that regulates, its master, and what is done to them.
class Scene {
 public:
  Scene() : rig(rig_config()), link_(rig, "master", [this] { look(); }), session_(link_, 1) {
    const std::vector<double> parameters(plenum::kValve.begin(), plenum::kValve.end());
    std::vector<client::ModelUpload> uploads;
    for (std::uint8_t c = 0; c < kChambers; ++c)
      uploads.push_back({c, client::encode_model("tassa9", parameters, {})});
    session_.upload_models(uploads);
    session_.write(0x1016, 1, std::uint32_t{kMaster} << 16U | kHeartbeat_ms);
    session_.nmt(plenum::canopen::NmtCommand::start);
    for (const std::uint16_t word :
         {plenum::canopen::word::kDisabled, plenum::canopen::word::kHold, plenum::canopen::word::kActive}) {
      session_.write(plenum::canopen::object::kControlWord, 0, word);
      for (int k = 0; k < 10; ++k) cycle(0.5);
    }
  }

  /// The master's part of a tick, at `phase` of it.
  void cycle(double phase) {
    wait_for(phase);
    if (setpoints) {
      for (std::size_t c = 0; c < kChambers; ++c) {
        setpoint_Pa_[c] = 3e5 + 1e5 * std::sin(3.0 * rig.now_s() * (1.0 + 0.2 * static_cast<double>(c)));
      }
      session_.send_setpoints(setpoint_Pa_);
      session_.send_sync();
    }
    if (heartbeats) link_.send({.id = 0x700U + kMaster, .length = 1, .data = {5}});
    said_s = rig.now_s();
  }

  void wait_for(double phase) {
    const double tick_s = rig::kTick_s * static_cast<double>(rig.ticks());
    session_.listen(tick_s + phase * rig::kTick_s - rig.now_s());
  }

  /// No chamber in use is at its safe output.
  bool nothing_safe() {
    for (std::size_t c = 0; c < kChambers; ++c) {
      if (at_safe_value(c)) return false;
    }
    return true;
  }

  std::uint16_t error_code() { return rig.board(0).controller().image().error_code; }
  rig::SimulatedBoard& board() { return rig.board(0); }

  rig::Rig rig;
  bool setpoints = true;
  bool heartbeats = true;
  double said_s = 0.0;               ///< when the master spoke last
  std::function<void()> cause = {};  ///< stands: done again after each tick
  bool vents = false;                ///< the first chamber's safe output is its vent
  bool by_power = false;             ///< safe without the valves' power
  std::optional<double> safe_s;      ///< since when

 private:
  void look() {
    bool safe = by_power && !board().digital().outputs().valve_power;
    if (!safe) {
      safe = true;
      for (std::size_t c = 0; c < kChambers; ++c) safe = safe && at_safe_value(c);
    }
    if (!safe) safe_s.reset();
    if (safe && !safe_s) safe_s = rig::kTick_s * static_cast<double>(rig.ticks() - 1);
    if (cause) cause();
  }

  bool at_safe_value(std::size_t c) {
    constexpr double kLsb_V = 10.0 / 65536.0;
    const plenum::config::ChamberSettings settings = rig_config().board.front().settings.chamber[c];
    const float safe_V = vents && c == 0 ? settings.vent_V : settings.null_V;
    return std::abs(board().analog_out().output_V(c) - static_cast<double>(safe_V)) <= kLsb_V;
  }

  tools::RigLink link_;
  client::Session session_;
  std::array<double, client::kChambers> setpoint_Pa_{};
};

struct Injection {
  Fault fault;
  double detection_ms;                ///< by the default settings
  std::function<void(Scene&)> begin;  ///< at the onset
  bool stands = false;                ///< `begin` is done again after each tick
  bool since_said = false;            ///< onset: what came last
};

double ticks_beyond_first(std::uint16_t on_end) {
  return kTick_ms * (on_end - 1);
}

std::vector<Injection> injections() {
  const plenum::config::ChamberSettings chamber;
  const plenum::config::BoardSettings board;
  const double stale_ms = ticks_beyond_first(chamber.stale_limit_ticks);
  return {
      {Fault::emergency_stop, 0.0, [](Scene& s) { s.board().digital().set_emergency_stop(true); }},
      {Fault::hardware, 0.0,
       [](Scene& s) {
         s.by_power = true;
         s.board().analog_out().set_refusing(true);
       }},
      {Fault::over_pressure, ticks_beyond_first(chamber.over_pressure_ticks),
       [](Scene& s) {
         s.vents = true;
         s.board().plant(0).set_pressure_Pa(980e3);
       },
       true},
      {Fault::tick_overrun, ticks_beyond_first(board.overrun_limit_ticks),
       [](Scene& s) { s.board().delay_next_tick(); }, true},
      {Fault::pressure_out_of_range, 0.0, [](Scene& s) { s.board().plant(0).set_pressure_Pa(1e3); }, true},
      {Fault::pressure_stale, stale_ms, [](Scene& s) { s.board().analog_in().set_dead(kPressure, true); }},
      {Fault::pressure_stale, stale_ms,
       [](Scene& s) {  // the whole converter stands still
         for (std::size_t i = 0; i < plenum::kAnalogInputs; ++i) s.board().analog_in().set_dead(i, true);
       }},
      {Fault::position_out_of_range, 0.0,
       [](Scene& s) { s.board().plant(0).set_volume(plant::VolumeMotion(20e-3)); }},
      {Fault::position_stale, stale_ms, [](Scene& s) { s.board().analog_in().set_dead(kPosition, true); }},
      {Fault::bus_off, 0.0, [](Scene& s) { s.board().can().set_state(plenum::ports::CanState::bus_off); }},
      {Fault::heartbeat_lost, kHeartbeat_ms, [](Scene& s) { s.heartbeats = false; }, false, true},
      {Fault::setpoint_timeout, kTick_ms * board.setpoint_watchdog_ticks,
       [](Scene& s) { s.setpoints = false; }, false, true},
  };
}

/// From onset to safe [ms]. Throws when the outputs do not become safe, or for another reason.
double to_safe_ms(const Injection& injection, double phase) {
  Scene scene;
  do scene.cycle(phase);
  while (!scene.nothing_safe());
  double onset_s = scene.said_s;
  if (!injection.since_said) {
    scene.wait_for(phase);
    onset_s = scene.rig.now_s();
  }
  injection.begin(scene);
  if (injection.stands) scene.cause = [&] { injection.begin(scene); };
  for (int k = 0; k < 50; ++k) scene.cycle(phase);
  const plenum::safety::FaultSpec& spec = plenum::safety::spec(injection.fault);
  if (!scene.safe_s || scene.error_code() != spec.code) {
    throw std::runtime_error(fmt::format("{}: outputs {}, error {:04X}h, expected safe ones and {:04X}h",
                                         spec.name, scene.safe_s ? "safe" : "not safe", scene.error_code(),
                                         spec.code));
  }
  return 1e3 * (*scene.safe_s - onset_s);
}

/// Of a reading that is no number, which begins right after a tick [ms].
double not_finite_to_safe_ms(std::size_t channel) {
  plenum::Bench bench;
  bench.go_active(300.0);
  const auto safe = [&](float output_V) { return output_V == plenum::bench_settings().chamber[0].null_V; };
  bench.setpoint_kPa = 400.0;
  bench.run(3);
  const auto& held_V = bench.analog_out.held_V;
  if (std::any_of(held_V.begin(), held_V.end(), safe))
    throw std::runtime_error("an output was safe before the fault");
  bench.forced[channel] = plenum::ports::AnalogReading{std::numeric_limits<float>::quiet_NaN(), true};
  const int onset = bench.ticks;
  while (!std::all_of(held_V.begin(), held_V.end(), safe)) {
    bench.tick();
    if (bench.ticks > onset + 50) throw std::runtime_error("a reading that is no number has no safe output");
  }
  return kTick_ms * (bench.ticks - onset);
}

struct Worst {
  double value_ms = 0.0;
  void take(double ms) { value_ms = std::max(value_ms, ms); }
};

int run() {
  Worst response;
  Worst whole;
  const auto take = [&](const char* name, double worst_ms, double detection_ms) {
    fmt::print(stderr, "{:<30} {:7.2f} ms, of which {:5.1f} ms are detection by settings\n", name, worst_ms,
               detection_ms);
    response.take(worst_ms - detection_ms);
    whole.take(worst_ms);
  };
  for (const Injection& injection : injections()) {
    Worst worst;
    for (const double phase : {0.001, 0.5, 0.95}) worst.take(to_safe_ms(injection, phase));
    take(plenum::safety::spec(injection.fault).name, worst.value_ms, injection.detection_ms);
  }
  take(plenum::safety::spec(Fault::pressure_not_finite).name, not_finite_to_safe_ms(kPressure), 0.0);
  take(plenum::safety::spec(Fault::position_not_finite).name, not_finite_to_safe_ms(kPosition), 0.0);
  plenum::bench::print({"board.fault_to_safe_ms", response.value_ms, "ms", "lower", kTarget_ms});
  plenum::bench::print({"board.fault_to_safe_with_detection_ms", whole.value_ms, "ms"});
  return 0;
}

}  // namespace

int main() {
  try {
    return run();
  } catch (const std::exception& error) {
    fmt::print(stderr, "fault: {}\n", error.what());
    return 1;
  }
}
