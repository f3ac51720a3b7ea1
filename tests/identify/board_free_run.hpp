// A model in free run as the board has it: chamber, valve and sensor, in the board's own code and scalar.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "firmware/control/any_model.hpp"
#include "firmware/control/model_paths.hpp"
#include "firmware/control/sensor_lag.hpp"
#include "firmware/control/sent_commands.hpp"
#include "firmware/control/supply_line.hpp"

namespace plenum::host::testing {

/// What the sensor shows in the mean of each tick [kPa], from a chamber, a valve and a sensor that rest at `start_kPa` and at the
/// first command [V]; volume [mL] and its speed [mL/s] at the middle of each tick.
inline std::vector<double> board_free_run_kPa(const plenum::config::ModelParameters& parameters,
                                              double start_kPa, std::span<const double> command_V,
                                              std::span<const double> volume_mL,
                                              std::span<const double> volume_rate_mL_s) {
  namespace control = plenum::control;
  control::AnyModel room;
  const control::PressureModel& model = *room.take_over(parameters, 0.0F, 10.0F);
  const control::ModelPaths paths = control::paths_of(parameters, 0.0F);
  control::ValvePath valve;
  control::SentCommands sent;
  control::SensorLag sensor;
  control::SupplyLine line;
  valve.configure(paths.valve);
  valve.reset(static_cast<float>(command_V.front()));
  sent.configure(valve.delay_ticks());
  line.configure(paths.supply, sent.part_ticks());
  sent.reset(static_cast<float>(command_V.front()));
  sensor.configure(paths.sensor_lag_ticks, 1.0F);
  plenum::numeric::Scalar pressure_kPa = static_cast<float>(start_kPa);
  sensor.reset(pressure_kPa);
  std::vector<double> shown_kPa;
  for (std::size_t k = 0; k < command_V.size(); ++k) {
    sent.push({.model_V = valve.sent(static_cast<float>(command_V[k]))});
    const control::Prediction next =
        sent.past_tick(model, pressure_kPa,
                       {.volume_mL = static_cast<float>(volume_mL[k]),
                        .volume_rate_mL_s = static_cast<float>(volume_rate_mL_s[k])},
                       line);
    shown_kPa.push_back(static_cast<double>(sensor.pass(pressure_kPa, next)));
    pressure_kPa = next.end_kPa;
  }
  return shown_kPa;
}

}  // namespace plenum::host::testing
