// What a model knows of valve, sensor and supply, besides the chamber.
//
// A model states the valve's dead time, a grey-box model also a spool on a spring, a hysteresis, a sensor's lag and the supply's
// line. Of one that leaves the dead time out the regulator's own stands.
//
// A spool of natural frequency f and damping z is late by z/(pi f) in all: by the area above its step response. Half of it
// is taken as a lag, which ValvePath makes up for, half as a delay, which a Smith predictor looks over. (A double pole at w
// is two lags of 1/w, and z/(pi f) is 2/w there. Making up for all of it would ask for the second derivative of the spool's
// way.) A lag beyond kMostLag_ticks is delay, too: to make up for more would send commands of more than four times the way.
#pragma once

#include "firmware/config/greybox_parameters.hpp"
#include "firmware/config/limits.hpp"
#include "firmware/config/model_image.hpp"
#include "firmware/control/supply_line.hpp"
#include "firmware/control/valve_path.hpp"

namespace plenum::control {

struct ModelPaths {
  ValvePath::Config valve;
  Scalar sensor_lag_ticks = 0;
  SupplyLine::Config supply{};
};

/// Of parameters that config::validate() has passed; `delay_ticks`: the regulator's own.
inline ModelPaths paths_of(const config::ModelParameters& parameters, Scalar delay_ticks) noexcept {
  constexpr Scalar kMostLag_ticks = Scalar(config::kMostSpoolLag_ticks);
  constexpr Scalar kTicks_per_s = Scalar(1) / Scalar(config::kTick_s);
  constexpr Scalar kPi = Scalar(3.14159265358979);
  const auto dead_s = config::dead_time_s(parameters);
  const Scalar dead_ticks = dead_s ? Scalar(*dead_s) * kTicks_per_s : delay_ticks;
  if (parameters.kind != config::ModelKind::greybox)
    return {.valve = {.dead_ticks = dead_ticks}, .sensor_lag_ticks = 0, .supply = {}};
  const auto of = config::scalars(parameters);
  const Scalar spool_ticks = of[config::kSpoolDamping] * of[config::kSpoolPeriod] / kPi * kTicks_per_s;
  const Scalar lag_ticks = numeric::min(Scalar(0.5) * spool_ticks, kMostLag_ticks);
  return {.valve = {.dead_ticks = dead_ticks + spool_ticks - lag_ticks,
                    .lag_ticks = lag_ticks,
                    .play_V = of[config::kHysteresis]},
          .sensor_lag_ticks = of[config::kSensorLag] * kTicks_per_s,
          .supply = {.supply_kPa = of[config::kSupply],
                     .resistance_s_L = of[config::kSupplyResistance],
                     .recovery_ticks = of[config::kSupplyRecovery] * kTicks_per_s,
                     .followed_share = of[config::kSupplyFollowed]}};
}

}  // namespace plenum::control
