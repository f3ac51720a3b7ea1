#include <cmath>

#include "host-sim/plant/servo/cylinder.hpp"
#include "host-sim/reproduce/samples.hpp"
#include "host-sim/reproduce/servo/parts.hpp"

namespace plenum::host::reproduce::servo {
namespace {

using namespace plant::servo;

ValvePair shut() {
  plant::ThinPlateValveConfig sealed;
  sealed.inlet_area_per_V_m2 = sealed.exhaust_area_per_V_m2 = 0.0;
  sealed.inlet_leak_m2 = sealed.exhaust_leak_m2 = sealed.transition_m2 = 0.0;
  const plant::ThinPlateValve port(sealed);
  return std::array<plant::ThinPlateValve, 2>{port, port};
}

// A piston thrown from balance on its shut chambers, without friction: what is kept.
struct Kept {
  double mass = 0.0;    ///< largest change, of the mass
  double energy = 0.0;  ///< largest change, of the energy that goes to and fro
};

Kept thrown() {
  ServoCylinderConfig c;
  c.friction = {0.0, 0.0, 0.01, 0.0};
  c.initial_pressure_2_Pa = 300e3;
  c.initial_pressure_1_Pa =
      (c.initial_pressure_2_Pa * c.piston_area_2_m2 + c.ambient_Pa * c.rod_area_m2()) / c.piston_area_1_m2;
  c.external_force_N = 60.0;
  ServoCylinder cylinder(shut(), c);
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
  const CylinderVector start = cylinder.state();
  const double start_J = inner_J();
  double most_moving_J = 0.0;
  double drift_J = 0.0;
  Kept kept;
  for (int i = 0; i < 300; ++i) {
    cylinder.advance({5.0, 5.0}, 0.01);
    most_moving_J = greater_of(most_moving_J, moving_J());
    drift_J = greater_of(drift_J, std::abs(inner_J() + moving_J() - start_J));
    for (const int m : {kMass1, kMass2})
      kept.mass = greater_of(kept.mass, std::abs(cylinder.state()[m] / start[m] - 1.0));
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
  part.title = "(20)-(22), Fig. 1: double-acting cylinder with a load";
  part.text =
      "A 32 mm cylinder of 200 mm stroke with a 12 mm rod and 5 kg, two ports or one 5/3 valve. The tests "
      "hold it to SUNDIALS CVODE at 1e-11 "
      "through stick, slip and reversal: 1 um and 10 Pa. The paper prints no figures for it.";
  part.findings.push_back({.item = "(22)",
                           .quantity = "net force with ambient in both chambers",
                           .unit = "N",
                           .paper = 0.0,
                           .ours = driving_force_N(at_ambient, initial_state(at_ambient)),
                           .tolerance = 1e-9});
  part.findings.push_back({.item = "(6)",
                           .quantity = "change of the masses behind shut ports, 3 s of motion",
                           .paper = 0.0,
                           .ours = kept.mass});
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
