// The chamber that these tests run: the default figures of a rig, and drives for it.
#pragma once

#include <cmath>
#include <complex>
#include <random>
#include <span>
#include <vector>

#include "host-sim/effects/chamber_model.hpp"
#include "host-sim/effects/free_run.hpp"
#include "host-sim/plant/orifice.hpp"
#include "host-sim/plant/volume_motion.hpp"

namespace plenum::host::effects {

inline constexpr double kTick_s = 0.01;
inline constexpr double kGain_m2_V = 1e-6;
inline constexpr double kSupply_Pa = 700000.0;
inline constexpr double kAmbient_Pa = 101325.0;

/// Of the thin plate: choked flow over area and upstream pressure.
inline double choked_s_m() {
  const Surroundings around;
  return plant::thin_plate_constants(around.gas, around.discharge_coefficient).beta_s_m;
}

inline EffectSet only(Id id) {
  return EffectSet{1} << id;
}

/// The valve of a rig file's defaults, every effect at the value at which it vanishes.
inline Figures nominal() {
  Figures figures = neutral_figures();
  const double valve[] = {5.08, 4.92, 1.5e-6, 1.6e-6, 3.0e-8, 3.0e-8, 5.0e-8};
  std::copy(std::begin(valve), std::end(valve), figures.begin());
  return figures;
}

/// A valve without leak and with sharp corners: an area is gain times opening.
inline Figures sharp_valve(double gain_m2_V) {
  Figures figures = nominal();
  figures[kOpenAbove] = 5.0;
  figures[kExhaustBelow] = 5.0;
  figures[kInletGain] = gain_m2_V;
  figures[kExhaustGain] = gain_m2_V;
  figures[kInletLeak] = 0.0;
  figures[kExhaustLeak] = 0.0;
  figures[kTransition] = 1e-18;
  return figures;
}

inline Figures sealed() {
  return sharp_valve(0.0);
}

/// `values` in the units of the parameters' names.
inline Figures with(Figures figures, Id id, std::initializer_list<double> values) {
  std::size_t k = 0;
  for (const double value : values) {
    figures[kFirstFigure[id] + k] = kCatalogue[id]->parameters[k].coordinate_of(value);
    ++k;
  }
  return figures;
}

/// Commands that jump all over the valve's range every quarter of a second.
inline std::vector<double> jumping_command_V(std::size_t rows, unsigned seed = 1) {
  std::mt19937 bits(seed);
  std::vector<double> command_V;
  for (std::size_t row = 0; row < rows; ++row) {
    command_V.push_back(row % 25 == 0 ? 3.0 + 4.0 * static_cast<double>(bits()) / 4294967296.0
                                      : command_V.back());
  }
  return command_V;
}

inline plant::VolumeMotion swinging_volume() {
  return plant::VolumeMotion(150e-6,
                             {{{.amplitude_m3 = 45e-6, .frequency_Hz = 0.9, .phase_rad = 0.3}, {}, {}}});
}

inline plant::VolumeMotion still_volume() {
  return plant::VolumeMotion(20e-3, {{{}, {}, {}}});
}

inline Drive drive_of(const std::vector<double>& command_V, const plant::VolumeMotion& volume, int steps) {
  Drive drive{command_V, {}, {.tick_s = kTick_s, .average_s = kTick_s, .steps = steps}};
  const std::size_t ends = (command_V.size() - 1) * static_cast<std::size_t>(steps) + 1;
  for (std::size_t i = 0; i < ends; ++i) {
    drive.volume_m3.push_back(volume.at(static_cast<double>(i) * kTick_s / steps).volume_m3);
  }
  return drive;
}

/// Readings of the one chamber, a row a tick; row 0 is start_Pa.
inline std::vector<double> run(EffectSet on, const Figures& figures, const Drive& drive, double start_Pa,
                               const Surroundings& around = {}, double start_warmth_Pa = 0.0) {
  ChamberModel<double> model(around, drive.timing, on, figures.data(), start_Pa, drive.command_V.front(),
                             drive.volume_m3.front(), start_warmth_Pa);
  std::vector<double> reading_Pa{start_Pa};
  for (std::size_t row = 0; row + 1 < drive.command_V.size(); ++row) {
    const std::size_t first = row * static_cast<std::size_t>(drive.timing.steps);
    reading_Pa.push_back(model.tick(drive.command_V[row], std::span(drive.volume_m3).subspan(first)));
  }
  return reading_Pa;
}

/// Of a second-order lag, w t after its input has stepped from 0 to 1.
inline double step_response(double wt, double damping) {
  if (damping == 1.0) return 1.0 - (1.0 + wt) * std::exp(-wt);
  const std::complex<double> gap = std::sqrt(std::complex<double>(damping * damping - 1.0));
  const std::complex<double> a = -damping + gap;
  const std::complex<double> b = -damping - gap;
  return 1.0 - ((a * std::exp(b * wt) - b * std::exp(a * wt)) / (a - b)).real();
}

/// Its mean from `from` over `span` of w t, by Simpson's rule in 200 pieces.
inline double mean_step_response(double from, double span, double damping) {
  constexpr int kPieces = 200;
  double sum = 0.0;
  for (int i = 0; i <= kPieces; ++i) {
    const double weight = i == 0 || i == kPieces ? 1.0 : (i % 2 == 1 ? 4.0 : 2.0);
    sum += weight * step_response(from + span * i / kPieces, damping);
  }
  return sum / (3.0 * kPieces);
}

inline double rms_difference(std::span<const double> a, std::span<const double> b) {
  double squares = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) squares += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(squares / static_cast<double>(a.size()));
}

inline double RT(const Surroundings& around = {}) {
  return around.gas.specific_gas_constant_J_kg_K() * around.gas.temperature_K;
}

/// Net flow into a chamber so large that its pressure stands still [kg/s]: after `ticks`, over the last of them.
inline double flow_kg_s(EffectSet on, const Figures& figures, double command_V, double pressure_Pa,
                        const Surroundings& around = {}, int ticks = 1) {
  constexpr double kVolume_m3 = 1000.0;
  const Timing timing{.tick_s = kTick_s, .average_s = 0.0, .steps = 4};
  const std::vector<double> volume_m3(5, kVolume_m3);
  ChamberModel<double> model(around, timing, on, figures.data(), pressure_Pa, command_V, kVolume_m3);
  double before_Pa = pressure_Pa;
  for (int k = 0; k < ticks; ++k) {
    before_Pa = model.pressure_Pa();
    model.tick(command_V, volume_m3);
  }
  return (model.pressure_Pa() - before_Pa) * kVolume_m3 / (1.4 * RT(around) * kTick_s);
}

}  // namespace plenum::host::effects
