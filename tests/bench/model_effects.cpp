// model.effect_rmse_shrink_*: what a closed loop gains when the board's model is told of an effect.
//
// For each effect of the catalogue: a simulated rig of four thin-plate chambers on moving volumes, with that effect alone, at a
// size at which a user would complain. Two grey-box models are uploaded over CAN, that of the rig as its data sheet has it and
// that of the rig with the effect (identify::greybox_of, what `plenum diagnose --save-model` writes), and each follows the same
// references with the same preview: a trapezoid, a sine of 2 Hz, and a filtered random one. A sensor's bias goes into the board's
// calibration instead, as by `plenum calibrate`. The RMS error is that of the chamber's true pressure at the ends of the ticks,
// not of the sensor's. Both regulators learn while they run (trim, disturbance, compression): what that makes up for is no gain
// of the model.
//
// The effects that a controller can answer are those of valve, supply, line and sensor that delay, shift or distort what it
// commands or reads; the others are in the chamber's physics, which the model has or has not. Both medians count 1 for an effect
// for which the board has nothing. The figures are the rig's own: what an identification would add to the error is not in it.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "host-sim/client/calibration.hpp"
#include "host-sim/identify/greybox.hpp"
#include "host-sim/rig/standard_rigs.hpp"
#include "host-sim/tools/watched_rig.hpp"
#include "tests/bench/row.hpp"

namespace {

using namespace plenum::host;

constexpr unsigned kChambers = 4;
constexpr double kMeanVolume_m3 = 172e-6;  // of the four of thin_plate_rig()
constexpr double kTick_s = 0.01;
constexpr std::size_t kRows = 1000;
constexpr std::size_t kSkip = 100;  // the way onto the reference
constexpr std::uint8_t kPreview_ticks = 8;

using Series = std::vector<double>;
using Figures = std::map<std::string, double>;

struct Trial {
  const char* effect;
  bool answerable;  ///< by a controller
  Figures figures;
};

constexpr const char* kSensorBias = "sensor_bias";

/// Sizes between barely seen and gross, as the blind cases draw them.
std::vector<Trial> trials() {
  return {{"spool_lag", true, {{"natural_frequency_Hz", 12.0}, {"damping", 0.8}}},
          {"dead_time", true, {{"delay_s", 0.025}}},
          {"valve_hysteresis", true, {{"width_V", 0.2}}},
          {"null_drift", true, {{"drift_at_60_s_V", 0.4}}},
          {"supply_droop", true, {{"resistance_kPa_s_per_g", 30.0}}},
          {"tube_dynamics", true, {{"length_m", 3.0}, {"bore_mm", 4.0}}},
          {"sensor_lag", true, {{"time_constant_s", 0.03}}},
          {kSensorBias, true, {{"offset_kPa", 5.0}}},
          {"area_shape", false, {{"inlet_slope", 1.0}, {"inlet_curve", -0.5}, {"exhaust_slope", -0.5}}},
          {"flow_function", false, {{"critical_ratio", 0.3}, {"subsonic_index", 0.7}}},
          {"exhaust_backpressure", false, {{"resistance_kPa_s_per_g", 30.0}}},
          {"chamber_leak", false, {{"conductance_g_s_MPa", 0.5}}},
          {"heat_transfer", false, {{"conductance_W_K", 0.5}}},
          {"volume_error", false, {{"offset_mL", 30.0}}}};
}

/// Slopes of 300 kPa/s at most or thereabouts: with what the volumes ask for, less than the slowest chamber's exhaust does at full
/// opening (800 kPa/s with the bent curve, at 340 kPa). A valve at its limit is no model's fault.
Series reference(int kind, unsigned chamber) {
  Series series(kRows);
  for (std::size_t k = 0; k < kRows; ++k) {
    const double t = kTick_s * static_cast<double>(k);
    double value_kPa = 400.0;
    if (kind == 0) {  // ramps of 0.4 s between two pressures, each held for 0.6 s
      const double phase = std::fmod(t + 0.1 * chamber, 2.0);
      const double up = std::clamp((phase - 0.2) / 0.4, 0.0, 1.0);
      const double down = std::clamp((phase - 1.2) / 0.4, 0.0, 1.0);
      value_kPa += 120.0 * (up - down - 0.5);
    } else if (kind == 1) {
      value_kPa += 25.0 * std::sin(2.0 * std::numbers::pi * 2.0 * t);
    } else {
      for (int i = 0; i < 12; ++i) {
        const double omega = 2.0 * std::numbers::pi * (0.2 + 0.23 * i);
        value_kPa += 8.0 * std::sin(omega * t + 1.7 * i * i + chamber);
      }
    }
    series[k] = 1e3 * value_kPa;
  }
  return series;
}
constexpr int kKinds = 3;

/// RMS error [kPa] of a rig that is `real` with the models of a rig as it is `known`.
double rms_kPa(const trace::RigDescription& real, const trace::RigDescription& known) {
  tools::WatchedRig rig(rig::thin_plate_rig(real, {.chambers = kChambers, .volume_swing = 0.1}), kChambers);
  rig.upload(identify::greybox_of(known, {}, kMeanVolume_m3).file);
  if (const auto bias = known.effects.find(kSensorBias); bias != known.effects.end()) {
    for (std::uint8_t c = 0; c < kChambers; ++c) {
      client::write_calibration(rig.session(), c,
                                client::corrected(client::read_calibration(rig.session(), c),
                                                  {.offset_kPa = bias->second.at("offset_kPa"),
                                                   .ambient_kPa = 1e-3 * known.ambient.pressure_Pa}));
    }
  }
  double squares = 0.0;
  std::size_t rows_counted = 0;
  for (int kind = 0; kind < kKinds; ++kind) {
    std::vector<Series> references;
    for (unsigned c = 0; c < kChambers; ++c) references.push_back(reference(kind, c));
    for (const Series& errors_Pa : rig.follow(references, kPreview_ticks)) {
      for (std::size_t k = kSkip; k < errors_Pa.size(); ++k) {
        squares += std::pow(1e-3 * errors_Pa[k], 2);
        ++rows_counted;
      }
    }
  }
  return std::sqrt(squares / static_cast<double>(rows_counted));
}

double median(std::vector<double> of) {
  std::sort(of.begin(), of.end());
  const std::size_t half = of.size() / 2;
  return of.size() % 2 != 0 ? of[half] : 0.5 * (of[half - 1] + of[half]);
}

}  // namespace

int main() {
  const trace::RigDescription sheet;
  fmt::print(stderr, "no effect: {:.2f} kPa RMS\n", rms_kPa(sheet, sheet));
  std::vector<double> of_all, of_answerable;
  for (const Trial& trial : trials()) {
    trace::RigDescription real = sheet;
    real.effects[trial.effect] = trial.figures;
    const auto left_out = identify::greybox_of(real).left_out;
    const bool answered = left_out.empty() || left_out.front() == kSensorBias;
    const double without_kPa = rms_kPa(real, sheet);
    const double with_kPa = answered ? rms_kPa(real, real) : without_kPa;
    const double ratio = with_kPa / without_kPa;
    of_all.push_back(ratio);
    if (trial.answerable) of_answerable.push_back(ratio);
    fmt::print(stderr, "{}: {:.2f} kPa RMS without, {:.2f} with{}\n", trial.effect, without_kPa, with_kPa,
               answered ? "" : ": the board has nothing for it");
    if (answered)
      plenum::bench::print({fmt::format("model.effect_rmse_shrink.{}", trial.effect), ratio, "x"});
  }
  plenum::bench::print({"model.effect_rmse_shrink_median", median(of_answerable), "x", "lower", 0.5});
  plenum::bench::print({"model.effect_rmse_shrink_median_catalogue", median(of_all), "x"});
}
