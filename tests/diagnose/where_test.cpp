#include "host-sim/diagnose/where.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "host-sim/plant/orifice.hpp"
#include "tests/identify/chamber/chamber_scene.hpp"

namespace plenum::host::diagnose {
namespace {

using identify::chamber::chamber_scene;
using identify::chamber::jumping_V;

double sum_of(const std::vector<RegimeShare>& shares) {
  double sum = 0.0;
  for (const RegimeShare& s : shares) sum += s.share;
  return sum;
}

/// A scene of one log, read by the nominal model, and its readings with `error_Pa(row)` added.
template <class Error>
std::vector<RegimeShare> regimes_with(const Scene& scene, Error&& error_Pa) {
  const Record& record = scene.records.front();
  Scored scored{&record, 0, record.measured_Pa, {}};
  for (std::size_t row = 1; row < record.rows(); ++row) scored.before_Pa[row] += error_Pa(row);
  return regimes(scene, scene.nominal, {scored});
}

TEST(Regimes, AnErrorOnlyWhileTheSupplyPortIsOpenIsAllGivenToIt) {
  const Scene scene = chamber_scene(jumping_V(3000), 0.0);
  const Record& record = scene.records.front();
  const auto shares = regimes_with(
      scene, [&](std::size_t row) { return record.drive.command_V[row - 1] > 5.08 ? 700.0 : 0.0; });
  ASSERT_EQ(shares.size(), 1U);
  EXPECT_EQ(shares[0].regime, "supply port open");
  EXPECT_NEAR(shares[0].share, 1.0, 1e-12);
}

TEST(Regimes, AnErrorJustAfterTheCommandMovedNamesTheMovement) {
  const Scene scene = chamber_scene(jumping_V(3000), 0.0);
  const auto shares = regimes_with(scene, [&](std::size_t row) { return (row - 1) % 25 < 4 ? 500.0 : 10.0; });
  double moving = 0.0;
  for (const RegimeShare& s : shares) {
    if (s.regime.starts_with("command moving") || s.regime.starts_with("command just reversed"))
      moving += s.share;
  }
  EXPECT_GT(moving, 0.97);
}

TEST(Regimes, AnErrorOfChokedVentingNamesIt) {
  const Scene scene = chamber_scene(jumping_V(3000), 0.0);
  const Record& record = scene.records.front();
  const auto shares = regimes_with(scene, [&](std::size_t row) {
    const bool venting = record.drive.command_V[row - 1] < 4.92;
    return venting && record.measured_Pa[row] > 1.8929 * 101325.0 ? 500.0 : 0.0;
  });
  ASSERT_FALSE(shares.empty());
  EXPECT_EQ(shares[0].regime, "exhaust port open, flow choked");
  EXPECT_GT(shares[0].share, 0.99);
}

TEST(Regimes, AnErrorOfChokedFillingNamesIt) {
  const Scene scene = chamber_scene(jumping_V(3000), 0.0);
  const Record& record = scene.records.front();
  const auto shares = regimes_with(scene, [&](std::size_t row) {
    const bool filling = record.drive.command_V[row - 1] > 5.08;
    return filling && record.measured_Pa[row] < 700000.0 / 1.8929 ? 500.0 : 0.0;
  });
  ASSERT_FALSE(shares.empty());
  EXPECT_EQ(shares[0].regime, "supply port open, flow choked");
  EXPECT_GT(shares[0].share, 0.99);
}

TEST(Regimes, AMovingVolumeIsNamedWhereTheErrorFollowsIt) {
  Scene scene = chamber_scene(jumping_V(3000), 0.0);
  std::vector<double> volume_m3(3000, 150e-6);  // moves in the middle only
  for (std::size_t row = 1000; row < 2000; ++row) {
    volume_m3[row] += 45e-6 * std::sin(0.05 * (static_cast<double>(row) - 1000.0));
  }
  Record& record = scene.records.front();
  record.drive = effects::make_drive(record.drive.command_V, volume_m3, record.drive.timing);
  const auto shares =
      regimes_with(scene, [](std::size_t row) { return row > 1030 && row < 2000 ? 500.0 : 0.0; });
  double moving = 0.0;
  for (const RegimeShare& s : shares) moving += s.regime.ends_with("volume moving") ? s.share : 0.0;
  EXPECT_GT(moving, 0.95);
}

/// The regime that has nearly all of an error, or a text that says how many share it.
std::string the_regime_of(const std::vector<RegimeShare>& shares) {
  if (shares.empty()) return "none";
  return shares[0].share > 0.97 ? shares[0].regime : std::to_string(shares.size()) + " regimes";
}

TEST(Regimes, AnErrorOfAPortThatOpensIsNotThatOfOneThatCloses) {
  std::vector<double> stairs_V;  // above the supply's threshold: up in steps, and down in as many
  for (std::size_t row = 0; row < 3000; ++row) {
    const std::size_t step = row / 25 % 10;
    stairs_V.push_back(5.2 + 0.1 * static_cast<double>(step < 5 ? step : 10 - step));
  }
  const Scene scene = chamber_scene(stairs_V, 0.0);
  const auto after_a_step = [](bool up) {
    return [up](std::size_t row) {
      const bool rises = (row - 1) / 25 % 10 < 6 && (row - 1) / 25 % 10 > 0;
      return (row - 1) % 25 < 4 && rises == up ? 500.0 : 0.0;
    };
  };
  EXPECT_EQ(the_regime_of(regimes_with(scene, after_a_step(true))),
            "command moving, valve opening, supply port open");
  EXPECT_EQ(the_regime_of(regimes_with(scene, after_a_step(false))),
            "command moving, valve closing, supply port open");
}

TEST(Regimes, AnErrorAtHighPressureInASmallVolumeOrLateIsThere) {
  const Scene scene = chamber_scene(jumping_V(3000), 45e-6);
  const Record& record = scene.records.front();
  const auto named = [&](auto&& where, const char* what) {
    double share = 0.0;
    for (const RegimeShare& s :
         regimes_with(scene, [&](std::size_t row) { return where(row) ? 500.0 : 0.0; }))
      share += s.regime.find(what) != std::string::npos ? s.share : 0.0;
    return share;
  };
  EXPECT_GT(named([&](std::size_t row) { return record.measured_Pa[row] > 400662.5; }, "pressure high"),
            0.97);
  EXPECT_GT(named([&](std::size_t row) { return record.drive.volume_m3[row * 4] < 150e-6; }, "volume small"),
            0.97);
  EXPECT_GT(named([&](std::size_t row) { return row >= 1500; }, "second half"), 0.97);
  EXPECT_GT(named([&](std::size_t row) { return row < 1500; }, "first half"), 0.97);
}

TEST(Regimes, AreDistinctFewAndSumToOneForAnyError) {
  const Scene scene = chamber_scene(jumping_V(2000), 45e-6);
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 bits(seed);
    double level = 100.0;
    const auto shares = regimes_with(scene, [&](std::size_t row) {
      if (row % 37 == 0) level = std::pow(10.0, static_cast<double>(bits() % 4));
      return level;
    });
    ASSERT_FALSE(shares.empty());
    EXPECT_LE(shares.size(), 8U) << "seed " << seed;
    EXPECT_NEAR(sum_of(shares), 1.0, 1e-9) << "seed " << seed;
    std::set<std::string> names;
    for (std::size_t i = 0; i < shares.size(); ++i) {
      names.insert(shares[i].regime);
      EXPECT_GE(shares[i].share, 0.01) << shares[i].regime;
      if (i > 0) {
        EXPECT_LE(shares[i].share, shares[i - 1].share);
      }
    }
    EXPECT_EQ(names.size(), shares.size()) << "seed " << seed;
  }
}

TEST(Regimes, AreNoneWhereThereIsNoError) {
  EXPECT_TRUE(regimes_with(chamber_scene(jumping_V(500), 0.0), [](std::size_t) { return 0.0; }).empty());
}

TEST(Regimes, RowsBeforeTheFirstScoredOneDoNotCount) {
  const Scene scene = chamber_scene(jumping_V(1000), 0.0);
  const Record& record = scene.records.front();
  Scored scored{&record, 600, record.measured_Pa, {}};
  for (std::size_t row = 0; row < 600; ++row) scored.before_Pa[row] += 1e5;
  EXPECT_TRUE(regimes(scene, scene.nominal, {scored}).empty());
}

TEST(ErrorMap, ACellHoldsTheRmsOfItsRowsAndIsNaNBelowFive) {
  Scene scene = chamber_scene(std::vector<double>(101, 5.0), 0.0);
  Record& record = scene.records.front();
  // columns of 4 .. 6 V, rows of the gauge pressure's eighths: 40 rows at 4 V low, 56 at 6 V high, 4 between
  const double gauge_Pa = 700000.0 - 101325.0;
  for (std::size_t row = 1; row <= 100; ++row) {
    record.drive.command_V[row - 1] = row <= 40 ? 4.0 : row <= 44 ? 5.05 : 6.0;
    record.measured_Pa[row] = 101325.0 + gauge_Pa * (row <= 40 ? 0.05 : 0.95);
  }
  Scored scored{&record, 0, record.measured_Pa, record.measured_Pa};
  for (std::size_t row = 1; row <= 100; ++row) {
    scored.before_Pa[row] += row <= 40 ? (row % 2 == 0 ? 300.0 : -400.0) : 50.0;
    scored.after_Pa[row] += 7.0;
  }
  const ErrorMap map = error_map(scene, {scored});
  ASSERT_EQ(map.pressure_ratio.size(), 8U);
  ASSERT_EQ(map.command_V.size(), 10U);
  EXPECT_NEAR(map.pressure_ratio[0], 1.0 / 16.0, 1e-12);
  EXPECT_NEAR(map.command_V[0], 4.1, 1e-12);
  EXPECT_NEAR(map.rms_Pa[0][0], std::sqrt(0.5 * (300.0 * 300.0 + 400.0 * 400.0)), 1e-9);
  EXPECT_NEAR(map.closed_Pa[0][0], 7.0, 1e-9);
  EXPECT_NEAR(map.rms_Pa[7][9], 50.0, 1e-9);
  EXPECT_TRUE(std::isnan(map.rms_Pa[7][5]));
  EXPECT_TRUE(std::isnan(map.rms_Pa[3][3]));
}

TEST(Disturbance, RecoversAKnownFlowIntoASealedChamberThatMoves) {
  // p v^kappa is driven by the flow alone: a Runge-Kutta of this test, 20 steps a tick, means over the tick.
  constexpr std::size_t kRows = 1000;
  constexpr double kVolume_m3 = 150e-6, kSwing_m3 = 40e-6, kRate_1_s = 4.0, kFlow_kg_s = 2e-4,
                   kPulse_1_s = 3.0;
  Scene scene = chamber_scene(std::vector<double>(kRows, 5.0), 0.0);
  for (const auto figure :
       {effects::kInletGain, effects::kExhaustGain, effects::kInletLeak, effects::kExhaustLeak}) {
    scene.nominal[figure] = 0.0;
  }
  scene.nominal[effects::kTransition] = 1e-18;
  const double RT = scene.around.gas.specific_gas_constant_J_kg_K() * scene.around.gas.temperature_K;
  const auto volume = [&](double t) { return kVolume_m3 + kSwing_m3 * std::sin(kRate_1_s * t); };
  const auto flow = [&](double t) { return kFlow_kg_s * std::sin(kPulse_1_s * t); };
  const auto rate = [&](double t, double p) {
    return 1.4 * (RT * flow(t) - p * kSwing_m3 * kRate_1_s * std::cos(kRate_1_s * t)) / volume(t);
  };
  Record& record = scene.records.front();
  std::vector<double> volume_m3(kRows);
  for (std::size_t row = 0; row < kRows; ++row) volume_m3[row] = volume(0.01 * static_cast<double>(row));
  record.drive = effects::make_drive(record.drive.command_V, volume_m3, record.drive.timing);
  double p = 3e5;
  record.measured_Pa[0] = p;
  for (std::size_t row = 1; row < kRows; ++row) {
    constexpr double h = 0.01 / 20;
    double sum = 0.0;
    for (int i = 0; i < 20; ++i) {
      const double t = 0.01 * static_cast<double>(row - 1) + h * i;
      const double k1 = rate(t, p), k2 = rate(t + 0.5 * h, p + 0.5 * h * k1);
      const double k3 = rate(t + 0.5 * h, p + 0.5 * h * k2), k4 = rate(t + h, p + h * k3);
      const double end = p + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
      sum += 0.5 * (p + end) / 20.0;
      p = end;
    }
    record.measured_Pa[row] = sum;
  }
  const std::vector<double> found = disturbance_kg_s(scene, record, scene.nominal);
  ASSERT_EQ(found.size(), kRows);
  for (std::size_t row = 15; row + 15 < kRows; ++row) {
    // a raised cosine over 0.11 s leaves 0.99 of 3 rad/s
    EXPECT_NEAR(found[row], flow(0.01 * static_cast<double>(row)), 0.02 * kFlow_kg_s) << "row " << row;
  }
}

TEST(Disturbance, RecoversALeakBesideAWorkingValveUnderNoise) {
  Scene scene = chamber_scene(jumping_V(3000), 30e-6);
  Record& record = scene.records.front();
  effects::Figures leaking = scene.nominal;
  leaking[effects::kFirstFigure[effects::kIdChamberLeak]] = 0.3;
  record.measured_Pa = run(scene, record, effects::EffectSet{1} << effects::kIdChamberLeak, leaking, {3e5});
  std::mt19937 bits(5);
  std::normal_distribution<double> noise(0.0, 50.0);
  for (double& pressure : record.measured_Pa) pressure += noise(bits);
  const std::vector<double> found = disturbance_kg_s(scene, record, scene.nominal);
  // laminar gap: G (p^2 - P_a^2)/(2 P_a); compared where the pressure is high, in the mean over the log
  double expected = 0.0, mean = 0.0;
  for (std::size_t row = 20; row + 20 < record.rows(); ++row) {
    const double pressure = record.measured_Pa[row];
    expected -= 0.3e-9 * (pressure * pressure - 101325.0 * 101325.0) / (2.0 * 101325.0);
    mean += found[row];
  }
  EXPECT_NEAR(mean / expected, 1.0, 0.03);
}

TEST(Disturbance, VanishesWhereTheModelIsRight) {
  const Scene scene = chamber_scene(jumping_V(3000), 30e-6);
  const Record& record = scene.records.front();
  const std::vector<double> found = disturbance_kg_s(scene, record, scene.nominal);
  double squares = 0.0;
  for (std::size_t row = 20; row + 20 < found.size(); ++row) squares += found[row] * found[row];
  // of flows of about 0.5 g/s
  EXPECT_LT(std::sqrt(squares / static_cast<double>(found.size())), 3e-7);
}

}  // namespace
}  // namespace plenum::host::diagnose
