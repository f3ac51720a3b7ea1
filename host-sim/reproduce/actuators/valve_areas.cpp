// Fig. 6: the areas of the two ports over the command, (3); Fig. 9 measures them.
#include <cmath>

#include "host-sim/plant/mpye_tables.hpp"
#include "host-sim/reproduce/actuators/by_differences.hpp"
#include "host-sim/reproduce/actuators/curve_figures.hpp"
#include "host-sim/reproduce/actuators/illustrated.hpp"
#include "host-sim/reproduce/actuators/parts.hpp"
#include "host-sim/reproduce/actuators/printed.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::actuators {
namespace {

// (3) as printed, in mm2 and mm2/V.
constexpr double kB = 1.5;
constexpr double kL = 0.1;
constexpr double kU_c = 5.2;
constexpr double kU_r = 4.8;

double largest_difference_of_plant_mm2() {
  const plant::ThinPlateValve valve({.open_above_V = kU_c,
                                     .exhaust_below_V = kU_r,
                                     .inlet_area_per_V_m2 = 1e-6 * kB,
                                     .exhaust_area_per_V_m2 = 1e-6 * kB,
                                     .inlet_leak_m2 = 1e-6 * kL,
                                     .exhaust_leak_m2 = 1e-6 * kL,
                                     .transition_m2 = 1e-6});
  double most = 0.0;
  for (const double u : evenly(0.0, 10.0, 1001)) {
    const auto opening = valve.opening(u);
    most = greater_of(most, std::abs(1e6 * opening.inlet_m2 - printed::compressor_area(u, kL, kU_c, kB)));
    most = greater_of(most, std::abs(1e6 * opening.exhaust_m2 - printed::room_area(u, kL, kU_r, kB)));
  }
  return most;
}

report::XyChart chart_of_guesses() {
  report::XyChart chart{
      .title = "Fig. 6: areas of the two ports",
      .caption = "Three guesses of the constants, ours. Rising: to the compressor; falling: to the room.",
      .x = {"Command", "V"},
      .y = {"Area", "mm2"}};
  for (const IllustratedValve& one : illustrated_valves()) {
    const plant::ThinPlateValve valve(one.valve);
    report::Curve to_compressor{.name = one.name, .x = evenly(kLow_V, kHigh_V, 201), .y = {}};
    report::Curve to_room = to_compressor;
    for (const double u : to_compressor.x) {
      to_compressor.y.push_back(1e6 * valve.opening(u).inlet_m2);
      to_room.y.push_back(1e6 * valve.opening(u).exhaust_m2);
    }
    chart.curves.push_back(std::move(to_compressor));
    chart.curves.push_back(std::move(to_room));
  }
  return chart;
}

/// A measured port over the commands used, and (3) fitted to it: area = L + w smax((B (u - U) -+ L)/w).
struct MeasuredPort {
  std::vector<double> command_V;
  std::vector<double> area_mm2;
  std::vector<double> fitted_mm2;
};

MeasuredPort fitted_port(const plant::MpyeTable& table, bool to_room) {
  MeasuredPort port;
  for (std::size_t i = 0; i < plant::kMpyeRows; ++i) {
    const double u = plant::kMpyeStep_V * static_cast<double>(i);
    if (u < kLow_V - 1e-9 || u > kHigh_V + 1e-9) continue;
    port.command_V.push_back(u);
    port.area_mm2.push_back(1e6 * table[i].area_m2);
  }
  // z: U [V], log B [mm2/V], log L [mm2], log w [mm2]
  const auto areas_mm2 = [&](const Variables& z) {
    plant::ThinPlateValveConfig config;
    config.open_above_V = config.exhaust_below_V = z[0];
    config.inlet_area_per_V_m2 = config.exhaust_area_per_V_m2 = 1e-6 * std::exp(z[1]);
    config.inlet_leak_m2 = config.exhaust_leak_m2 = 1e-6 * std::exp(z[2]);
    config.transition_m2 = 1e-6 * std::exp(z[3]);
    const plant::ThinPlateValve valve(config);
    return over(port.command_V, [&](double u) {
      const auto opening = valve.opening(u);
      return 1e6 * (to_room ? opening.exhaust_m2 : opening.inlet_m2);
    });
  };
  const Errors errors = [&](const Variables& z) {
    const std::vector<double> areas = areas_mm2(z);
    Eigen::VectorXd e(static_cast<Eigen::Index>(areas.size()));
    for (std::size_t i = 0; i < areas.size(); ++i) {
      e[static_cast<Eigen::Index>(i)] = areas[i] - port.area_mm2[i];
    }
    return e;
  };
  Variables start(4), low(4), high(4);
  start << 5.0, std::log(2.0), std::log(0.05), std::log(0.5);
  low << 4.0, std::log(0.1), std::log(1e-4), std::log(1e-3);
  high << 6.0, std::log(20.0), std::log(1.0), std::log(5.0);
  port.fitted_mm2 = areas_mm2(least_squares(errors, start, low, high));
  return port;
}

report::XyChart chart_of_measured(const MeasuredPort& inlet, const MeasuredPort& exhaust) {
  return {.title = "Beside Fig. 9: measured areas of an MPYE valve, and (3) fitted to them",
          .caption =
              "The paper shows its measured flows in a figure only. These are the areas of an "
              "MPYE-5-3/8-010-B of \"Parameter Identification and Evaluation of a Proportional Directional "
              "Flow Control Valve Model\", Tables 2 and 3.",
          .x = {"Command", "V"},
          .y = {"Area", "mm2"},
          .curves = {{.name = "supply to chamber",
                      .x = inlet.command_V,
                      .y = inlet.area_mm2,
                      .stroke = report::Stroke::kPoints},
                     {.name = "supply to chamber", .x = inlet.command_V, .y = inlet.fitted_mm2},
                     {.name = "chamber to exhaust",
                      .x = exhaust.command_V,
                      .y = exhaust.area_mm2,
                      .stroke = report::Stroke::kPoints},
                     {.name = "chamber to exhaust", .x = exhaust.command_V, .y = exhaust.fitted_mm2}}};
}

}  // namespace

Part valve_areas() {
  Part part{
      .title = "Fig. 6 and 9: areas of the valve's ports",
      .text =
          "(3) as printed, with areas in mm2, and as the plant has it, where the width of the transition "
          "is a parameter. The paper does not print its three guesses; for the numbers B = 1.5 mm2/V, L = "
          "0.1 mm2, U_c = 5.2 V, U_r = 4.8 V. For Fig. 9, whose points are in the figure only, (3) is "
          "fitted to the measured areas of another valve of the series.",
      .findings = {}};
  part.findings.push_back(
      {.item = "(3)",
       .quantity = "largest difference of the plant's areas from (3), transition width 1 mm2",
       .unit = "mm2",
       .paper = 0.0,
       .ours = largest_difference_of_plant_mm2(),
       .tolerance = 1e-12});
  std::vector<double> compressor;
  std::vector<double> room;
  double identity = 0.0;
  for (const double u : evenly(0.0, 10.0, 1001)) {
    compressor.push_back(printed::compressor_area(u, kL, kU_c, kB));
    room.push_back(printed::room_area(u, kL, kU_r, kB));
    identity = greater_of(identity, std::abs(printed::smax(u) + printed::smax(-u) - std::sqrt(u * u + 1.0)));
  }
  part.findings.push_back({.item = "II.A.3",
                           .quantity = "falling steps of a_c and rising steps of a_r over the command",
                           .paper = 0.0,
                           .ours = static_cast<double>(falling_steps(compressor) + rising_steps(room))});
  part.findings.push_back({.item = "(3a)",
                           .quantity = "a_c - L_c where the port is blocked, 1000 mm2 of travel away",
                           .unit = "mm2",
                           .paper = 0.0,
                           .ours = printed::compressor_area(kU_c - 1000.0 / kB, kL, kU_c, kB) - kL,
                           .tolerance = 1e-3});
  const double far_V = kU_c + 1000.0 / kB;
  part.findings.push_back({.item = "(3a)",
                           .quantity = "a_c - B (u - U_c) where it is open, 1000 mm2 of travel away",
                           .unit = "mm2",
                           .paper = 0.0,
                           .ours = printed::compressor_area(far_V, kL, kU_c, kB) - kB * (far_V - kU_c),
                           .tolerance = 1e-3});
  part.findings.push_back(
      {.item = "(3a)",
       .quantity = "\"U_c ... the voltage ... sealed\": a_c - L_c at U_c, with areas in mm2",
       .unit = "mm2",
       .paper = 0.0,
       .ours = printed::compressor_area(kU_c, kL, kU_c, kB) - kL,
       .why = "the paper calls smax an approximation and prints neither leak nor unit of area; 0.1 mm2 is "
              "ours. smax is half a unit of area at 0 whatever the unit, so that by (3) in mm2 the port is "
              "open by more than four such leaks at U_c. (3) needs the width of its transition as a "
              "parameter, as the "
              "plant has"});
  part.findings.push_back({.item = "III.B",
                           .quantity = "smax(x) + smax(-x) - sqrt(x^2 + 1), largest over 0 to 10",
                           .paper = 0.0,
                           .ours = identity,
                           .tolerance = 1e-12});
  const MeasuredPort inlet = fitted_port(plant::kMpyeChannelAInlet, false);
  const MeasuredPort exhaust = fitted_port(plant::kMpyeChannelAExhaust, true);
  part.findings.push_back(
      {.item = "V.A, Fig. 9",
       .quantity =
           "\"captures the principal features\" (more than half of the variance): (3) fitted to measured "
           "areas of an MPYE valve, 3 to 7 V, the lesser of both ports",
       .unit = "%",
       .paper = 50.0,
       .ours = lesser_of(explained_percent(inlet.fitted_mm2, inlet.area_mm2),
                         explained_percent(exhaust.fitted_mm2, exhaust.area_mm2)),
       .expect = Expect::kAtLeast,
       .instead = "our reading of \"the principal features\"",
       .why = "the measured areas do not have the shape of (3)"});
  part.charts = {chart_of_guesses(), chart_of_measured(inlet, exhaust)};
  return part;
}

}  // namespace plenum::host::reproduce::actuators
