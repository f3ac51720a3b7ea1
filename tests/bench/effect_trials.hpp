// Rigs with one effect of the catalogue each, and what a board makes of them in closed loop.
//
// A rig is four thin-plate chambers on moving volumes, with one effect alone at a size at which a user would complain. It follows
// three references with the same preview: a trapezoid, a sine of 2 Hz, and a filtered random one. The RMS error is that of the
// chamber's true pressure at the ends of the ticks, not of the sensor's.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "host-sim/client/calibration.hpp"
#include "host-sim/rig/standard_rigs.hpp"
#include "host-sim/tools/watched_rig.hpp"
#include "host-sim/trace/model_json.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::bench {

namespace trace = host::trace;

struct EffectTrial {
  const char* effect;
  bool answerable;  ///< by a controller
  std::map<std::string, double> figures;
};

inline constexpr const char* kSensorBias = "sensor_bias";

/// Sizes between barely seen and gross, as the blind cases draw them.
inline std::vector<EffectTrial> effect_trials() {
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

/// Chambers of a trial's rig, and the references' length.
inline constexpr unsigned kChambers = 4;
inline constexpr std::size_t kRows = 1000;

inline host::rig::RigConfig effect_rig(const trace::RigDescription& real) {
  return host::rig::thin_plate_rig(real, {.chambers = kChambers, .volume_swing = 0.1});
}

/// Slopes of 300 kPa/s at most or thereabouts: with what the volumes ask for, less than the slowest chamber's exhaust does at full
/// opening (800 kPa/s with the bent curve, at 340 kPa). A valve at its limit is no model's fault.
inline std::vector<double> effect_reference_Pa(int kind, unsigned chamber) {
  constexpr double kTick_s = 0.01;
  std::vector<double> series(kRows);
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

/// RMS error [kPa] of a rig that is `real` with this model in every chamber. Of the effects of the rig as it is `known` a sensor's bias
/// goes into the board's calibration.
inline double tracking_rms_kPa(const trace::RigDescription& real, const trace::RigDescription& known,
                               const trace::ModelFile& model,
                               host::client::Doubted doubted = host::client::Doubted::refuse) {
  constexpr int kKinds = 3;
  constexpr std::size_t kSkip = 100;  // the way onto the reference
  constexpr std::uint8_t kPreview_ticks = 8;
  host::tools::WatchedRig rig(effect_rig(real), kChambers);
  rig.upload(model, doubted);
  if (const auto bias = known.effects.find(kSensorBias); bias != known.effects.end()) {
    for (std::uint8_t c = 0; c < kChambers; ++c) {
      host::client::write_calibration(
          rig.session(), c,
          host::client::corrected(host::client::read_calibration(rig.session(), c),
                                  {.offset_kPa = bias->second.at("offset_kPa"),
                                   .ambient_kPa = 1e-3 * known.ambient.pressure_Pa}));
    }
  }
  double squares = 0.0;
  std::size_t rows_counted = 0;
  for (int kind = 0; kind < kKinds; ++kind) {
    std::vector<std::vector<double>> references;
    for (unsigned c = 0; c < kChambers; ++c) references.push_back(effect_reference_Pa(kind, c));
    for (const std::vector<double>& errors_Pa : rig.follow(references, kPreview_ticks)) {
      for (std::size_t k = kSkip; k < errors_Pa.size(); ++k) {
        squares += std::pow(1e-3 * errors_Pa[k], 2);
        ++rows_counted;
      }
    }
  }
  return std::sqrt(squares / static_cast<double>(rows_counted));
}

inline double median(std::vector<double> of) {
  std::sort(of.begin(), of.end());
  const std::size_t half = of.size() / 2;
  return of.size() % 2 != 0 ? of[half] : 0.5 * (of[half - 1] + of[half]);
}

}  // namespace plenum::bench
