#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "host-sim/identify/relief_valve/dynamic_fit.hpp"
#include "host-sim/identify/relief_valve/static_fit.hpp"
#include "host-sim/plant/relief_valve/two_stage_static.hpp"
#include "host-sim/reproduce/relief_valve/parts.hpp"
#include "host-sim/reproduce/relief_valve/printed.hpp"
#include "host-sim/reproduce/relief_valve/recorded.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::relief_valve {
namespace {

using namespace identify::relief_valve;
using namespace plant::relief_valve;

/// Changes of flow that the source did not try: as sudden as the supply allows.
const std::vector<FlowChange> kSudden{{"sudden, 9.3 to 89 l/min", 9.3, 89.0, 79.7e3, 0.28},
                                      {"sudden, 89 to 60 l/min", 89.0, 60.0, 29e3, 0.28},
                                      {"sudden, 200 to 240 l/min", 200.0, 240.0, 40e3, 0.28}};

struct Test {
  FlowChange change;
  Transient record;
  std::vector<double> predicted_Pa;
  PredictionError error, static_error, constant_error;
  double swing_psi;       ///< of the record
  double worst_of_swing;  ///< largest |P model - P|, of the swing
  double final_of_swing;  ///< P model - P of the last tenth of the record, of the swing
};

Test tried(const TwoStagePhysics& physics, const FlowChange& change, const GreyBoxConfig& valve) {
  Test test{.change = change,
            .record = recorded(physics, change),
            .predicted_Pa = {},
            .error = {},
            .static_error = {},
            .constant_error = {},
            .swing_psi = 0.0,
            .worst_of_swing = 0.0,
            .final_of_swing = 0.0};
  test.predicted_Pa = predict_pressure(valve, test.record);
  test.error = prediction_error(test.predicted_Pa, test.record);
  GreyBoxConfig without_lag = valve;
  without_lag.lag_s = 0.0;
  test.static_error = prediction_error(predict_pressure(without_lag, test.record), test.record);
  const std::vector<double> constant(test.record.pressure_Pa.size(), test.record.pressure_Pa.front());
  test.constant_error = prediction_error(constant, test.record);
  const auto [least, most] =
      std::minmax_element(test.record.pressure_Pa.begin(), test.record.pressure_Pa.end());
  test.swing_psi = (*most - *least) / kPsi_Pa;
  const std::size_t rows = test.predicted_Pa.size();
  const std::size_t tail = std::max<std::size_t>(1, rows / 10);
  for (std::size_t k = 0; k < rows; ++k) {
    const double part = (test.predicted_Pa[k] - test.record.pressure_Pa[k]) / (*most - *least);
    test.worst_of_swing = greater_of(test.worst_of_swing, std::abs(part));
    if (k + tail >= rows) test.final_of_swing += part / static_cast<double>(tail);
  }
  return test;
}

std::vector<double> psi(std::vector<double> pressure_Pa) {
  for (double& P : pressure_Pa) P /= kPsi_Pa;
  return pressure_Pa;
}

report::LineChart chart(const Test& test) {
  std::vector<double> time_s;
  for (std::size_t k = 0; k < test.record.pressure_Pa.size(); ++k)
    time_s.push_back(test.record.step_s * static_cast<double>(k));
  return {.title = "Test " + test.change.name + ": pressure",
          .y = {"Pressure difference", "psi"},
          .curves = {{"classical valve", time_s, psi(test.record.pressure_Pa), report::Stroke::kSolid,
                      report::Ink::kNeutral},
                     {"grey-box model", time_s, psi(test.predicted_Pa)}}};
}

}  // namespace

Part identified_valve() {
  const TwoStagePhysics physics(appendix_a_settling());
  const double density = physics.config().density_kg_m3;
  // First stage: the static curve, tests' range. Second: the lag alone, on run 1, as the paper.
  const std::vector<StaticPoint> points = static_points(physics, 10.0, 110.0, 21);
  const GreyBoxConfig valve = identified_in_two_stages(physics, points);
  const StaticGreyBox line{valve.k1_m2_Pa, 0.0, valve.k3_m2, density};
  const StaticGreyBox two_points = static_through(cracking_pressure_Pa(line), points.back(), density);

  std::vector<Test> tests;
  for (const FlowChange& change : table_v()) tests.push_back(tried(physics, change, valve));
  const std::size_t from_table = tests.size();
  for (const FlowChange& change : kSudden) tests.push_back(tried(physics, change, valve));

  Part part{
      .title = "Two-stage identification of the classical valve, Fig. 17 to 23", .text = "", .findings = {}};
  part.findings.push_back(
      {.item = "Fig. 16",
       .quantity = "largest error of the static line (3.15) through cracking and 110 l/min",
       .unit = "%",
       .paper = 3.0,
       .ours = 100.0 * worst_pressure_error(two_points, points),
       .expect = Expect::kAtMost,
       .why = "the static curve bends more than the paper's"});
  for (const Test& test : tests) {
    const bool printed = &test < tests.data() + from_table;
    const char* const item = printed ? "summary, Table V" : "summary";
    const char* const instead = printed ? "the summary's bound, there of the pressure" : "";
    part.findings.push_back(
        {.item = item,
         .quantity = std::string("largest transient error") + (printed ? " of the swing" : "") + ", test " +
                     test.change.name,
         .unit = "%",
         .paper = 15.0,
         .ours = 100.0 * (printed ? test.worst_of_swing : test.error.worst),
         .expect = Expect::kAtMost,
         .instead = instead,
         .why = printed
                    ? "the bound is the paper's for the error as a share of the pressure, which a constant "
                      "pressure meets here; of the swing the model misses more"
                    : "the grey-box model does not follow this change"});
    part.findings.push_back(
        {.item = item,
         .quantity = std::string("error at the end") + (printed ? " of the swing" : "") + ", test " +
                     test.change.name,
         .unit = "%",
         .paper = 5.0,
         .ours = 100.0 * std::abs(printed ? test.final_of_swing : test.error.final),
         .expect = Expect::kAtMost,
         .instead = instead,
         .why = printed
                    ? "the bound is the paper's for the error as a share of the pressure, which a constant "
                      "pressure meets here; of the swing the model is off by more"
                    : "the grey-box model does not settle where the valve does"});
  }
  for (std::size_t i = 0; i < from_table; ++i) {
    const Test& test = tests[i];
    part.findings.push_back(
        {.item = "Table V",
         .quantity = "largest transient error, test " + test.change.name,
         .unit = "%",
         .paper = kTable5[i].worst_percent,
         .ours = 100.0 * test.error.worst,
         .expect = Expect::kAtMost,
         .why = "the classical valve is followed less closely than the paper followed its own"});
    part.findings.push_back({.item = "Table V",
                             .quantity = "error at the end, test " + test.change.name,
                             .unit = "%",
                             .paper = std::abs(kTable5[i].final_percent),
                             .ours = 100.0 * std::abs(test.error.final),
                             .tolerance = 0.5,  // "0 %" of test 1
                             .expect = Expect::kAtMost,
                             .why = "the classical valve settles farther off than the paper's own did"});
  }
  for (std::size_t i = from_table; i < tests.size(); ++i) {
    part.findings.push_back(
        {.item = "summary",
         .quantity = "largest error of a constant pressure, test " + tests[i].change.name,
         .unit = "%",
         .paper = 15.0,
         .ours = 100.0 * tests[i].constant_error.worst,
         .expect = Expect::kAtLeast,
         .instead = "a bound that asks for a model",
         .why = "a constant pressure meets the paper's bound too: of a change that moves the "
                "pressure so little it says nothing"});
  }
  // All three constants from the transient, either damping law: Table IV.
  const std::vector<Transient> run_1{recorded(physics, table_v().front())};
  const auto free_run_error = [&](Damping damping) {
    const GreyBoxConfig found = fit_free_run(run_1, fit_algebraic(run_1, density, damping)).valve;
    return 100.0 * prediction_error(predict_pressure(found, run_1[0]), run_1[0]).worst;
  };
  const double constant_percent = free_run_error(Damping::kConstant);
  const double over_pressure_percent = free_run_error(Damping::kOverPressure);
  part.findings.push_back(
      {.item = "Table IV",
       .quantity = "difference of the largest errors with k2 and with k2/P, all three constants from run 1",
       .unit = "%",
       .paper = 1.5,
       .ours = std::abs(constant_percent - over_pressure_percent),
       .expect = Expect::kAtMost,
       .why = "the two damping laws differ by more than in the paper"});

  double worst_of_swing = 0.0;
  double worst_constant = 0.0;
  for (std::size_t i = 0; i < from_table; ++i) {
    const Test& test = tests[i];
    worst_of_swing = greater_of(worst_of_swing, 100.0 * test.worst_of_swing);
    worst_constant = greater_of(worst_constant, 100.0 * test.constant_error.worst);
  }
  std::vector<double> sudden_constant;
  for (std::size_t i = from_table; i < tests.size(); ++i)
    sudden_constant.push_back(100.0 * tests[i].constant_error.worst);
  const double most_sudden_constant = largest(sudden_constant);
  const double least_sudden_constant = *std::min_element(sudden_constant.begin(), sudden_constant.end());
  part.text = fmt::format(
      "The real valve is appendix A's (the settling one); records hold pressure and flow at its port every "
      "millisecond, without noise. The seven changes of flow are "
      "those of Table V as ramps of the supply at the average rates printed. Stage one: k1 and k3 by least "
      "squares on the static curve from 10 to 110 l/min (cracking at {:.1f} psi). "
      "Stage two: the lag alone on run 1 by (4.5): {:.1f} ms. The other tests are predicted. This valve "
      "regulates so well (its static curve rises by {:.0f} psi over the whole range) that "
      "15 % of the pressure is no hard test: on Table V's changes even a constant pressure is off by no more "
      "than {:.1f} %. Beside Table V, test by test, their errors are therefore taken as a share of the swing "
      "of "
      "pressure, too, of which the grey-box model misses {:.0f} % at most. The flows of tests 5, 3 and 6 are "
      "guessed where the scan is damaged. The sudden changes "
      "are the "
      "harder ones: there a constant pressure is off by {:.1f} to {:.1f} %, so that 15 % is a test only "
      "where "
      "it is off by more, and the static model alone is off by up to {:.0f} %.",
      cracking_pressure_Pa(line) / kPsi_Pa, 1e3 * valve.lag_s,
      (points.back().pressure_Pa - points.front().pressure_Pa) / kPsi_Pa, worst_constant, worst_of_swing,
      least_sudden_constant, most_sudden_constant,
      100.0 * std::max_element(tests.begin(), tests.end(), [](const Test& a, const Test& b) {
                return a.static_error.worst < b.static_error.worst;
              })->static_error.worst);

  report::BarChart bars{
      .title = "Largest error of pressure by test",
      .categories = {},
      .value = {"Largest error", "%"},
      .series = {{"grey-box model", {}}, {"static model alone", {}}, {"constant pressure", {}}},
      .marks = {{report::Mark::On::kY, 15.0, "paper's claim"}}};
  for (const Test& test : tests) {
    bars.categories.push_back(test.change.name);
    bars.series[0].values.push_back(100.0 * test.error.worst);
    bars.series[1].values.push_back(100.0 * test.static_error.worst);
    bars.series[2].values.push_back(100.0 * test.constant_error.worst);
  }
  part.charts = {std::move(bars)};
  for (const Test& test : tests) part.charts.emplace_back(chart(test));
  return part;
}

}  // namespace plenum::host::reproduce::relief_valve
