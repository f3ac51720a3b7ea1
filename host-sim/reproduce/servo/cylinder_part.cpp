#include <array>
#include <cmath>

#include "host-sim/plant/servo/cylinder.hpp"
#include "host-sim/reproduce/samples.hpp"
#include "host-sim/reproduce/servo/parts.hpp"
#include "host-sim/reproduce/servo/sealed_ports.hpp"

namespace plenum::host::reproduce::servo {
namespace {

using namespace plant::servo;

// A piston thrown from balance on its shut chambers, without friction: what is kept.
struct Kept {
  double polytrope = 0.0;  ///< largest change of P / rho^n
  double energy = 0.0;     ///< largest change, of the energy that goes to and fro
};

// P V^n, which (6) and (7) keep where no mass passes.
double polytrope(const ServoCylinder& cylinder, int chamber) {
  const double V = volume_of(cylinder.config(), chamber, cylinder.position_m(), 0.0).volume_m3;
  return cylinder.pressure_Pa(chamber) * std::pow(V, cylinder.config().gas.kappa);
}

Kept thrown() {
  ServoCylinderConfig c;
  c.friction = {0.0, 0.0, 0.01, 0.0};
  c.initial_pressure_2_Pa = 300e3;
  c.initial_pressure_1_Pa =
      (c.initial_pressure_2_Pa * c.piston_area_2_m2 + c.ambient_Pa * c.rod_area_m2()) / c.piston_area_1_m2;
  c.external_force_N = 60.0;
  ServoCylinder cylinder(sealed_ports(), c);
  const auto inner_J = [&] {
    double sum = 0.0;
    for (int j = 0; j < 2; ++j)
      sum += cylinder.pressure_Pa(j) * volume_of(c, j, cylinder.position_m(), 0.0).volume_m3 /
             (c.gas.kappa - 1.0);
    return sum + (c.ambient_Pa * c.rod_area_m2() + c.external_force_N) * cylinder.position_m();
  };
  const auto moving_J = [&] {
    return 0.5 * c.moving_mass_kg * cylinder.velocity_m_s() * cylinder.velocity_m_s();
  };
  const std::array<double, 2> start_polytrope{polytrope(cylinder, 0), polytrope(cylinder, 1)};
  const double start_J = inner_J();
  double most_moving_J = 0.0;
  double drift_J = 0.0;
  Kept kept;
  for (int i = 0; i < 300; ++i) {
    cylinder.advance({5.0, 5.0}, 0.01);
    most_moving_J = greater_of(most_moving_J, moving_J());
    drift_J = greater_of(drift_J, std::abs(inner_J() + moving_J() - start_J));
    for (int j = 0; j < 2; ++j)
      kept.polytrope =
          greater_of(kept.polytrope,
                     std::abs(polytrope(cylinder, j) / start_polytrope[static_cast<std::size_t>(j)] - 1.0));
  }
  kept.energy = drift_J / most_moving_J;
  return kept;
}

void strokes(Part& part) {
  ServoCylinderConfig c;
  c.spool = plant::SpoolConfig{65.0, 0.7};
  const plant::ThinPlateValve port(plant::ThinPlateValveConfig{});
  ServoCylinder cylinder(std::array<plant::ThinPlateValve, 2>{port, port}, c);
  report::LineChart position{.title = "5/3 valve: command steps and the piston's answer",
                             .y = {"Position", "mm"},
                             .group = "strokes"};
  report::LineChart pressure{
      .title = "Pressures of both chambers", .y = {"Pressure", "kPa"}, .group = "strokes"};
  position.curves = {{.name = "piston", .x = {}, .y = {}}};
  pressure.curves = {{.name = "chamber 1", .x = {}, .y = {}}, {.name = "chamber 2", .x = {}, .y = {}}};
  const double period_s = 2e-3;
  for (int i = 0; i < 800; ++i) {
    const double t = i * period_s;
    position.curves[0].x.push_back(t);
    position.curves[0].y.push_back(1e3 * cylinder.position_m());
    for (std::size_t j = 0; j < 2; ++j) {
      pressure.curves[j].x.push_back(t);
      pressure.curves[j].y.push_back(1e-3 * cylinder.pressure_Pa(static_cast<int>(j)));
    }
    const double command_V = t < 0.4 ? 5.6 : t < 0.8 ? 5.0 : t < 1.2 ? 4.3 : 5.0;
    cylinder.advance(five_three_commands_V(command_V), period_s);
  }
  part.charts.push_back(position);
  part.charts.push_back(pressure);
}

}  // namespace

Part cylinder_part() {
  const ServoCylinderConfig at_ambient;
  const Kept kept = thrown();
  Part part;
  part.title = "(22), Fig. 1: double-acting cylinder with a load";
  part.text =
      "A 32 mm cylinder of 200 mm stroke with a 12 mm rod and 5 kg, two ports or one 5/3 valve. The tests "
      "hold it to SUNDIALS CVODE at 1e-11 "
      "through stick, slip and reversal: 1 um and 10 Pa. The paper prints no figures for it.";
  part.findings.push_back({.item = "(22)",
                           .quantity = "net force with ambient in both chambers",
                           .unit = "N",
                           .paper = 0.0,
                           .ours = driving_force_N(at_ambient, initial_state(at_ambient)),
                           .tolerance = 1e-9,
                           .source = Source::kTwoForms});  // A_r is A_1 - A_2
  part.findings.push_back({.item = "(6), (7)",
                           .quantity = "change of P V^n behind shut ports, n = k, 3 s of motion",
                           .paper = 0.0,
                           .ours = kept.polytrope,
                           .tolerance = 1e-5});
  part.findings.push_back(
      {.item = "(13), (22)",
       .quantity = "change of the energy behind shut ports without friction, of the kinetic",
       .paper = 0.0,
       .ours = kept.energy,
       .tolerance = 1e-3});
  strokes(part);
  return part;
}

}  // namespace plenum::host::reproduce::servo
