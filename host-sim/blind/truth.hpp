// The blind machine: the first paper's physics written a third time, with departures, at a fine step.
//
//   m'  = C a phi(p_u, p_d), phi the thin-plate flow (1), constants (11)-(13)                [kg/s]
//   a_c = L_c + w smax((B_c (x - U_c) - L_c)/w), a_r likewise in U_r - x    (3), a gain a port  [m2]
//   p'  = kappa R T/v m' - kappa v'/v p                                      (4)              [Pa/s]
//
// Symbols: p chamber pressure, absolute [Pa]; v its volume [m3]; x spool in volts of command [V]; U thresholds
// [V]; B area per volt [m2/V]; L leak [m2]; w width of the transition [m2]; C discharge coefficient; R gas
// constant of air over its compressibility [J/(kg K)]; T temperature [K]; kappa 1.4.
// Assumptions: one temperature, unless WallHeat; supply and ambient constant, unless a departure says otherwise.
// Range: chambers of 20 mL to 1 L, 1 to 10 bar, ports to 12 mm2.
// Numerical treatment: Runge-Kutta of order 4 at kStep_s, a step being parted where the command jumps in it, so that
// delays may be any fraction of one; halving the step moves a row by less than 5 Pa (test). At pressure ratio 1 the flow's
// slope is infinite: there the result chatters by less than 1 Pa in the mean over a tick.
// Source: "Modeling and Identification of Pneumatic Actuators", (1)-(4), (11)-(13), Table II.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "host-sim/blind/departures.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::blind {

inline constexpr double kStep_s = 5e-5;
inline constexpr double kKappa = 1.4;
/// Z R / M of Table II [J/(kg K)].
inline constexpr double kGasConstant_J_kg_K = 0.99 * 8.31 / 0.029;

/// phi of (1) for the discharge coefficient 1 [kg/(s m2)]; negative when p_d > p_u.
double thin_plate_flux(double upstream_Pa, double downstream_Pa, double temperature_K);

/// Area of one port; `opening_V` is x - U_c or U_r - x.
double port_area(double opening_V, double area_per_V_m2, double leak_m2, double transition_m2);

/// v(t) = mean (1 + sum share sin(2 pi f t + phase)).
struct Motion {
  struct Tone {
    double share = 0.0;
    double frequency_Hz = 0.0;
    double phase = 0.0;
  };
  double mean_m3 = 1e-4;
  std::array<Tone, 2> tones{};

  double at(double time_s) const;
  double rate(double time_s) const;
  bool moves() const { return tones[0].share != 0.0 || tones[1].share != 0.0; }
};

/// What every real recording has and no catalogue lists; all 0: none.
struct Clutter {
  double command_lsb_V = 0.0;    ///< of the DAC: the log says what was asked
  double pressure_lsb_Pa = 0.0;  ///< of a row
  double volume_lsb_m3 = 0.0;    ///< of a row
  double jitter_s = 0.0;         ///< a command acts up to this late, evenly spread
  double ripple_Pa = 0.0;        ///< amplitude of the supply's ripple
  double ripple_Hz = 0.0;
  double ripple_phase = 0.0;
  std::uint64_t seed = 0;
};

struct Machine {
  trace::RigDescription rig;  ///< with the true valve
  Motion motion;              ///< as logged
  Departures departures;
  Clutter clutter;
  double initial_Pa = 101325.0;  ///< half a second before the first row
};

/// Command of row `row`, given the reading of that row.
using Driver = std::function<double(std::size_t row, double pressure_Pa)>;

/// Columns of a log without noise and rounding; row k is at k/rate.
struct Rows {
  std::vector<double> command_V;
  std::vector<double> pressure_Pa;
  std::vector<double> volume_m3;
};

/// Runs the machine from half a second before its first row, under the first row's command, which the driver gives
/// for initial_Pa. Throws std::invalid_argument when a tick or the averaging time is no multiple of `step_s`.
Rows simulate(const Machine& machine, std::size_t rows, const Driver& driver, double step_s = kStep_s);

/// The same commands again.
Driver replay(const std::vector<double>& command_V);

}  // namespace plenum::host::blind
