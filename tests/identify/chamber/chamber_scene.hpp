// A scene of one log that the nominal model itself has read: the chamber of a rig file's defaults.
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <random>
#include <vector>

#include "host-sim/identify/chamber/fit.hpp"

namespace plenum::host::identify::chamber {

/// Commands that jump all over the valve's range every quarter of a second.
inline std::vector<double> jumping_V(std::size_t rows, unsigned seed = 1) {
  std::mt19937 bits(seed);
  std::vector<double> command_V;
  for (std::size_t row = 0; row < rows; ++row) {
    command_V.push_back(row % 25 == 0 ? 4.3 + 1.2 * static_cast<double>(bits()) / 4294967296.0
                                      : command_V.back());
  }
  return command_V;
}

/// 150 mL, swinging by `swing_m3` at 0.9 Hz.
inline Scene chamber_scene(const std::vector<double>& command_V, double swing_m3) {
  Scene scene = make_scene({});
  std::vector<double> volume_m3;
  for (std::size_t row = 0; row < command_V.size(); ++row) {
    const double t = 0.01 * static_cast<double>(row);
    volume_m3.push_back(150e-6 + swing_m3 * std::sin(2.0 * std::numbers::pi * 0.9 * t));
  }
  Record record;
  record.name = "chamber";
  record.drive = effects::make_drive(command_V, volume_m3, {.tick_s = 0.01, .average_s = 0.01, .steps = 4});
  record.measured_Pa.resize(command_V.size());
  record.fitted_rows = command_V.size();
  record.measured_Pa = run(scene, record, 0, scene.nominal, {3e5});
  add_record(scene, std::move(record));
  return scene;
}

}  // namespace plenum::host::identify::chamber
