// Fits of the chamber: effects that the rig already has, and what held-out rows say of a fit.
#include "host-sim/identify/chamber/fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "host-sim/identify/box_solver.hpp"
#include "host-sim/plant/chamber.hpp"
#include "tests/identify/chamber/chamber_scene.hpp"

namespace plenum::host::identify::chamber {
namespace {

using effects::EffectSet;

constexpr double kNoise_Pa = 100.0;

void add_noise(Record& record, unsigned seed) {
  std::mt19937 bits(seed);
  std::normal_distribution<double> noise(0.0, kNoise_Pa);
  for (double& p : record.measured_Pa) p += noise(bits);
}

/// Commands that never open the exhaust, from 1 V below to `high_V` above where the supply opens.
std::vector<double> filling_V(std::size_t rows, double low_V, double high_V) {
  std::vector<double> command_V = jumping_V(rows);
  const auto [least, greatest] = std::minmax_element(command_V.begin(), command_V.end());
  const double from = *least, span = *greatest - *least;
  for (double& u : command_V) u = low_V + (u - from) / span * (high_V - low_V);
  return command_V;
}

TEST(ChamberFit, AnEffectOfTheRigIsInEveryRun) {
  trace::RigDescription rig;
  rig.effects["dead_time"]["delay_s"] = 0.013;
  const Scene known = make_scene(rig);
  EXPECT_EQ(known.known, effects::EffectSet{1} << effects::kIdDeadTime);
  Scene plain = chamber_scene(jumping_V(600), 30e-6);
  effects::Figures late = plain.nominal;
  late[effects::kFirstFigure[effects::kIdDeadTime]] = 0.013;
  const std::vector<double> expected =
      run(plain, plain.records[0], effects::EffectSet{1} << effects::kIdDeadTime, late, {3e5});
  EXPECT_EQ(run(known, plain.records[0], 0, known.nominal, {3e5}), expected);
  EXPECT_NE(run(plain, plain.records[0], 0, plain.nominal, {3e5}), expected);
}

/// Readings of the error-controlled plant at `rate_Hz`, a new command each quarter of a second, and what the plant was.
trace::Log plant_log(double rate_Hz) {
  const plant::VolumeMotion volume(
      150e-6, {{{.amplitude_m3 = 45e-6, .frequency_Hz = 0.9, .phase_rad = 0.3}, {}, {}}});
  plant::ChamberConfig config;
  config.initial_pressure_Pa = 3e5;
  config.tolerance_Pa = 0.1;
  plant::ChamberPlant chamber(plant::ThinPlateValve({}), config, volume);
  std::mt19937 bits(5);
  trace::Log log;
  log.period_s = log.pressure_average_s = 1.0 / rate_Hz;
  log.pressure_Pa = {3e5};
  for (double t = 0.0; t < 20.0; t += log.period_s) {
    const bool jumps = std::floor(4.0 * t) > std::floor(4.0 * (t - log.period_s));
    log.time_s.push_back(t);
    log.command_V.push_back(jumps ? 3.0 + 4.0 * static_cast<double>(bits()) / 4294967296.0
                                  : log.command_V.back());
    log.volume_m3.push_back(volume.at(t).volume_m3);
    log.pressure_Pa.push_back(chamber.advance(log.command_V.back(), log.period_s).mean_Pa);
  }
  log.pressure_Pa.pop_back();
  return log;
}

TEST(ChamberFit, ALogOfAnyRateIsRunAsExactlyAsOneOf100Hz) {
  for (const double rate_Hz : {25.0, 40.0, 50.0, 100.0, 200.0, 500.0}) {
    const trace::Log log = plant_log(rate_Hz);
    const Scene scene = make_scene({});
    const Record record = make_record("log", log, 1.0);
    const std::vector<double> reading_Pa = run(scene, record, 0, scene.nominal, {3e5});
    double squares = 0.0;
    for (std::size_t row = 1; row < log.size(); ++row) {
      squares += std::pow(reading_Pa[row] - log.pressure_Pa[row], 2);
    }
    EXPECT_LT(std::sqrt(squares / static_cast<double>(log.size())), 25.0) << "Pa RMS at " << rate_Hz << " Hz";
  }
}

TEST(ChamberFit, FiguresBendAboutTheMeanVolumeOfTheFirstLogWhateverTheNext) {
  Scene scene = chamber_scene(jumping_V(600), 30e-6);
  const double mean_m3 = scene.around.volume_m3;
  EXPECT_NEAR(mean_m3, 150e-6, 5e-6);
  Record larger = scene.records[0];
  for (double& volume_m3 : larger.drive.volume_m3) volume_m3 *= 3.0;
  add_record(scene, larger);
  EXPECT_EQ(scene.around.volume_m3, mean_m3);
  // a bow adds nothing to a chamber at rest at that volume, and the square of its way elsewhere
  effects::Figures bowed = scene.nominal;
  bowed[effects::kFirstFigure[effects::kIdVolumeError] + 1] = 0.5;
  Record rests = scene.records[0];
  const auto at_volume = [&](double volume_m3, effects::EffectSet on, const effects::Figures& figures) {
    std::fill(rests.drive.volume_m3.begin(), rests.drive.volume_m3.end(), volume_m3);
    return run(scene, rests, on, figures, {3e5});
  };
  const EffectSet on = EffectSet{1} << effects::kIdVolumeError;
  EXPECT_EQ(at_volume(mean_m3, on, bowed), at_volume(mean_m3, 0, scene.nominal));
  const std::vector<double> bent = at_volume(1.2 * mean_m3, on, bowed);
  const std::vector<double> actual = at_volume((1.2 + 0.5 * 0.04) * mean_m3, 0, scene.nominal);
  for (std::size_t k = 0; k < bent.size(); ++k) ASSERT_NEAR(bent[k], actual[k], 1e-3) << "Pa, row " << k;
}

TEST(ChamberFit, AVolumeThatRestsIsTakenOutWithoutAChange) {
  const Scene scene = chamber_scene(jumping_V(600), 0.0);
  const EffectSet volume_error = EffectSet{1} << effects::kIdVolumeError;
  effects::Figures larger = scene.nominal;
  larger[effects::kFirstFigure[effects::kIdVolumeError]] = 60.0;  // mL
  const effects::Figures smaller = figures_without(scene, larger, effects::kIdVolumeError);
  EXPECT_EQ(smaller[effects::kFirstFigure[effects::kIdVolumeError]], 0.0);
  const std::vector<double> expected = run(scene, scene.records[0], volume_error, larger, {3e5});
  const std::vector<double> found = run(scene, scene.records[0], 0, smaller, {3e5});
  const std::vector<double> kept = run(scene, scene.records[0], 0, scene.nominal, {3e5});
  double most_Pa = 0.0;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    EXPECT_NEAR(found[k], expected[k], 1e-6 * expected[k]);
    most_Pa = std::max(most_Pa, std::abs(kept[k] - expected[k]));
  }
  EXPECT_GT(most_Pa, 1000.0);
}

TEST(ChamberFit, WithAnEffectOfTheRigTheValveIsFittedAsWithoutIt) {
  trace::RigDescription rig;
  rig.effects["dead_time"]["delay_s"] = 0.013;
  Scene known = make_scene(rig);
  known.records = chamber_scene(jumping_V(1500), 30e-6).records;
  known.records[0].measured_Pa = run(known, known.records[0], 0, known.nominal, {3e5});
  effects::Figures wrong = known.nominal;
  wrong[effects::kInletGain] *= 1.1;
  wrong[effects::kOpenAbove] += 0.02;
  const Fit found = fit(known, 0, wrong, {});
  EXPECT_NEAR(found.figures[effects::kInletGain] / known.nominal[effects::kInletGain], 1.0, 1e-3);
  EXPECT_NEAR(found.figures[effects::kOpenAbove], known.nominal[effects::kOpenAbove], 1e-3);
  EXPECT_LT(found.rms_Pa(), 5.0);
}

TEST(ChamberFit, WhatHasChangedActsOnTheLaterRecordsAlone) {
  trace::RigDescription rig;
  rig.effects["dead_time"]["delay_s"] = 0.013;
  Scene scene = make_scene(rig);
  scene.records = chamber_scene(jumping_V(1500), 30e-6).records;
  scene.records.push_back(scene.records[0]);
  scene.records[1].before = true;
  effects::Figures later = scene.nominal;
  later[effects::kFirstFigure[effects::kIdDeadTime]] = 0.031;  // was 0.013
  later[effects::kFirstFigure[effects::kIdSensorBias]] = 4.0;  // was none
  const EffectSet changed = EffectSet{1} << effects::kIdDeadTime | EffectSet{1} << effects::kIdSensorBias;
  const std::vector<double> as_it_was = run(scene, scene.records[0], 0, scene.nominal, {3e5});
  EXPECT_EQ(run(scene, scene.records[1], changed, later, {3e5}), as_it_was);

  for (Record& record : scene.records) record.measured_Pa = run(scene, record, changed, later, {3e5});
  ASSERT_NE(scene.records[0].measured_Pa, as_it_was);
  const Fit found = fit(scene, changed, scene.nominal, {});
  EXPECT_LT(found.rms_Pa(), 5.0);
  EXPECT_NEAR(found.figures[effects::kFirstFigure[effects::kIdDeadTime]], 0.031, 1e-3);
  EXPECT_NEAR(found.figures[effects::kFirstFigure[effects::kIdSensorBias]], 4.0, 0.1);
}

constexpr EffectSet kHeat = EffectSet{1} << effects::kIdHeatTransfer;

/// A log of gas that begins at 0.3 MPa with `warmth_Pa`, read with noise.
Scene warm_scene(double warmth_Pa, double conductance_W_K) {
  Scene scene = chamber_scene(jumping_V(1500), 30e-6);
  effects::Figures heat = scene.nominal;
  heat[effects::kFirstFigure[effects::kIdHeatTransfer]] = conductance_W_K;
  scene.records[0].measured_Pa = run(scene, scene.records[0], kHeat, heat, {3e5, warmth_Pa});
  scene.noise_Pa = kNoise_Pa;
  add_noise(scene.records[0], 4);
  return scene;
}

TEST(ChamberFit, RowsThatDoNotCountSayNothing) {
  Scene scene = chamber_scene(jumping_V(1500), 30e-6);
  effects::Figures wrong = scene.nominal;
  wrong[effects::kInletGain] *= 1.1;
  Record& record = scene.records[0];
  record.half = {600, 100, false};
  for (std::size_t row = 0; row < record.rows(); ++row) {
    if (!record.counts(row)) record.measured_Pa[row] = 9e9;
  }
  const Fit found = fit(scene, 0, wrong, {});
  EXPECT_NEAR(found.figures[effects::kInletGain] / scene.nominal[effects::kInletGain], 1.0, 1e-3);
  EXPECT_LT(found.rms_Pa(), 5.0);
  EXPECT_EQ(found.rows, 600 - record.settled_rows + 500)
      << "of 900: 100, 300, 500, 700 and the last are fitted";
  const Score judged = score(run(scene, record, 0, found.figures, found.start[0]), record, 600);
  EXPECT_EQ(judged.rows, 500U);
  EXPECT_LT(judged.rms_Pa(), 5.0);
}

TEST(ChamberFit, TheTwoHalvesAreAllRowsAndNoneTwice) {
  Record first = chamber_scene(jumping_V(300), 0.0).records[0], second = first;
  first.half = {130, 7, false};
  second.half = {130, 7, true};
  for (std::size_t row = 0; row < 300; ++row) {
    if (row < 130) {
      EXPECT_TRUE(first.counts(row) && second.counts(row)) << row;
    } else {
      EXPECT_NE(first.counts(row), second.counts(row)) << row;
    }
  }
}

TEST(ChamberFit, FindsHowWarmTheGasBegan) {
  for (const double warmth_Pa : {3e4, -5e4}) {
    const Scene scene = warm_scene(warmth_Pa, 0.05);
    effects::Figures start = scene.nominal;
    start[effects::kFirstFigure[effects::kIdHeatTransfer]] = 0.02;
    const Fit found = fit(scene, kHeat, start, {});
    EXPECT_EQ(found.warmths, 1U);
    EXPECT_NEAR(found.start[0].warmth_Pa, warmth_Pa, 0.1 * std::abs(warmth_Pa));
    EXPECT_LT(found.rms_Pa(), 1.05 * kNoise_Pa);
    const effects::Start again = estimate_start(scene, scene.records[0], kHeat, found.figures);
    EXPECT_NEAR(again.warmth_Pa, warmth_Pa, 0.1 * std::abs(warmth_Pa));
  }
}

TEST(ChamberFit, TakesNoGasForWarmerThanCompressionWithoutHeatMadeIt) {
  const Scene scene = warm_scene(1.4e5, 0.05);  // 0.3 MPa came from ambient pressure: at most 80 kPa
  const effects::Surroundings& around = scene.around;
  const double most_Pa = 3e5 * (1.0 - std::pow(around.ambient_Pa / 3e5, 0.4 / 1.4));
  effects::Figures start = scene.nominal;
  start[effects::kFirstFigure[effects::kIdHeatTransfer]] = 0.05;
  const Fit found = fit(scene, kHeat, start, {});
  EXPECT_NEAR(found.start[0].warmth_Pa, most_Pa, 0.1 * most_Pa);
}

TEST(ChamberFit, WithoutHeatTheGasHasNoWarmth) {
  const Scene scene = warm_scene(3e4, 0.05);
  const Fit found = fit(scene, 0, scene.nominal, {});
  EXPECT_EQ(found.warmths, 0U);
  EXPECT_EQ(found.start[0].warmth_Pa, 0.0);
}

TEST(LeastError, IsOfTheChamberThatMadeTheRecordsWhereverItStandsAmongEight) {
  const Scene plain = chamber_scene(jumping_V(600), 30e-6);
  const EffectSet on = EffectSet{1} << effects::kIdVolumeError;
  const std::size_t offset = effects::kFirstFigure[effects::kIdVolumeError];
  const std::vector<effects::Start> starts{{3e5}, {5e5}};
  for (std::size_t truth = 0; truth < 8; ++truth) {
    std::vector<effects::Figures> offered(8, plain.nominal);
    for (std::size_t i = 0; i < offered.size(); ++i) offered[i][offset] = 3.0 * static_cast<double>(i);
    Scene scene = plain;
    scene.records.push_back(scene.records[0]);
    for (std::size_t r = 0; r < 2; ++r) {
      scene.records[r].measured_Pa = run(plain, plain.records[0], on, offered[truth], starts[r]);
    }
    EXPECT_EQ(least_error(scene, on, offered, starts), truth);
    offered[(truth + 1) % 8][offset] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(least_error(scene, on, offered, starts), truth) << "beside one that is not a number";
  }
}

TEST(JointSquares, OfTheSameRowsTwiceAreTwiceTheFit) {
  Scene scene = chamber_scene(jumping_V(1500), 30e-6);
  add_noise(scene.records[0], 3);
  const Fit found = fit(scene, 0, scene.nominal, {}, {.most_iterations = 100, .tolerance = 1e-9});
  const JointSquares joint = joint_squares(scene, found, scene.records, found.start, true);
  EXPECT_NEAR(joint.both / (2.0 * found.squares), 1.0, 1e-4);
  EXPECT_NEAR(joint.judged() / found.squares, 1.0, 1e-4);
}

TEST(JointSquares, LeaveToTheHeldOutRowsWhatTheFittedOnesDoNotShow) {
  Scene scene = chamber_scene(jumping_V(10), 0.0);
  const effects::Figures truth = scene.nominal;
  const auto record_of = [&](const std::vector<double>& command_V, double start_Pa, unsigned seed) {
    Record record = chamber_scene(command_V, 0.0).records[0];
    record.measured_Pa = run(scene, record, 0, truth, {start_Pa});
    add_noise(record, seed);
    return record;
  };
  scene.records = {record_of(
      filling_V(1500, truth[effects::kOpenAbove] - 0.2, truth[effects::kOpenAbove] + 0.3), 1.2e5, 5)};
  const std::vector<Record> held{record_of(jumping_V(1500), 3e5, 6)};
  effects::Figures start = truth;
  start[effects::kExhaustGain] *= 1.04;
  const Fit found = fit(scene, 0, start, {});
  const effects::Start start_there = estimate_start(scene, held[0], 0, found.figures);
  const Score alone = score(run(scene, held[0], 0, found.figures, start_there), held[0], 1);
  const JointSquares joint = joint_squares(scene, found, held, {start_there}, false);
  ASSERT_GT(alone.rms_Pa(), 5.0 * kNoise_Pa) << "the fitted log shows the exhaust";
  EXPECT_LT(std::sqrt(joint.both / static_cast<double>(found.rows + alone.rows)), 1.1 * kNoise_Pa);
  EXPECT_NEAR(std::sqrt(joint.judged() / static_cast<double>(alone.rows)), kNoise_Pa, 0.1 * kNoise_Pa);
}

TEST(JointSquares, AreInfiniteWhereMoreLogsAreHeldOutThanThereIsRoomForStarts) {
  const Scene scene = chamber_scene(jumping_V(60), 0.0);
  const Fit found = fit(scene, 0, scene.nominal, {});
  const auto of_logs = [&](std::size_t logs) {
    return joint_squares(scene, found, std::vector<Record>(logs, scene.records[0]),
                         std::vector<effects::Start>(logs, found.start[0]), false)
        .both;
  };
  const auto taken = static_cast<std::size_t>(found.gram.rows()) - 1;
  const std::size_t room = identify::kMostVariables - taken;
  EXPECT_TRUE(std::isfinite(of_logs(room)));
  EXPECT_TRUE(std::isinf(of_logs(room + 1)));
}

}  // namespace
}  // namespace plenum::host::identify::chamber
