#include "host-sim/identify/free_run.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host-sim/identify/cannot_identify.hpp"
#include "tests/identify/chamber_of_record.hpp"

namespace plenum::host::identify {
namespace {

Tassa9 model_of(const Recording& recording) {
  Tassa9 model;
  model.c = recording.c;
  model.supply_kPa = recording.supply_kPa;
  model.ambient_kPa = recording.ambient_kPa;
  return model;
}

TEST(FreeRun, OfTheTrueModelFollowsTheChamberForTheWholeLog) {
  for (const double average_s : {0.0, 0.01}) {
    Recording recording;
    recording.average_s = average_s;
    const trace::Log log = record(recording);
    const std::vector<double> predicted = predict_free_run(model_of(recording), log, 5, log.size() - 6);
    ASSERT_EQ(predicted.size(), log.size() - 6);
    for (std::size_t k = 0; k < predicted.size(); ++k) {
      ASSERT_NEAR(predicted[k], log.pressure_Pa[6 + k], 0.5)
          << "[Pa], row " << 6 + k << ", averaged over " << average_s;
    }
  }
}

// A chamber of 8000 1/s has forgotten the start of a tick long before its end.
TEST(FreeRun, ATickOfTwoEqualCommandsIsATickOfOneHoweverFastTheChamber) {
  for (const double average_s : {0.0, 0.004, 0.01}) {
    for (const double rate_per_s : {30.0, 8000.0}) {
      Recording recording;
      recording.rows = 200;
      recording.noise_kPa = 20.0;
      trace::Log log = record(recording);
      log.pressure_average_s = average_s;
      for (double& command_V : log.command_V) command_V = 5.3;
      Tassa9 model = model_of(recording);
      model.c[6] = 1.0;
      model.c[6] = rate_per_s / steady_and_rate(model, 5.3, 120.0, 0.0).rate_per_s;
      const double whole_kPa = next_tick_rms_kPa(model, lay_out({log}));
      EXPECT_NEAR(next_tick_rms_kPa(model, lay_out({log}, 0.0055)), whole_kPa, 1e-9 * whole_kPa)
          << "kPa, " << rate_per_s << " 1/s, averaged over " << average_s << " s";
    }
  }
}

TEST(FreeRun, ReinitialisedRunsCoverEveryRowButTheFirstOnce) {
  Recording recording;
  recording.rows = 950;
  const trace::Log log = record(recording);
  std::size_t next = 0;
  for (const FreeRun& run : reinitialised_runs(model_of(recording), log, 2.0)) {
    EXPECT_EQ(run.start_row, next);
    EXPECT_LE(run.pressure_Pa.size(), 200U);
    next += run.pressure_Pa.size();
  }
  EXPECT_EQ(next, 949U);
}

TEST(FreeRun, HeldStartsErrByHowFarThePressureGoesFromEachStart) {
  trace::Log log;
  for (int k = 0; k < 6; ++k) {
    log.time_s.push_back(0.01 * k);
    log.pressure_Pa.push_back(101e3 + 1e3 * k);
  }
  // Runs of 2 ticks start at rows 0, 2 and 4: errors 1, 2, 1, 2, 1 kPa.
  EXPECT_NEAR(held_start_rms_kPa(log, 0.02), std::sqrt(11.0 / 5.0), 1e-12);
}

TEST(FreeRun, RefusesToPredictBeyondTheLog) {
  const trace::Log log = record({});
  EXPECT_THROW(predict_free_run(Tassa9{}, log, 0, log.size()), CannotIdentify);
}

/// p = k^2 kPa
trace::Log of_squares() {
  trace::Log log;
  log.pressure_average_s = 0.0;
  for (int k = 0; k < 11; ++k) {
    log.time_s.push_back(0.01 * k);
    log.command_V.push_back(5.0);
    log.pressure_Pa.push_back(1e3 * k * k);
    log.volume_m3.push_back(1e-4);
  }
  return log;
}

TEST(Drift, MatchesAHandComputation) {
  // A model of rate 0 predicts the start pressure for ever.
  Tassa9 model;
  model.c[6] = 0.0;
  model.supply_kPa = 600.0;
  model.ambient_kPa = 100.0;
  // Horizon of 2 ticks, starts at rows 0, 4 and 8. Errors start^2 - (start + j)^2: after one tick -1, -9,
  // -17; after two -4, -20, -36. Means -9 and -20; deviations 8 and 16 kPa; of a span of 500 kPa that is 1.6
  // % and 3.2 %.
  const Drift got = drift(of_squares(), model, 3, 0.02);
  ASSERT_EQ(got.std_percent.size(), 2U);
  EXPECT_NEAR(got.std_percent[0], 1.6, 1e-12);
  EXPECT_NEAR(got.std_percent[1], 3.2, 1e-12);
  EXPECT_NEAR(got.mean_percent[0], -1.8, 1e-12);
  EXPECT_NEAR(got.mean_percent[1], -4.0, 1e-12);
  EXPECT_NEAR(got.worst_std_percent, 3.2, 1e-12);
  EXPECT_NEAR(got.time_s[1], 0.02, 1e-15);
}

TEST(Drift, OfPartOfALogStartsAndEndsWithinIt) {
  const Ticks ticks = lay_out({of_squares()});
  const auto held = [&](std::size_t start_row, std::size_t rows) {
    return std::vector<double>(rows, ticks.pressure_kPa[start_row]);
  };
  // Starts at rows 4 and 8 - 2 = 6: errors after one tick -9 and -13, after two -20 and -28 kPa.
  const Drift got = drift(ticks, 500.0, held, {.from_row = 4, .to_row = 9, .starts = 2, .horizon_s = 0.02});
  ASSERT_EQ(got.mean_percent.size(), 2U);
  EXPECT_NEAR(got.mean_percent[0], -2.2, 1e-12);
  EXPECT_NEAR(got.mean_percent[1], -4.8, 1e-12);
  EXPECT_NEAR(got.std_percent[0], 0.2 * std::sqrt(8.0), 1e-12);
  EXPECT_NEAR(got.worst_std_percent, 0.2 * std::sqrt(32.0), 1e-12);
  EXPECT_THROW(drift(ticks, 500.0, held, {.from_row = 8, .to_row = 4, .starts = 2, .horizon_s = 0.02}),
               CannotIdentify);
}

TEST(Drift, RefusesALogThatIsTooShort) {
  Recording recording;
  recording.rows = 100;
  EXPECT_THROW(drift(record(recording), Tassa9{}, 48, 2.0), CannotIdentify);
}

}  // namespace
}  // namespace plenum::host::identify
