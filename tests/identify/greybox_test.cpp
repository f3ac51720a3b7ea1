// The board's model of a rig against the rig's own physics, which share no code: free runs of ten seconds.
#include "host-sim/identify/greybox.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "host-sim/effects/free_run.hpp"
#include "host-sim/identify/chamber/fit.hpp"
#include "host-sim/trace/input_error.hpp"
#include "tests/identify/board_free_run.hpp"
#include "tests/identify/board_parameters.hpp"

namespace plenum::host::identify {
namespace {

constexpr std::size_t kRows = 1000;
constexpr double kMeanVolume_m3 = 100e-6;

/// Random commands, each held for 50 to 500 ms, on a volume that doubles at 1.6 Hz.
struct Drive {
  std::vector<double> command_V, volume_m3;
};
Drive violent() {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> command(3.5, 6.5);
  std::uniform_int_distribution<int> hold(5, 50);
  Drive drive;
  while (drive.command_V.size() < kRows) {
    const double u = command(random);
    for (int left = hold(random); left > 0; --left) drive.command_V.push_back(u);
  }
  drive.command_V.resize(kRows);
  for (std::size_t k = 0; k < kRows; ++k) {
    const double phase = 2.0 * 3.14159265358979 * 1.6 * 0.01 * static_cast<double>(k);
    drive.volume_m3.push_back(kMeanVolume_m3 * std::pow(2.0, 0.5 * std::sin(phase)));
  }
  return drive;
}

/// What the sensor shows in the mean of the tick before each row.
std::vector<double> of_the_rig(const trace::RigDescription& rig, const Drive& drive) {
  const chamber::Scene scene = chamber::make_scene(rig);
  constexpr effects::Timing kMeans{.tick_s = 0.01, .average_s = 0.01, .steps = 8};
  const effects::Run run{scene.nominal, {300e3}};
  std::vector<double> lanes(kRows * effects::kLanes);
  effects::free_run(scene.around, effects::make_drive(drive.command_V, drive.volume_m3, kMeans), scene.known,
                    {&run, 1}, lanes);
  std::vector<double> readings;
  for (std::size_t k = 0; k < kRows; ++k) readings.push_back(lanes[k * effects::kLanes]);
  return readings;
}

/// The largest difference of the sensor's reading over the run, in percent of P_c - P_r, with a model of the rig as it is
/// `known`.
double worst_drift_percent(const trace::RigDescription& rig, const trace::RigDescription& known) {
  const Drive drive = violent();
  const std::vector<double> truth_Pa = of_the_rig(rig, drive);
  const GreyboxModel made = greybox_of(known);
  const plenum::config::ModelParameters parameters =
      host::testing::board_parameters(made.file.kind, made.file.parameters);
  std::vector<double> volume_mL, volume_rate_mL_s;
  for (std::size_t k = 0; k + 1 < kRows; ++k) {
    const double from_mL = 1e6 * drive.volume_m3[k], to_mL = 1e6 * drive.volume_m3[k + 1];
    volume_mL.push_back(0.5 * (from_mL + to_mL));
    volume_rate_mL_s.push_back((to_mL - from_mL) / 0.01);
  }
  const std::vector<double> shown_kPa = host::testing::board_free_run_kPa(
      parameters, 300.0, std::span(drive.command_V).first(kRows - 1), volume_mL, volume_rate_mL_s);
  double worst_kPa = 0.0;
  for (std::size_t k = 0; k + 1 < kRows; ++k)
    worst_kPa = std::max(worst_kPa, std::abs(shown_kPa[k] - 1e-3 * truth_Pa[k + 1]));
  return 1e5 * worst_kPa / (rig.supply.pressure_Pa - rig.ambient.pressure_Pa);
}

double worst_drift_percent(const trace::RigDescription& rig) {
  return worst_drift_percent(rig, rig);
}

double of_model(const GreyboxModel& made, std::string_view parameter) {
  const auto& names = trace::parameter_names("greybox");
  return made.file.parameters.at(
      static_cast<std::size_t>(std::ranges::find(names, parameter) - names.begin()));
}

TEST(GreyboxOfARig, FollowsTheThinPlate) {
  EXPECT_LT(worst_drift_percent({}), 0.3);
}

TEST(GreyboxOfARig, FollowsTheRigsEffectsThatDoNotChangeInTime) {
  trace::RigDescription rig;
  rig.effects["area_shape"] = {{"inlet_slope", 1.0}, {"inlet_curve", -0.5}, {"exhaust_slope", 0.6}};
  rig.effects["flow_function"] = {
      {"critical_ratio", 0.35}, {"subsonic_index", 0.6}, {"discharge_slope", 0.1}};
  rig.effects["volume_error"] = {{"offset_mL", 15.0}};
  rig.effects["chamber_leak"] = {{"conductance_g_s_MPa", 0.3}};
  EXPECT_LT(worst_drift_percent(rig), 0.3);
  EXPECT_THAT(greybox_of(rig).left_out, ::testing::IsEmpty());
}

TEST(GreyboxOfARig, CompressesItsGasWithTheExponentOfTheRigs) {
  trace::RigDescription rig;
  rig.effects["heat_transfer"] = {{"exponent", 1.15}};
  EXPECT_LT(worst_drift_percent(rig), 0.3);
  EXPECT_GT(worst_drift_percent(rig, {}), 3.0);
  EXPECT_THAT(greybox_of(rig).left_out, ::testing::IsEmpty());
  rig.effects["heat_transfer"]["conductance_W_K"] = 0.5;
  const GreyboxModel made = greybox_of(rig);
  EXPECT_THAT(made.left_out, ::testing::ElementsAre("heat_transfer"));
  EXPECT_EQ(made.rig.effects,
            (std::map<std::string, std::map<std::string, double>>{{"heat_transfer", {{"exponent", 1.15}}}}))
      << "what the model does have";
}

TEST(GreyboxOfARig, LeavesOutALeakThatGoesElsewhereThanToAmbient) {
  trace::RigDescription rig;
  rig.effects["chamber_leak"] = {{"conductance_g_s_MPa", 0.3}, {"beyond_kPa", 2.0}};
  EXPECT_THAT(greybox_of(rig).left_out, ::testing::IsEmpty());
  rig.effects["chamber_leak"]["beyond_kPa"] = 250.0;
  EXPECT_THAT(greybox_of(rig).left_out, ::testing::ElementsAre("chamber_leak"));
}

TEST(GreyboxOfARig, FollowsItsValveAndItsSensor) {
  trace::RigDescription rig;
  rig.effects["dead_time"] = {{"delay_s", 0.0234}};
  rig.effects["valve_hysteresis"] = {{"width_V", 0.2}};
  rig.effects["sensor_lag"] = {{"time_constant_s", 0.03}};
  EXPECT_LT(worst_drift_percent(rig), 0.3);
  EXPECT_THAT(greybox_of(rig).left_out, ::testing::IsEmpty());
}

TEST(GreyboxOfARig, ComesNearASpoolByItsLagAndItsDelay) {
  trace::RigDescription rig;
  rig.effects["spool_lag"] = {{"natural_frequency_Hz", 12.0}, {"damping", 0.8}};
  EXPECT_LT(worst_drift_percent(rig, rig), 0.25 * worst_drift_percent(rig, {}));
  EXPECT_THAT(greybox_of(rig).left_out, ::testing::IsEmpty());
}

TEST(GreyboxOfARig, NamesTheFiguresOfItsEffectsThatABoardHasNoPlaceFor) {
  trace::RigDescription rig;
  rig.effects["spool_lag"] = {{"natural_frequency_Hz", 40.0}, {"slew_V_s", 15.0}, {"coil_s", 0.004}};
  rig.effects["volume_error"] = {{"lag_s", 0.06}, {"offset_mL", 2.0}};
  rig.effects["supply_droop"] = {{"resistance_kPa_s_per_g", 20.0}, {"followed_share", 0.5}};
  rig.effects["null_drift"] = {{"drift_at_60_s_V", 0.1}};
  rig.effects["sensor_bias"] = {{"drift_at_60_s_kPa", 5.0}};
  const GreyboxModel made = greybox_of(rig);
  EXPECT_THAT(made.refinements_left_out, ::testing::ElementsAre("spool_lag.slew_V_s", "volume_error.lag_s"));
  EXPECT_FALSE(made.rig.effects.at("spool_lag").contains("slew_V_s"));
  EXPECT_TRUE(made.rig.effects.at("spool_lag").contains("coil_s"));
  EXPECT_EQ(made.rig.effects.at("volume_error").size(), 1U);
  EXPECT_EQ(made.rig.effects.at("sensor_bias"), rig.effects.at("sensor_bias")) << "calibrated away";
  EXPECT_EQ(made.rig.effects.at("null_drift"), rig.effects.at("null_drift"));
}

TEST(GreyboxOfARig, IsAsLateAsASpoolOfOneLagAndItsCoilThoughABoardKnowsNeither) {
  trace::RigDescription rig;
  rig.effects["spool_lag"] = {
      {"natural_frequency_Hz", 8.0 / (std::numbers::pi * 0.02)}, {"damping", 8.0}, {"coil_s", 0.004}};
  const GreyboxModel made = greybox_of(rig);
  EXPECT_NEAR(of_model(made, "spool_damping") * of_model(made, "spool_period_s") / std::numbers::pi, 0.024,
              1e-12);
  EXPECT_LT(worst_drift_percent(rig, rig), 0.25 * worst_drift_percent(rig, {}));
}

TEST(GreyboxOfARig, TakesAHoseForItsAirAndAWavesWayThroughIt) {
  trace::RigDescription rig;
  rig.effects["dead_time"] = {{"delay_s", 0.005}};
  rig.effects["volume_error"] = {{"offset_mL", 10.0}};
  rig.effects["tube_dynamics"] = {{"length_m", 4.0}, {"bore_mm", 4.0}};
  EXPECT_NEAR(of_model(greybox_of(rig), "dead_volume_mL"), 10.0 + 16.0 * std::numbers::pi, 1e-9);
  EXPECT_NEAR(of_model(greybox_of(rig), "dead_time_s"), 0.005 + 4.0 / std::sqrt(1.4 * 287.05 * 293.15), 2e-4);
  EXPECT_THAT(greybox_of(rig).left_out, ::testing::IsEmpty());
}

TEST(GreyboxOfARig, ComesNearAHose) {
  trace::RigDescription rig;
  rig.effects["tube_dynamics"] = {{"length_m", 3.0}, {"bore_mm", 4.0}};
  EXPECT_LT(worst_drift_percent(rig, rig), 0.5 * worst_drift_percent(rig, {}));
}

TEST(GreyboxOfARig, FollowsASupplyThatDroops) {
  for (const double resistance : {20.0, 100.0, 400.0}) {
    for (const double recovery_s : {0.005, 0.02, 0.1, 1.0}) {
      trace::RigDescription rig;
      rig.effects["supply_droop"] = {{"resistance_kPa_s_per_g", resistance}, {"recovery_s", recovery_s}};
      // what a tick knows of the supply is its mean
      EXPECT_LT(worst_drift_percent(rig), 0.2 + 0.04 * worst_drift_percent(rig, {}))
          << resistance << " kPa s/g, " << recovery_s << " s";
      EXPECT_THAT(greybox_of(rig).left_out, ::testing::IsEmpty());
    }
  }
}

TEST(GreyboxOfARig, NamesTheEffectsThatItDoesNotCarry) {
  trace::RigDescription rig;
  rig.effects["exhaust_backpressure"] = {{"resistance_kPa_s_per_g", 20.0}};
  rig.effects["volume_error"] = {{"offset_mL", 15.0}};
  EXPECT_THAT(greybox_of(rig).left_out, ::testing::ElementsAre("exhaust_backpressure"));
  rig.effects["black_magic"] = {};
  EXPECT_THROW(greybox_of(rig), trace::InputError);
}

TEST(GreyboxOfARig, HasTheNullWhereADriftHasTakenItByThen) {
  trace::RigDescription rig;
  rig.effects["null_drift"] = {{"drift_at_60_s_V", 1.2}, {"time_constant_s", 20.0}};
  const double half_minute_V = 1.2 * (1.0 - std::exp(-30.0 / 20.0)) / (1.0 - std::exp(-60.0 / 20.0));
  for (const auto& [at_s, null_V] : {std::pair{0.0, 0.0}, {30.0, half_minute_V}, {60.0, 1.2}}) {
    const GreyboxModel made = greybox_of(rig, {}, at_s);
    EXPECT_NEAR(of_model(made, "open_above_V") - rig.valve.open_above_V, null_V, 1e-3) << at_s << " s";
    EXPECT_NEAR(of_model(made, "exhaust_below_V") - rig.valve.exhaust_below_V, null_V, 1e-3) << at_s << " s";
  }
}

TEST(GreyboxOfARig, SaysWhichChamberItIsOf) {
  EXPECT_EQ(greybox_of({}, 3).file.chamber, 3U);
  EXPECT_EQ(greybox_of({}).file.kind, "greybox");
}

}  // namespace
}  // namespace plenum::host::identify
