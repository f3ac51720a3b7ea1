#include "host-sim/blind/score.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::blind {
namespace {

using Json = nlohmann::ordered_json;

Label one(const char* id, const char* equation, double gap = 10.0, double rest = 8.0, int tier = 1) {
  return {"case", "one", tier, 100.0, rest, {{id, true, equation, gap, rest}}};
}

Label many(std::vector<TrueEffect> effects) {
  return {"case", "many", 1, 100.0, 10.0, std::move(effects)};
}

Label none() {
  return {"case", "none", 1, 100.0, 0.0, {}};
}

Label unknown() {
  return {"case", "unknown", 1, 100.0, 10.0, {{"neighbour", false, "supply", 10.0, 10.0}}};
}

Answer says(const char* verdict, std::vector<NamedEffect> effects = {}, const char* equation = "") {
  return {true, verdict, std::move(effects), {}, equation, 1000.0, 100.0};
}

TEST(BlindScore, CountsTheFirstNameByTier) {
  const std::vector<Label> labels{one("spool_lag", "command"), one("dead_time", "command", 10, 8, 2),
                                  one("dead_time", "command", 10, 8, 2)};
  const std::vector<Answer> answers{
      says("explained", {{"spool_lag", 0.9, {}}}, "command"),
      says("explained", {{"dead_time", 0.9, {}}, {"sensor_lag", 0.6, {}}}, "command"),
      says("explained", {{"sensor_lag", 0.9, {"dead_time"}}}, "sensor")};
  const Json result = score(labels, answers);
  EXPECT_EQ(result["top1_percent"]["tier1"]["percent"], 100.0);
  EXPECT_EQ(result["top1_percent"]["tier2"]["percent"], 50.0);
  EXPECT_EQ(result["top1_percent"]["all"]["right"], 2);
  EXPECT_EQ(result["coverage_percent"]["right"], 3) << "an alias is in the set";
  EXPECT_EQ(result["singleton_correct_percent"]["of"], 1)
      << "two names, or a name with an alias, are no singletons";
  EXPECT_EQ(result["equation_named_percent"]["right"], 2);
}

TEST(BlindScore, CountsTheEquationThatWasFoundBeforeAnyNameApart) {
  const std::vector<Label> labels(3, one("dead_time", "command"));
  std::vector<Answer> answers(3, says("explained", {{"dead_time", 0.9, {}}}, "command"));
  answers[0].disturbed = "command";
  answers[1].disturbed = "sensor";
  const Json result = score(labels, answers);
  EXPECT_EQ(result["equation_named_percent"]["right"], 3);
  EXPECT_EQ(result["equation_before_names_percent"]["right"], 1);
  EXPECT_EQ(result["equation_before_names_percent"]["of"], 2) << "a report that has none is not asked";
}

TEST(BlindScore, AnAmbiguousAnswerWithTheTruthIsNoFailureAndOneWithoutItIs) {
  const std::vector<Label> labels{one("dead_time", "command"), one("dead_time", "command")};
  const std::vector<Answer> answers{
      says("ambiguous", {{"spool_lag", 0.5, {}}, {"dead_time", 0.5, {}}}, "command"),
      says("ambiguous", {{"spool_lag", 0.5, {}}, {"sensor_lag", 0.5, {}}}, "command")};
  const Json result = score(labels, answers);
  EXPECT_EQ(result["top1_percent"]["all"]["of"], 1);
  EXPECT_EQ(result["top1_percent"]["all"]["right"], 0);
  EXPECT_EQ(result["counts"]["one_ambiguous_with_truth"], 1);
  EXPECT_EQ(result["coverage_percent"]["percent"], 50.0);
}

TEST(BlindScore, WhatCalibrationAbsorbsIsCountedApart) {
  const std::vector<Label> labels{
      one("volume_error", "energy", 50.0, 0.1), one("volume_error", "energy", 50.0, 20.0),
      one("volume_error", "energy", 0.3, 0.2), one("volume_error", "energy", 50.0, 0.8)};
  const std::vector<Answer> answers(4, says("calibration"));
  const Json result = score(labels, answers);
  EXPECT_EQ(result["counts"]["one_absorbed"], 1);
  EXPECT_EQ(result["counts"]["one_absorbed_answered_calm"], 1);
  EXPECT_EQ(result["counts"]["one_small"], 2) << "below the floor, or between closed and detectable";
  EXPECT_EQ(result["top1_percent"]["all"]["of"], 1);
  EXPECT_EQ(result["top1_percent"]["all"]["right"], 0) << "calibration leaves 20 floors here: a miss";
}

TEST(BlindScore, AWrongNameAloneCountsHoweverSmallTheEffect) {
  const Json result = score({one("dead_time", "command", 0.2, 0.1)},
                            {says("explained", {{"sensor_lag", 0.9, {}}}, "sensor")});
  EXPECT_EQ(result["singleton_correct_percent"]["percent"], 0.0);
  EXPECT_TRUE(result["top1_percent"]["all"]["percent"].is_null());
}

TEST(BlindScore, F1CountsHitsFalseNamesAndMissesOverAllSets) {
  const Label label = many({{"spool_lag", true, "command", 10, 9},
                            {"sensor_bias", true, "sensor", 10, 9},
                            {"volume_error", true, "energy", 10, 0.0}});
  const Json result = score(
      {label},
      {says("explained", {{"spool_lag", 0.9, {}}, {"tube_dynamics", 0.6, {}}, {"volume_error", 0.5, {}}})});
  EXPECT_EQ(result["multi_f1"]["hits"], 1);
  EXPECT_EQ(result["multi_f1"]["misses"], 1) << "the absorbed one is none";
  EXPECT_EQ(result["multi_f1"]["false_names"], 1) << "a true one that is absorbed is not false";
  EXPECT_DOUBLE_EQ(result["multi_f1"]["f1"].get<double>(), 2.0 / 4.0);
}

TEST(BlindScore, AnythingButCalmIsAFalseAlarmWhereNothingIsWrong) {
  const Json result = score(
      {none(), none(), none(), none()},
      {says("none"), says("calibration"), says("unexplained"), says("explained", {{"dead_time", 0.9, {}}})});
  EXPECT_EQ(result["false_alarm_percent"]["percent"], 50.0);
}

TEST(BlindScore, UnknownEffectsMustBeFlaggedUnlessTheCatalogueFitsThem) {
  Answer poor = says("explained", {{"supply_droop", 0.9, {}}});
  poor.with_effects_Pa = 500.0;
  Answer fits = poor;
  fits.with_effects_Pa = 105.0;
  const Json result =
      score({unknown(), unknown(), unknown(), unknown()},
            {says("unexplained"), says("partly_explained", {{"supply_droop", 0.7, {}}}), poor, fits});
  EXPECT_EQ(result["unknown_flagged_percent"]["right"], 2);
  EXPECT_EQ(result["unknown_flagged_percent"]["of"], 3);
  EXPECT_EQ(result["counts"]["unknown_fitted_by_the_catalogue"], 1);
}

TEST(BlindScore, ClosedIsMeasuredAgainstTheLabelsFloor) {
  Answer half = says("explained", {{"spool_lag", 0.9, {}}}, "command");
  half.recalibrated_Pa = 1100.0;
  half.with_effects_Pa = 600.0;
  EXPECT_EQ(score({one("spool_lag", "command")}, {half})["closed_median_percent"], 50.0);
}

TEST(BlindScore, CalibrationErrorIsTheMeanDistanceOfConfidenceFromFrequency) {
  // Four names at 0.9 of which three are right, one at 0.2 that is wrong: (4 |0.9 - 0.75| + |0.2 - 0|)/5.
  std::vector<Label> labels(4, one("spool_lag", "command"));
  std::vector<Answer> answers(3, says("explained", {{"spool_lag", 0.9, {}}}, "command"));
  answers.push_back(says("explained", {{"dead_time", 0.9, {}}, {"sensor_lag", 0.2, {}}}, "command"));
  EXPECT_NEAR(score(labels, answers)["calibration_error"].get<double>(), (4 * 0.15 + 0.2) / 5.0, 1e-12);
}

TEST(BlindScore, ACaseWithoutAnswerIsWrong) {
  const Json result = score({one("spool_lag", "command"), none()}, {Answer{}, Answer{}});
  EXPECT_EQ(result["missing_answers"], 2);
  EXPECT_EQ(result["top1_percent"]["all"]["percent"], 0.0);
  EXPECT_EQ(result["false_alarm_percent"]["percent"], 100.0);
}

TEST(BlindScore, ConfusionCountsFirstNames) {
  const Json result = score({one("spool_lag", "command"), one("spool_lag", "command"), none()},
                            {says("explained", {{"spool_lag", 0.9, {}}}, "command"),
                             says("explained", {{"dead_time", 0.9, {}}}, "command"), says("calibration")});
  EXPECT_EQ(result["confusion"]["truth"], Json({"spool_lag", "none"}));
  unsigned all = 0;
  for (const Json& line : result["confusion"]["counts"]) {
    for (const Json& n : line) all += n.get<unsigned>();
  }
  EXPECT_EQ(all, 3U);
  EXPECT_NE(confusion_text(result).find("dead_time"), std::string::npos);
}

TEST(BlindAnswers, AreReadToTheContractOrRefusedWithFileAndField) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("plenum-blind-answers-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const auto file = folder / "case-0001.json";
  const Json good = Json::parse(R"({"schema": "plenum-gap/1",
    "gap_kPa": {"as_configured": 21.4, "recalibrated": 13.6, "with_effects": 0.52, "noise_floor": 0.31},
    "closed_fraction": 0.984, "verdict": "explained",
    "effects": [{"id": "spool_lag", "confidence": 0.99, "gap_without_kPa": 13.6, "gap_with_kPa": 0.52,
                 "parameters": {}, "aliases": ["dead_time"]}],
    "candidates": [{"id": "spool_lag", "heldout_kPa": 0.52, "confidence": 0.99}],
    "equation": {"id": "command", "confidence": 0.97}, "where": [], "next_experiment": null})");
  trace::write_whole_file(file, good.dump());
  const Answer answer = read_answer(file);
  EXPECT_TRUE(answer.given);
  EXPECT_EQ(answer.effects.at(0).aliases.at(0), "dead_time");
  EXPECT_EQ(answer.equation, "command");
  EXPECT_DOUBLE_EQ(answer.recalibrated_Pa, 13.6e3);
  EXPECT_FALSE(answer.disturbed.has_value());
  EXPECT_FALSE(read_answer(folder / "absent.json").given);
  Json more = good;
  more["disturbances"] = Json::array();
  trace::write_whole_file(file, more.dump());
  EXPECT_EQ(read_answer(file).disturbed, "") << "none was looked for";
  more["disturbances"].push_back({{"equation", "sensor"}, {"probability", 0.8}});
  more["disturbances"].push_back({{"equation", "command"}, {"probability", 0.2}});
  trace::write_whole_file(file, more.dump());
  EXPECT_EQ(read_answer(file).disturbed, "sensor");

  const auto refused = [&](const Json& report, const char* expected) {
    trace::write_whole_file(file, report.dump());
    try {
      read_answer(file);
      ADD_FAILURE() << "read, expected an error of " << expected;
    } catch (const trace::InputError& error) {
      EXPECT_NE(std::string(error.what()).find("case-0001.json"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(expected), std::string::npos) << error.what();
    }
  };
  Json bad = good;
  bad["schema"] = "plenum-gap/2";
  refused(bad, "schema");
  bad = good;
  bad["verdict"] = "perhaps";
  refused(bad, "verdict");
  bad = good;
  bad["effects"][0]["confidence"] = 1.5;
  refused(bad, "confidence");
  bad = good;
  bad["gap_kPa"].erase("recalibrated");
  refused(bad, "recalibrated");
  bad = good;
  bad["effects"] = 3;
  refused(bad, "effects");
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace plenum::host::blind
