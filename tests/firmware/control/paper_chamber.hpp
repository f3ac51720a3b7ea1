// A chamber that follows the equations of the 9-parameter model, and differs from it in known ways. In double.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "tests/firmware/control/admissible.hpp"

namespace plenum::control::testing {

/// c1..c9, c_gamma, P_c, P_r like those of an MPYE valve.
inline constexpr std::array<float, 12> kMpyeLike = {5.0F,  0.6F, 1.5F,  0.0F, 0.0F,   0.01F,
                                                    40.0F, 0.1F, 0.02F, 0.1F, 620.0F, 101.3F};

/// p' = (s - p) r + leak - 1.4 p v'/v: the paper's equations, and the compression that they leave out. The valve's command is late by `delay_ticks`, then loses `play_V` at each reversal, then the spool
/// follows it with the time constant `lag_ticks`, off by `valve_offset_V`; the sensor follows the pressure with
/// `sensor_lag_ticks`. 50 substeps a tick.
struct PaperChamber {
  std::array<float, 12> parameters = kMpyeLike;
  double pressure_kPa = 300;
  double leak_kPa_s = 0;
  double valve_offset_V = 0;
  double delay_ticks = 0;
  double play_V = 0;
  double lag_ticks = 0;
  double sensor_lag_ticks = 0;
  std::vector<double> sent_V = std::vector<double>(32, 5.0);
  double held_V = 5;
  double place_V = 5;
  double shown_kPa = 300;

  /// Returns the mean over the tick, as the averaging sensor reads it.
  double tick(double command_V, double volume_mL, double volume_rate_mL_s) {
    sent_V.push_back(command_V);
    RandomChamber shape{.parameters = parameters,
                        .volume_mL = static_cast<float>(volume_mL),
                        .volume_rate_mL_s = static_cast<float>(volume_rate_mL_s),
                        .pressure_kPa = 0};
    constexpr int kSteps = 50;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double ago = std::ceil(delay_ticks - static_cast<double>(i) / kSteps - 1e-9);
      const double u = sent_V[sent_V.size() - 1 - static_cast<std::size_t>(std::max(ago, 0.0))];
      held_V = std::clamp(held_V, u - 0.5 * play_V, u + 0.5 * play_V);
      const double before_V = place_V;
      place_V = lag_ticks > 0 ? held_V + (place_V - held_V) * std::exp(-1.0 / (lag_ticks * kSteps)) : held_V;
      const double acting_V = 0.5 * (lag_ticks > 0 ? before_V + place_V : 2.0 * place_V) - valve_offset_V;
      const auto [s, r] = reference(shape, acting_V);
      // the compression that the model leaves out: -1.4 p v'/v
      const double drift = leak_kPa_s - 1.4 * pressure_kPa * volume_rate_mL_s / volume_mL;
      const double end = s + drift / r + (pressure_kPa - s - drift / r) * std::exp(-r * 0.01 / kSteps);
      const double middle = 0.5 * (pressure_kPa + end);
      const double shown = sensor_lag_ticks > 0
                               ? middle + (shown_kPa - middle) * std::exp(-1.0 / (sensor_lag_ticks * kSteps))
                               : middle;
      sum += sensor_lag_ticks > 0 ? 0.5 * (shown_kPa + shown) : middle;
      shown_kPa = shown;
      pressure_kPa = end;
    }
    return sum / kSteps;
  }
};

}  // namespace plenum::control::testing
