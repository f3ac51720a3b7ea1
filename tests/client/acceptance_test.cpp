// The statistics of an acceptance test against closed forms, and its verdicts at their limits.
#include "host-sim/client/acceptance.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace plenum::host::client {
namespace {

using ::testing::HasSubstr;

// ---- loop ----

/// Bins from 0, 10, 20 and 40 us.
std::vector<LatencyBin> bins(std::uint32_t from_0, std::uint32_t from_10, std::uint32_t from_20,
                             std::uint32_t from_40) {
  return {{0, from_0}, {10, from_10}, {20, from_20}, {40, from_40}};
}

TEST(LoopLatency, CountsOnlyTheTicksBetweenTwoReadings) {
  const LoopLatency loop = latency_between(bins(5, 0, 0, 7), bins(1005, 0, 0, 7), 900);
  EXPECT_EQ(loop.ticks, 1000U);
  EXPECT_DOUBLE_EQ(loop.p999_us, 9.0) << "the seven late ticks were before";
  EXPECT_DOUBLE_EQ(loop.max_us, 9.0);
  EXPECT_DOUBLE_EQ(loop.jitter_us, 9.0);
}

TEST(LoopLatency, OneTickInAThousandIsBeyondTheNinehundredNinetyNinth) {
  const LoopLatency one = latency_between(bins(0, 0, 0, 0), bins(0, 989, 10, 1), 57);
  EXPECT_DOUBLE_EQ(one.p999_us, 39.0);
  EXPECT_DOUBLE_EQ(one.max_us, 57.0) << "the last bin is open: the greatest ever bounds it";
  EXPECT_DOUBLE_EQ(one.jitter_us, 29.0) << "from the least of the median's bin";
  const LoopLatency two = latency_between(bins(0, 0, 0, 0), bins(0, 988, 10, 2), 57);
  EXPECT_DOUBLE_EQ(two.p999_us, 57.0);
}

TEST(LoopLatency, ABoardThatStandsStillOrHasStartedAnewHasNone) {
  EXPECT_THROW(latency_between(bins(9, 0, 0, 0), bins(9, 0, 0, 0), 3), ProtocolError);
  EXPECT_THROW(latency_between(bins(9, 5, 0, 0), bins(99, 0, 0, 0), 3), ProtocolError);
}

// ---- readings ----

TEST(Reading, OfAnAlternatingPressureIsThatOfItsClosedForm) {
  std::vector<double> pressure_Pa(100);
  for (std::size_t k = 0; k < 100; ++k) pressure_Pa[k] = 2e5 + (k % 2 == 0 ? 30.0 : -30.0);
  const Reading reading = reading_of(pressure_Pa);
  EXPECT_DOUBLE_EQ(reading.mean, 2e5);
  EXPECT_NEAR(reading.std, 30.0 * std::sqrt(100.0 / 99.0), 1e-9);
  EXPECT_NEAR(reading.noise, std::sqrt(120.0 * 120.0 / 6.0), 1e-9) << "every second difference is 120 Pa";
}

TEST(Reading, DriftEntersTheStandardDeviationAndNotTheNoise) {
  std::vector<double> pressure_Pa(1001);
  for (std::size_t k = 0; k <= 1000; ++k) pressure_Pa[k] = 1e5 + 2.0 * static_cast<double>(k);
  const Reading reading = reading_of(pressure_Pa);
  EXPECT_NEAR(reading.noise, 0.0, 1e-9);
  EXPECT_NEAR(reading.std, 2000.0 / std::sqrt(12.0), 1.0);  // of an even distribution over the drift
}

std::vector<double> gaussian(std::size_t count, double std_Pa, std::uint32_t seed) {
  std::mt19937 bits(seed);
  std::normal_distribution<double> noise(1e5, std_Pa);
  std::vector<double> samples(count);
  for (double& sample : samples) sample = noise(bits);
  return samples;
}

TEST(Reading, TheNoiseOfWhiteNoiseIsItsStandardDeviationAlsoWhereThePressureJumpsAndSettles) {
  // 200 windows of 98 second differences: their squares are correlated (the variance of a window's mean is 35/9 / 98 of its
  // square), so a window's median is 1.3 % low, and the median of 200 has a standard error of 0.9 % of the noise.
  std::vector<double> samples = gaussian(20'000, 50.0, 3);
  EXPECT_NEAR(reading_of(samples).noise, 50.0, 0.04 * 50.0);
  for (std::size_t k = 0; k < samples.size(); ++k)
    samples[k] += 3e5 * std::exp(-static_cast<double>(k) / 1000.0) + (k > 7000 ? 5e4 : 0.0);
  EXPECT_NEAR(reading_of(samples).noise, 50.0, 0.04 * 50.0);
}

TEST(Reading, TheStepOfAConverterShowsWhenTheNoiseIsNotMuchWider) {
  std::vector<double> samples = gaussian(3000, 40.0, 5);
  EXPECT_FALSE(reading_of(samples).step) << "no two samples are equal: no step shows";
  for (double& sample : samples) sample = 17.0 + 12.2 * std::round(sample / 12.2);
  const Reading reading = reading_of(samples);
  ASSERT_TRUE(reading.step);
  EXPECT_NEAR(*reading.step, 12.2, 1e-6);
}

TEST(Reading, AStuckChannelIsSeenAndWhatIsNoNumberStaysOne) {
  const Reading stuck = reading_of(std::vector<double>(50, 1e5));
  EXPECT_FALSE(stuck.changed);
  EXPECT_EQ(stuck.noise, 0.0);
  EXPECT_TRUE(std::isnan(reading_of(std::vector{1e5, std::nan(""), 1e5}).noise));
  EXPECT_THROW(reading_of(std::vector{1e5, 1e5}), std::invalid_argument);
}

// ---- answers ----

/// Levels from 4 to 6 V, each held for 2 to 40 ticks.
std::vector<double> commands(std::size_t rows, std::uint32_t seed) {
  std::mt19937 bits(seed);
  std::uniform_real_distribution<double> level_V(4.0, 6.0);
  std::uniform_int_distribution<std::size_t> hold(2, 40);
  std::vector<double> command_V;
  while (command_V.size() < rows) command_V.insert(command_V.end(), hold(bits), level_V(bits));
  command_V.resize(rows);
  return command_V;
}

/// An ideal valve, behind `dead` ticks: p' = gain (u - 5 V).
std::vector<double> filled_by(const std::vector<double>& command_V, double gain_Pa_per_V, std::size_t dead) {
  std::vector<double> pressure_Pa{2e5};
  for (std::size_t k = 1; k < command_V.size(); ++k) {
    const double command = k > dead ? command_V[k - 1 - dead] : 5.0;
    pressure_Pa.push_back(pressure_Pa.back() + gain_Pa_per_V * (command - 5.0));
  }
  return pressure_Pa;
}

constexpr std::size_t kRows = 3000;
constexpr MotionLimits kNoLimits{.pressure_low_Pa = -1e12, .pressure_high_Pa = 1e12, .command_mean_V = 5.0};
constexpr MotionLimits kLimits{.pressure_low_Pa = 150e3, .pressure_high_Pa = 400e3, .command_mean_V = 5.0};

TEST(Answers, AnIdealValveIsAnsweredFullyWhateverItsDeadTime) {
  const std::vector<std::vector<double>> command_V{commands(kRows, 1)};
  for (const std::size_t dead : {0U, 1U, 6U, 11U}) {
    const std::vector<std::vector<double>> pressure_Pa{filled_by(command_V[0], 900.0, dead)};
    const Answer answer = answers_of(pressure_Pa, command_V, kNoLimits).front();
    EXPECT_NEAR(answer.own, 1.0, 0.02) << dead << " ticks of dead time";
    EXPECT_EQ(trouble_of(answer, 0), "");
  }
}

TEST(Answers, AValveThatIsWiredBackwardsGoesTheWrongWay) {
  const std::vector<std::vector<double>> command_V{commands(kRows, 1)};
  const std::vector<std::vector<double>> pressure_Pa{filled_by(command_V[0], -900.0, 2)};
  const Answer answer = answers_of(pressure_Pa, command_V, kNoLimits).front();
  EXPECT_NEAR(answer.own, -1.0, 0.02);
  EXPECT_EQ(trouble_of(answer, 0), "goes the wrong way");
}

TEST(Answers, SwappedTubesAreNamedWithTheValveThatIsFollowed) {
  const std::vector<std::vector<double>> command_V{commands(kRows, 1), commands(kRows, 2),
                                                   commands(kRows, 3)};
  const std::vector<std::vector<double>> pressure_Pa{filled_by(command_V[0], 900.0, 1),
                                                     filled_by(command_V[2], 900.0, 1),
                                                     filled_by(command_V[1], 900.0, 1)};
  const std::vector<Answer> answers = answers_of(pressure_Pa, command_V, kNoLimits);
  EXPECT_EQ(trouble_of(answers[0], 0), "");
  EXPECT_THAT(trouble_of(answers[1], 1), HasSubstr("follows valve 3"));
  EXPECT_THAT(trouble_of(answers[2], 2), HasSubstr("follows valve 2"));
}

TEST(Answers, NoiseAndAStuckPressureAnswerNothing) {
  for (std::uint32_t seed = 1; seed <= 50; ++seed) {
    const std::vector<std::vector<double>> command_V{commands(kRows, seed)};
    const std::vector<std::vector<double>> noise_Pa{gaussian(kRows, 100.0, seed)};
    const Answer answer = answers_of(noise_Pa, command_V, kNoLimits).front();
    EXPECT_LT(std::abs(answer.own), kAnswers) << "seed " << seed;
    EXPECT_EQ(trouble_of(answer, 0), "does not answer");
  }
  const std::vector<std::vector<double>> command_V{commands(kRows, 1)};
  const std::vector<std::vector<double>> stuck_Pa{std::vector<double>(kRows, 1e5)};
  EXPECT_EQ(answers_of(stuck_Pa, command_V, kNoLimits).front().own, 0.0);
}

TEST(Answers, OneThatLeavesItsLimitsAgainstItsValveIsAmissWhateverItsCorrelation) {
  // Commands 4 V; a pressure above 400 kPa that rests, that rises, that sinks by 2 % of its distance in a second.
  const std::vector<double> emptied_V(400, 4.0);
  const auto escapes = [&](const std::function<double(double)>& pressure_Pa,
                           const std::vector<double>& command_V) {
    std::vector<double> pressures;
    for (std::size_t k = 0; k < command_V.size(); ++k)
      pressures.push_back(pressure_Pa(0.01 * static_cast<double>(k)));
    const std::vector<std::vector<double>> pressure(1, pressures);
    const std::vector<std::vector<double>> command(1, command_V);
    return answers_of(pressure, command, kLimits).front().escapes;
  };
  EXPECT_TRUE(escapes([](double) { return 700e3; }, emptied_V));
  EXPECT_TRUE(escapes([](double t) { return 410e3 + 1e3 * t; }, emptied_V));
  EXPECT_FALSE(escapes([](double t) { return 400e3 + 300e3 * std::pow(0.98, t); }, emptied_V))
      << "slow, and right";
  EXPECT_FALSE(escapes([](double) { return 399e3; }, emptied_V)) << "within";
  EXPECT_FALSE(escapes([](double) { return 700e3; }, std::vector<double>(400, 6.0)))
      << "its own valve feeds it";
  EXPECT_FALSE(escapes([](double) { return 700e3; }, std::vector<double>(100, 4.0))) << "no second yet";
  EXPECT_TRUE(escapes([](double) { return 101e3; }, std::vector<double>(400, 6.0))) << "below the least";
  const Answer lucky{.own = 0.93, .best = 0, .best_correlation = 0.93, .escapes = true};
  EXPECT_THAT(trouble_of(lucky, 0), HasSubstr("stays beyond its limits"));
}

TEST(Answers, NoOtherValveIsNamedByChance) {
  for (std::uint32_t seed = 1; seed <= 40; ++seed) {
    std::vector<std::vector<double>> command_V;
    for (std::uint32_t c = 0; c < 8; ++c) command_V.push_back(commands(kRows, 100 * seed + c));
    std::vector<std::vector<double>> pressure_Pa(8, gaussian(kRows, 100.0, seed));
    pressure_Pa[7] = filled_by(command_V[0], 900.0, 1);
    const std::vector<Answer> answers = answers_of(pressure_Pa, command_V, kNoLimits);
    for (std::size_t c = 0; c < 7; ++c)
      EXPECT_EQ(trouble_of(answers[c], c), "does not answer") << "seed " << seed;
    EXPECT_THAT(trouble_of(answers[7], 7), HasSubstr("follows valve 1")) << "seed " << seed;
  }
}

// ---- verdict ----

Verdict verdict_of(const std::string& id, std::optional<double> value, const std::string& limit = "") {
  const std::vector<Measured> measured{{id, value, ""}};
  const std::vector<std::string> limits(limit.empty() ? 0 : 1, limit);
  for (const Judged& one : judge(measured, limits)) {
    if (one.criterion.id == id) return one.verdict;
  }
  ADD_FAILURE() << "no criterion " << id;
  return Verdict::not_run;
}

TEST(Judge, EveryCriterionPassesAtItsLimitAndFailsJustBeyond) {
  for (const Criterion& criterion : acceptance_criteria()) {
    const std::string id(criterion.id);
    EXPECT_EQ(verdict_of(id, criterion.limit), Verdict::pass) << id;
    EXPECT_EQ(verdict_of(id, criterion.limit + 1e-6), Verdict::fail) << id;
  }
}

TEST(Judge, WhatIsNotFiniteFails) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double value : {std::nan(""), infinity, -infinity}) {
    EXPECT_EQ(verdict_of("noise_Pa", value), Verdict::fail);
  }
}

TEST(Judge, WhatWasNotMeasuredIsNotRunAndFailsNothing) {
  EXPECT_EQ(verdict_of("chambers_amiss", std::nullopt), Verdict::not_run);
  const std::vector<Judged> nothing = judge({}, {});
  EXPECT_EQ(nothing.size(), acceptance_criteria().size());
  EXPECT_TRUE(accepted(nothing));
  const std::vector<Measured> late{{"overruns", 1.0, "once"}};
  const std::vector<Judged> judged = judge(late, {});
  EXPECT_FALSE(accepted(judged)) << "one item fails it whole";
}

TEST(Judge, AnotherLimitTakesThePlaceOfTheDefault) {
  EXPECT_EQ(verdict_of("noise_Pa", 250.0), Verdict::pass);
  EXPECT_EQ(verdict_of("noise_Pa", 250.0, "noise_Pa=200"), Verdict::fail);
  EXPECT_EQ(verdict_of("chambers_amiss", 1.0, "chambers_amiss=1"), Verdict::pass);
}

TEST(Judge, ALimitThatIsNoneIsRefusedByItsName) {
  for (const char* limit :
       {"noise", "noise_kPa=2", "noise_Pa=", "noise_Pa=loud", "noise_Pa=1e2x", "noise_Pa=inf"}) {
    try {
      judge({}, std::vector<std::string>{limit});
      ADD_FAILURE() << limit << " was taken";
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr(limit));
    }
  }
}

}  // namespace
}  // namespace plenum::host::client
