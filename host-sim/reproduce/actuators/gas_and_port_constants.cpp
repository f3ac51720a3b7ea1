// (11)-(13) and Table II, and what (1) claims of the function they make.
#include <algorithm>
#include <cmath>

#include "host-sim/plant/gas.hpp"
#include "host-sim/plant/orifice.hpp"
#include "host-sim/reproduce/actuators/illustrated.hpp"
#include "host-sim/reproduce/actuators/parts.hpp"
#include "host-sim/reproduce/actuators/printed.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::actuators {
namespace {

/// d/dx of sqrt(x^(2/kappa) - x^((kappa+1)/kappa)), the shape of (1c), at the choked limit x = 1/theta.
double slope_of_shape_when_choked(double kappa) {
  const double x = 1.0 / printed::theta(kappa);
  const double square = std::pow(x, 2.0 / kappa) - std::pow(x, (kappa + 1.0) / kappa);
  return (2.0 / kappa * std::pow(x, 2.0 / kappa - 1.0) - (kappa + 1.0) / kappa * std::pow(x, 1.0 / kappa)) /
         (2.0 * std::sqrt(square));
}

/// Largest difference of the plant's flow from (1) with (11)-(13), of the choked flow, outside of its laminar
/// neighbourhood of equal pressures.
double largest_difference_of_plant(const plant::ThinPlateConstants& constants) {
  const plant::ThinPlate plate(constants);
  double most = 0.0;
  for (const double ratio : evenly(0.05, 8.0, 4001)) {
    if (std::abs(ratio - 1.0) < 2.0 * plant::kLaminarBelow) continue;
    const double p_u = ratio * kAmbient_Pa;
    const double choked = printed::beta({}) * std::max(p_u, kAmbient_Pa);
    most =
        greater_of(most, std::abs(plate.phi(p_u, kAmbient_Pa) - printed::phi(p_u, kAmbient_Pa, {})) / choked);
  }
  return most;
}

}  // namespace

Part gas_and_port_constants() {
  const plant::Gas gas;
  const plant::ThinPlateConstants air = plant::thin_plate_constants(gas);
  Part part{.title = "(11)-(13) and Table II: the constants of the thin-plate port",
            .text =
                "The gas of the plant, and alpha, beta, theta from it. Table II leaves the temperature "
                "open; ours is 20 degC. The paper prints no value of alpha, beta, theta: the plant's stand "
                "beside (11)-(13) written a second time, letter by letter, and what the paper says of the "
                "function they make is put to it: the two branches of (1c) and their slopes meet at theta, "
                "for every kappa. The one printed number that depends on their size is the scale of Fig. 3 "
                "and 4 (see Fig. 4).",
            .findings = {}};
  const auto set_to = [&](const char* quantity, const char* unit, double paper, double ours) {
    part.findings.push_back({.item = "Table II",
                             .quantity = quantity,
                             .unit = unit,
                             .paper = paper,
                             .ours = ours,
                             .source = Source::kSetToPaper});
  };
  const printed::TableTwo table;
  set_to("M, molar mass", "kg/mol", table.M, gas.molar_mass_kg_mol);
  set_to("R, universal gas constant", "Pa m3/(mol K)", table.R, gas.universal_gas_constant_J_mol_K);
  set_to("C, discharge coefficient", "", table.C, plant::ThinPlateValveConfig{}.discharge_coefficient);
  set_to("Z, compressibility", "", table.Z, gas.compressibility);
  set_to("kappa, ratio of specific heats", "", table.kappa, gas.kappa);

  const auto constant = [&](const char* item, const char* quantity, const char* unit, double paper,
                            double ours) {
    part.findings.push_back({.item = item,
                             .quantity = quantity,
                             .unit = unit,
                             .paper = paper,
                             .ours = ours,
                             .tolerance = 1e-12 * paper,
                             .instead = "the equation with Table II, 20 degC",
                             .why = "the plant does not compute what the equation says"});
  };
  constant("(11)", "alpha of the plant", "s/m", printed::alpha(table), air.alpha_s_m);
  constant("(12)", "beta of the plant", "s/m", printed::beta(table), air.beta_s_m);
  constant("(13)", "theta of the plant", "", printed::theta(table.kappa), air.theta);

  double jump = 0.0;
  double slope = 0.0;
  for (const double kappa : evenly(1.05, 1.67, 32)) {
    const printed::TableTwo other{.kappa = kappa};
    const double theta = printed::theta(kappa);
    const double below = printed::z(theta * (1.0 - 1e-15), 1.0, other);
    jump = greater_of(jump, std::abs(below / (printed::beta(other) * theta) - 1.0));
    slope = greater_of(slope, std::abs(slope_of_shape_when_choked(kappa)));
  }
  const auto meets = [&](const char* quantity, double ours) {
    part.findings.push_back({.item = "(1c), (11)-(13)",
                             .quantity = quantity,
                             .paper = 0.0,
                             .ours = ours,
                             .tolerance = 1e-12,
                             .source = Source::kPapersOwnEquation,
                             .why = "alpha, beta and theta of (11)-(13) do not join the branches of (1c)"});
  };
  meets("jump of the flow at p_u/p_d = theta, of the flow there, kappa 1.05 to 1.67", jump);
  meets("slope of the subsonic shape by p_d/p_u at theta, kappa 1.05 to 1.67", slope);
  part.findings.push_back(
      {.item = "(1)",
       .quantity = "largest difference of the plant's flow from (1), (11)-(13) as printed, of choked flow",
       .paper = 0.0,
       .ours = largest_difference_of_plant(air),
       .tolerance = 1e-12});
  const auto chord = [&](double off) {
    return printed::phi(kAmbient_Pa * (1.0 + off), kAmbient_Pa, table) / (kAmbient_Pa * off);
  };
  part.findings.push_back(
      {.item = "II.A.1",
       .quantity =
           "\"continuously differentiable\": slope at equal pressures, a hundred times nearer to them",
       .paper = 1.0,
       .ours = chord(1e-8) / chord(1e-6),
       .tolerance = 0.01,
       .source = Source::kPapersOwnEquation,
       .why = "(1c) is a square root of the pressure difference at p_u = p_d: its slope there has no bound "
              "(ten times as steep a hundred times nearer). The plant takes the chord within 1e-5 of equal "
              "pressures"});
  part.findings.push_back({.item = "(4a), Table II",
                           .quantity = "R that (4a) needs so that it is the same gas as in (11)",
                           .unit = "J/(kg K)",
                           .paper = table.R,
                           .ours = table.Z * table.R / table.M,
                           .tolerance = 0.005,
                           .source = Source::kPapersOwnEquation,
                           .why = "(4a) multiplies R T/v with a mass flow in kg/s, so its R is Z R/M of "
                                  "(11), not the molar R of Table II: as printed the pressure would "
                                  "change 34 times too slowly"});
  return part;
}

}  // namespace plenum::host::reproduce::actuators
