#include <cmath>
#include <string>

#include "host-sim/reproduce/relief_valve/parts.hpp"
#include "host-sim/reproduce/relief_valve/printed.hpp"

namespace plenum::host::reproduce::relief_valve {
namespace {

struct Row {
  const char* valve;
  PrintedStatic printed;
  PrintedStatic half_digit;  // half a unit of the last digit printed
  double cracks_psi, cracks_half_digit;
  double maximum_psi, maximum_half_digit;
  const char* maximum_in_doubt = nullptr;  // why one of the numbers may not be the paper's
};

// Read from the scan, where 4 stands as k or L; 10^-5 for k1 of RV-21 is that of Table I, where it stands
// clearly. RV-9 has k3 = 0 and cracks at 0 psi: one says the other.
constexpr Row kTable2[] = {
    {"RV-9, increasing",
     {4.24e-7, 3.21e-6, 0.0},
     {5e-10, 5e-9, 0.0},
     0.0,
     0.5,
     2000.0,
     5.0,
     "0.00636/k2 of the k2 read is 1981 psi; k2 = 3.18e-6 would give 2000 psi, which may be rounded, or the "
     "scan may have damaged a digit of k2"},
    {"RV-9, decreasing",
     {4.82e-7, 2.93e-6, 0.0},
     {5e-10, 5e-9, 0.0},
     0.0,
     0.5,
     1870.0,
     5.0,
     "0.00636/k2 of the k2 read is 2171 psi; 1870 psi would take k2 = 3.40e-6, and a digit of either may be "
     "damaged in the scan"},
    {"RV-21, increasing", {1.26e-5, 4.85e-6, -3.57e-3}, {5e-8, 5e-9, 5e-6}, 283.3, 0.05, 1310.0, 5.0},
    {"RV-21, decreasing", {1.26e-5, 4.59e-6, -4.53e-3}, {5e-8, 5e-9, 5e-6}, 360.0, 0.5, 1385.0, 2.5},
    {"RV-22, increasing", {9.09e-6, 4.36e-6, -1.25e-2}, {5e-9, 5e-9, 5e-5}, 1370.0, 5.0, 1460.0, 5.0},
    {"RV-22, decreasing", {4.04e-6, 3.43e-6, -5.05e-3}, {5e-9, 5e-9, 5e-6}, 1250.0, 5.0, 1850.0, 5.0},
};

}  // namespace

Part cracking_and_maximum() {
  Part part{.title = "Table II: cracking and maximum pressures",
            .text =
                "P_c = -k3/k1 and P_m = sqrt(rho/2)/k2 from the printed constants. The tolerance is half a "
                "unit of the last digit of "
                "every number that enters. The scan leaves the exponent of k1 of RV-21 to be guessed; "
                "it follows from Table I. RV-9 is printed with k3 = 0 and with a cracking pressure of 0, of "
                "which one says the other.",
            .findings = {}};
  for (const Row& row : kTable2) {
    const auto valve = in_si(row.printed);
    const double cracks_psi = cracking_pressure_Pa(valve) / units::kPsi_Pa;
    const double maximum_psi = maximum_pressure_Pa(valve) / units::kPsi_Pa;
    if (row.printed.k3 != 0.0) {
      const double k3_part = std::abs(row.half_digit.k3 / row.printed.k3);
      part.findings.push_back(
          {.item = "Table II",
           .quantity = std::string("cracking pressure, ") + row.valve,
           .unit = "psi",
           .paper = row.cracks_psi,
           .ours = cracks_psi,
           .tolerance = row.cracks_half_digit + cracks_psi * (k3_part + row.half_digit.k1 / row.printed.k1),
           .source = Source::kPapersOwnEquation,
           .why = "-k3/k1 of the printed constants is not the printed pressure"});
    }
    part.findings.push_back(
        {.item = "Table II",
         .quantity = std::string("maximum pressure, ") + row.valve,
         .unit = "psi",
         .paper = row.maximum_psi,
         .ours = maximum_psi,
         .tolerance = row.maximum_half_digit +
                      maximum_psi * (row.half_digit.k2 / row.printed.k2 + 0.5e-5 / kPrintedRootHalfDensity),
         .source = row.maximum_in_doubt == nullptr ? Source::kPapersOwnEquation : Source::kDoubtfulReading,
         .why = row.maximum_in_doubt == nullptr ? "0.00636/k2 of the printed k2 is not the printed pressure"
                                                : row.maximum_in_doubt});
  }
  part.findings.push_back({.item = "text to Table II",
                           .quantity = "maximum pressure by the text's 6.36e-6/k2, RV-21 increasing",
                           .unit = "psi",
                           .paper = 1310.0,
                           .ours = 6.36e-6 / 4.85e-6,
                           .tolerance = 5.0,
                           .source = Source::kDoubtfulReading,
                           .why =
                               "the text reads 6.36e-6 where the footnote of Table II has 0.00636; only the "
                               "latter gives the table, and the scan may have damaged the exponent"});
  return part;
}

}  // namespace plenum::host::reproduce::relief_valve
