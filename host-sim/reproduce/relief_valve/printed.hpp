// The constants of the paper's static models, as printed: pounds force, inches and seconds.
#pragma once

#include "host-sim/plant/relief_valve/grey_box.hpp"
#include "host-sim/plant/relief_valve/inch_units.hpp"

namespace plenum::host::reproduce::relief_valve {

namespace units = plant::relief_valve;

/// sqrt(rho/2) of Table II's footnote [sqrt(lbf) s/in2]: 54 lb/ft3, 865 kg/m3.
inline constexpr double kPrintedRootHalfDensity = 0.00636;
inline constexpr double kPrintedDensity_kg_m3 = 2.0 * kPrintedRootHalfDensity * kPrintedRootHalfDensity *
                                                units::kPoundForce_N / (units::kInch2_m2 * units::kInch2_m2);

struct PrintedStatic {
  double k1;  ///< [in2/psi]
  double k2;  ///< [s/(in sqrt(psi))]
  double k3;  ///< [in2]
};

plant::relief_valve::StaticGreyBox in_si(const PrintedStatic& printed);

/// Table I: fig. 3 curves A, B, C; fig. 4 curves A, B. Read from a scan: the exponents of B and C in fig. 3
/// and of B in fig. 4 are those that double k1 and keep k3/k1.
inline constexpr PrintedStatic kFig3[] = {
    {1.26e-5, 4.85e-6, -3.57e-3}, {2.52e-5, 4.85e-6, -3.57e-3}, {5.04e-5, 4.85e-6, -3.57e-3}};
inline constexpr PrintedStatic kFig4[] = {{1.26e-5, 4.85e-6, -3.57e-3}, {1.26e-4, 4.85e-6, -3.57e-2}};

/// Rated flow of the valves tested, 100 l/min.
inline constexpr double kRatedFlow_m3_s = 100.0 * units::kLitrePerMinute_m3_s;

}  // namespace plenum::host::reproduce::relief_valve
