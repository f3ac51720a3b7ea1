// A staged model against the one in force: logs written by hand, and those of the bench's closed-form chambers.
#include "firmware/shadow_run.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "firmware/canopen/objects.hpp"
#include "firmware/config/greybox_parameters.hpp"
#include "firmware/control/any_model.hpp"
#include "firmware/control/greybox.hpp"
#include "firmware/control/model_paths.hpp"
#include "firmware/control/sensor_lag.hpp"
#include "firmware/control/supply_line.hpp"
#include "tests/firmware/board/bench.hpp"
#include "tests/firmware/board/greybox_image.hpp"
#include "tests/firmware/scalars.hpp"

namespace plenum {
namespace {

using config::SetPhase;
using config::Trial;
using telemetry::kLogTicks;
using telemetry::Recorder;
using testing::HasSubstr;
using testing::StartsWith;
using testing::ThrowsMessage;
using Values = std::array<float, 12>;
namespace object = canopen::object;

/// Slots with a model in force in every chamber, a recorder, and the run between them.
struct Rig {
  Recorder recorder;
  ShadowRun run{recorder, 0.0F};
  config::ParameterSlots slots{&run};
  std::uint32_t tick = 0;

  explicit Rig(const Values& active) {
    for (std::uint8_t c = 0; c < kChambers; ++c) {
      const auto image = image_of(active);
      slots.stage(c, image);
      const std::uint32_t crc = config::trailing_crc(image);
      slots.commit(static_cast<std::uint8_t>(1U << c), config::commit_crc({&crc, 1}), config::kCommitKey);
      slots.apply_at_tick_edge();
    }
  }

  /// One row of all chambers.
  void write(double pressure_kPa, double command_V, bool measured = true) {
    Recorder::Samples samples;
    samples.fill({.pressure_Pa = static_cast<float>(1000.0 * pressure_kPa),
                  .volume_m3 = 150e-6F,
                  .command_V = static_cast<float>(command_V),
                  .measured = measured});
    recorder.write(++tick, false, samples);
  }
  /// Random steps of the command about the null, as long as 0.02 to 0.4 s; the chamber is that of the bench.
  void write_steps(std::size_t rows) {
    Chamber chamber;
    chamber.pressure_kPa = 300.0;
    std::mt19937 random(1);
    double mean_kPa = 300.0, command_V = 5.02;
    for (std::size_t k = 0, left = 0; k < rows; ++k, --left) {
      if (left == 0) {
        left = 2 + random() % 39;
        command_V = 4.62 + 0.8 * static_cast<double>(random() % 1000) / 1000.0;
      }
      write(mean_kPa, command_V);
      mean_kPa = chamber.advance(static_cast<double>(static_cast<float>(command_V)));
    }
  }

  /// Ticks until chamber 0 is judged; at most 1000.
  int ticks_to_verdict(std::uint8_t chamber = 0) {
    int ticks = 0;
    for (; slots.checking(chamber) && ticks < 1000; ++ticks) run.step(slots);
    return ticks;
  }
  config::TrialResult compare(const Values& staged) {
    slots.stage(0, image_of(staged));
    ticks_to_verdict();
    return slots.state(0).trial;
  }
};

Values scaled(std::size_t parameter, float factor) {
  Values values = kValve;
  values[parameter] *= factor;
  return values;
}
constexpr std::size_t kC2 = 1, kC7 = 6;

TEST(ShadowRun, FindsTheSameModelAsGood) {
  Rig rig(kValve);
  rig.write_steps(kLogTicks);
  const config::TrialResult result = rig.compare(kValve);
  EXPECT_EQ(result.outcome, Trial::passed);
  EXPECT_EQ(result.staged_rms_kPa, result.active_rms_kPa);
  EXPECT_LT(result.active_rms_kPa, 1.0F)
      << "the model is the chamber: what is left is the start of each stretch";
}

TEST(ShadowRun, FindsAModelWorseThatIs) {
  for (const Values& worse : {scaled(kC7, 0.6F), scaled(kC7, 1.8F), scaled(kC2, 0.5F)}) {
    Rig rig(kValve);
    rig.write_steps(kLogTicks);
    const config::TrialResult result = rig.compare(worse);
    EXPECT_EQ(result.outcome, Trial::worse);
    EXPECT_GT(result.staged_rms_kPa, 2.0F * result.active_rms_kPa);
    EXPECT_EQ(rig.slots.state(0).phase, SetPhase::doubted);
    EXPECT_EQ(rig.slots.state(0).refusal.error, config::ImageError::predicts_worse);
  }
}

TEST(ShadowRun, LetsABetterModelPass) {
  Rig rig(scaled(kC7, 0.6F));
  rig.write_steps(kLogTicks);
  const config::TrialResult result = rig.compare(kValve);
  EXPECT_EQ(result.outcome, Trial::passed);
  EXPECT_LT(result.staged_rms_kPa, 0.5F * result.active_rms_kPa);
}

TEST(ShadowRun, LetsAModelPassThatIsWorseByLessThanTheLogCanTell) {
  Rig rig(scaled(kC7, 0.6F));
  rig.write_steps(kLogTicks);
  const config::TrialResult result = rig.compare(scaled(kC7, 0.595F));
  EXPECT_GT(result.staged_rms_kPa, result.active_rms_kPa);
  EXPECT_EQ(result.outcome, Trial::passed) << result.staged_rms_kPa << " kPa, " << result.active_rms_kPa;
}

// At its null and with c7 = 1e6 / (V s) the model is at s = (P_c + P_r) / 2 within a tick: (7) with rh = 24. The log
// goes to and fro between 200 and 210 kPa, so that each stretch begins at 205 kPa. The model with s = 205 kPa misses by
// 5 kPa in every tick; that with s = 200 kPa by 0 and 10 kPa in turn, but for its first tick: 5 / 24 and 10 - 5 / 24
// or the like. RMS: 5 kPa, and sqrt(50) = 7.07 kPa.
Values at_once(float supply_kPa) {
  Values values = kValve;
  values[kC7] = 1e6F;
  values[10] = supply_kPa;
  values[11] = 100.0F;
  return values;
}
const Values kAt205 = at_once(310.0F), kAt200 = at_once(300.0F);
constexpr double kNull_V = 5.02;

double to_and_fro_kPa(std::size_t k) {
  return k % 2 == 0 ? 200.0 : 210.0;
}

TEST(ShadowRun, ComputesTheRmsOfBothModels) {
  Rig rig(kAt200);
  for (std::size_t k = 0; k < kLogTicks; ++k) rig.write(to_and_fro_kPa(k), kNull_V);
  const config::TrialResult result = rig.compare(kAt205);
  EXPECT_EQ(result.outcome, Trial::passed);
  EXPECT_NEAR(result.staged_rms_kPa, 5.0F, 1e-3F);
  EXPECT_NEAR(result.active_rms_kPa, 7.07F, 0.05F);
}

TEST(ShadowRun, PassesOverWhatWasNotMeasuredAndWhatDoesNotFollow) {
  Rig rig(kAt200);
  for (std::size_t k = 0; k < kLogTicks; ++k) {
    const bool lost = k % 100 == 30, no_number = k % 100 == 50;
    if (k % 100 == 70) ++rig.tick;
    const double wrong_kPa = no_number ? std::nan("") : 900.0;
    rig.write(lost || no_number ? wrong_kPa : to_and_fro_kPa(k), kNull_V, !lost);
  }
  const config::TrialResult result = rig.compare(kAt205);
  EXPECT_EQ(result.outcome, Trial::passed);
  EXPECT_NEAR(result.staged_rms_kPa, 5.0F, 1e-3F);
}

TEST(ShadowRun, LetsTheCommandBeforeActForTheDelayOfTheValve) {
  // With the delay put in, the model that is the chamber fits up to the start of each stretch; without it, it does not.
  const auto rms_kPa = [](float delay_ticks) {
    Rig rig(kValve);
    ShadowRun run(rig.recorder, delay_ticks);
    config::ParameterSlots slots(&run);
    const auto image = image_of(kValve);
    const std::uint32_t crc = config::trailing_crc(image);
    slots.stage(0, image);
    slots.commit(1, config::commit_crc({&crc, 1}), config::kCommitKey);
    slots.apply_at_tick_edge();
    Chamber chamber;
    chamber.pressure_kPa = 300.0;
    double mean_kPa = 300.0, before_V = kNull_V;
    for (std::size_t k = 0; k < kLogTicks; ++k) {
      const double command_V = k % 34 < 17 ? 5.2 : 4.9;
      rig.write(mean_kPa, command_V);
      mean_kPa = chamber.advance(before_V);  // a whole tick late
      before_V = static_cast<double>(static_cast<float>(command_V));
    }
    slots.stage(0, image);
    while (slots.checking(0)) run.step(slots);
    return slots.state(0).trial.active_rms_kPa;
  };
  EXPECT_LT(rms_kPa(1.0F), 0.5F * rms_kPa(0.0F));
}

std::vector<std::uint8_t> late_greybox(float dead_time_s, float sensor_lag_s) {
  return greybox_with({{config::kDeadTime, dead_time_s}, {config::kSensorLag, sensor_lag_s}});
}

std::vector<std::uint8_t> drooping_greybox(float resistance_s_L) {
  return greybox_with({{config::kSupplyResistance, resistance_s_L}, {config::kSupplyRecovery, 0.1F}});
}

TEST(ShadowRun, CountsInTheDeadTimeAndTheSensorsLagThatAModelStates) {
  // The log is of a valve three ticks late and a sensor of five ticks: the model that states both fits, those that leave one
  // out do not.
  control::Greybox chamber;
  config::ModelParameters parameters;
  ASSERT_TRUE(config::decode(late_greybox(0.0F, 0.0F), parameters));
  chamber.configure(
      std::span<const numeric::Scalar>(config::scalars(parameters)).first<control::Greybox::kParameters>(),
      0.0F, 10.0F);
  const control::ChamberMotion motion{.volume_mL = 150.0F, .volume_rate_mL_s = 0.0F};
  const auto rms_kPa = [&](float dead_time_s, float sensor_lag_s) {
    Rig rig(kValve);
    control::SensorLag sensor;
    sensor.configure(5.0F, 1.0F);
    sensor.reset(300.0F);
    numeric::Scalar pressure_kPa = 300.0F, shown_kPa = 300.0F;
    std::array<float, kLogTicks + 3> command_V{};
    command_V.fill(5.0F);
    for (std::size_t k = 0; k < kLogTicks; ++k) {
      command_V[k + 3] = k % 34 < 17 ? 5.9F : 4.2F;
      rig.write(static_cast<double>(shown_kPa), static_cast<double>(command_V[k + 3]));
      const control::Prediction next = chamber.step(pressure_kPa, command_V[k], motion, 1.0F);
      shown_kPa = sensor.pass(pressure_kPa, next);
      pressure_kPa = next.end_kPa;
    }
    rig.slots.stage(0, late_greybox(dead_time_s, sensor_lag_s));
    rig.ticks_to_verdict();
    return rig.slots.state(0).trial.staged_rms_kPa;
  };
  const float right_kPa = rms_kPa(0.03F, 0.05F);
  EXPECT_LT(right_kPa, 0.25F * rms_kPa(0.0F, 0.05F));
  EXPECT_LT(right_kPa, 0.25F * rms_kPa(0.03F, 0.0F));
}

TEST(ShadowRun, CountsInTheSupplyThatDroopsByWhatAModelStates) {
  const auto parameters_of = [](float resistance_s_L) {
    config::ModelParameters parameters;
    EXPECT_TRUE(config::decode(drooping_greybox(resistance_s_L), parameters));
    return parameters;
  };
  const config::ModelParameters true_model = parameters_of(5.0F);
  control::AnyModel room;
  const control::PressureModel& chamber = *room.take_over(true_model, 0.0F, 10.0F);
  const auto rms_kPa = [&](float resistance_s_L) {
    Rig rig(kValve);
    control::SupplyLine line;
    line.configure(control::paths_of(true_model, 0.0F).supply, 0.0F);
    numeric::Scalar pressure_kPa = 300.0F, shown_kPa = 300.0F;
    for (std::size_t k = 0; k < kLogTicks; ++k) {
      const float command_V = k % 34 < 17 ? 5.9F : 4.2F;
      rig.write(static_cast<double>(shown_kPa), static_cast<double>(command_V));
      control::ChamberMotion motion{.volume_mL = 150.0F, .volume_rate_mL_s = 0.0F, .supply = line.supply()};
      const control::Prediction next = line.step(line.tick(), 1.0F, chamber, pressure_kPa,
                                                 chamber.opening(command_V), motion, chamber.moving(motion));
      shown_kPa = next.mean_kPa;
      pressure_kPa = next.end_kPa;
    }
    rig.slots.stage(0, drooping_greybox(resistance_s_L));
    rig.ticks_to_verdict();
    return rig.slots.state(0).trial.staged_rms_kPa;
  };
  EXPECT_LT(rms_kPa(5.0F), 0.25F * rms_kPa(0.0F));
}

TEST(ShadowRun, HasNothingToCompareByWithoutALog) {
  Rig rig(kValve);
  rig.slots.stage(0, image_of(scaled(kC7, 0.5F)));
  EXPECT_EQ(rig.slots.state(0).phase, SetPhase::staged) << "at once";
  EXPECT_EQ(rig.slots.state(0).trial.outcome, Trial::not_compared);
  rig.write_steps(ShadowRun::kLeastMoved * ShadowRun::kStretchTicks);
  rig.slots.stage(0, image_of(scaled(kC7, 0.5F)));
  EXPECT_EQ(rig.slots.state(0).trial.outcome, Trial::not_compared) << "200 rows are 199 ticks";
}

TEST(ShadowRun, ComparesNothingByAPressureThatStandsStill) {
  Rig rig(kAt205);
  for (std::size_t k = 0; k < kLogTicks; ++k) rig.write(203.1 + (k % 2 == 0 ? 1.9 : -1.9), kNull_V);
  EXPECT_EQ(rig.compare(at_once(400.0F)).outcome, Trial::not_compared);
  EXPECT_EQ(rig.slots.state(0).phase, SetPhase::staged);
}

TEST(ShadowRun, NeedsTenStretchesInWhichThePressureMoves) {
  for (const std::size_t moving : {183U, 190U}) {
    Rig rig(kAt205);
    for (std::size_t k = 0; k < 600; ++k) rig.write(k < moving ? to_and_fro_kPa(k) : 205.0, kNull_V);
    EXPECT_EQ(rig.compare(at_once(400.0F)).outcome == Trial::worse, moving > 183)
        << moving << " rows that move";
  }
}

TEST(ShadowRun, TakesAFullLogIn32Ticks) {
  Rig rig(kValve);
  rig.write_steps(kLogTicks);
  rig.slots.stage(0, image_of(kValve));
  EXPECT_EQ(rig.ticks_to_verdict(), 32) << "1023 ticks of the log, 32 a tick";
}

TEST(ShadowRun, ComparesEachOfEightChambers) {
  Rig rig(kValve);
  rig.write_steps(kLogTicks);
  for (std::uint8_t c = 0; c < kChambers; ++c)
    rig.slots.stage(c, image_of(c % 2 == 0 ? kValve : scaled(kC7, 0.5F)));
  for (int tick = 0; tick < 8 * 32; ++tick) rig.run.step(rig.slots);
  for (std::uint8_t c = 0; c < kChambers; ++c) {
    EXPECT_EQ(rig.slots.state(c).trial.outcome, c % 2 == 0 ? Trial::passed : Trial::worse) << "chamber " << c;
  }
}

TEST(ShadowRun, ComparesByTheLogAsItWasWhileTheRecorderRolls) {
  Rig still(kValve), rolling(kValve);
  still.write_steps(kLogTicks);
  rolling.write_steps(kLogTicks);
  const config::TrialResult expected = still.compare(scaled(kC7, 0.9F));
  rolling.slots.stage(0, image_of(scaled(kC7, 0.9F)));
  while (rolling.slots.checking(0)) {
    rolling.run.step(rolling.slots);
    rolling.write(999.0, 9.0);
  }
  EXPECT_EQ(rolling.slots.state(0).trial.staged_rms_kPa, expected.staged_rms_kPa);
  EXPECT_EQ(rolling.slots.state(0).trial.active_rms_kPa, expected.active_rms_kPa);
}

TEST(ShadowRun, EndsWhenItsLogIsForgottenMeanwhile) {
  Rig rig(kValve);
  rig.write_steps(kLogTicks);
  rig.slots.stage(0, image_of(scaled(kC7, 0.5F)));
  rig.run.step(rig.slots);
  rig.run.step(rig.slots);
  ASSERT_TRUE(rig.recorder.order(static_cast<std::uint8_t>(Recorder::Order::record)));
  EXPECT_EQ(rig.ticks_to_verdict(), 1);
  EXPECT_EQ(rig.slots.state(0).trial.outcome, Trial::not_compared) << "64 ticks were compared";
}

TEST(ShadowRun, BeginsAnewWithANewImage) {
  Rig rig(kValve);
  rig.write_steps(kLogTicks);
  rig.slots.stage(0, image_of(scaled(kC7, 0.5F)));
  for (int i = 0; i < 20; ++i) rig.run.step(rig.slots);
  rig.slots.stage(0, image_of(kValve));
  EXPECT_EQ(rig.ticks_to_verdict(), 32);
  EXPECT_EQ(rig.slots.state(0).trial.outcome, Trial::passed);
}

TEST(ShadowRun, DropsAComparisonThatIsNotWantedAnyMore) {
  Rig rig(kValve);
  rig.write_steps(kLogTicks);
  rig.slots.stage(0, image_of(scaled(kC7, 0.5F)));
  rig.slots.stage(3, image_of(kValve));
  for (int i = 0; i < 5; ++i) rig.run.step(rig.slots);
  auto spoilt = image_of(kValve);
  spoilt[40] ^= 1U;
  EXPECT_FALSE(rig.slots.stage(0, spoilt));
  EXPECT_EQ(rig.ticks_to_verdict(3), 32);
  EXPECT_EQ(rig.slots.state(0).phase, SetPhase::refused);
  EXPECT_EQ(rig.slots.state(0).trial.outcome, Trial::none);
}

// ---- the whole board

/// Regulates steps of the set point, so that the log tells models apart.
void record_steps(Bench& bench) {
  bench.go_active(300.0);
  for (int i = 0; i < 40; ++i) {
    bench.setpoint_kPa = i % 2 == 0 ? 450.0 : 250.0;
    bench.run(25);
  }
}

TEST(ShadowRunOnABoard, RefusesAWorseModelAndSaysByHowMuch) {
  Bench bench;
  record_steps(bench);
  EXPECT_THAT([&] { bench.session.upload_model(2, image_of(scaled(kC7, 0.5F))); },
              ThrowsMessage<host::client::Refused>(HasSubstr("predicts")));
  const auto state = static_cast<std::uint16_t>(object::kSetState + 2);
  EXPECT_EQ(bench.session.read<std::uint8_t>(state, 1), 6) << "doubted";
  EXPECT_EQ(bench.session.read<std::uint8_t>(state, 2), 13) << "predicts worse";
  EXPECT_EQ(bench.session.read<std::uint8_t>(state, 9), 4) << "worse";
  EXPECT_GT(bench.session.read<float>(state, 10), 5.0F * bench.session.read<float>(state, 11)) << "Pa";
  EXPECT_EQ(bench.session.download_model(2), image_of(kValve, 100));
}

TEST(ShadowRunOnABoard, TakesAWorseModelByForce) {
  Bench bench;
  record_steps(bench);
  const auto worse = image_of(scaled(kC7, 0.5F));
  bench.session.upload_model(2, worse, host::client::Doubted::force);
  EXPECT_EQ(bench.session.download_model(2), worse);
}

TEST(ShadowRunOnABoard, TellsWhoAcceptsWhatItDoubtsWhyItDoes) {
  using host::client::Doubted;
  Bench bench;
  record_steps(bench);
  const auto taken = bench.session.upload_model(2, image_of(scaled(kC7, 0.5F)), Doubted::accept);
  EXPECT_EQ(bench.session.download_model(2), image_of(scaled(kC7, 0.5F)));
  EXPECT_EQ(taken.outcome, host::client::Comparison::Outcome::worse);
  EXPECT_GT(taken.rms_Pa, 5.0 * taken.before_rms_Pa);
  EXPECT_THAT(host::client::caveat_of(taken), StartsWith("taken by force: it predicts the board's log"));
  const auto back = bench.session.upload_model(2, image_of(kValve, 100), Doubted::accept);
  EXPECT_EQ(back.outcome, host::client::Comparison::Outcome::passed);
  EXPECT_EQ(host::client::caveat_of(back), "");
}

TEST(ShadowRunOnABoard, IsToldToWhoUploadsAlsoWhereItHadNothingToCompareBy) {
  using Outcome = host::client::Comparison::Outcome;
  Bench bench;
  EXPECT_EQ(bench.session.upload_model(2, image_of(kValve, 6)).outcome, Outcome::no_model);
  const auto unmoved = bench.session.upload_model(2, image_of(kValve, 7));
  EXPECT_EQ(unmoved.outcome, Outcome::no_movement);
  EXPECT_THAT(host::client::caveat_of(unmoved), HasSubstr("not compared with the model before"));
  EXPECT_EQ(bench.session.upload_model(2, image_of(kValve, 7)).outcome, Outcome::same);
  record_steps(bench);
  const auto passed = bench.session.upload_model(2, image_of(kValve, 8));
  EXPECT_EQ(passed.outcome, Outcome::passed);
  EXPECT_EQ(host::client::caveat_of(passed), "");
  EXPECT_GT(passed.rms_Pa, 0.0);
  EXPECT_EQ(passed.rms_Pa, passed.before_rms_Pa) << "the same parameters";
  const auto forced = bench.session.upload_model(2, image_of(kValve, 9), host::client::Doubted::force);
  EXPECT_EQ(forced.outcome, Outcome::not_awaited);
  EXPECT_THAT(host::client::caveat_of(forced), HasSubstr("forced"));
}

TEST(ShadowRunOnABoard, AnswersACommitWhileItRunsWithThePresentStateOfTheDevice) {
  Bench bench;
  record_steps(bench);
  const auto image = image_of(kValve, 7);
  const std::uint32_t crc = config::trailing_crc(image);
  const auto commit = [&] {
    bench.session.write(object::kCommit, 1, std::uint8_t{1});
    bench.session.write(object::kCommit, 2, config::commit_crc({&crc, 1}));
    bench.session.write(object::kCommit, 3, config::kCommitKey);
  };
  bench.session.sdo_write(object::kStagedModel, 0, image);
  EXPECT_EQ(bench.session.read<std::uint8_t>(object::kSetState, 1), 5) << "checking";
  EXPECT_THAT(commit, ThrowsMessage<host::client::SdoAbort>(HasSubstr("08000022h")));
  bench.run(3 + 32);  // the check of its inverse comes first
  EXPECT_EQ(bench.session.read<std::uint8_t>(object::kSetState, 1), 2) << "staged";
  commit();
  bench.run(1);
  EXPECT_EQ(bench.session.download_model(0), image);
}

TEST(ShadowRunOnABoard, RefusesAModelOfAnotherValve) {
  Settings settings = bench_settings();
  settings.chamber[1].valve_serial = 815;
  Bench bench(settings);
  EXPECT_THAT([&] { bench.session.upload_model(1, image_of(kValve, 4711)); },
              ThrowsMessage<host::client::Refused>(HasSubstr("valve 4711, the board has 815")));
  bench.session.upload_model(1, image_of(kValve, 815));
  const auto taken = bench.session.upload_model(1, image_of(kValve, 4711), host::client::Doubted::accept);
  EXPECT_EQ(bench.session.download_model(1), image_of(kValve, 4711));
  EXPECT_THAT(host::client::caveat_of(taken), HasSubstr("valve 4711, the board has 815"));
}

TEST(ShadowRunOnABoard, LeavesTheCommandsAsTheyWouldBeWithoutIt) {
  Bench bench, twin;
  for (Bench* one : {&bench, &twin}) record_steps(*one);
  bench.session.sdo_write(object::kStagedModel, 0, image_of(kValve, 7));
  twin.run(bench.ticks - twin.ticks);  // until it was answered
  ASSERT_EQ(bench.analog_out.held_V, twin.analog_out.held_V);
  for (int i = 0; i < 40; ++i) {
    bench.tick();
    twin.tick();
    ASSERT_EQ(bench.analog_out.held_V, twin.analog_out.held_V) << "tick " << i;
  }
}

}  // namespace
}  // namespace plenum
