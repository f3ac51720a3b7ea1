// Fig. 11: the change of pressure within a tick, measured and predicted from the measured pressure.
#include "host-sim/identify/ticks.hpp"
#include "host-sim/reproduce/actuators/curve_figures.hpp"
#include "host-sim/reproduce/actuators/parts.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::actuators {
namespace {

/// p(t+h) - p(t) of every tick [kPa].
struct Changes {
  std::vector<double> measured;
  std::vector<double> predicted;
};
Changes changes_of(const Identified& chamber) {
  const identify::Ticks ticks = identify::lay_out({chamber.log});
  Changes changes;
  for (std::size_t row = 0; row + 1 < ticks.size(); ++row) {
    const double now = ticks.pressure_kPa[row];
    changes.measured.push_back(ticks.pressure_kPa[row + 1] - now);
    changes.predicted.push_back(
        identify::predict_free_run_kPa(chamber.one_step.model, ticks, row, 1).front() - now);
  }
  return changes;
}

/// Share of the variance of the measured change that the prediction explains [%].
double change_explained_percent(const Identified& chamber) {
  const Changes changes = changes_of(chamber);
  return explained_percent(changes.predicted, changes.measured);
}

report::LineChart chart_of(const Identified& chamber, const char* title, std::size_t from, std::size_t rows) {
  const Changes changes = changes_of(chamber);
  report::LineChart chart{.title = title, .y = {"Change of pressure in 10 ms", "kPa"}};
  report::Curve measured{.name = "measured", .x = {}, .y = {}, .ink = report::Ink::kNeutral};
  report::Curve predicted{.name = "predicted", .x = {}, .y = {}};
  for (std::size_t i = from; i < from + rows; ++i) {
    measured.x.push_back(chamber.log.time_s[i]);
    measured.y.push_back(changes.measured[i]);
    predicted.y.push_back(changes.predicted[i]);
  }
  predicted.x = measured.x;
  chart.curves = {std::move(measured), std::move(predicted)};
  return chart;
}

}  // namespace

Part pressure_change(const Study& study) {
  Part part{
      .title = "Fig. 11: fit of the pressure change",
      .text =
          "Change of pressure from one sample to the next, measured on the simulated chamber and predicted "
          "from the measured pressure by the one-step fit to that record. Typical: the chamber whose drift "
          "is the median of the 76. The paper shows its overlay and prints no number of it: \"the main "
          "features ... are captured\" is read as more than half of the variance.",
      .findings = {}};
  const Identified& at_rest_one = study.at_rest[place_of_typical(study.at_rest)];
  const Identified& moving_one = study.moving[place_of_typical(study.moving)];
  const std::vector<double> at_rest = over(study.at_rest, change_explained_percent);
  const std::vector<double> moving = over(study.moving, change_explained_percent);
  const auto explained = [&](const char* quantity, double ours) {
    part.findings.push_back(
        {.item = "Fig. 11",
         .quantity = quantity,
         .unit = "%",
         .paper = 50.0,
         .ours = ours,
         .expect = Expect::kAtLeast,
         .instead = "our reading of \"the main features\"",
         .why = "the one-step fit of this chamber does not describe its pressure change"});
  };
  explained("variance of the change explained, typical chamber, moving",
            change_explained_percent(moving_one));
  explained("variance of the change explained, the least of all chambers, moving", percentile(moving, 1e-9));
  explained("variance of the change explained, typical chamber at rest",
            change_explained_percent(at_rest_one));
  explained("variance of the change explained, the least of all chambers, at rest",
            percentile(at_rest, 1e-9));
  part.charts = {chart_of(moving_one, "Fig. 11: pressure change, 20 s of a typical chamber", 2000, 2000),
                 chart_of(moving_one, "Fig. 11, bottom: 2 s of it", 2500, 200)};
  return part;
}

}  // namespace plenum::host::reproduce::actuators
