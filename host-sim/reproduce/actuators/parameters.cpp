// Table I: the nine parameters, their limits, and what they are said to mean.
#include <cmath>

#include "host-sim/reproduce/actuators/parts.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::actuators {
namespace {

using Parameters = std::array<double, identify::kFree>;

constexpr double kFollows = 0.95;  // of a correlation: "c_7: B" names no number
const char* const kFollowsReading = "our reading of \"interpretation\"";

bool inside_table_one(const Parameters& c) {
  return c[0] > 2.0 && c[0] < 8.0 && c[2] > -1.0 && c[7] > -1.0 && c[7] < 1.0 && c[8] > 0.0;
}

double middle_V(const plant::ThinPlateValveConfig& valve) {
  return 0.5 * (valve.open_above_V + valve.exhaust_below_V);
}

double outside(const std::vector<Identified>& chambers, identify::Tassa9Fit Identified::*fit) {
  double count = 0.0;
  for (const Identified& chamber : chambers) count += inside_table_one((chamber.*fit).model.c) ? 0.0 : 1.0;
  return count;
}

double c1_V(const Identified& chamber) {
  return chamber.one_step.model.c[0];
}

/// c_7/(1 + c_6 V) V: the part of c_7 that does not depend on the volume [mL/(V s)].
double c7_of_volume(const Identified& chamber) {
  const Parameters& c = chamber.one_step.model.c;
  const double V_mL = chamber.mean_volume_mL();
  return c[6] / (1.0 + c[5] * V_mL) * V_mL;
}

double B_mm2_V(const Identified& chamber) {
  return 1e6 * chamber.truth.valve.inlet_area_per_V_m2;
}

double leak_V(const Identified& chamber) {
  return 0.5 * (chamber.truth.valve.inlet_leak_m2 + chamber.truth.valve.exhaust_leak_m2) /
         chamber.truth.valve.inlet_area_per_V_m2;
}

}  // namespace

Part parameters(const Study& study) {
  Part part{
      .title = "Table I: limits and meaning of the parameters",
      .text =
          "The fits of V.C on the 76 simulated chambers, with the volume moving and at rest, against Table "
          "I and against the valves they were identified on. Where Table I is not enough for what the "
          "paper asks (s rising with u, k > 0) our fit keeps the stricter condition, so the limits cannot "
          "be broken; and at 0.1 V for c_gamma.",
      .findings = {}};
  part.findings.push_back(
      {.item = "Table I",
       .quantity =
           "fits outside of 2 < c_1 < 8, -1 < c_3, -1 < c_8 < 1, 0 < c_9, of 304: our fit's own bounds",
       .paper = 0.0,
       .ours = outside(study.moving, &Identified::one_step) + outside(study.moving, &Identified::free_run) +
               outside(study.at_rest, &Identified::one_step) + outside(study.at_rest, &Identified::free_run),
       .source = Source::kSetToPaper,
       .why = "the fits ended outside of Table I"});
  part.findings.push_back({.item = "Table I",
                           .quantity = "c_gamma",
                           .unit = "V",
                           .paper = 0.1,
                           .ours = study.at_rest.front().one_step.model.c_gamma_V,
                           .source = Source::kSetToPaper});
  const auto off_middle = [](const Identified& chamber) {
    return c1_V(chamber) - middle_V(chamber.truth.valve);
  };
  part.findings.push_back({.item = "Table I",
                           .quantity = "c_1 - (U_c + U_r)/2, mean of the fits at rest",
                           .unit = "V",
                           .paper = 0.0,
                           .ours = mean(over(study.at_rest, off_middle)),
                           .tolerance = 0.05,
                           .why = "at c_1 the sigmoid is at (P_c + P_r)/2, which the plant reaches "
                                  "below (U_c + U_r)/2: at the middle it rests nearer to P_c (see Fig. 7)"});
  part.findings.push_back(
      {.item = "Table I",
       .quantity = "c_1 - (U_c + U_r)/2, mean of the magnitudes, fits on moving volumes",
       .unit = "V",
       .paper = 0.05,
       .ours = mean(over(study.moving, [&](const Identified& one) { return std::abs(off_middle(one)); })),
       .expect = Expect::kAtMost,
       .instead = "our bound of \"(U_c + U_r)/2\"",
       .why = "as at rest, and c_1 gives way to the misplaced v' of (10c)"});
  const std::vector<double> B = over(study.at_rest, B_mm2_V);
  part.findings.push_back({.item = "Table I",
                           .quantity = "\"c_7: B of Eq. (3)\": correlation over the valves, at rest",
                           .paper = kFollows,
                           .ours = correlation(over(study.at_rest, c7_of_volume), B),
                           .expect = Expect::kAtLeast,
                           .instead = kFollowsReading});
  part.findings.push_back({.item = "Table I",
                           .quantity = "\"c_7: B of Eq. (3)\": correlation over the valves, moving",
                           .paper = kFollows,
                           .ours = correlation(over(study.moving, c7_of_volume), over(study.moving, B_mm2_V)),
                           .expect = Expect::kAtLeast,
                           .instead = kFollowsReading,
                           .why = "c_7 gives way to the misplaced v' of (10c); a few fits lose the valve "
                                  "altogether, with c_1 2 V off its null"});
  part.findings.push_back(
      {.item = "Table I",
       .quantity = "\"c_2: valve-voltage scale, B\": correlation over the valves, at rest",
       .paper = kFollows,
       .ours =
           correlation(over(study.at_rest, [](const Identified& one) { return one.one_step.model.c[1]; }), B),
       .expect = Expect::kAtLeast,
       .instead = kFollowsReading,
       .why = "c_2 is the slope of s at its null over c_s, and p_ss of (2) depends on a_c/a_r: on the "
              "leaks and on the distance of the ports beside B. Some of the fits leave c_2 undetermined, "
              "c_3 takes over"});
  part.findings.push_back(
      {.item = "Table I",
       .quantity = "\"c_9: leakage, (L_c + L_r)/2\" in volts, over B: correlation over the valves, at rest",
       .paper = kFollows,
       .ours = correlation(over(study.at_rest, [](const Identified& one) { return one.one_step.model.c[8]; }),
                           over(study.at_rest, leak_V)),
       .expect = Expect::kAtLeast,
       .instead = kFollowsReading,
       .why = "beyond its null the total area is B |u - c_1| - B (U_c - U_r)/2 + L, so that c_9 is "
              "c_gamma + L/B less half the distance of the ports, which is as large as L/B here; some of "
              "the fits leave it undetermined"});

  report::XyChart null{
      .title = "Null command: fitted against the valve's", .x = {"(U_c + U_r)/2", "V"}, .y = {"c_1", "V"}};
  const auto middle = [](const Identified& chamber) { return middle_V(chamber.truth.valve); };
  null.curves = {{.name = "at rest",
                  .x = over(study.at_rest, middle),
                  .y = over(study.at_rest, c1_V),
                  .stroke = report::Stroke::kPoints},
                 {.name = "moving",
                  .x = over(study.moving, middle),
                  .y = over(study.moving, c1_V),
                  .stroke = report::Stroke::kPoints},
                 {.name = "Table I", .x = {4.85, 5.15}, .y = {4.85, 5.15}, .ink = report::Ink::kNeutral}};
  report::XyChart gain{.title = "Gain of the rate: fitted against the valve's",
                       .x = {"B", "mm2/V"},
                       .y = {.quantity = "c_7 V/(1 + c_6 V)", .unit = "mL/(V s)", .logarithmic = true}};
  gain.curves = {
      {.name = "at rest", .x = B, .y = over(study.at_rest, c7_of_volume), .stroke = report::Stroke::kPoints},
      {.name = "moving", .x = B, .y = over(study.moving, c7_of_volume), .stroke = report::Stroke::kPoints}};
  part.charts = {std::move(null), std::move(gain)};
  return part;
}

}  // namespace plenum::host::reproduce::actuators
