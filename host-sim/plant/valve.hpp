// The valve: for a command, the opening of its two ports; for an opening and the pressures, the two port
// flows.
//
// Thin-plate valve, areas smooth in the command:
//   a_c(u) = L_c + w smax((B_c (u - U_c) - L_c) / w)                                                (3a)
//   a_r(u) = L_r + w smax((B_r (U_r - u) - L_r) / w),    smax(x) = (sqrt(x^2 + 1) + x) / 2          (3b)
//   mdot_c = a_c phi(P_c, p) into the chamber, mdot_r = a_r phi(p, P_r) out of it                   (4b)
// The paper writes one gain B for both ports and no w: its form is B_c = B_r and w = 1 in its unit of area.
//
// Measured valve (FESTO MPYE-5-3/8-010-B): A, b, a, beta of (B4), (B6) tabulated at 0, 0.2 .. 10 V for the
// inlet and the exhaust of channels A and B, interpolated linearly in the command; C_d = 0.575. The command
// is clamped to the tables.
//   * Rows with A = 0 were not measured: their b = 0.528, a = 1, beta = 0.5 are placeholders. They take those
//     of the nearest row with A > 0, so that next to such a row the area closes at constant flow shape.
//     Interpolating the placeholders would open the port, while its area shrinks, to pressure ratios at which
//     neither neighbour conducts (a from 0.187 to 1), and the flow would not fall monotonically to zero.
//   * Channel B conducts supply below 5 V. Mirrored, it is read at 10 V - u: the second channel of a 5/3
//     valve driven by an inverted signal, so that its pressure too rises with the command.
//
// Gas entering the chamber heats it by compression, gas leaving cools it: the flow term of the chamber
// carries an exponent for each direction, kappa for both in (4a), alpha_in = 1.4 and alpha_ex = 1 in (B7). It
// follows the actual direction of the flow, so that air drawn backwards through the exhaust carries alpha_in.
// Vanishes: no flow at zero area, at equal pressures, and for the measured valve beyond the cracking ratio.
// Source: "Modeling and Identification of Pneumatic Actuators" (3), (4b); B: "Parameter Identification and
// Evaluation of a Proportional Directional Flow Control Valve Model", (4), (6), (7), Tables 1 to 5.
#pragma once

#include <array>
#include <variant>

#include "host-sim/plant/gas.hpp"
#include "host-sim/plant/mpye_tables.hpp"
#include "host-sim/plant/orifice.hpp"

namespace plenum::host::plant {

/// The two port flows of a chamber, and their slopes with respect to its pressure.
struct PortFlows {
  double inlet_kg_s = 0.0;  ///< from the supply into the chamber
  double inlet_slope_kg_s_Pa = 0.0;
  double exhaust_kg_s = 0.0;  ///< from the chamber to ambient
  double exhaust_slope_kg_s_Pa = 0.0;
};

/// Exponents of the flow term of the chamber, by direction of the gas.
struct FlowExponents {
  double entering = 1.4;
  double leaving = 1.4;
};

/// Data-sheet figures of a thin-plate valve: the [valve] table of a rig.
struct ThinPlateValveConfig {
  double open_above_V = 5.08;             ///< U_c
  double exhaust_below_V = 4.92;          ///< U_r
  double inlet_area_per_V_m2 = 1.5e-6;    ///< B_c
  double exhaust_area_per_V_m2 = 1.6e-6;  ///< B_r
  double inlet_leak_m2 = 3.0e-8;          ///< L_c
  double exhaust_leak_m2 = 3.0e-8;        ///< L_r
  double transition_m2 = 5.0e-8;          ///< w; 0: a sharp corner
  double discharge_coefficient = 0.72;    ///< C
};

/// (1) with (3). Throws std::invalid_argument naming the field when a figure is out of range.
class ThinPlateValve {
 public:
  struct Opening {
    double inlet_m2 = 0.0;
    double exhaust_m2 = 0.0;
  };

  explicit ThinPlateValve(const ThinPlateValveConfig& config, const Gas& gas = {});

  Opening opening(double command_V) const;

  PortFlows flows(const Opening& opening, double pressure_Pa, double supply_Pa, double ambient_Pa) const {
    const Flux inlet = plate_.flux(supply_Pa, pressure_Pa);
    const Flux exhaust = plate_.flux(pressure_Pa, ambient_Pa);
    return {opening.inlet_m2 * inlet.flow, opening.inlet_m2 * inlet.by_second,
            opening.exhaust_m2 * exhaust.flow, opening.exhaust_m2 * exhaust.by_first};
  }

  FlowExponents exponents() const { return {plate_.constants().kappa, plate_.constants().kappa}; }
  const ThinPlateValveConfig& config() const { return config_; }

 private:
  ThinPlateValveConfig config_;
  ThinPlate plate_;
};

enum class MpyeChannel { a, b_mirrored };

/// The measured valve. `gas` gives R T_0 and gamma of (B2), (B4).
class MpyeValve {
 public:
  struct Opening {
    EllipsePort inlet;
    EllipsePort exhaust;
  };

  explicit MpyeValve(MpyeChannel channel, const Gas& gas = reference_atmosphere());

  /// For channel B the tables are read at 10 V - command_V.
  Opening opening(double command_V) const;

  PortFlows flows(const Opening& opening, double pressure_Pa, double supply_Pa, double ambient_Pa) const {
    const Flux inlet = opening.inlet.flux(supply_Pa, pressure_Pa);
    const Flux exhaust = opening.exhaust.flux(pressure_Pa, ambient_Pa);
    return {inlet.flow, inlet.by_second, exhaust.flow, exhaust.by_first};
  }

  FlowExponents exponents() const { return {kMpyeChargeExponent, kMpyeDischargeExponent}; }
  MpyeChannel channel() const { return channel_; }

 private:
  using Ports = std::array<EllipsePort, kMpyeRows>;

  MpyeChannel channel_;
  Ports inlet_;
  Ports exhaust_;
};

using Valve = std::variant<ThinPlateValve, MpyeValve>;

}  // namespace plenum::host::plant
