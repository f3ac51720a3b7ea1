#include <fmt/format.h>

#include <vector>

#include "host-sim/identify/servo/friction_fit.hpp"
#include "host-sim/reproduce/samples.hpp"
#include "host-sim/reproduce/servo/driven_friction.hpp"
#include "host-sim/reproduce/servo/measured_friction.hpp"
#include "host-sim/reproduce/servo/parts.hpp"

namespace plenum::host::reproduce::servo {
namespace {

using namespace identify::servo;

std::vector<std::vector<SlidingRow>> records() {
  std::vector<std::vector<SlidingRow>> all;
  for (const std::vector<PulledMean>& record : kMeasuredFriction) {
    std::vector<SlidingRow> rows;
    rows.reserve(record.size());
    for (const PulledMean& mean : record)
      rows.push_back({0.0, 0.0, mean.velocity_m_s, mean.pressure_Pa, mean.force_N, mean.samples});
    all.push_back(rows);
  }
  return all;
}

void add_fit(Part& part, const FrictionFit& fit, const FrictionFit& viscous, const FrictionFit& stribeck) {
  const double mean_N = mean(fit.coulomb_N);
  const char* const kOdd =
      "The seal drags differently in the two directions and along the stroke; (23) is odd in the velocity "
      "and knows no place.";
  part.findings.push_back({.item = "(23)",
                           .quantity =
                               "RMS error of the means over 1 mm/s with one F_c a pressure, of the mean F_c; "
                               "the paper's form has no error",
                           .unit = "%",
                           .paper = 0.0,
                           .ours = 100.0 * fit.rms_N / mean_N,
                           .why = kOdd});
  part.findings.push_back({.item = "(23)",
                           .quantity = "RMS error of the samples themselves, likewise",
                           .unit = "%",
                           .paper = 0.0,
                           .ours = 100.0 * kRmsOfTheSamples_N / mean_N,
                           .why = kOdd});
  part.findings.push_back(
      {.item = "(23)",
       .quantity = "Coulomb friction at 7 bar over that at 1 bar",
       .paper = 1.0,
       .ours = fit.coulomb_N[3] / fit.coulomb_N[0],
       .tolerance = 2.0 * kRmsOfTheSamples_N / mean_N,
       .why = "(23) has one F_c; the seal is pressed on by the pressure and drags twice as much at 7 "
              "bar. A model holds at the pressure at which it was identified."});
  part.findings.push_back(
      {.item = "(23)",
       .quantity = "F_c at 1 bar when F_v is fitted too",
       .unit = "N",
       .paper = 0.0,
       .ours = viscous.coulomb_N[0],
       .expect = Expect::kAtLeast,
       .why = "Speed and direction go together in these records, so F_v takes up what differs between "
              "the directions; they do not show F_v."});
  part.findings.push_back({.item = "(23)",
                           .quantity = "F_s at v_s = 5 mm/s",
                           .unit = "N",
                           .paper = 0.0,
                           .ours = stribeck.stribeck_N,
                           .expect = Expect::kAtLeast,
                           .why = "Nothing slides below 4 mm/s in these records; they do not show F_s."});
}

report::XyChart means_chart(const std::vector<std::vector<SlidingRow>>& rows, const FrictionFit& fit) {
  report::XyChart chart{.title = "Measured friction and (23) with Coulomb friction for each pressure",
                        .x = {"Velocity", "mm/s"},
                        .y = {"Force less A p and zero", "N"}};
  for (std::size_t r = 0; r < rows.size(); ++r) {
    report::Curve measured{.name = fmt::format("{} bar, measured", kPulledAt_bar[r]),
                           .x = {},
                           .y = {},
                           .stroke = report::Stroke::kPoints};
    for (const SlidingRow& row : rows[r]) {
      measured.x.push_back(1e3 * row.velocity_m_s);
      measured.y.push_back(row.force_N - fit.area_m2 * row.pressure_Pa - fit.zero_N);
    }
    const double F = fit.coulomb_N[r];
    chart.curves.push_back(measured);
    chart.curves.push_back({.name = fmt::format("{} bar, (23)", kPulledAt_bar[r]),
                            .x = {-15.0, 0.0, 0.0, 15.0},
                            .y = {-F, -F, F, F}});
  }
  return chart;
}

// The plant, with the F_c of the fit and no other figure, through one reversal at each pressure.
void add_reversals(Part& part, const FrictionFit& fit) {
  double most_stuck_s = 0.0;
  for (std::size_t r = 0; r < kMeasuredReversals.size(); ++r) {
    plant::servo::Friction coulomb;
    coulomb.coulomb_N = fit.coulomb_N[r];
    const DrivenFriction driven =
        driven_friction(kMeasuredReversals[r], {.area_m2 = fit.area_m2, .zero_N = fit.zero_N}, coulomb);
    most_stuck_s = greater_of(most_stuck_s, driven.stuck_s);
    part.findings.push_back(
        {.item = "(22), (23)",
         .quantity =
             fmt::format("RMS error of the plant's friction through a measured reversal at {} bar, of the "
                         "measured span; the paper's form has no error",
                         kPulledAt_bar[r]),
         .unit = "%",
         .paper = 0.0,
         .ours = 100.0 * driven.rms_N() / driven.span_N(),
         .why = "The measured force takes one to two tenths of a second and up to a millimetre to turn, as "
                "the seal and the bench give way, and it differs along the stroke; (23) turns with the sign "
                "of the velocity."});
    part.charts.push_back(
        report::LineChart{.title = fmt::format("Friction through a reversal at {} bar", kPulledAt_bar[r]),
                          .caption = "The plant's piston, with stick and slip, follows the measured motion.",
                          .y = {"Friction", "N"},
                          .curves = {{.name = "measured",
                                      .x = driven.time_s,
                                      .y = driven.measured_N,
                                      .stroke = report::Stroke::kPoints,
                                      .ink = report::Ink::kNeutral},
                                     {.name = "plant", .x = driven.time_s, .y = driven.plant_N}}});
  }
  part.text += fmt::format(
      " The plant's cylinder is then taken through the measured motion of one reversal at each pressure, "
      "with that F_c alone. The records hardly show its stick phase: no piston keeps within 0.2 mm for "
      "longer than {:.2f} s, and the plant's sticks for {:.1f} ms at most.",
      kLongestStay_s, 1e3 * most_stuck_s);
}

}  // namespace

Part measured_friction_part() {
  const std::vector<std::vector<SlidingRow>> rows = records();
  const FrictionTerms coulomb{.viscous = false, .stribeck_velocity_m_s = {}};
  const FrictionFit fit = fit_friction(rows, coulomb);
  const FrictionFit viscous = fit_friction(rows);
  const FrictionFit stribeck = fit_friction(rows, {.viscous = false, .stribeck_velocity_m_s = 5e-3});
  double in_means = 0.0;
  for (const std::vector<PulledMean>& record : kMeasuredFriction)
    for (const PulledMean& mean : record) in_means += mean.samples;

  Part part;
  part.title = "(23) on measured friction";
  part.text = fmt::format(
      "A 25 mm O-ring piston pulled at four pressures (not of the paper; "
      "EvaZillen/3D-printed-pneumatic-actuator, CC0): means over 1 mm/s of {:.0f} of {:.0f} sliding samples. "
      "Coulomb friction for each pressure: {:.1f}, {:.1f}, {:.1f}, {:.1f} N at 1, 3, 5, 7 bar; area {:.0f} "
      "mm2, force zero {:.1f} N; the means are met within {:.2f} N RMS, the samples within {:.2f} N. The "
      "bench pulls at 5 to 10 mm/s one way and 11 to 14 the other and imposes the motion: viscous, Stribeck "
      "and breakaway friction cannot be told.",
      in_means, kSlidingSamples, fit.coulomb_N[0], fit.coulomb_N[1], fit.coulomb_N[2], fit.coulomb_N[3],
      1e6 * fit.area_m2, fit.zero_N, fit.rms_N, kRmsOfTheSamples_N);
  add_fit(part, fit, viscous, stribeck);
  part.charts.push_back(means_chart(rows, fit));
  add_reversals(part, fit);
  return part;
}

}  // namespace plenum::host::reproduce::servo
