#include "host-sim/diagnose/gap_json.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace plenum::host::diagnose {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The report that the contract shows as its example.
GapReport example() {
  GapReport report;
  report.as_configured_Pa = 21400.0;
  report.recalibrated_Pa = 13600.0;
  report.with_effects_Pa = 520.0;
  report.noise_floor_Pa = 310.0;
  report.closed_fraction = 0.984;
  report.verdict = Verdict::explained;
  report.effects = {{.id = "spool_lag",
                     .confidence = 0.99,
                     .gap_without_Pa = 13600.0,
                     .gap_with_Pa = 520.0,
                     .share = 1.0,
                     .parameters = {{"natural_frequency_Hz", 9.8, 9.7, 9.9, false}},
                     .aliases = {"dead_time"}}};
  report.candidates = {{"spool_lag", 520.0, 0.99, {{"natural_frequency_Hz", 9.8, 9.7, 9.9, false}}}};
  report.equation = Blame{"command", 0.97};
  report.where = {{"command moving, supply port open", 0.71}};
  report.gap_p_value = 0.001;
  report.calibration = {{"open_above_V", 5.08, {"open_above_V", 5.1, 5.09, 5.11, false}, 5.095}};
  report.detectable = {{"chamber_leak", "area_m2", 2.5e-8}};
  report.alias_classes = {{"spool_lag", "dead_time"}};
  report.disturbances = {{"command", 0.97, 0.12, "V", "the command before", 0.83}};
  report.baseline = Baseline{Verdict::calibration, 9100.0, 305.0, {}};
  report.baseline->effects.push_back(
      {.id = "dead_time", .parameters = {{"delay_s", 0.03, 0.029, 0.031, false}}, .aliases = {}});
  report.stamped_early_s = 0.00025;
  return report;
}

/// Written by hand from the contract; what is added to it stands last in each object.
constexpr const char* kGolden = R"({
  "schema": "plenum-gap/1",
  "gap_kPa": {"as_configured": 21.4, "recalibrated": 13.6, "with_effects": 0.52, "noise_floor": 0.31},
  "closed_fraction": 0.984,
  "verdict": "explained",
  "effects": [
    {"id": "spool_lag", "confidence": 0.99, "gap_without_kPa": 13.6, "gap_with_kPa": 0.52,
     "parameters": {"natural_frequency_Hz": {"value": 9.8, "ci95": [9.7, 9.9]}},
     "aliases": ["dead_time"], "share": 1.0}
  ],
  "candidates": [{"id": "spool_lag", "heldout_kPa": 0.52, "confidence": 0.99,
                  "parameters": {"natural_frequency_Hz": {"value": 9.8, "ci95": [9.7, 9.9]}}}],
  "equation": {"id": "command", "confidence": 0.97},
  "where": [{"regime": "command moving, supply port open", "share": 0.71}],
  "next_experiment": null,
  "gap_p_value": 0.001,
  "calibration": {"open_above_V": {"configured": 5.08, "value": 5.1, "ci95": [5.09, 5.11], "with_effects": 5.095}},
  "detectable": [{"id": "chamber_leak", "parameter": "area_m2", "smallest": 2.5e-8}],
  "alias_classes": [["spool_lag", "dead_time"]],
  "disturbances": [{"equation": "command", "probability": 0.97, "size": 0.12, "unit": "V",
                    "depends_on": "the command before", "dependence": 0.83}],
  "baseline": {"verdict": "calibration", "as_configured_kPa": 9.1, "with_effects_kPa": 0.305, "effects": ["dead_time"],
               "parameters": {"dead_time": {"delay_s": {"value": 0.03, "ci95": [0.029, 0.031]}}}},
  "stamped_early_s": 0.00025
})";

TEST(GapJson, IsTheDocumentOfTheContractKeyByKeyInItsOrder) {
  EXPECT_EQ(to_json(example()).dump(1), Json::parse(kGolden).dump(1));
}

TEST(GapJson, OfAnEmptyReportHasEveryKeyOfTheContract) {
  const Json golden = Json::parse(kGolden);
  const Json json = to_json(GapReport{});
  for (const auto& [key, value] : golden.items()) EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_EQ(json["verdict"], "none");
  EXPECT_TRUE(json["equation"].is_null());
  for (const char* list : {"effects", "candidates", "where", "detectable", "alias_classes"}) {
    EXPECT_EQ(json[list], Json::array()) << list;
  }
  EXPECT_EQ(json["calibration"], Json::object());
  EXPECT_TRUE(json["baseline"].is_null());
}

TEST(GapJson, NamesTheNextExperimentWithItsReasonAndPower) {
  GapReport report = example();
  report.next = NextExperiment{
      "steps", "Steps part a lag from a delay.", {"spool_lag", "dead_time"}, 0.975123456, "Steps of 30 s."};
  EXPECT_EQ(to_json(report)["next_experiment"].dump(),
            R"({"excitation":"steps","why":"Steps part a lag from a delay.",)"
            R"("separates":["spool_lag","dead_time"],"power":0.97512,"instruction":"Steps of 30 s."})");
}

TEST(GapJson, NamesEachVerdictAsTheContractDoes) {
  const std::vector<std::pair<Verdict, const char*>> names{
      {Verdict::none, "none"},           {Verdict::calibration, "calibration"},
      {Verdict::explained, "explained"}, {Verdict::partly_explained, "partly_explained"},
      {Verdict::ambiguous, "ambiguous"}, {Verdict::unexplained, "unexplained"}};
  for (const auto& [verdict, name] : names) {
    GapReport report;
    report.verdict = verdict;
    EXPECT_EQ(to_json(report)["verdict"], name);
  }
}

TEST(GapJson, RoundsToFiveDigitsWhateverTheMagnitude) {
  GapReport report = example();
  report.as_configured_Pa = 21412.3456789;
  report.effects[0].parameters = {{"area_m2", 1.23456789e-8, -1.23456789e-8, 123456.789, false}};
  const Json json = to_json(report);
  EXPECT_EQ(json["gap_kPa"]["as_configured"].dump(), "21.412");
  EXPECT_EQ(json["effects"][0]["parameters"]["area_m2"].dump(),
            R"({"value":1.2346e-08,"ci95":[-1.2346e-08,123460.0]})");
}

TEST(GapJson, SaysNullWhereAFigureIsNotFiniteAndTellsABoundThatWasHit) {
  GapReport report = example();
  report.with_effects_Pa = kNaN;
  report.closed_fraction = kNaN;
  report.effects[0].parameters = {{"delay_s", 0.05, -std::numeric_limits<double>::infinity(), kNaN, true}};
  const Json json = to_json(report);
  EXPECT_TRUE(json["gap_kPa"]["with_effects"].is_null());
  EXPECT_TRUE(json["closed_fraction"].is_null());
  EXPECT_EQ(json["effects"][0]["parameters"]["delay_s"].dump(),
            R"({"value":0.05,"ci95":[null,null],"at_bound":true})");
}

}  // namespace
}  // namespace plenum::host::diagnose
