// Fig. 6: steps up and down, dead band and hysteresis, and the piecewise model of three conditions.
#include <cmath>
#include <cstddef>

#include "host-sim/identify/regulator_valve/branch.hpp"
#include "host-sim/identify/regulator_valve/fit_measure.hpp"
#include "host-sim/identify/regulator_valve/piecewise.hpp"
#include "host-sim/reproduce/regulator_valve/parts.hpp"
#include "host-sim/reproduce/regulator_valve/printed.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::regulator_valve {
namespace {

namespace id = identify::regulator_valve;

constexpr std::size_t kEvery = 8;  // sample of a chart

id::CenteredModel centered(const Identified& identified) {
  return {identified.swarm.model, identified.branch.mean_screw_m, identified.branch.mean_pressure_Pa};
}

// The largest change of a settled pressure over turns that stay within the dead band after the top.
double largest_change_within_band_Pa(const std::vector<id::Plateau>& plateaus, std::size_t top) {
  double largest = 0.0;
  for (std::size_t i = top + 1; i < plateaus.size(); ++i) {
    if (plateaus[i].screw_m > plateaus[top].screw_m - kPrintedDeadBand_m)
      largest = greater_of(largest, std::abs(plateaus[i].settled_Pa - plateaus[top].settled_Pa));
  }
  return largest;
}

}  // namespace

Part step_experiment(const Campaign& campaign) {
  const Run& run = campaign.runs.front();
  const auto& recording = run.recording;
  const id::DeadBand band = id::measure_dead_band(recording);
  const std::vector<id::Plateau> plateaus = id::plateaus(recording);
  const auto top = static_cast<std::size_t>(kTurns);
  const double noise_Pa = plant::regulator_valve::TestbedConfig{}.noise_Pa;
  // From the first rest within (11) on the way up to the last one on the way down: what the models are for, and the
  // top beyond it, where the rising model is on its own.
  const std::size_t first = run.rising.branch.first;
  const std::size_t end = run.falling.branch.first + run.falling.branch.screw_m.size();
  const id::PiecewiseModel model{
      .rising = centered(run.rising), .falling = centered(run.falling), .dead_band_m = band.width_m};
  const auto cut = [&](const std::vector<double>& whole) {
    return std::vector<double>(whole.begin() + static_cast<std::ptrdiff_t>(first),
                               whole.begin() + static_cast<std::ptrdiff_t>(end));
  };
  const std::vector<double> predicted =
      id::predict(model, cut(recording.screw_m), recording.pressure_Pa[first]);
  const double piecewise_fit = id::fit_percent(cut(recording.pressure_Pa), predicted);

  report::Curve screw{.name = "screw", .x = {}, .y = {}, .stroke = report::Stroke::kSteps};
  report::Curve pressure{.name = "measured", .x = {}, .y = {}, .ink = report::Ink::kNeutral};
  report::Curve piecewise{.name = "piecewise model", .x = {}, .y = {}};
  for (std::size_t k = 0; k < recording.screw_m.size(); k += kEvery) {
    const double t_s = static_cast<double>(k) * recording.sample_s;
    screw.x.push_back(t_s);
    screw.y.push_back(1e3 * recording.screw_m[k]);
    pressure.x.push_back(t_s);
    pressure.y.push_back(recording.pressure_Pa[k]);
    if (k < first || k >= end) continue;
    piecewise.x.push_back(t_s);
    piecewise.y.push_back(predicted[k - first]);
  }
  report::Curve up{.name = "up", .x = {}, .y = {}};
  report::Curve down{.name = "down", .x = {}, .y = {}};
  for (std::size_t i = 0; i < plateaus.size(); ++i) {
    for (report::Curve* branch : {&up, &down}) {  // the top belongs to both
      if (branch == &up ? i > top : i < top) continue;
      branch->x.push_back(1e3 * plateaus[i].screw_m);
      branch->y.push_back(plateaus[i].settled_Pa);
    }
  }
  const std::vector<report::Mark> range{{report::Mark::On::kY, kPrintedLow_Pa, "(11)"},
                                        {report::Mark::On::kY, kPrintedHigh_Pa, "(11)"}};
  return {
      .title = "Fig. 6: step experiment, and the model of three conditions",
      .text =
          "Thirteen quarter turns up from 0 mm and thirteen down, 5 s each, 1 kPa of noise (the paper "
          "prints neither holds nor noise). Dead band and slopes from the settled pressures within (11); "
          "the bench valve is made of the very 0.9 mm and 1.56e5 Pa/mm of section 4, so hysteresis, dead "
          "band and slopes show that they come back from a noisy recording, and nothing of the paper's "
          "valve. The piecewise model: (30) and (31) as the swarm found them, the pressure at rest within "
          "the measured dead band; run freely over up, top and down from one start pressure.",
      .findings =
          {{.item = "Fig. 6",
            .quantity = "hysteresis: distance of the falling from the rising line",
            .unit = "mm",
            .paper = 1e3 * kPrintedDeadBand_m,
            .ours = 1e3 * band.width_m,
            .tolerance = 0.05,
            .source = Source::kSetToPaper,
            .why = "the overlap of the spool does not give the hysteresis"},
           {.item = "Fig. 6, section 2",
            .quantity = "dead band at the beginning of the range: where the rising line leaves no pressure",
            .unit = "mm",
            .paper = 1e3 * kPrintedDeadBand_m,
            .ours = 1e3 * band.rising_start_m,
            .tolerance = 0.05,
            .source = Source::kSetToPaper,
            .why = "the overlap of the spool does not give the dead band"},
           {.item = "section 4",
            .quantity =
                "\"else the pressure stays steady\": largest change of the settled pressure within the band",
            .unit = "Pa",
            .paper = 0.0,
            .ours = largest_change_within_band_Pa(plateaus, top),
            .tolerance = noise_Pa / 3.0,
            .why = "air leaks while both ports are shut"},
           {.item = "section 4",
            .quantity = "pressure for each mm, rising",
            .unit = "Pa/mm",
            .paper = 1e-3 * kPrintedSlope_Pa_m,
            .ours = 1e-3 * band.rising_slope_Pa_m,
            .tolerance = 0.005e5,
            .source = Source::kSetToPaper,
            .why = "the plateaus have not settled"},
           {.item = "section 4",
            .quantity = "pressure for each mm, falling",
            .unit = "Pa/mm",
            .paper = 1e-3 * kPrintedSlope_Pa_m,
            .ours = 1e-3 * band.falling_slope_Pa_m,
            .tolerance = 0.005e5,
            .source = Source::kSetToPaper,
            .why = "the plateaus have not settled"},
           {.item = "section 4, (39)",
            .quantity = "fit of the piecewise model, free run over up, top and down",
            .unit = "%",
            .paper = 90.0,
            .ours = piecewise_fit,
            .expect = Expect::kAtLeast,
            .why = "above (11) the inlet is no longer blocked, which the rising model does not know"}},
      .charts = {
          report::LineChart{.title = "Fig. 6: pressure",
                            .caption = "The piecewise model starts once, at the first rest within (11).",
                            .y = {"Gauge pressure", "Pa"},
                            .curves = {pressure, piecewise},
                            .marks = range,
                            .group = "regulator valve, Fig. 6"},
          report::LineChart{.title = "Fig. 6: screw",
                            .y = {"Screw", "mm"},
                            .curves = {screw},
                            .group = "regulator valve, Fig. 6"},
          report::XyChart{
              .title = "Fig. 6: settled pressure over the screw",
              .caption = "Dead band at the beginning, hysteresis between up and down: one number, 0.9 mm.",
              .x = {"Screw", "mm"},
              .y = {"Gauge pressure", "Pa"},
              .curves = {up, down}}}};
}

}  // namespace plenum::host::reproduce::regulator_valve
