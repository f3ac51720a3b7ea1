// Numbers of the paper's prose that follow from others of it.
#include <numbers>

#include "host-sim/reproduce/actuators/parts.hpp"

namespace plenum::host::reproduce::actuators {
namespace {

constexpr double kNewtonPerPound = 4.4482216;
constexpr double kPascalPerPsi = 6894.757;

}  // namespace

Part numbers_of_the_text() {
  Part part{
      .title = "Sections I and V: the numbers of the text",
      .text =
          "What the text states as a number and what follows from its other numbers. Nothing of ours is "
          "in it: where the two are apart, the paper contradicts itself.",
      .findings = {}};
  const double area_m2 = std::numbers::pi * 0.025 * 0.025;
  const auto own = [&](Finding finding) {
    finding.source = Source::kPapersOwnEquation;
    part.findings.push_back(std::move(finding));
  };
  own({.item = "I",
       .quantity = "85 psi",
       .unit = "kPa",
       .paper = 590.0,
       .ours = 85e-3 * kPascalPerPsi,
       .tolerance = 5.0});
  own({.item = "I",
       .quantity = "force of a cylinder of 5 cm at 590 kPa above room",
       .unit = "N",
       .paper = 1160.0,
       .ours = 590e3 * area_m2,
       .tolerance = 5.0});
  own({.item = "I",
       .quantity = "that force in pounds",
       .unit = "lb",
       .paper = 260.0,
       .ours = 590e3 * area_m2 / kNewtonPerPound,
       .tolerance = 5.0});
  own({.item = "Fig. 3",
       .quantity = "P_c, 90 psi",
       .unit = "kPa",
       .paper = 620.0,
       .ours = 90e-3 * kPascalPerPsi,
       .tolerance = 5.0});
  own({.item = "Fig. 3",
       .quantity = "P_r, 14.7 psi",
       .unit = "kPa",
       .paper = 100.0,
       .ours = 14.7e-3 * kPascalPerPsi,
       .tolerance = 5.0});
  own({.item = "V",
       .quantity = "joints driven: 44 without the 6 of the hands",
       .paper = 38.0,
       .ours = 44.0 - 6.0});
  own({.item = "V", .quantity = "valves: two for each of 38 joints", .paper = 76.0, .ours = 2.0 * 38.0});
  own({.item = "V",
       .quantity = "sensors: 76 of pressure and 38 of angle",
       .paper = 114.0,
       .ours = 76.0 + 38.0});
  own({.item = "V",
       .quantity = "rate of the loop: 20 kHz in blocks of 200",
       .unit = "Hz",
       .paper = 100.0,
       .ours = 20e3 / 200.0});
  own({.item = "V.B",
       .quantity = "valve-chamber pairs whose steady state was measured",
       .paper = 78.0,
       .ours = 2.0 * 38.0,
       .why = "V.B says all 78; two for each of 38 joints are 76, which V, V.C, V.D and the caption of "
              "Fig. 10 say"});
  own({.item = "V.C",
       .quantity = "data points in 100 s",
       .paper = 1e5,
       .ours = 100.0 * 20e3 / 200.0,
       .why = "the loop averages 20 kHz by 200 to 100 Hz, so 100 s are 1e4 points, not 1e5"});
  own({.item = "V.D", .quantity = "integration sequences", .paper = 3648.0, .ours = 76.0 * 48.0});
  return part;
}

}  // namespace plenum::host::reproduce::actuators
