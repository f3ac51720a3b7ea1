// The numbers that the paper prints of its valve.
#pragma once

#include "host-sim/identify/regulator_valve/branch.hpp"
#include "host-sim/identify/regulator_valve/discrete_model.hpp"
#include "host-sim/identify/regulator_valve/internal_parameters.hpp"

namespace plenum::host::reproduce::regulator_valve {

/// The models of both conditions that one method found.
struct PrintedModels {
  const char* method;
  identify::regulator_valve::DiscreteModel rising;   ///< b_0, a_1, a_2, a_3
  identify::regulator_valve::DiscreteModel falling;  ///< b_1, a_4, a_5, a_6

  const identify::regulator_valve::DiscreteModel& of(identify::regulator_valve::Direction direction) const {
    return direction == identify::regulator_valve::Direction::kRising ? rising : falling;
  }
};

/// (34)
inline const PrintedModels kPrintedLeastSquares{
    .method = "LS",
    .rising = {.b_Pa_m = 117420.7, .a = {-1.3735, -0.1457, 0.5200}, .sample_s = 0.005},
    .falling = {.b_Pa_m = 199160.3, .a = {-1.2985, -0.1678, 0.4677}, .sample_s = 0.005}};
/// (38)
inline const PrintedModels kPrintedSwarm{
    .method = "PSO",
    .rising = {.b_Pa_m = 421310.6, .a = {-1.3733, -0.1456, 0.5219}, .sample_s = 0.005},
    .falling = {.b_Pa_m = 311826.7, .a = {-1.2977, -0.1677, 0.4677}, .sample_s = 0.005}};

/// The four decimals of the a leave 1 + a_1 + a_2 + a_3 known to this, at worst.
inline constexpr double kResidueRounding = 1.5e-4;

/// Table 2, in the units printed.
inline const identify::regulator_valve::InternalParameters kTable2LeastSquares{.diaphragm_area_m2 = 17.77e-3,
                                                                               .plunger_mass_kg = 17.30e-3,
                                                                               .spool_mass_kg = 16.79e-3,
                                                                               .plunger_spring_N_m = 2607.56,
                                                                               .spool_spring_N_m = 2702.85,
                                                                               .inlet_width_m = 8.2e-9,
                                                                               .exhaust_width_m = 14.3e-6};
inline const identify::regulator_valve::InternalParameters kTable2Swarm{.diaphragm_area_m2 = 18.57e-3,
                                                                        .plunger_mass_kg = 17.30e-3,
                                                                        .spool_mass_kg = 16.77e-3,
                                                                        .plunger_spring_N_m = 2607.63,
                                                                        .spool_spring_N_m = 2705.23,
                                                                        .inlet_width_m = 29.4e-9,
                                                                        .exhaust_width_m = 23.4e-6};

/// Section 4.
inline constexpr double kPrintedSlope_Pa_m = 1.56e8;
inline constexpr double kPrintedTimeConstant_s = 0.15;
inline constexpr double kPrintedDeadBand_m = 0.9e-3;
/// (11), gauge.
inline constexpr double kPrintedLow_Pa = 0.894e5;
inline constexpr double kPrintedHigh_Pa = 3.224e5;

}  // namespace plenum::host::reproduce::regulator_valve
