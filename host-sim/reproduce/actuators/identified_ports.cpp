// Fig. 3 and 6 from identified models: the flow of an open port, and the areas of both, against the plants.
//
// (10) knows neither flow nor area. (4a) at rest turns its rate into the flow  mdot = V/(kappa R T) r (s - p).
// Two areas follow from s and r at a command, by two conditions on (2):
//   choked ends:  at p = P_r only the supply flows, choked; at p = P_c only the exhaust:
//                 a_c = K (s - P_r)/(beta P_c),  a_r = K (P_c - s)/(beta P_c),  K = V r/(kappa R T)
//   at rest:      a_c phi(P_c, s) = a_r phi(s, P_r),  and K is what (2) falls by there for each Pa.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "host-sim/identify/tassa9.hpp"
#include "host-sim/plant/reach.hpp"
#include "host-sim/reproduce/actuators/curve_figures.hpp"
#include "host-sim/reproduce/actuators/illustrated.hpp"
#include "host-sim/reproduce/actuators/parts.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::actuators {
namespace {

/// V/(kappa R T) at the mean volume [kg/Pa].
double capacity_kg_Pa(const Identified& chamber) {
  const plant::Gas gas;
  return chamber.truth.volume.mean_m3() /
         (gas.kappa * gas.specific_gas_constant_J_kg_K() * gas.temperature_K);
}

/// beta P_c [kg/(s m2)]: the choked flow of a port behind the compressor's pressure.
double choked_kg_s_m2() {
  return plant::thin_plate_constants({}).beta_s_m * kSupply_Pa;
}

identify::SteadyAndRate identified_at(const Identified& chamber, double u) {
  return identify::steady_and_rate(chamber.one_step.model, u, chamber.mean_volume_mL(), 0.0);
}

/// A port as open as the commands used make it: filling at 7 V behind P_c, emptying at 3 V into the room.
enum class Open { supply, exhaust };

/// Pressure of the chamber where upstream is `ratio` times downstream [Pa].
double pressure_Pa(Open open, double ratio) {
  return open == Open::supply ? kSupply_Pa / ratio : kAmbient_Pa * ratio;
}

double open_area_m2(const Identified& chamber, Open open) {
  const plant::ThinPlateValve valve(chamber.truth.valve);
  return open == Open::supply ? valve.opening(kHigh_V).inlet_m2 : valve.opening(kLow_V).exhaust_m2;
}

/// Flow through the open port, along it [kg/s]; of the plant less the leak of the other port, as a chamber has it.
struct Flow {
  double plant;
  double identified;
};
Flow flow_kg_s(const Identified& chamber, Open open, double ratio) {
  const double u = open == Open::supply ? kHigh_V : kLow_V;
  const double along = open == Open::supply ? 1.0 : -1.0;
  const double p_Pa = pressure_Pa(open, ratio);
  const identify::SteadyAndRate at = identified_at(chamber, u);
  return {along * plant::mass_flow_kg_s(plant::ThinPlateValve(chamber.truth.valve), p_Pa, u, kSupply_Pa,
                                        kAmbient_Pa),
          along * capacity_kg_Pa(chamber) * at.rate_per_s * (1e3 * at.steady_kPa - p_Pa)};
}

const std::vector<double>& ratios() {
  static const std::vector<double> ratio = evenly(1.0, kSupply_Pa / kAmbient_Pa, 301);
  return ratio;
}

/// Largest distance of the identified flow from the plant's over the ratios, of the choked flow behind P_c [%].
double flow_off_percent(const Identified& chamber, Open open) {
  double most_kg_s = 0.0;
  for (const double ratio : ratios()) {
    const Flow flow = flow_kg_s(chamber, open, ratio);
    most_kg_s = greater_of(most_kg_s, std::abs(flow.identified - flow.plant));
  }
  return 100.0 * most_kg_s / (open_area_m2(chamber, open) * choked_kg_s_m2());
}

/// Flow at P_c/P_r over that at theta: what a port still gains beyond its choked limit.
Flow gain_beyond_theta(const Identified& chamber, Open open) {
  const Flow end = flow_kg_s(chamber, open, ratios().back());
  const Flow limit = flow_kg_s(chamber, open, plant::thin_plate_constants({}).theta);
  return {end.plant / limit.plant, end.identified / limit.identified};
}

const std::vector<double>& commands_V() {
  static const std::vector<double> commands = evenly(kLow_V, kHigh_V, 201);
  return commands;
}

/// Areas of both ports over the commands used [mm2].
struct Areas {
  std::vector<double> supply;
  std::vector<double> exhaust;
};

Areas true_areas(const Identified& chamber) {
  const plant::ThinPlateValve valve(chamber.truth.valve);
  return {over(commands_V(), [&](double u) { return 1e6 * valve.opening(u).inlet_m2; }),
          over(commands_V(), [&](double u) { return 1e6 * valve.opening(u).exhaust_m2; })};
}

Areas areas_by_choked_ends(const Identified& chamber) {
  Areas areas;
  for (const double u : commands_V()) {
    const identify::SteadyAndRate at = identified_at(chamber, u);
    const double K_kg_s_Pa = capacity_kg_Pa(chamber) * at.rate_per_s;
    areas.supply.push_back(1e6 * K_kg_s_Pa * (1e3 * at.steady_kPa - kAmbient_Pa) / choked_kg_s_m2());
    areas.exhaust.push_back(1e6 * K_kg_s_Pa * (kSupply_Pa - 1e3 * at.steady_kPa) / choked_kg_s_m2());
  }
  return areas;
}

Areas areas_at_rest(const Identified& chamber) {
  const plant::ThinPlateValve valve(chamber.truth.valve);
  Areas areas;
  for (const double u : commands_V()) {
    const identify::SteadyAndRate at = identified_at(chamber, u);
    const plant::PortFlows phi = valve.flows({1.0, 1.0}, 1e3 * at.steady_kPa, kSupply_Pa, kAmbient_Pa);
    const double through_kg_s =
        capacity_kg_Pa(chamber) * at.rate_per_s /
        (phi.exhaust_slope_kg_s_Pa / phi.exhaust_kg_s - phi.inlet_slope_kg_s_Pa / phi.inlet_kg_s);
    areas.supply.push_back(1e6 * through_kg_s / phi.inlet_kg_s);
    areas.exhaust.push_back(1e6 * through_kg_s / phi.exhaust_kg_s);
  }
  return areas;
}

using AreasOf = Areas (*)(const Identified&);

/// Share of the variance of the plant's area over 3 to 7 V that the identified one explains, median [%].
double area_explained_percent(const std::vector<Identified>& chambers, AreasOf areas_of,
                              std::vector<double> Areas::*port) {
  return median(over(chambers, [&](const Identified& one) {
    return explained_percent(areas_of(one).*port, true_areas(one).*port);
  }));
}

/// Steps of both areas to the wrong side.
double wrong_steps(const Identified& chamber) {
  const Areas areas = areas_by_choked_ends(chamber);
  return static_cast<double>(falling_steps(areas.supply) + rising_steps(areas.exhaust));
}

report::XyChart flow_chart(const Identified& chamber) {
  const plant::Gas gas;
  const double cm3_kg = 1e6 * gas.specific_gas_constant_J_kg_K() * gas.temperature_K / kAmbient_Pa;
  report::XyChart chart{.title = "Fig. 3 from an identified model: flow of an open port",
                        .caption =
                            "The typical chamber at rest, filling at 7 V and emptying at 3 V. Beyond "
                            "the mark the port is choked.",
                        .x = {"Upstream over downstream pressure"},
                        .y = {"Flow, as room air", "cm3/s"},
                        .marks = {{report::Mark::On::kX, plant::thin_plate_constants({}).theta, "theta"}}};
  for (const Open open : {Open::supply, Open::exhaust}) {
    const char* const name = open == Open::supply ? "filling" : "emptying";
    const auto curve = [&](const char* whose, double Flow::*flow, report::Ink ink) {
      chart.curves.push_back(
          {.name = fmt::format("{}, {}", whose, name),
           .x = ratios(),
           .y = over(ratios(), [&](double ratio) { return cm3_kg * flow_kg_s(chamber, open, ratio).*flow; }),
           .ink = ink});
    };
    curve("plant", &Flow::plant, report::Ink::kNeutral);
    curve("identified", &Flow::identified, report::Ink::kPalette);
  }
  return chart;
}

report::XyChart area_chart(const Identified& chamber) {
  report::XyChart chart{
      .title = "Fig. 6 from an identified model: areas of the two ports",
      .caption = "The typical chamber at rest. Rising: to the compressor; falling: to the room.",
      .x = {"Command", "V"},
      .y = {"Area", "mm2"}};
  const auto curves = [&](const char* name, AreasOf areas_of, report::Ink ink) {
    Areas areas = areas_of(chamber);
    chart.curves.push_back({.name = name, .x = commands_V(), .y = std::move(areas.supply), .ink = ink});
    chart.curves.push_back({.name = name, .x = commands_V(), .y = std::move(areas.exhaust), .ink = ink});
  };
  curves("plant", true_areas, report::Ink::kNeutral);
  curves("identified, by the choked ends", areas_by_choked_ends, report::Ink::kPalette);
  curves("identified, by the slope at rest", areas_at_rest, report::Ink::kPalette);
  return chart;
}

constexpr double kBound_percent = 10.0;  // of Fig. 3, after V.D: "less than 10 %" of the span

void add_flows(Part& part, const std::vector<Identified>& chambers) {
  const auto off = [&](const char* quantity, Open open, const char* why) {
    part.findings.push_back(
        {.item = "Fig. 3",
         .quantity = quantity,
         .unit = "% of choked",
         .paper = 0.0,
         .ours = median(over(chambers, [&](const Identified& one) { return flow_off_percent(one, open); })),
         .tolerance = kBound_percent,
         .instead = "the physical model",
         .why = why});
  };
  off("identified flow of an emptying port, p_u from P_r to P_c: largest distance, median at rest",
      Open::exhaust, "a line through s for a curve that is a line through 0 beyond theta");
  off("identified flow of a filling port, p_d from P_c to P_r: largest distance, median at rest",
      Open::supply,
      "(6) is a line in p with no choked limit: it goes on rising where the plant's flow stays");
  std::vector<double> plants, models;
  for (const Identified& one : chambers) {
    const Flow gain = gain_beyond_theta(one, Open::supply);
    plants.push_back(gain.plant);
    models.push_back(gain.identified);
  }
  part.findings.push_back(
      {.item = "II.A.1, Fig. 3",
       .quantity =
           "\"independent of the downstream pressure\": flow of a filling port at P_c/P_r over that at "
           "theta, median at rest",
       .paper = median(plants),
       .ours = median(models),
       .tolerance = 0.01 * kBound_percent,
       .instead = "the physical model",
       .why = "(6) has (s - P_r)/(s - P_c/theta) there whatever its parameters, with s at P_c: no choice of "
              "the nine gives a choked flow"});
}

void add_areas(Part& part, const std::vector<Identified>& chambers) {
  const auto captures = [&](const char* quantity, double ours, const char* why) {
    part.findings.push_back({.item = "Fig. 6, V.A",
                             .quantity = quantity,
                             .unit = "%",
                             .paper = 50.0,
                             .ours = ours,
                             .expect = Expect::kAtLeast,
                             .instead = "our reading of \"the principal features\"",
                             .why = why});
  };
  captures("identified a_r by the choked ends: variance over 3 to 7 V explained, median at rest",
           area_explained_percent(chambers, areas_by_choked_ends, &Areas::exhaust),
           "the line of (6) misses the exhaust too");
  captures("identified a_c by the choked ends: variance over 3 to 7 V explained, median at rest",
           area_explained_percent(chambers, areas_by_choked_ends, &Areas::supply),
           "as Fig. 3: this reads the line at P_r, where it lies far above the choked flow");
  captures(
      "identified areas by the slope at rest: variance over 3 to 7 V explained, the greater of both ports, "
      "median at rest",
      greater_of(area_explained_percent(chambers, areas_at_rest, &Areas::supply),
                 area_explained_percent(chambers, areas_at_rest, &Areas::exhaust)),
      "an open port rests next to the pressure behind it, where (1) is a root of the difference and (2) "
      "falls without bound; r is one number for the whole range of p, not its slope there");
  part.findings.push_back(
      {.item = "II.A.3, Fig. 6",
       .quantity = "falling steps of a_c and rising steps of a_r by the choked ends, of 400, median at rest",
       .paper = 0.0,
       .ours = median(over(chambers, wrong_steps)),
       .why = "both areas go with r, which is least at c_1: below it a_c falls, above it a_r rises, where "
              "the plant's closed port keeps its leak"});
}

}  // namespace

Part identified_ports(const Study& study) {
  Part part{
      .title = "Fig. 3 and 6 from identified models: port flow and areas",
      .text =
          "The models of the 76 chambers at rest (the one-step fits of V.C), against the plants they were "
          "identified on. (10) knows neither flow nor area; (4a) at rest turns it into the flow "
          "V/(kappa R T) r (s - p). Fig. 3: this flow where one port is as open as the commands let it be, "
          "7 V filling, 3 V emptying. Fig. 6: two areas follow from s and r by two conditions. By the "
          "choked ends: at p = P_r only the supply flows, at P_c only the exhaust, both choked; then r goes "
          "with a_c + a_r, as III.B has it, and s is (a_c P_c + a_r P_r)/(a_c + a_r). By the slope at rest: "
          "(2) is 0 at s and falls there as the line of (6) does. The bound of the flows is 10 %, as V.D has "
          "it of the span; that of the areas is V.A's, as in Fig. 9.",
      .findings = {}};
  add_flows(part, study.at_rest);
  add_areas(part, study.at_rest);
  const Identified& typical = study.at_rest[place_of_typical(study.at_rest)];
  part.charts = {flow_chart(typical), area_chart(typical)};
  return part;
}

}  // namespace plenum::host::reproduce::actuators
