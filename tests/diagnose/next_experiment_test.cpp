#include "host-sim/diagnose/next_experiment.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "host-sim/effects/catalogue.hpp"
#include "tests/identify/chamber/chamber_scene.hpp"

namespace plenum::host::diagnose {
namespace {

using identify::chamber::chamber_scene;
using identify::chamber::jumping_V;
using identify::chamber::make_scene;
using identify::chamber::Record;

using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Rival rival(const Scene& scene, effects::Id id, std::initializer_list<double> values) {
  Rival r{std::string(effects::kCatalogue[id]->id), effects::EffectSet{1} << id, scene.nominal};
  std::size_t at = effects::kFirstFigure[id];
  std::size_t k = 0;
  for (const double value : values)
    r.figures[at++] = effects::kCatalogue[id]->parameters[k++].coordinate_of(value);
  return r;
}

/// The odds of two rivals, as the README has the evidence, in logs of white noise about the one, drawn: how often they name it alone.
double drawn(double apart, std::size_t rows, double price) {
  constexpr int kLogs = 4000;
  const double pieces = std::min(static_cast<double>(rows), 200.0);
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise;
  int alone = 0;
  for (int log = 0; log < kLogs; ++log) {
    double of_true = 0.0, of_other = 0.0;
    for (std::size_t row = 0; row < rows; ++row) {
      const double error = noise(random);
      of_true += error * error;
      of_other += std::pow(error + (row % 2 == 0 ? apart : -apart), 2);
    }
    const double odds =
        std::exp(0.5 * pieces * std::log(of_other / of_true) + 0.5 * price * std::log(pieces));
    alone += odds / (1.0 + odds) >= 0.8 ? 1 : 0;
  }
  return static_cast<double>(alone) / kLogs;
}

TEST(NamedAlone, IsAsOftenAsInLogsThatAreDrawn) {
  struct Case {
    double apart;
    std::size_t rows;
    double price;
  };
  for (const auto& [apart, rows, price] :
       {Case{0.12, 400, 0.0}, {0.12, 1500, 0.0}, {0.3, 100, 0.0}, {0.25, 1500, -1.0}, {0.2, 1500, -1.0}}) {
    const double told = named_alone(apart, static_cast<double>(rows), price);
    EXPECT_NEAR(told, drawn(apart, rows, price), 0.02) << apart << ", " << rows << " rows, price " << price;
    EXPECT_GT(told, 0.02);
    EXPECT_LT(told, 0.98);
  }
  EXPECT_EQ(named_alone(0.0, 3000.0, 0.0), 0.0);
  EXPECT_EQ(named_alone(0.0, 3000.0, 1.0), 1.0) << "the simpler of two that are one, by its price";
}

TEST(NextExperiment, AVolumeErrorIsPartedFromAChangeOfGainByAnotherVolumeOnly) {
  const Scene scene = chamber_scene(jumping_V(2000), 0.0);
  const Rival volume = rival(scene, effects::kIdVolumeError, {20.0});
  Rival gain{"gain", 0, scene.nominal};
  for (const auto figure : {effects::kInletGain, effects::kExhaustGain, effects::kInletLeak,
                            effects::kExhaustLeak, effects::kTransition}) {
    gain.figures[figure] *= 150.0 / 170.0;
  }
  const NextExperiment next = next_experiment(scene, {volume, gain});
  EXPECT_THAT(next.excitation, AnyOf(HasSubstr("volume"), HasSubstr("moving")));
  EXPECT_GT(next.power, 0.99);
  EXPECT_THAT(next.separates, ElementsAre("volume_error", "gain"));
  EXPECT_THAT(next.why, HasSubstr("volume_error and gain answer alike on this log"));
  EXPECT_THAT(next.why, HasSubstr("kPa RMS"));
}

TEST(NextExperiment, TheSameChamberUnderTwoNamesIsPartedByNoInput) {
  const Scene scene = chamber_scene(jumping_V(1000), 0.0);
  const Rival one = rival(scene, effects::kIdDeadTime, {0.01});
  Rival other = one;
  other.id = "twin";
  const NextExperiment next = next_experiment(scene, {one, other});
  EXPECT_NEAR(next.power, 0.0, 1e-6) << "neither is ever named alone";
  EXPECT_THAT(next.separates, IsEmpty());
  EXPECT_THAT(next.why, HasSubstr("within the noise"));
}

TEST(NextExperiment, WhatCalibrationTakesUpPartsNothing) {
  Scene scene = chamber_scene(jumping_V(1000), 0.0);
  scene.noise_Pa = 20.0;
  const Rival one{"one", 0, scene.nominal};
  Rival other{"other", 0, scene.nominal};
  other.figures[effects::kInletGain] *= 1.0002;  // small: the calibration is linearised
  other.figures[effects::kOpenAbove] += 0.0001;
  EXPECT_LT(next_experiment(scene, {one, other}).power, 0.75);
}

TEST(NextExperiment, MoreNoiseLeavesLessPower) {
  Scene scene = chamber_scene(jumping_V(1000), 0.0);
  const std::vector<Rival> rivals{rival(scene, effects::kIdDeadTime, {0.006}),
                                  rival(scene, effects::kIdSensorLag, {0.006})};
  scene.noise_Pa = 1e4;
  const double quiet = next_experiment(scene, rivals).power;
  scene.noise_Pa = 1e5;
  const double loud = next_experiment(scene, rivals).power;
  EXPECT_GT(loud, 0.0);
  EXPECT_LT(loud, quiet);
}

TEST(NextExperiment, OfThreeRivalsTwoThatAreOneDoNotKeepTheThirdFromBeingParted) {
  const Scene scene = chamber_scene(jumping_V(1000), 0.0);
  const Rival lag = rival(scene, effects::kIdSpoolLag, {10.0, 0.8});
  const Rival leak = rival(scene, effects::kIdChamberLeak, {0.5});
  Rival twin = leak;
  twin.id = "twin";
  const NextExperiment two = next_experiment(scene, {lag, leak});
  const NextExperiment three = next_experiment(scene, {lag, leak, twin});
  EXPECT_EQ(three.excitation, two.excitation) << "a pair that no input parts chooses none";
  EXPECT_NEAR(three.power, (two.power + two.power) / 3.0, 1e-6)
      << "the mean of three pairs, one of them never told";
  EXPECT_THAT(three.why, HasSubstr("spool_lag, chamber_leak and twin answer alike"));
  EXPECT_THAT(three.why, HasSubstr("the nearest two, chamber_leak and twin, differ"));
  EXPECT_THAT(three.separates, ElementsAre("spool_lag", "chamber_leak", "twin"));
}

// That a log may be stamped early would take up a part of any lateness.
TEST(NextExperiment, AStampThatTheLogAtHandTellsTakesUpNothing) {
  Scene scene = chamber_scene(jumping_V(1000), 0.0);
  scene.noise_Pa = 1e4;
  const std::vector<Rival> rivals{rival(scene, effects::kIdDeadTime, {0.002}),
                                  rival(scene, effects::kIdSensorLag, {0.002})};
  const NextExperiment known = next_experiment(scene, rivals);
  scene.most_early_s = 1e-3;
  const NextExperiment asked = next_experiment(scene, rivals);
  EXPECT_EQ(asked.excitation, known.excitation);
  EXPECT_DOUBLE_EQ(asked.power, known.power);
}

TEST(NextExperiment, AnUnexplainedGapIsAnsweredWithVarietyAndNoPower) {
  const Scene scene = chamber_scene(jumping_V(1000), 0.0);
  for (const std::vector<Rival>& rivals :
       {std::vector<Rival>{}, {rival(scene, effects::kIdDeadTime, {0.01})}}) {
    const NextExperiment next = next_experiment(scene, rivals);
    EXPECT_EQ(next.power, 0.0);
    EXPECT_THAT(next.separates, IsEmpty());
    EXPECT_THAT(next.excitation, HasSubstr("moving"))
        << "a volume that moves adds to the variety of any input";
  }
}

TEST(NextExperiment, WithoutALogThereIsNone) {
  EXPECT_THROW(next_experiment(make_scene({}), {}), std::invalid_argument);
}

TEST(Library, InputsAreShortAndStayWithinTheValve) {
  const Scene scene = chamber_scene(jumping_V(1000), 0.0);
  for (const Excitation& e : library(scene)) {
    double seconds = 0.0;
    for (const Stretch& s : e.stretches) {
      seconds += static_cast<double>(s.drive.command_V.size()) * s.drive.timing.tick_s;
      ASSERT_EQ(s.drive.volume_m3.size(), (s.drive.command_V.size() - 1) * 4 + 1) << e.id;
      const auto [low, high] = std::minmax_element(s.drive.command_V.begin(), s.drive.command_V.end());
      EXPECT_GE(*low, 0.0) << e.id << " [V]";
      EXPECT_LE(*high, 10.0) << e.id << " [V]";
      EXPECT_LT(*low, 4.92) << e.id << " opens the exhaust";
      EXPECT_GT(*high, 5.08) << e.id << " opens the supply";
    }
    EXPECT_GE(seconds, 15.0) << e.id;
    EXPECT_LE(seconds, 45.0) << e.id;
  }
}

TEST(Library, HoldsOfFillAndDumpSealAtTwoPressuresFarApart) {
  const Scene scene = chamber_scene(jumping_V(1000), 0.0);
  const Excitation filling = library(scene).front();
  ASSERT_EQ(filling.id, "fill_and_dump");
  Record record;
  record.drive = filling.stretches[0].drive;
  record.measured_Pa.resize(record.drive.command_V.size());
  const std::vector<double> reading = run(scene, record, 0, scene.nominal, {101325.0});
  double low = 1e9, high = 0.0;
  for (std::size_t row = 1; row < reading.size(); ++row) {
    if (std::abs(record.drive.command_V[row - 1] - 5.0) > 1e-9) continue;
    low = std::min(low, reading[row]);
    high = std::max(high, reading[row]);
  }
  EXPECT_GT(high - low, 200000.0) << "[Pa]";
}

}  // namespace
}  // namespace plenum::host::diagnose
