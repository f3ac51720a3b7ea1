#include "host-sim/tools/demo_gap.hpp"

#include <cmath>
#include <thread>

#include "host-sim/client/calibration.hpp"
#include "host-sim/client/errors.hpp"
#include "host-sim/client/references.hpp"
#include "host-sim/diagnose/diagnose.hpp"
#include "host-sim/diagnose/found_rig.hpp"
#include "host-sim/identify/greybox.hpp"
#include "host-sim/identify/in_parallel.hpp"
#include "host-sim/rig/standard_rigs.hpp"
#include "host-sim/tools/inproc.hpp"
#include "host-sim/tools/recorded_log.hpp"
#include "host-sim/tools/watched_rig.hpp"

namespace plenum::host::tools {
namespace {

constexpr double kRecorded_s = 20.0;
constexpr double kFollowed_from_s = 22.0;  ///< since the machine was switched on: it has its model by then
constexpr double kFollowed_s = 8.0;
/// The latest valve below answers after six ticks.
constexpr std::uint8_t kPreview_ticks = 8;

struct Machine {
  const char* effect;
  std::map<std::string, double> figures;
};

/// Of sizes at which a user would complain.
std::vector<Machine> machines() {
  return {{"spool_lag", {{"natural_frequency_Hz", 12.0}}},
          {"dead_time", {{"delay_s", 0.03}}},
          {"valve_hysteresis", {{"width_V", 0.2}}},
          {"sensor_lag", {{"time_constant_s", 0.03}}},
          {"chamber_leak", {{"conductance_g_s_MPa", 1.0}}},
          {"area_shape", {{"inlet_slope", 1.0}}},
          {"volume_error", {{"offset_mL", 50.0}}},
          {"flow_function", {{"critical_ratio", 0.3}}},
          {"sensor_bias", {{"offset_kPa", 8.0}}},
          {"supply_droop", {{"resistance_kPa_s_per_g", 200.0}, {"recovery_s", 0.05}}}};
}

/// Records the machine, and gives it the data sheet's model.
trace::Log commission(WatchedRig& rig, const trace::ModelFile& configured, std::uint32_t seed) {
  const auto rows = client::capture(rig.session(), {.seconds = kRecorded_s, .seed = seed, .chambers = 1});
  rig.upload(configured, client::Doubted::force);
  return log_of(rows, 0, false);
}

GapTracked follow(WatchedRig& rig) {
  rig.pass_until(kFollowed_from_s);
  const auto reference_Pa = client::references(
      {.kind = client::ReferenceKind::random, .mean_Pa = 380e3, .amplitude_Pa = 110e3, .frequency_Hz = 2.0},
      1, kFollowed_s);
  GapTracked tracked{.error_Pa = rig.follow(reference_Pa, kPreview_ticks).front()};
  double squares = 0.0;
  for (std::size_t k = client::kOnsetRows; k < tracked.error_Pa.size(); ++k)
    squares += tracked.error_Pa[k] * tracked.error_Pa[k];
  tracked.rms_Pa = std::sqrt(squares / static_cast<double>(tracked.error_Pa.size() - client::kOnsetRows));
  return tracked;
}

/// What a sensor errs is no model's: it goes into the board's calibration.
void calibrate(client::Session& session, const trace::RigDescription& found) {
  const auto& bias = found.effects.at("sensor_bias");
  client::write_calibration(session, 0,
                            client::corrected(client::read_calibration(session, 0),
                                              {.offset_kPa = bias.at("offset_kPa"),
                                               .gain_error = bias.at("gain_error"),
                                               .ambient_kPa = found.ambient.pressure_Pa / 1e3}));
}

DemoGap close_gap(const trace::RigDescription& sheet, const Machine& machine, std::uint32_t seed) {
  DemoGap gap;
  gap.effect = machine.effect;
  gap.figures = machine.figures;
  trace::RigDescription real = sheet;
  real.effects[machine.effect] = machine.figures;
  const rig::RigConfig config = rig::thin_plate_rig(real, {.chambers = 1, .seed = seed});
  const trace::ModelFile configured = identify::greybox_of(sheet).file;

  WatchedRig rig(config, 1);
  const trace::Log log = commission(rig, configured, seed);
  gap.before = follow(rig);

  diagnose::DiagnoseOptions how;
  how.threads = 1;
  gap.report = diagnose::diagnose({{"recording", log}}, {}, sheet, how);
  const trace::RigDescription& found = gap.report.found;

  // Switched on anew it moves its volume alike, and both models meet the same: how much a valve must pass, and can, hangs on it.
  WatchedRig again(config, 1);
  commission(again, configured, seed);
  if (found.effects.contains("sensor_bias")) calibrate(again.session(), found);
  try {
    again.upload(identify::greybox_of(found).file);
    gap.uploaded = true;
  } catch (const client::Refused& refused) {
    gap.refusal = refused.what();
  }
  gap.after = follow(again);
  return gap;
}

}  // namespace

std::string named_by(const DemoGap& gap) {
  return gap.report.effects.empty() ? "nothing" : gap.report.effects.front().id;
}

std::vector<DemoGap> close_gaps(const trace::RigDescription& sheet, std::uint32_t seed,
                                const std::function<void(double done)>& progress) {
  const std::vector<Machine> all = machines();
  std::vector<DemoGap> gaps(all.size());
  identify::in_parallel(
      all.size(), std::thread::hardware_concurrency(),
      [&](std::size_t i) { gaps[i] = close_gap(sheet, all[i], seed + static_cast<std::uint32_t>(i)); },
      progress);
  return gaps;
}

}  // namespace plenum::host::tools
