#include <algorithm>
#include <cmath>

#include "host-sim/plant/mpye_tables.hpp"
#include "host-sim/plant/orifice.hpp"
#include "host-sim/reproduce/proportional_valve/parts.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::proportional_valve {
namespace {

using plant::EllipsePort;

constexpr double kGamma = 1.4;
constexpr double kPrintedPsiMax = 0.484;
constexpr double kPrintedCriticalRatio = 0.528;
constexpr double kThirdDigit = 0.0005;
constexpr std::size_t kPoints = 401;

double critical_ratio(double gamma) {
  return std::pow(2.0 / (gamma + 1.0), gamma / (gamma - 1.0));
}

// psi of (3), from the plant's thin plate.
double ideal_flow_function(double ratio) {
  const plant::Gas gas = plant::reference_atmosphere();
  const plant::ThinPlate plate(plant::thin_plate_constants(gas, 1.0));
  const double RT = gas.specific_gas_constant_J_kg_K() * gas.temperature_K;
  return plate.phi(1e5, ratio * 1e5) / 1e5 / std::sqrt(2.0 / RT);
}

// psi_e of (6) as read, from the plant's port.
double flow_function(double ratio, double b, double a, double beta) {
  const EllipsePort port{plant::choked_flow_function(kGamma), b, a, beta};
  return port.flux(1e5, ratio * 1e5).flow / 1e5;
}

// (6) to the letter, its P_d read as P_d / P_u, without which it has no dimension.
double printed_flow_function(double ratio, double b, double a, double beta) {
  if (ratio <= b) return kPrintedPsiMax;
  if (ratio >= a) return 0.0;
  return kPrintedPsiMax * (1.0 - std::pow((ratio - b) / (a - b), beta));
}

// The quarter ellipse of ISO 6358, in shares of its maximum.
double iso_share(double ratio, double b) {
  if (ratio <= b) return 1.0;
  const double xi = (ratio - b) / (1.0 - b);
  return std::sqrt(std::max(1.0 - xi * xi, 0.0));
}

template <class F, class G>
double greatest_distance(const F& f, const G& g) {
  double distance = 0.0;
  // The end is left out: there (6) is a chord over the last 1e-5, plant/orifice.hpp.
  for (const double r : evenly(0.0, 0.999, kPoints)) distance = greater_of(distance, std::abs(f(r) - g(r)));
  return distance;
}

// (5) against (4): the choked mass flow of both, for one area and upstream pressure.
double conductance_over_choked_flow() {
  const plant::Gas gas = plant::reference_atmosphere();
  const double RT = gas.specific_gas_constant_J_kg_K() * gas.temperature_K;
  const double exponent = (kGamma + 1.0) / (kGamma - 1.0);
  const double conductance_times_density = std::sqrt(kGamma / RT * std::pow(2.0 / (kGamma + 1.0), exponent));
  return conductance_times_density / (plant::choked_flow_function(kGamma) * std::sqrt(2.0 / RT));
}

report::XyChart figure_2() {
  const std::vector<double> r = evenly(0.0, 1.0, kPoints);
  report::XyChart chart{
      .title = "Fig. 2: flow function",
      .caption = "(3), the ellipse (6) at b = 0.528, a = 1, beta = 1/2, and (6) as it is printed.",
      .x = {"Pressure ratio P_d / P_u", ""},
      .y = {"Flow function psi", ""}};
  chart.curves = {
      {"ideal orifice (3)", r, over(r, ideal_flow_function)},
      {"ellipse (6)", r, over(r, [](double x) { return flow_function(x, kPrintedCriticalRatio, 1.0, 0.5); }),
       report::Stroke::kDashed},
      {"(6) as printed", r,
       over(r, [](double x) { return printed_flow_function(x, kPrintedCriticalRatio, 1.0, 0.5); }),
       report::Stroke::kDotted},
      {"printed maximum",
       {kPrintedCriticalRatio},
       {kPrintedPsiMax},
       report::Stroke::kPoints,
       report::Ink::kNeutral}};
  return chart;
}

report::XyChart figure_3() {
  const std::vector<double> r = evenly(0.0, 1.0, kPoints);
  report::XyChart chart{.title = "Fig. 3: what b, a and beta do",
                        .caption = "(6) as read; the paper does not print which values its figure shows.",
                        .x = {"Pressure ratio P_d / P_u", ""},
                        .y = {"Flow function psi_e", ""}};
  const auto add = [&](const char* name, double b, double a, double beta) {
    chart.curves.push_back({name, r, over(r, [=](double x) { return flow_function(x, b, a, beta); })});
  };
  add("b 0.528, a 1, beta 0.5", 0.528, 1.0, 0.5);
  add("b 0.2", 0.2, 1.0, 0.5);
  add("a 0.8", 0.528, 0.8, 0.5);
  add("beta 0.25", 0.528, 1.0, 0.25);
  add("beta 1", 0.528, 1.0, 1.0);
  return chart;
}

}  // namespace

Part flow_function_part() {
  const auto iso = [](double r) { return iso_share(r, kPrintedCriticalRatio); };
  Part part;
  part.title = "(1) to (6), Fig. 2 and 3: flow through an orifice";
  part.text =
      "The plant's thin plate gives (1) to (3), its ellipse port (4) and (6). (6) is printed as psi_max [1 - "
      "((P_d - b)/(a - "
      "b))^beta]. Two things are lost in it: P_d must be the ratio P_d/P_u to be compared with b, and the "
      "fraction must be "
      "squared inside, the index outside of the bracket: [1 - ((r - b)/(a - b))^2]^beta. Only so does beta = "
      "1/2 reproduce the "
      "ISO function, as the text says, a quarter of an ellipse. Everything else here uses that reading.";
  part.findings = {
      {.item = "(2), Table 1",
       .quantity = "psi_max",
       .paper = kPrintedPsiMax,
       .ours = plant::choked_flow_function(kGamma),
       .tolerance = kThirdDigit},
      {.item = "Fig. 2",
       .quantity = "P_cr",
       .paper = kPrintedCriticalRatio,
       .ours = critical_ratio(kGamma),
       .tolerance = kThirdDigit},
      {.item = "(3)",
       .quantity = "jump of psi at the choked limit",
       .paper = 0.0,
       .ours = ideal_flow_function(critical_ratio(kGamma) + 1e-9) -
               ideal_flow_function(critical_ratio(kGamma) - 1e-9),
       .tolerance = 1e-9},
      {.item = "(5)",
       .quantity = "C rho_0 over the choked flow of (4)",
       .paper = 1.0,
       .ours = conductance_over_choked_flow(),
       .tolerance = 1e-12,
       .source = Source::kTwoForms},
      {.item = "(6) as read",
       .quantity = "greatest distance to the ISO ellipse at beta = 1/2, of psi_max",
       .paper = 0.0,
       .ours = greatest_distance(
           [](double r) {
             return flow_function(r, kPrintedCriticalRatio, 1.0, 0.5) / plant::choked_flow_function(kGamma);
           },
           iso),
       .tolerance = 1e-12},
      {.item = "(6) as printed",
       .quantity = "greatest distance to the ISO ellipse at beta = 1/2, of psi_max",
       .paper = 0.0,
       .ours = greatest_distance(
           [](double r) {
             return printed_flow_function(r, kPrintedCriticalRatio, 1.0, 0.5) / kPrintedPsiMax;
           },
           iso),
       .tolerance = kThirdDigit,
       .source = Source::kDoubtfulReading,
       .why = "The text says that beta = 1/2 reproduces the theoretical and the ISO function; (6) to the "
              "letter, with the ratio for P_d, is 1 - ((r - b)/(a - b))^beta, convex where the ellipse is "
              "concave. An exponent was lost, in the paper or in the text of it that we have."},
      {.item = "(3), (6)",
       .quantity = "greatest distance of the ellipse to the ideal orifice, of psi_max",
       .paper = 0.0,
       .ours = greatest_distance(
           [](double r) { return ideal_flow_function(r) / plant::choked_flow_function(kGamma); }, iso),
       .tolerance = 5.0 / 700.0,
       .why = "The ellipse approximates (3); the tolerance is the text's own 5 kPa of 700 kPa."},
  };
  part.charts = {figure_2(), figure_3()};
  return part;
}

}  // namespace plenum::host::reproduce::proportional_valve
