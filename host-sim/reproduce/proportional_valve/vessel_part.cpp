#include <cmath>

#include "host-sim/plant/orifice.hpp"
#include "host-sim/plant/valve.hpp"
#include "host-sim/reproduce/proportional_valve/parts.hpp"

namespace plenum::host::reproduce::proportional_valve {
namespace {

using identify::orifice::Flow;

// The choked rate of A at 10 V by (8) to the letter, [1/s]-like: its dimension is off by the square root of a
// volume.
double printed_choked_rate(double area_m2) {
  const plant::Gas gas = plant::reference_atmosphere();
  const double RT = gas.specific_gas_constant_J_kg_K() * gas.temperature_K;
  return area_m2 * plant::kMpyeDischargeCoefficient * plant::choked_flow_function(1.4) *
         plant::kMpyeChargeExponent * std::sqrt(2.0 * RT / kVessel_m3);
}

// The same by the plant, whose valve and chamber know (4), (6) and (7).
double plants_choked_rate() {
  const plant::Gas gas = plant::reference_atmosphere();
  const double RT = gas.specific_gas_constant_J_kg_K() * gas.temperature_K;
  const plant::MpyeValve valve(plant::MpyeChannel::a, gas);
  const plant::PortFlows flows = valve.flows(valve.opening(10.0), kAmbient_Pa, kSupply_Pa, kAmbient_Pa);
  return valve.exponents().entering * RT / kVessel_m3 * flows.inlet_kg_s / kSupply_Pa;
}

// (9) to the letter: the sum runs from 0 to n.
int printed_terms(int n) {
  int terms = 0;
  for (int i = 0; i <= n; ++i) ++terms;
  return terms;
}

}  // namespace

Part vessel_part() {
  const double area_m2 = plant::kMpyeChannelAInlet.back().area_m2;
  const double rate_1_s =
      area_m2 * identify::orifice::choked_rate_of_area_1_s_m2(papers_vessel(Flow::kCharge)).value();
  constexpr int kAnyCount = 10;
  Part part;
  part.title = "(7) to (9): the pressure of the vessel, and the error";
  part.text =
      "(4) put into (7) gives pdot = A C_d psi P_u alpha sqrt(2 R T_0) / V: the volume stands outside of the "
      "root. R is not printed; P_a / (rho_0 T_0) of Table 1 gives 287.9 J/(kg K). Choked and wide open "
      "(Channel A, 10 V, 7 bar) the vessel fills at 11 MPa/s, in some 60 ms. (9) sums n + 1 terms and "
      "divides by n.";
  part.findings = {
      {.item = "(7), (4)",
       .quantity = "choked rate of charge at 10 V, Channel A",
       .unit = "1/s",
       .paper = rate_1_s,
       .ours = plants_choked_rate(),
       .tolerance = 1e-9,
       .source = Source::kTwoForms},
      {.item = "(8)",
       .quantity = "choked rate of charge at 10 V, Channel A, as printed",
       .unit = "1/s",
       .paper = rate_1_s,
       .ours = printed_choked_rate(area_m2),
       .tolerance = 0.005 * rate_1_s,
       .source = Source::kPapersOwnEquation,
       .why = "(8) prints sqrt(2 R T_0 / V); (4) in (7) gives sqrt(2 R T_0) / V. The printed form is off by "
              "sqrt(V) = 0.02 and has not the dimension of a pressure per second."},
      {.item = "(9)",
       .quantity = "terms of the sum beyond the n elements by which it is divided",
       .paper = 0.0,
       .ours = static_cast<double>(printed_terms(kAnyCount) - kAnyCount),
       .source = Source::kPapersOwnEquation,
       .why = "The sum of (9) runs from 0 to n, n + 1 terms, over n, which the nomenclature calls the number "
              "of elements."},
  };
  return part;
}

}  // namespace plenum::host::reproduce::proportional_valve
