// Fig. 3: the flow through a thin plate.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "host-sim/plant/orifice.hpp"
#include "host-sim/reproduce/actuators/illustrated.hpp"
#include "host-sim/reproduce/actuators/parts.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::actuators {

Part thin_plate_flow() {
  const plant::ThinPlateConstants c = plant::thin_plate_constants({});
  const plant::ThinPlate plate(c);
  const double room_density_kg_m3 =
      kAmbient_Pa / (plant::Gas{}.specific_gas_constant_J_kg_K() * plant::Gas{}.temperature_K);
  Part part{
      .title = "Fig. 3: flow through a thin plate",
      .text =
          "(1) with one side at room pressure and the other from vacuum to the compressor's. The diameters "
          "of the paper's four curves are in the figure only; ours are 1 to 4 mm.",
      .findings = {}};

  const std::vector<double> pressure_Pa = evenly(1e3, kSupply_Pa, 2001);
  const std::vector<double> flow = over(pressure_Pa, [&](double p) { return plate.phi(p, kAmbient_Pa); });
  part.findings.push_back({.item = "Fig. 3",
                           .quantity = "falling steps of the flow over p_u, of 2000",
                           .paper = 0.0,
                           .ours = static_cast<double>(falling_steps(flow))});
  double off_line = 0.0;
  double by_downstream = 0.0;
  for (const double p : evenly(c.theta * kAmbient_Pa * (1.0 + 1e-12), kSupply_Pa, 501)) {
    const double choked = c.beta_s_m * p;
    off_line = greater_of(off_line, std::abs(plate.phi(p, kAmbient_Pa) / choked - 1.0));
    by_downstream = greater_of(by_downstream, std::abs(plate.phi(p, 0.1 * kAmbient_Pa) / choked - 1.0));
  }
  part.findings.push_back({.item = "II.A.1, Fig. 3",
                           .quantity = "largest departure from a line in p_u beyond theta, of the flow",
                           .paper = 0.0,
                           .ours = off_line,
                           .tolerance = 1e-12});
  part.findings.push_back(
      {.item = "II.A.1",
       .quantity = "change of the flow beyond theta when p_d falls to a tenth, of the flow",
       .paper = 0.0,
       .ours = by_downstream,
       .tolerance = 1e-12});

  report::XyChart chart{.title = "Fig. 3: flow through a thin plate against room pressure",
                        .caption = "Outside of the marks the flow is choked: linear in the higher pressure.",
                        .x = {"Pressure of the other side", "kPa"},
                        .y = {"Flow, as room air", "cm3/s"}};
  for (const double diameter_mm : {1.0, 2.0, 3.0, 4.0}) {
    report::Curve curve{.name = fmt::format("diameter {:.0f} mm", diameter_mm), .x = {}, .y = {}};
    const double area_m2 = 0.25e-6 * std::numbers::pi * diameter_mm * diameter_mm;
    for (std::size_t i = 0; i < pressure_Pa.size(); i += 5) {
      curve.x.push_back(1e-3 * pressure_Pa[i]);
      curve.y.push_back(1e6 * area_m2 * flow[i] / room_density_kg_m3);
    }
    chart.curves.push_back(std::move(curve));
  }
  chart.marks = {{report::Mark::On::kX, 1e-3 * kAmbient_Pa * c.theta, "theta P_r"},
                 {report::Mark::On::kX, 1e-3 * kAmbient_Pa / c.theta, "P_r / theta"}};
  part.charts.push_back(std::move(chart));
  return part;
}

}  // namespace plenum::host::reproduce::actuators
