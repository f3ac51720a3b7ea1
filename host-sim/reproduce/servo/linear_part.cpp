#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "host-sim/plant/servo/cylinder.hpp"
#include "host-sim/plant/servo/linear_servo.hpp"
#include "host-sim/reproduce/samples.hpp"
#include "host-sim/reproduce/servo/parts.hpp"

namespace plenum::host::reproduce::servo {
namespace {

using namespace plant::servo;
using Complex = std::complex<double>;
using ComplexMatrix = Eigen::Matrix<Complex, 6, 6>;

constexpr double kGamma = 1.4;
constexpr double kPosition_m = 0.03;

// Viscous friction alone and gas at constant temperature in the flow term: the assumptions of (24)-(28).
ServoCylinderConfig smooth() {
  ServoCylinderConfig c;
  c.friction = {0.0, 0.0, 0.01, 80.0};
  c.law = MixedExponents{kGamma, kGamma, kGamma};
  return c;
}

ValvePair valve() {
  const plant::ThinPlateValve port(plant::ThinPlateValveConfig{});
  return std::array<plant::ThinPlateValve, 2>{port, port};
}

// How far each root of (28) is from the nearest eigenvalue of the Jacobian, of the largest root.
double pole_difference(const LinearServo& servo, const NumericalLinearisation& numerical) {
  const Eigen::Matrix<Complex, 6, 1> eigenvalues = numerical.by_state.eigenvalues();
  const Eigen::Vector4cd roots = poles(servo);
  double worst = 0.0;
  for (Eigen::Index i = 0; i < 4; ++i)
    worst = greater_of(worst, (eigenvalues.array() - roots[i]).abs().minCoeff());
  return worst / roots.cwiseAbs().maxCoeff();
}

void responses(Part& part, const LinearServo& servo, const NumericalLinearisation& numerical) {
  report::XyChart bode{.title = "Position for a command: (26) and the nonlinear model's Jacobian",
                       .caption = "The valve's own lag is left out of both. As printed: alpha = 1.",
                       .x = {"Frequency", "Hz", {}, {}, true},
                       .y = {"Gain", "mm/V", {}, {}, true}};
  report::Curve ours{.name = "(26), corrected", .x = {}, .y = {}};
  report::Curve jacobian{
      .name = "Jacobian", .x = {}, .y = {}, .stroke = report::Stroke::kPoints, .ink = report::Ink::kNeutral};
  report::Curve printed{
      .name = "(26) over (28) as printed", .x = {}, .y = {}, .stroke = report::Stroke::kDashed};
  double worst_G = 0.0;
  double worst_G_d = 0.0;
  double worst_printed = 0.0;
  for (double f = 0.01; f < 100.0; f *= 1.15) {
    const Complex s(0.0, 2.0 * std::numbers::pi * f);
    const ComplexMatrix resolvent = s * ComplexMatrix::Identity() - numerical.by_state.cast<Complex>();
    const Eigen::PartialPivLU<ComplexMatrix> lu(resolvent);
    const Complex G = lu.solve(numerical.by_command_V.cast<Complex>())[kPosition];
    const Complex G_d = -lu.solve(numerical.by_force_N.cast<Complex>())[kPosition];
    worst_G = greater_of(worst_G, std::abs(command_response(servo, s) / G - 1.0));
    worst_G_d = greater_of(worst_G_d, std::abs(force_response(servo, s) / G_d - 1.0));
    const double gRT = servo.gamma * servo.gas_constant_J_kg_K * servo.temperature_K;
    const PrintedDenominator D = as_printed(servo, 1.0, s);
    const Complex flow =
        gRT * servo.area_1_m2 *
        (servo.flow_gain_1_kg_s_V * (gRT * servo.flow_pressure_2_kg_s_Pa + servo.volume_2_m3 * s) +
         servo.flow_gain_2_kg_s_V * (gRT * servo.flow_pressure_1_kg_s_Pa + servo.volume_1_m3));
    for (report::Curve* curve : {&ours, &jacobian, &printed}) curve->x.push_back(f);
    ours.y.push_back(1e3 * std::abs(command_response(servo, s)));
    jacobian.y.push_back(1e3 * std::abs(G));
    const Complex G_printed = flow / (D.inertia + D.pressure);
    worst_printed = greater_of(worst_printed, std::abs(G_printed / G - 1.0));
    printed.y.push_back(1e3 * std::abs(G_printed));
  }
  bode.curves = {ours, jacobian, printed};
  part.charts.push_back(bode);
  part.findings.push_back(
      {.item = "derived (26)",
       .quantity = "G from 0.01 to 100 Hz against the Jacobian, largest relative difference",
       .paper = 0.0,
       .ours = worst_G,
       .tolerance = 1e-4});
  part.findings.push_back(
      {.item = "derived (27)",
       .quantity = "G_d from 0.01 to 100 Hz against the Jacobian, largest relative difference",
       .paper = 0.0,
       .ours = worst_G_d,
       .tolerance = 1e-4});
  part.findings.push_back(
      {.item = "printed (26), (28)",
       .quantity = "G with alpha = 1 from 0.01 to 100 Hz against the Jacobian, largest relative difference",
       .paper = 0.0,
       .ours = worst_printed,
       .tolerance = 1e-4,
       .why =
           "V_10 lacks its s and the area stands in the third power. How far that leads is ours too: alpha "
           "is nowhere defined and taken as 1 here, and the one area of the print is that of chamber 1."});
}

// The nonlinear cylinder at rest, after `kSmallStep_s` of a small step of command, of force, or of both [m].
constexpr double kSmallStep_s = 0.2;
constexpr double kSmall_V = 1e-3;
constexpr double kSmall_N = 0.1;
double moved_m(const OperatingPoint& point, double step_V, double step_N) {
  ServoCylinderConfig c = smooth();
  c.initial_position_m = point.position_m;
  c.initial_pressure_1_Pa = point.pressure_1_Pa;
  c.initial_pressure_2_Pa = point.pressure_2_Pa;
  c.external_force_N = step_N;
  c.tolerance = 1e-11;
  ServoCylinder cylinder(valve(), c);
  cylinder.advance(five_three_commands_V(point.command_V + step_V), kSmallStep_s);
  return cylinder.position_m() - point.position_m;
}

void superposition(Part& part, const OperatingPoint& point) {
  const double rest_m = moved_m(point, 0.0, 0.0);
  const double command_m = moved_m(point, kSmall_V, 0.0) - rest_m;
  const double force_m = moved_m(point, 0.0, kSmall_N) - rest_m;
  const double both_m = moved_m(point, kSmall_V, kSmall_N) - rest_m;
  part.findings.push_back(
      {.item = "(25)",
       .quantity = "way of the nonlinear cylinder by 1 mV and 0.1 N together, over the sum of both ways",
       .paper = 1.0,
       .ours = both_m / (command_m + force_m),
       .tolerance = 1e-3});
  part.findings.push_back({.item = "(25)",
                           .quantity = "way by 0.1 N of F_d: against +x",
                           .unit = "um",
                           .paper = 0.0,
                           .ours = 1e6 * force_m,
                           .expect = Expect::kAtMost});
}

// The power p for which `f` grows as x^p, from two values a decade apart.
double power_of(double at_one, double at_ten) {
  return std::log10(at_ten / at_one);
}

void printed_forms(Part& part, const LinearServo& servo) {
  const auto contradiction = [&](const char* item, const char* quantity, double paper, double ours,
                                 const char* why) {
    part.findings.push_back({.item = item,
                             .quantity = quantity,
                             .paper = paper,
                             .ours = ours,
                             .tolerance = 1e-3,
                             .source = Source::kPapersOwnEquation,
                             .why = why});
  };
  const Complex far(0.0, 1e6);
  const auto printed = [&](const LinearServo& one, Complex s) {
    const PrintedDenominator D = as_printed(one, 1.0, s);
    return std::abs(D.inertia + D.pressure);
  };
  const auto derived = [&](const LinearServo& one, Complex s) {
    const auto c = characteristic_polynomial(one);
    return std::abs(c[0] + s * (c[1] + s * (c[2] + s * (c[3] + s * c[4]))));
  };
  contradiction("(28)", "order of D(s)", power_of(printed(servo, far), printed(servo, 10.0 * far)),
                power_of(derived(servo, far), derived(servo, 10.0 * far)),
                "(11), (12), (22), (24) make four states; (28) has V_10 where V_10 s belongs, once here, "
                "once in (26) and "
                "once in (27), and so three.");
  LinearServo larger = servo;  // the pressure terms alone: no mass, no friction
  larger.mass_kg = larger.viscous_N_s_m = 0.0;
  LinearServo first = larger;
  larger.area_1_m2 *= 10.0;
  larger.area_2_m2 *= 10.0;
  const Complex s(0.0, 10.0);
  contradiction("(28)", "power of the piston area in the pressure term",
                power_of(printed(first, s), printed(larger, s)),
                power_of(derived(first, s), derived(larger, s)),
                "Area times pressure, pressure by volume, volume by area: A^2. With A^3 the two terms of "
                "(28) are not of "
                "one unit unless alpha, nowhere defined, is in 1/m2.");
  // what C_f2 adds to G with the sign of (26), and with that of (24) in (11), (12), (22)
  LinearServo without = servo;
  without.flow_gain_2_kg_s_V = 0.0;
  LinearServo both_fill = servo;
  both_fill.flow_gain_2_kg_s_V *= -1.0;
  const Complex by_26 = command_response(servo, s) - command_response(without, s);
  const Complex by_24 = command_response(both_fill, s) - command_response(without, s);
  contradiction(
      "(24), (26)", "what C_f2 of (24) adds to G, over what it adds in (26)", 1.0, (by_24 / by_26).real(),
      "(24) fills both chambers with x_s; P_1 A - P_2 A of (22) then subtracts C_f2, while (26) adds it. One "
      "chamber empties as the other fills: (26) is right, (24) lacks the minus.");
}

}  // namespace

Part linear_part() {
  const ServoCylinderConfig config = smooth();
  const OperatingPoint point = operating_point(config, valve(), kPosition_m);
  const LinearServo servo = linearise(config, valve(), point, kGamma);
  const NumericalLinearisation numerical = linearise_numerically(config, valve(), point);
  const Eigen::Vector4cd roots = poles(servo);
  Part part;
  part.title = "(24)-(28): linear servo model";
  part.text = fmt::format(
      "(24)-(28) derived anew from (11), (12), (22), called derived below, and as printed. The nonlinear "
      "cylinder at rest at {:.0f} mm ({:.4f} V, {:.0f} and {:.0f} kPa), viscous friction "
      "alone, linearised in closed form and by "
      "central differences. Poles [1/s]: {:.2f} +- {:.2f}i, {:.2f} and 0. Two different "
      "piston areas are kept where the paper has one "
      "A. tau_v is 2 zeta / omega of the spool (1): the same delay at low frequency.",
      1e3 * point.position_m, point.command_V, 1e-3 * point.pressure_1_Pa, 1e-3 * point.pressure_2_Pa,
      roots[1].real(), roots[1].imag(), roots[2].real());
  part.findings.push_back({.item = "derived (28)",
                           .quantity = "roots of D against eigenvalues of the Jacobian, of the largest",
                           .paper = 0.0,
                           .ours = pole_difference(servo, numerical),
                           .tolerance = 1e-5});
  responses(part, servo, numerical);
  superposition(part, point);
  printed_forms(part, servo);
  return part;
}

}  // namespace plenum::host::reproduce::servo
