#include <cmath>
#include <cstdint>

#include "host-sim/plant/servo/cylinder.hpp"
#include "host-sim/reproduce/samples.hpp"
#include "host-sim/reproduce/servo/parts.hpp"
#include "host-sim/reproduce/servo/sealed_ports.hpp"

namespace plenum::host::reproduce::servo {
namespace {

using namespace plant::servo;

const Friction kSeal{30.0, 15.0, 0.02, 80.0};

// A piston in balance on its shut chambers.
ServoCylinder balanced() {
  ServoCylinderConfig c;
  c.friction = kSeal;
  c.initial_pressure_2_Pa = 300e3;
  c.initial_pressure_1_Pa =
      (c.initial_pressure_2_Pa * c.piston_area_2_m2 + c.ambient_Pa * c.rod_area_m2()) / c.piston_area_1_m2;
  return {sealed_ports(), c};
}

// A piston in balance under a load that swings up to `share` of breakaway for 10 s: how far it gets, how
// often it lets go.
struct Swung {
  double furthest_m = 0.0;
  std::uint64_t slips = 0;
};
Swung swung(double share) {
  ServoCylinder cylinder = balanced();
  Swung result;
  for (int i = 0; i < 2000; ++i) {
    cylinder.set_external_force_N(share * kSeal.breakaway_N() * std::sin(0.05 * i));
    cylinder.advance({5.0, 5.0}, 5e-3);
    result.furthest_m = greater_of(result.furthest_m, std::abs(cylinder.position_m()));
  }
  result.slips = cylinder.slips();
  return result;
}

// The load, raised by kLoadStep_N every 5 ms, at which a piston in balance lets go.
constexpr double kLoadStep_N = 0.05;
double load_at_breakaway_N() {
  ServoCylinder cylinder = balanced();
  double load_N = 0.0;
  while (cylinder.slips() == 0 && load_N < 100.0) {
    load_N += kLoadStep_N;
    cylinder.set_external_force_N(load_N);
    cylinder.advance({5.0, 5.0}, 5e-3);
  }
  return load_N;
}

void slow_stroke(Part& part) {
  ServoCylinderConfig c;
  c.friction = {5.0, 10.0, 0.01, 20.0};
  c.moving_mass_kg = 1.0;
  plant::ThinPlateValveConfig small;
  small.inlet_area_per_V_m2 = small.exhaust_area_per_V_m2 = 2e-8;
  small.inlet_leak_m2 = small.exhaust_leak_m2 = small.transition_m2 = 0.0;
  const plant::ThinPlateValve port(small);
  ServoCylinder cylinder(std::array<plant::ThinPlateValve, 2>{port, port}, c);
  report::Curve position{.name = "piston", .x = {}, .y = {}};
  report::Curve friction{.name = "friction", .x = {}, .y = {}};
  for (int i = 0; i < 1600; ++i) {
    position.x.push_back(5e-3 * i);
    position.y.push_back(1e3 * cylinder.position_m());
    friction.x.push_back(5e-3 * i);
    friction.y.push_back(cylinder.friction_N());
    cylinder.advance({6.0, 4.0}, 5e-3);
  }
  part.charts.push_back(
      report::LineChart{.title = "Driven slowly: stick and slip",
                        .caption = "F_c 5 N, F_s 10 N, v_s 10 mm/s; choked flow through 0.02 mm2.",
                        .y = {"Position", "mm"},
                        .curves = {position},
                        .group = "slip"});
  part.charts.push_back(report::LineChart{.title = "Friction as it acts",
                                          .y = {"Friction", "N"},
                                          .curves = {friction},
                                          .marks = {{report::Mark::On::kY, 15.0, "breakaway"}},
                                          .group = "slip"});
}

void curve_chart(Part& part) {
  Friction gaussian = kSeal;
  gaussian.stribeck_exponent = 2.0;
  report::Curve printed{.name = "(23) as printed", .x = {}, .y = {}};
  report::Curve named{.name = "Gaussian, as named", .x = {}, .y = {}, .stroke = report::Stroke::kDashed};
  for (int i = -200; i <= 200; ++i) {
    const double v = 1e-3 * i;
    const double direction = i < 0 ? -1.0 : 1.0;
    const double y = i == 0 ? std::nan("") : sliding_friction_N(kSeal, direction, v);
    printed.x.push_back(v);
    printed.y.push_back(y);
    named.x.push_back(v);
    named.y.push_back(i == 0 ? std::nan("") : sliding_friction_N(gaussian, direction, v));
  }
  part.charts.push_back(report::XyChart{.title = "Friction over velocity",
                                        .caption = "F_c 30 N, F_s 15 N, v_s 20 mm/s, F_v 80 N s/m.",
                                        .x = {"Velocity", "m/s"},
                                        .y = {"Friction", "N"},
                                        .curves = {printed, named}});
}

}  // namespace

Part friction_part() {
  Part part;
  part.title = "(23): Coulomb, Stribeck and viscous friction, with stick and slip";
  part.text =
      "At rest friction is what the other forces ask for, up to F_c + F_s. The instants at which a piston "
      "sticks and lets go are located; no sgn "
      "is smoothed.";
  part.findings.push_back({.item = "(23)",
                           .quantity = "rising load at which a piston lets go, F_c + F_s of 30 and 15 N",
                           .unit = "N",
                           .paper = 45.0,
                           .ours = load_at_breakaway_N(),
                           .tolerance = kLoadStep_N});
  part.findings.push_back({.item = "(22), (23)",
                           .quantity = "way in 10 s under a load swinging up to 99.8 % of breakaway",
                           .unit = "um",
                           .paper = 0.0,
                           .ours = 1e6 * swung(0.998).furthest_m});
  part.findings.push_back({.item = "(22), (23)",
                           .quantity = "times it lets go under a load swinging up to 110 % of breakaway",
                           .paper = 1.0,
                           .ours = static_cast<double>(swung(1.1).slips),
                           .expect = Expect::kAtLeast});
  const double v = 1e-9;
  const double slope = (std::exp(-v / kSeal.stribeck_velocity_m_s) - 1.0) / (v / kSeal.stribeck_velocity_m_s);
  part.findings.push_back({.item = "(23)",
                           .quantity = "slope of the Stribeck term at rest, in F_s / v_s (a Gaussian's is 0)",
                           .paper = 0.0,
                           .ours = slope,
                           .tolerance = 1e-3,
                           .source = Source::kPapersOwnEquation,
                           .why = "The text calls (23) a Gaussian exponential; printed is exp(-|v/v_s|), "
                                  "whose slope at rest is -F_s / v_s. "
                                  "Both forms are in the plant."});
  curve_chart(part);
  slow_stroke(part);
  return part;
}

}  // namespace plenum::host::reproduce::servo
