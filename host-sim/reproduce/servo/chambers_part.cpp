#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "host-sim/plant/runge_kutta.hpp"
#include "host-sim/plant/servo/chamber_law.hpp"
#include "host-sim/plant/servo/cylinder_rates.hpp"
#include "host-sim/reproduce/servo/parts.hpp"
#include "host-sim/reproduce/servo/printed.hpp"

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
struct Stroke {
  double from_m3 = kVolume_m3;
  double rate_m3_s = 0.0;
  double duration_s = 0.0;
  int steps = 2000;

  ChamberVolume end() const { return {from_m3 + rate_m3_s * duration_s, rate_m3_s}; }
};

ChamberState run(const ChamberLaw& law, ChamberState y, const Stroke& stroke, const Course& flow,
                 const Watch& watch = {}) {
  const double h = stroke.duration_s / stroke.steps;
  using State = std::array<double, 2>;  // pressure, mass
  const auto rate = [&](double t, const State& at) {
    const ChamberState s{at[0], at[1]};
    const Throughflow f = flow(s);
    return State{
        pressure_rate_Pa_s(law, kAir, s, f, {stroke.from_m3 + stroke.rate_m3_s * t, stroke.rate_m3_s}),
        f.in_kg_s - f.out_kg_s};
  };
  for (int i = 0; i < stroke.steps; ++i) {
    const double t = i * h;
    if (watch) watch(t, y);
    const State next = plant::runge_kutta_step(t, State{y.pressure_Pa, y.mass_kg}, h, rate);
    y = {next[0], next[1]};
  }
  return y;
}

Course steady(const Throughflow& flow) {
  return [flow](const ChamberState&) { return flow; };
}

printed::Filling filling(const ChamberState& s, double volume_m3, const Throughflow& flow) {
  return {s.pressure_Pa, temperature_of_K(kAir, s, volume_m3), flow.in_kg_s, flow.out_kg_s};
}

const double kR = kAir.specific_gas_constant_J_kg_K();
constexpr Throughflow kShut{};
constexpr Throughflow kThrough{1.7e-3, 0.4e-3};
constexpr double kGrowing_m3_s = 30e-6;
// 2 bar, 20 C, 200 mL pressed to 80 mL: where the start of (10) is, and where its rate is asked for
constexpr double kStart_Pa = 200e3;
constexpr Stroke kPressed{.from_m3 = 200e-6, .rate_m3_s = -120e-6, .duration_s = 1.0};

void agrees(Part& part, const char* item, const char* quantity, double paper, double ours,
            Source source = Source::kOurModel) {
  part.findings.push_back({.item = item,
                           .quantity = quantity,
                           .unit = "kPa/s",
                           .paper = 1e-3 * paper,
                           .ours = 1e-3 * ours,
                           .tolerance = 1e-9 * std::abs(1e-3 * paper),
                           .source = source});
}

// (10) knows a start; the others do not. Gas pressed there by another law than the one that is asked.
void limits_of_the_polytrope(Part& part) {
  const double T_i = kAir.temperature_K;
  const ChamberState start = at_gas_temperature(kStart_Pa, kPressed.from_m3);
  const ChamberVolume volume{kPressed.end().volume_m3, kGrowing_m3_s};
  const auto by_10 = [&](double n, const ChamberState& s, const ChamberVolume& at) {
    return polytropic_rate_Pa_s(kAir, n, s, kStart_Pa, T_i, kThrough, at);
  };
  const ChamberState hot = run(EnergyBalance{}, start, kPressed, steady(kShut));
  agrees(part, "(10), (15)", "dP/dt of (10) at n = k, pressed there without heat",
         printed::rate_15(kR, kAir.kappa, filling(hot, volume.volume_m3, kThrough), volume.volume_m3,
                          volume.rate_m3_s),
         by_10(kAir.kappa, hot, volume));
  const ChamberState cool = run(MixedExponents{1.0, 1.0, 1.0}, start, kPressed, steady(kShut));
  agrees(part, "(10), (18)", "dP/dt of (10) at n = 1, pressed there at constant T",
         printed::rate_18(kR, filling(cool, volume.volume_m3, kThrough), volume.volume_m3, volume.rate_m3_s),
         by_10(1.0, cool, volume));
  // the piston's term, whose printed sign is another matter, is left out: the volume rests
  const double n = 1.2;
  const ChamberState between = run(Polytropic{n}, start, kPressed, steady(kThrough));
  const printed::Side side{1.0, 1e-3, 0.0, volume.volume_m3};
  agrees(
      part, "(10)", "dP/dt of the law that takes T for P V / (m R), n = 1.2, filled and pressed there",
      printed::rate_10(side, kR, n, kStart_Pa, T_i, filling(between, volume.volume_m3, kThrough), 0.0, 0.0),
      pressure_rate_Pa_s(Polytropic{n}, kAir, between, kThrough, {volume.volume_m3, 0.0}));
}

void limits_of_the_energy_balance(Part& part) {
  const double k = kAir.kappa;
  const ChamberVolume volume{80e-6, kGrowing_m3_s};
  const ChamberState s = at_gas_temperature(430e3, volume.volume_m3);
  const auto law = [&](const ChamberLaw& one) { return pressure_rate_Pa_s(one, kAir, s, kThrough, volume); };
  const printed::Filling f = filling(s, volume.volume_m3, kThrough);
  const double adiabatic = printed::rate_15(kR, k, f, volume.volume_m3, volume.rate_m3_s);
  const double isothermal = printed::rate_18(kR, f, volume.volume_m3, volume.rate_m3_s);
  agrees(part, "(13)-(15)", "dP/dt of the energy balance without heat, T_in = T", adiabatic,
         law(EnergyBalance{}));
  part.findings.push_back({.item = "(15), (18)",
                           .quantity = "rate of the energy balance without heat over that of alpha = 1: k",
                           .paper = k,
                           .ours = law(EnergyBalance{}) / law(MixedExponents{1.0, 1.0, 1.0}),
                           .tolerance = 1e-12});
  agrees(part, "(19)", "dP/dt at alpha = k against (15), gas at the constant T", adiabatic,
         law(MixedExponents{k, k, k}), Source::kTwoForms);
  agrees(part, "(19)", "dP/dt at alpha = 1 against (18)", isothermal, law(MixedExponents{1.0, 1.0, 1.0}),
         Source::kTwoForms);
  const ChamberState filled =
      run(EnergyBalance{}, at_gas_temperature(10.0, kVolume_m3), {.duration_s = 0.5}, steady({1e-3, 0.0}));
  part.findings.push_back({.item = "(13), (14)",
                           .quantity = "temperature of an empty chamber after filling, over the supply's: k",
                           .paper = k,
                           .ours = temperature_of_K(kAir, filled, kVolume_m3) / kAir.temperature_K,
                           .tolerance = 1e-4});
}

// A wall that keeps the gas at its temperature: (18) without the energy balance having heard of it.
void limit_of_the_wall(Part& part) {
  constexpr EnergyBalance kWall{1e5, 293.15};
  // the gas is late by C_v m / G_w = 3 us: of the 50 ms of the run this share
  constexpr double kLate = 1e-4;
  constexpr Stroke kStroke{.from_m3 = 200e-6, .rate_m3_s = -1e-3, .duration_s = 0.05, .steps = 20000};
  const ChamberState start = at_gas_temperature(kStart_Pa, kStroke.from_m3);
  const ChamberState end = run(kWall, start, kStroke, steady(kThrough));
  const ChamberVolume volume = kStroke.end();
  const double entered_kg = (kThrough.in_kg_s - kThrough.out_kg_s) * kStroke.duration_s;
  const double by_18_Pa =  // (18) integrated: P V grows by R T of what has entered
      (kStart_Pa * kStroke.from_m3 + kR * kAir.temperature_K * entered_kg) / volume.volume_m3;
  part.findings.push_back({.item = "(13), (18)",
                           .quantity = "pressure of the energy balance with a wall of 0.1 MW/K, filled and "
                                       "pressed for 50 ms, against (18)",
                           .unit = "kPa",
                           .paper = 1e-3 * by_18_Pa,
                           .ours = 1e-3 * end.pressure_Pa,
                           .tolerance = kLate * 1e-3 * by_18_Pa});
  const double T = temperature_of_K(kAir, end, volume.volume_m3);
  const double heat_W = printed::heat_17(kR, filling(end, volume.volume_m3, kThrough), volume.rate_m3_s);
  part.findings.push_back({.item = "(17)",
                           .quantity = "heat that this wall gives at the end",
                           .unit = "W",
                           .paper = heat_W,
                           .ours = kWall.wall_conductance_W_K * (kWall.wall_temperature_K - T),
                           .tolerance = kLate * std::abs(heat_W)});
  part.findings.push_back({.item = "(17)",
                           .quantity = "the plant's heat of a chamber at constant temperature, there",
                           .unit = "W",
                           .paper = heat_W,
                           .ours = isothermal_heat_W(kAir, end, kThrough, volume),
                           .tolerance = 1e-9,
                           .source = Source::kTwoForms});
}

printed::Side side_of(const ServoCylinderConfig& c, int chamber) {
  return chamber == 0 ? printed::Side{1.0, c.piston_area_1_m2, c.stroke_m, c.dead_volume_1_m3}
                      : printed::Side{-1.0, c.piston_area_2_m2, c.stroke_m, c.dead_volume_2_m3};
}

void volumes(Part& part) {
  const ServoCylinderConfig c;
  constexpr double kPlace_m = 0.03;  // from the middle
  const auto row = [&](const char* item, const char* quantity, double paper, double ours, Source source,
                       const char* why) {
    part.findings.push_back({.item = item,
                             .quantity = quantity,
                             .unit = "mL",
                             .paper = 1e6 * paper,
                             .ours = 1e6 * ours,
                             .tolerance = 1e-9,
                             .source = source,
                             .why = why});
  };
  const auto plants = [&](int chamber) { return volume_of(c, chamber, kPlace_m, 0.0).volume_m3; };
  const printed::Side one = side_of(c, 0);
  const printed::Side two = side_of(c, 1);
  row("(8)", "chamber 1, 30 mm from the middle", printed::volume_8(one, kPlace_m), plants(0),
      Source::kTwoForms, "");
  row("(20)", "chamber 2, 30 mm from the middle", printed::volume_20(two, kPlace_m), plants(1),
      Source::kTwoForms, "");
  row("(8), (12)", "chamber 2, 30 mm from the middle, x from its end against x from the middle",
      printed::volume_12(two, two.x_0() + kPlace_m), printed::volume_8(two, kPlace_m),
      Source::kPapersOwnEquation, "");
  row("(9)", "chamber 2, 30 mm from the middle, as (9) has it", printed::volume_9(two, kPlace_m),
      printed::volume_8(two, kPlace_m), Source::kPapersOwnEquation,
      "(9) is said to be (7) and (8) put into (6), and has +- x_m where (8) and (10) have + x_m: the dead "
      "volume of chamber 2 is taken off.");
}

// The piston's term alone: ports shut, in mid-stroke, for each m/s.
void signs(Part& part) {
  const ServoCylinderConfig c;
  const double k = c.gas.kappa;
  const printed::Side one = side_of(c, 0);
  const printed::Side two = side_of(c, 1);
  const printed::Filling shut{500e3, c.gas.temperature_K, 0.0, 0.0};
  // rho V stays, (6), with rho of (7) and V of (20): P V^n stays
  const auto by_volume = [&](double n, const printed::Side& j) {
    return -n * shut.P / printed::volume_20(j, 0.0) * j.sign * j.area_m2;
  };
  const auto contradiction = [&](const char* item, const char* quantity, double paper, double ours,
                                 const char* why) {
    part.findings.push_back({.item = item,
                             .quantity = quantity,
                             .unit = "kPa/s for each m/s",
                             .paper = 1e-3 * paper,
                             .ours = 1e-3 * ours,
                             .tolerance = 1e-12 * std::abs(paper),
                             .source = Source::kPapersOwnEquation,
                             .why = why});
  };
  const double n = 1.2;
  contradiction(
      "(10)", "dP_1/dt by dx/dt, n = 1.2, 5 bar, mid-stroke, upper sign",
      printed::rate_10(one, kR, n, shut.P, shut.T, shut, 0.0, 1.0), by_volume(n, one),
      "(9) carries +P A dx/dt for chamber 1; solved for dP/dt it changes sign, which (10) does not: as "
      "printed, a growing chamber compresses its gas.");
  contradiction("(11)", "dP_1/dt by dx/dt, 5 bar, mid-stroke",
                printed::rate_11(one, kR, k, shut, one.x_0(), 1.0), by_volume(k, one), "");
  contradiction("(12)", "dP_2/dt by dx/dt, 5 bar, mid-stroke",
                printed::rate_12(two, kR, k, shut, two.x_0(), 1.0), by_volume(k, two),
                "(12) has volume A_2 (L - x) + V_2o, which shrinks as x grows, but the piston's term of "
                "chamber 1: (15) with that volume has the other sign.");
  contradiction("(21)", "dP_2/dt by dx/dt, alpha = k, 5 bar, mid-stroke",
                printed::rate_21(two, kR, {k, k, k}, shut, 0.0, 1.0), by_volume(k, two),
                "(20) gives chamber 2 the minus sign, so that (19) needs -+ before alpha P A_j / V_j dx/dt; "
                "(21) prints minus for both chambers.");
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
    run(law, at_gas_temperature(600e3, kVolume_m3), {.duration_s = 0.3}, venting,
        [&](double t, const ChamberState& s) {
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
  part.title = "(6)-(21): polytropic, adiabatic, isothermal and mixed chambers";
  part.text =
      "The plant's chamber laws in their limits, against the equations letter by letter, and the printed "
      "volumes and signs put beside those that follow from (6), (7), (20). The polytrope (10) is asked after "
      "gas was pressed from 2 bar and 200 mL to 80 mL by another law; the energy balance with a wall becomes "
      "isothermal as the wall conducts. (6) as printed repeats (7); (14) reads d/dt(C_v mdot T) where the "
      "internal energy is C_v m T.";
  limits_of_the_polytrope(part);
  limits_of_the_energy_balance(part);
  limit_of_the_wall(part);
  volumes(part);
  signs(part);
  discharge_chart(part);
  return part;
}

}  // namespace plenum::host::reproduce::servo
