#include <cmath>

#include "host-sim/plant/orifice.hpp"
#include "host-sim/plant/servo/orifice_constants.hpp"
#include "host-sim/reproduce/samples.hpp"
#include "host-sim/reproduce/servo/parts.hpp"

namespace plenum::host::reproduce::servo {
namespace {

using namespace plant::servo;

constexpr double kAir_J_kg_K = 287.0;
constexpr double kUniversal_J_mol_K = 8.314;
constexpr double kArea_m2 = 5e-6;
constexpr double kDischarge = 0.72;
constexpr double kSupply_Pa = 700e3;
constexpr double kTemperature_K = 293.15;
// half of the last digits of C1 and C2 together, of the flow; P_cr sits where the flow is flat
constexpr double kDigits = 5e-7 / kPrintedForAir.choked + 5e-7 / kPrintedForAir.subsonic;

}  // namespace

Part orifice_part() {
  const OrificeConstants air = orifice_constants(1.4, kAir_J_kg_K);
  const OrificeConstants universal = orifice_constants(1.4, kUniversal_J_mol_K);
  const double edge = kPrintedForAir.critical_ratio;
  const double jump = kPrintedForAir.subsonic * std::pow(edge, 1.0 / 1.4) *
                          std::sqrt(1.0 - std::pow(edge, 0.4 / 1.4)) / kPrintedForAir.choked -
                      1.0;

  Part part;
  part.title = "(2), (3): flow through an orifice and its constants";
  part.text =
      "C1, C2 and P_cr in closed form for k = 1.4 and R = 287 J/(kg K). The cylinder's valve flows through "
      "the thin plate of plant/orifice, "
      "which is (2) with other letters.";
  const auto constant = [&](const char* name, const char* unit, double paper, double ours, double digits) {
    part.findings.push_back({.item = "(3)",
                             .quantity = name,
                             .unit = unit,
                             .paper = paper,
                             .ours = ours,
                             .tolerance = digits,
                             .source = Source::kPapersOwnEquation});
  };
  constant("C1 of air", "sqrt(K) s/m", kPrintedForAir.choked, air.choked, 5e-7);
  constant("C2 of air", "sqrt(K) s/m", kPrintedForAir.subsonic, air.subsonic, 5e-7);
  constant("P_cr of air", "", kPrintedForAir.critical_ratio, air.critical_ratio, 5e-4);
  part.findings.push_back({.item = "(3)",
                           .quantity = "C2 with R the universal gas constant",
                           .unit = "sqrt(K) s/m",
                           .paper = kPrintedForAir.subsonic,
                           .ours = universal.subsonic,
                           .tolerance = 5e-7,
                           .source = Source::kPapersOwnEquation,
                           .why = "The text under (2) calls R the universal gas constant; (3) gives the "
                                  "printed C1 and C2 only with air's "
                                  "own 287 J/(kg K)."});
  part.findings.push_back(
      {.item = "text above (2)",
       .quantity = "critical ratio of upstream to downstream pressure",
       .paper = kPrintedForAir.critical_ratio,
       .ours = 1.0 / air.critical_ratio,
       .tolerance = 5e-4,
       .source = Source::kPapersOwnEquation,
       .why =
           "The text chokes above P_cr as upstream over downstream, (2) at and below P_cr as downstream over "
           "upstream. With 0.528 the text would choke every flow; (3) gives (2) right."});
  part.findings.push_back({.item = "(2)",
                           .quantity = "jump of the flow at P_cr with the printed constants, of the flow",
                           .paper = 0.0,
                           .ours = jump,
                           .tolerance = kDigits,
                           .source = Source::kPapersOwnEquation});

  plant::Gas gas;
  gas.compressibility = 1.0;
  gas.molar_mass_kg_mol = gas.universal_gas_constant_J_mol_K / kAir_J_kg_K;
  const plant::ThinPlate plate(plant::thin_plate_constants(gas, kDischarge));
  report::Curve ours{.name = "thin plate of the plant", .x = {}, .y = {}};
  report::Curve paper{.name = "(2), printed constants", .x = {}, .y = {}, .stroke = report::Stroke::kPoints};
  double largest = 0.0;
  for (int i = 4; i < 100; ++i) {
    const double ratio = 0.01 * i;
    const double flow = kArea_m2 * plate.phi(kSupply_Pa, ratio * kSupply_Pa);
    const double printed = orifice_flow_kg_s(kPrintedForAir, 1.4, kDischarge * kArea_m2, kSupply_Pa,
                                             ratio * kSupply_Pa, kTemperature_K);
    largest = greater_of(largest, std::abs(flow / printed - 1.0));
    ours.x.push_back(ratio);
    ours.y.push_back(1e3 * flow);
    if (i % 4 == 0) {
      paper.x.push_back(ratio);
      paper.y.push_back(1e3 * printed);
    }
  }
  part.findings.push_back({.item = "(2)",
                           .quantity = "largest difference of the plant's flow from (2), of the flow",
                           .paper = 0.0,
                           .ours = largest,
                           .tolerance = kDigits});
  part.charts.push_back(report::XyChart{.title = "Flow of air through 5 mm2 from 7 bar",
                                        .x = {"Downstream over upstream pressure", ""},
                                        .y = {"Mass flow", "g/s"},
                                        .curves = {ours, paper},
                                        .marks = {{report::Mark::On::kX, air.critical_ratio, "P_cr"}}});
  return part;
}

}  // namespace plenum::host::reproduce::servo
