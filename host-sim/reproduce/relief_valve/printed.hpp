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

/// A row of Table V.
struct PrintedTest {
  const char* test;
  double from_l_min, to_l_min, change_l_min;
  double worst_percent, final_percent;  ///< errors of its grey-box model, of the pressure
  const char* in_doubt = nullptr;       // what the scan may have damaged in the flows
};
/// Table V as the scan has it, but that 4 stands there as k or L; in the order of table_v() (recorded.hpp).
inline constexpr PrintedTest kTable5[] = {
    {"1", 9.3, 89.0, 79.7, 9.3, 0.0},
    {"5", 7.0, 100.3, 92.7, 22.0, 4.9,
     "the scan reads 7.0 to 100.3, a change of 93.3 l/min; 7.6 would give the change printed, and a digit "
     "may be "
     "damaged"},
    {"3", 77.0, 94.0, 16.9, 4.0, -0.7,
     "the scan reads 77 to 94, without the tenths that most flows have; one may be lost"},
    {"4", 65.8, 88.6, 22.8, 6.0, -2.1},
    {"2", 85.6, 107.8, 22.2, 6.0, -2.9},
    {"6", 99.7, 78.0, 23.7, 1.95, 7.0,
     "the scan reads 99.7 to 78, a change of 21.7 l/min; 76 would give the change printed, and a digit may "
     "be "
     "damaged"},
    {"7", 107.8, 84.4, 23.4, 2.52, 2.1}};

}  // namespace plenum::host::reproduce::relief_valve
