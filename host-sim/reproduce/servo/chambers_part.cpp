#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "host-sim/plant/runge_kutta.hpp"
#include "host-sim/plant/servo/chamber_law.hpp"
#include "host-sim/plant/servo/cylinder_rates.hpp"
#include "host-sim/reproduce/servo/parts.hpp"

namespace plenum::host::reproduce::servo {
namespace {

using namespace plant::servo;

const plant::Gas kAir;
constexpr double kVolume_m3 = 100e-6;

ChamberState at_gas_temperature(double pressure_Pa, double volume_m3) {
  return {pressure_Pa, mass_of_kg(kAir, pressure_Pa, volume_m3, kAir.temperature_K)};
}

using Course = std::function<Throughflow(const ChamberState&)>;
using Watch = std::function<void(double time_s, const ChamberState&)>;

// A chamber whose volume moves at a steady rate, by Runge-Kutta.
ChamberState run(const ChamberLaw& law, ChamberState y, double rate_m3_s, double duration_s,
                 const Course& flow, const Watch& watch = {}) {
  constexpr int kSteps = 2000;
  const double h = duration_s / kSteps;
  using State = std::array<double, 2>;  // pressure, mass
  const auto rate = [&](double t, const State& at) {
    const ChamberState s{at[0], at[1]};
    const Throughflow f = flow(s);
    return State{pressure_rate_Pa_s(law, kAir, s, f, {kVolume_m3 + rate_m3_s * t, rate_m3_s}),
                 f.in_kg_s - f.out_kg_s};
  };
  for (int i = 0; i < kSteps; ++i) {
    const double t = i * h;
    if (watch) watch(t, y);
    const State next = plant::runge_kutta_step(t, State{y.pressure_Pa, y.mass_kg}, h, rate);
    y = {next[0], next[1]};
  }
  return y;
}

void limits(Part& part) {
  const ChamberState s{430e3, mass_of_kg(kAir, 430e3, 80e-6, 301.0)};
  const Throughflow flow{1.7e-3, 0.4e-3};
  const ChamberVolume volume{80e-6, 30e-6};
  const double k = kAir.kappa;
  const double R = kAir.specific_gas_constant_J_kg_K();
  const auto law = [&](const ChamberLaw& one) { return pressure_rate_Pa_s(one, kAir, s, flow, volume); };
  const double mdot = flow.in_kg_s - flow.out_kg_s;
  const double adiabatic = k * R * 301.0 / 80e-6 * mdot - k * s.pressure_Pa / 80e-6 * 30e-6;  // (15)
  const double isothermal = R * 301.0 / 80e-6 * mdot - s.pressure_Pa / 80e-6 * 30e-6;         // (18)
  const auto agrees = [&](const char* item, const char* quantity, double paper, double ours) {
    part.findings.push_back({.item = item,
                             .quantity = quantity,
                             .unit = "kPa/s",
                             .paper = 1e-3 * paper,
                             .ours = 1e-3 * ours,
                             .tolerance = 1e-9 * std::abs(1e-3 * paper)});
  };
  agrees("(15)", "dP/dt of the polytrope (10) at n = k", adiabatic, law(Polytropic{k}));
  agrees("(18)", "dP/dt of the polytrope (10) at n = 1", isothermal, law(Polytropic{1.0}));
  const ChamberState cool = at_gas_temperature(430e3, 80e-6);
  const auto of_cool = [&](const ChamberLaw& one) {
    return pressure_rate_Pa_s(one, kAir, cool, flow, volume);
  };
  agrees("(13), (14)", "dP/dt of the energy balance without heat, T_in = T, against (15)",
         of_cool(Polytropic{k}), of_cool(EnergyBalance{}));
  agrees("(19)", "dP/dt at alpha = k against (15), gas at the constant T", of_cool(Polytropic{k}),
         of_cool(MixedExponents{k, k, k}));
  agrees("(19)", "dP/dt at alpha = 1 against (18)", of_cool(Polytropic{1.0}),
         of_cool(MixedExponents{1.0, 1.0, 1.0}));
  part.findings.push_back({.item = "(15), (18)",
                           .quantity = "ratio of the adiabatic to the isothermal rate",
                           .paper = k,
                           .ours = law(Polytropic{k}) / law(Polytropic{1.0}),
                           .tolerance = 1e-12});
  const double enthalpy_W = k * R / (k - 1.0) * 301.0 * mdot;
  const double energy_W = R / (k - 1.0) * mdot * 301.0;  // (16)
  part.findings.push_back(
      {.item = "(16), (17)",
       .quantity = "first law (13) with the heat of (17), what is left",
       .unit = "W",
       .paper = 0.0,
       .ours = isothermal_heat_W(kAir, s, flow, volume) + enthalpy_W - s.pressure_Pa * 30e-6 - energy_W,
       .tolerance = 1e-9});
  const ChamberState filled =
      run(EnergyBalance{}, at_gas_temperature(10.0, kVolume_m3), 0.0, 0.5, [](const ChamberState&) {
        return Throughflow{1e-3, 0.0};
      });
  part.findings.push_back({.item = "(13), (14)",
                           .quantity = "temperature of an empty chamber after filling, over the supply's: k",
                           .paper = k,
                           .ours = temperature_of_K(kAir, filled, kVolume_m3) / kAir.temperature_K,
                           .tolerance = 1e-4});
}

void signs(Part& part) {
  ServoCylinderConfig c;
  const double P = 500e3;
  const double k = c.gas.kappa;
  const double n = 1.2;
  // per (m/s) of the piston, ports shut, in mid-stroke
  const ChamberVolume first = volume_of(c, 0, 0.0, 1.0);
  const ChamberVolume second = volume_of(c, 1, 0.0, 1.0);
  const auto by_velocity = [&](double exponent, const ChamberVolume& v) {
    return 1e-3 * -exponent * P * v.rate_m3_s / v.volume_m3;  // from (6), (7), (20)
  };
  const auto contradiction = [&](const char* item, const char* quantity, double paper, double ours,
                                 const char* why) {
    part.findings.push_back({.item = item,
                             .quantity = quantity,
                             .unit = "kPa/s for each m/s",
                             .paper = paper,
                             .ours = ours,
                             .tolerance = 1e-9 * std::abs(paper),
                             .source = Source::kPapersOwnEquation,
                             .why = why});
  };
  contradiction(
      "(10)", "dP_1/dt by dx/dt, n = 1.2, 5 bar, mid-stroke, upper sign", -by_velocity(n, first),
      by_velocity(n, first),
      "(9) carries +P A dx/dt for chamber 1; solved for dP/dt it changes sign, which (10) does not: as "
      "printed, a growing chamber compresses its gas.");
  contradiction("(11)", "dP_1/dt by dx/dt, 5 bar, mid-stroke",
                1e-3 * -k * P * c.piston_area_1_m2 / first.volume_m3, by_velocity(k, first), "");
  contradiction("(12)", "dP_2/dt by dx/dt, 5 bar, mid-stroke",
                1e-3 * -k * P * c.piston_area_2_m2 / second.volume_m3, by_velocity(k, second),
                "(12) has volume A_2 (L - x) + V_2o, which shrinks as x grows, but the piston's term of "
                "chamber 1: (15) "
                "with that volume has the other sign.");
  contradiction("(21)", "dP_2/dt by dx/dt, alpha = k, 5 bar, mid-stroke",
                1e-3 * -k * P * c.piston_area_2_m2 / second.volume_m3, by_velocity(k, second),
                "(20) gives chamber 2 the minus sign, so that (19) needs -+ before alpha P A_j / V_j dx/dt; "
                "(21) prints "
                "minus for both chambers.");
}

void discharge_chart(Part& part) {
  const double choked_s_m = 5e-6 * 0.72 * 0.040418 / std::sqrt(293.15);
  const Course venting = [choked_s_m](const ChamberState& s) {
    return Throughflow{0.0, choked_s_m * std::max(s.pressure_Pa - 101325.0, 0.0)};
  };
  report::LineChart chart{
      .title = "100 mL discharging from 6 bar under the four laws",
      .caption = "The flow is taken proportional to the gauge pressure, so that the laws alone differ.",
      .y = {"Pressure", "kPa"}};
  const auto add = [&](const char* name, const ChamberLaw& law, report::Stroke stroke) {
    report::Curve curve{.name = name, .x = {}, .y = {}, .stroke = stroke};
    int count = 0;
    run(law, at_gas_temperature(600e3, kVolume_m3), 0.0, 0.3, venting, [&](double t, const ChamberState& s) {
      if (count++ % 10 != 0) return;
      curve.x.push_back(t);
      curve.y.push_back(1e-3 * s.pressure_Pa);
    });
    chart.curves.push_back(curve);
  };
  add("adiabatic (15)", Polytropic{1.4}, report::Stroke::kSolid);
  add("polytropic (10), n = 1.2", Polytropic{1.2}, report::Stroke::kDashed);
  add("energy balance (13)-(14), 1 W/K", EnergyBalance{1.0, 293.15}, report::Stroke::kSolid);
  add("isothermal (18)", Polytropic{1.0}, report::Stroke::kSolid);
  add("mixed (19), alpha_out = 1.2", MixedExponents{1.4, 1.2, 1.2}, report::Stroke::kDotted);
  part.charts.push_back(chart);
}

}  // namespace

Part chambers_part() {
  Part part;
  part.title = "(6)-(19): polytropic, adiabatic, isothermal and mixed chambers";
  part.text =
      "The chamber laws in their limits, at one state (4.3 bar, 80 mL, filling and growing), and the printed "
      "signs put beside those that follow "
      "from the volumes. (6) as printed repeats (7); (14) reads d/dt(C_v mdot T) where the internal energy "
      "is C_v m T.";
  limits(part);
  signs(part);
  discharge_chart(part);
  return part;
}

}  // namespace plenum::host::reproduce::servo
