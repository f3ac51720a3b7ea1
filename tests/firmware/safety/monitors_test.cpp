#include "firmware/safety/monitors.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace plenum::safety {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

ChamberMonitor::Input healthy() {
  ChamberMonitor::Input in;
  in.pressure_V = 4.0F;
  in.pressure_fresh = true;
  in.position_V = 5.0F;
  in.position_fresh = true;
  in.regulation_asked = true;
  in.model_ready = true;
  return in;
}

// The number of the first tick, counted from 1, in which `fault` is raised by `input` held; 0: never within
// 200.
template <typename Monitor, typename Settings, typename Input>
int first_tick_with(Fault fault, const Settings& settings, const Input& input) {
  Monitor monitor;
  for (int tick = 1; tick <= 200; ++tick) {
    FaultSet causes = 0;
    if constexpr (std::is_same_v<Monitor, ChamberMonitor>) {
      causes = monitor.step(settings, input).causes;
    } else {
      causes = monitor.step(settings, input);
    }
    if (holds(causes, fault)) return tick;
  }
  return 0;
}

int chamber_tick(Fault fault, const ChamberMonitor::Input& input,
                 const config::ChamberSettings& settings = {}) {
  return first_tick_with<ChamberMonitor>(fault, settings, input);
}

TEST(ChamberMonitor, RaisesNothingOfAHealthyChamber) {
  ChamberMonitor monitor;
  for (int tick = 0; tick < 100; ++tick) {
    const auto out = monitor.step({}, healthy());
    EXPECT_EQ(out.causes, 0U);
    EXPECT_TRUE(out.pressure_usable);
    EXPECT_TRUE(out.position_usable);
  }
}

// The first of 40 ticks that raises it; 0: none. The command goes up and down by `stroke_V`, the reading by `noise_V`.
int stuck_tick(float stroke_V, float noise_V, bool driven = true,
               const config::ChamberSettings& settings = {}) {
  ChamberMonitor monitor;
  for (int tick = 1; tick <= 40; ++tick) {
    auto in = healthy();
    in.driven = driven;
    in.command_V = tick % 4 < 2 ? 5.0F : 5.0F + stroke_V;
    in.pressure_V += tick % 8 == 0 ? noise_V : 0.0F;
    if (holds(monitor.step(settings, in).causes, Fault::pressure_stuck)) return tick;
  }
  return 0;
}

// An eighth of 3 to 7 V is 0.5 V; the first of the eleven readings has none before it.
TEST(ChamberMonitor, RaisesAStuckSensorOnceTenReadingsEqualTheOneBeforeWhileTheValveMoves) {
  EXPECT_EQ(stuck_tick(0.6F, 0.0F), 11);
  EXPECT_EQ(stuck_tick(-2.0F, 0.0F), 11);
  EXPECT_EQ(stuck_tick(0.4F, 0.0F), 0) << "the valve hardly moves";
  EXPECT_EQ(stuck_tick(0.6F, 1e-4F), 0) << "the reading moves now and then";
  EXPECT_EQ(stuck_tick(0.6F, 0.0F, false), 0) << "nobody drives the valve";
  config::ChamberSettings settings;
  settings.stuck_ticks = 20;
  EXPECT_EQ(stuck_tick(0.6F, 0.0F, true, settings), 21);
  settings.stuck_ticks = 0;
  EXPECT_EQ(stuck_tick(0.6F, 0.0F, true, settings), 0) << "not watched";
}

TEST(ChamberMonitor, RaisesAStaleSensorInTheTickOfItsLimit) {
  config::ChamberSettings settings;
  settings.stale_limit_ticks = 4;
  auto in = healthy();
  in.pressure_fresh = false;
  EXPECT_EQ(chamber_tick(Fault::pressure_stale, in, settings), 4);
  in = healthy();
  in.position_fresh = false;
  EXPECT_EQ(chamber_tick(Fault::position_stale, in, settings), 4);
}

TEST(ChamberMonitor, CountsTheTicksThatWereLeftOutWhereTimeIsWhatCounts) {
  config::ChamberSettings settings;
  settings.stale_limit_ticks = 10;
  settings.over_pressure_ticks = 10;
  settings.residual_ticks = 10;
  auto in = healthy();
  in.ticks = 4;
  in.pressure_fresh = false;
  EXPECT_EQ(chamber_tick(Fault::pressure_stale, in, settings), 3) << "12 of 10 have passed";
  in = healthy();
  in.ticks = 4;
  in.position_fresh = false;
  EXPECT_EQ(chamber_tick(Fault::position_stale, in, settings), 3);
  in = healthy();
  in.ticks = 4;
  in.pressure_V =
      (settings.over_pressure_kPa + 1.0F - settings.pressure_offset_kPa) / settings.pressure_gain_kPa_per_V;
  EXPECT_EQ(chamber_tick(Fault::over_pressure, in, settings), 4)
      << "1, 5, 9, 13: the first says nothing of those before it";
  in = healthy();
  in.ticks = 4;
  in.residual_kPa = 2.0F * settings.residual_alarm_kPa;
  EXPECT_EQ(chamber_tick(Fault::model_residual, in, settings), 10) << "as often as it was seen";
}

TEST(ChamberMonitor, ForgivesGapsShorterThanTheStaleLimit) {
  const config::ChamberSettings settings;
  ASSERT_EQ(settings.stale_limit_ticks, 3);
  ChamberMonitor monitor;
  for (int tick = 0; tick < 99; ++tick) {
    auto in = healthy();
    in.pressure_fresh = tick % 3 == 0;
    const auto out = monitor.step(settings, in);
    EXPECT_EQ(out.causes, 0U) << "tick " << tick;
    EXPECT_EQ(out.pressure_usable, in.pressure_fresh);
  }
}

TEST(ChamberMonitor, RaisesANonFiniteReadingAtOnce) {
  for (const float bad : {kNaN, kInfinity, -kInfinity}) {
    auto in = healthy();
    in.pressure_V = bad;
    EXPECT_EQ(chamber_tick(Fault::pressure_not_finite, in), 1);
    EXPECT_FALSE(ChamberMonitor{}.step({}, in).pressure_usable);
    in = healthy();
    in.position_V = bad;
    EXPECT_EQ(chamber_tick(Fault::position_not_finite, in), 1);
    EXPECT_FALSE(ChamberMonitor{}.step({}, in).position_usable);
  }
}

TEST(ChamberMonitor, RaisesAWireBreakAtOnce) {
  auto in = healthy();
  in.pressure_V = 0.05F;
  EXPECT_EQ(chamber_tick(Fault::pressure_out_of_range, in), 1);
  in = healthy();
  in.position_V = 10.5F;
  EXPECT_EQ(chamber_tick(Fault::position_out_of_range, in), 1);
}

TEST(ChamberMonitor, APressureAtTheEndOfItsConverterMayBeAnyAboveAndCountsAsNone) {
  auto in = healthy();
  in.pressure_at_end = true;
  EXPECT_EQ(chamber_tick(Fault::pressure_out_of_range, in), 1);
  EXPECT_FALSE(ChamberMonitor{}.step({}, in).pressure_usable);
}

TEST(ChamberMonitor, RaisesOverPressureThatLastsAndHoldsItUntilThePressureIsAdmissibleAgain) {
  config::ChamberSettings settings;
  settings.over_pressure_ticks = 3;
  settings.pressure_high_kPa = 800.0F;
  settings.over_pressure_kPa = 900.0F;
  auto in = healthy();
  in.pressure_V = 9.1F;
  EXPECT_EQ(chamber_tick(Fault::over_pressure, in, settings), 3);

  ChamberMonitor monitor;
  for (int tick = 0; tick < 3; ++tick) monitor.step(settings, in);
  in.pressure_V = 8.5F;  // below the trip, above the highest reference
  EXPECT_TRUE(holds(monitor.step(settings, in).causes, Fault::over_pressure));
  in.pressure_fresh = false;
  in.pressure_V = 1.0F;
  EXPECT_TRUE(holds(monitor.step(settings, in).causes, Fault::over_pressure))
      << "an old value proves nothing";
  in.pressure_fresh = true;
  in.pressure_V = 7.9F;
  EXPECT_FALSE(holds(monitor.step(settings, in).causes, Fault::over_pressure));
  in.pressure_V = 8.5F;
  EXPECT_FALSE(holds(monitor.step(settings, in).causes, Fault::over_pressure)) << "not tripped again";
}

TEST(ChamberMonitor, RaisesALastingResidualOfEitherSignOrNotANumber) {
  config::ChamberSettings settings;
  settings.residual_ticks = 7;
  settings.residual_alarm_kPa = 20.0F;
  for (const float residual_kPa : {20.5F, -20.5F, kNaN}) {
    auto in = healthy();
    in.residual_kPa = residual_kPa;
    if (in.residual_kPa == numeric::Scalar(0)) continue;  // what a fixed-point core takes not-a-number for
    EXPECT_EQ(chamber_tick(Fault::model_residual, in, settings), 7) << residual_kPa << " kPa";
  }
  auto in = healthy();
  in.residual_kPa = 19.5F;
  EXPECT_EQ(chamber_tick(Fault::model_residual, in, settings), 0);
  settings.residual_ticks = 0;
  in.residual_kPa = 500.0F;
  EXPECT_EQ(chamber_tick(Fault::model_residual, in, settings), 0) << "switched off";
}

TEST(ChamberMonitor, WarnsOfADriftThatIsLargeBesideTheFitUntilItIsSmall) {
  config::ChamberSettings settings;
  settings.drift_alarm_ratio = 3.0F;
  auto in = healthy();
  in.drift_limit_kPa = drift_limit_kPa(settings, 2.0F);
  ChamberMonitor monitor;
  const auto told = [&](float drift_kPa) {
    in.drift_kPa = drift_kPa;
    return holds(monitor.step(settings, in).causes, Fault::model_drift);
  };
  EXPECT_FALSE(told(5.9F));
  EXPECT_TRUE(told(6.1F));
  EXPECT_TRUE(told(4.3F));
  EXPECT_FALSE(told(4.1F));
  EXPECT_FALSE(told(5.9F));
  in.drift_limit_kPa = drift_limit_kPa(settings, 0.0F);
  EXPECT_FALSE(told(100.0F)) << "nobody has said what is usual";
  in.drift_limit_kPa = drift_limit_kPa(settings, 0.001F);
  EXPECT_FALSE(told(0.59F)) << "no model is taken to fit better than 0.2 kPa";
  EXPECT_TRUE(told(0.61F));
  settings.drift_alarm_ratio = 0.0F;
  in.drift_limit_kPa = drift_limit_kPa(settings, 2.0F);
  EXPECT_FALSE(told(100.0F)) << "switched off";
}

/// Regulated to 400 kPa plus what is asked for; healthy() has the pressure at 400 kPa.
ChamberMonitor::Input asked_to_be_off_by(float deviation_kPa) {
  auto in = healthy();
  in.regulated = true;
  in.reference_kPa = numeric::Scalar(400.0F + deviation_kPa);
  return in;
}

config::ChamberSettings watching() {
  config::ChamberSettings settings;
  settings.deviation_watched = true;
  settings.deviation_low_kPa = -10.0F;
  settings.deviation_high_kPa = 20.0F;
  settings.deviation_delay_ms = 70;
  settings.target_watched = true;
  settings.target_low_kPa = -1.0F;
  settings.target_high_kPa = 2.0F;
  settings.target_time_ms = 40;
  return settings;
}

TEST(ChamberMonitor, WarnsOfAControlDeviationOutsideItsBandForTheDelay) {
  const auto raised = [](float deviation_kPa, const config::ChamberSettings& settings) {
    return chamber_tick(Fault::control_deviation, asked_to_be_off_by(deviation_kPa), settings);
  };
  config::ChamberSettings settings = watching();
  EXPECT_EQ(raised(20.5F, settings), 7) << "70 ms";
  EXPECT_EQ(raised(-10.5F, settings), 7);
  EXPECT_EQ(raised(19.5F, settings), 0);
  EXPECT_EQ(raised(-9.5F, settings), 0);
  settings.deviation_delay_ms = 71;
  EXPECT_EQ(raised(20.5F, settings), 8) << "a tick that has begun";
  settings.deviation_delay_ms = 0;
  EXPECT_EQ(raised(20.5F, settings), 1);
  settings.deviation_watched = false;
  EXPECT_EQ(raised(500.0F, settings), 0) << "switched off";
}

TEST(ChamberMonitor, TakesADeviationBackAsSoonAsItIsWithinItsBandOrNobodyRegulates) {
  const config::ChamberSettings settings = watching();
  ChamberMonitor monitor;
  const auto deviates = [&](const ChamberMonitor::Input& in) {
    return holds(monitor.step(settings, in).causes, Fault::control_deviation);
  };
  for (int tick = 1; tick <= 9; ++tick) EXPECT_EQ(deviates(asked_to_be_off_by(30.0F)), tick >= 7);
  EXPECT_FALSE(deviates(asked_to_be_off_by(0.0F)));
  for (int tick = 1; tick <= 9; ++tick) deviates(asked_to_be_off_by(30.0F));
  auto in = asked_to_be_off_by(30.0F);
  in.regulated = false;
  EXPECT_FALSE(deviates(in));
  in.regulated = true;
  for (int tick = 1; tick <= 9; ++tick) EXPECT_EQ(deviates(in), tick >= 7) << "anew";
}

TEST(ChamberMonitor, CountsTheTicksThatALateBoardHasLeftOutOfADeviation) {
  const config::ChamberSettings settings = watching();
  ChamberMonitor monitor;
  auto in = asked_to_be_off_by(30.0F);
  EXPECT_EQ(monitor.step(settings, in).causes, 0U);
  in.ticks = 6;
  EXPECT_TRUE(holds(monitor.step(settings, in).causes, Fault::control_deviation));
}

TEST(ChamberMonitor, JudgesNoDeviationByAPressureThatDidNotCome) {
  const config::ChamberSettings settings = watching();
  ChamberMonitor monitor;
  auto silent = asked_to_be_off_by(30.0F);
  silent.pressure_fresh = false;
  for (int tick = 1; tick <= 5; ++tick) monitor.step(settings, asked_to_be_off_by(30.0F));
  for (int tick = 1; tick <= 5; ++tick)
    EXPECT_FALSE(holds(monitor.step(settings, silent).causes, Fault::control_deviation));
  for (int tick = 1; tick <= 2; ++tick)
    EXPECT_EQ(holds(monitor.step(settings, asked_to_be_off_by(30.0F)).causes, Fault::control_deviation),
              tick == 2);
}

TEST(ChamberMonitor, IsOnTargetWithinItsWindowForItsTime) {
  const auto first_on_target = [](float deviation_kPa, const config::ChamberSettings& settings) {
    ChamberMonitor monitor;
    for (int tick = 1; tick <= 20; ++tick)
      if (monitor.step(settings, asked_to_be_off_by(deviation_kPa)).on_target) return tick;
    return 0;
  };
  config::ChamberSettings settings = watching();
  EXPECT_EQ(first_on_target(0.0F, settings), 4) << "40 ms";
  EXPECT_EQ(first_on_target(1.9F, settings), 4);
  EXPECT_EQ(first_on_target(2.1F, settings), 0);
  EXPECT_EQ(first_on_target(-1.1F, settings), 0);
  settings.target_watched = false;
  EXPECT_EQ(first_on_target(0.0F, settings), 0) << "switched off";

  settings = watching();
  ChamberMonitor monitor;
  for (int tick = 1; tick <= 6; ++tick) monitor.step(settings, asked_to_be_off_by(0.0F));
  EXPECT_FALSE(monitor.step(settings, asked_to_be_off_by(5.0F)).on_target);
  for (int tick = 1; tick <= 6; ++tick)
    EXPECT_EQ(monitor.step(settings, asked_to_be_off_by(0.0F)).on_target, tick >= 4) << "anew";
  auto at_rest = asked_to_be_off_by(0.0F);
  at_rest.regulated = false;
  EXPECT_FALSE(monitor.step(settings, at_rest).on_target);
}

TEST(ChamberMonitor, RaisesAMissingModelOnlyWhenRegulationIsAsked) {
  auto in = healthy();
  in.model_ready = false;
  EXPECT_EQ(chamber_tick(Fault::no_model, in), 1);
  in.regulation_asked = false;
  EXPECT_EQ(chamber_tick(Fault::no_model, in), 0);
}

TEST(ChamberMonitor, RaisesNothingOfAChamberThatIsNotInUse) {
  config::ChamberSettings settings;
  settings.in_use = false;
  ChamberMonitor monitor;
  ChamberMonitor::Input dead;
  dead.pressure_V = kNaN;
  dead.regulation_asked = true;
  for (int tick = 0; tick < 100; ++tick) EXPECT_EQ(monitor.step(settings, dead).causes, 0U);
}

int board_tick(Fault fault, const BoardMonitor::Input& input, const config::BoardSettings& settings = {}) {
  return first_tick_with<BoardMonitor>(fault, settings, input);
}

TEST(BoardMonitor, PassesLinesAndBusStatesOnAtOnce) {
  BoardMonitor::Input in;
  EXPECT_EQ(BoardMonitor{}.step({}, in), 0U);
  in.emergency_stop = true;
  in.outputs_ok = false;
  in.bus_off = true;
  in.error_passive = true;
  in.frames_lost = true;
  in.heartbeat_lost = true;
  in.setpoint_lost = true;
  in.pdo_short = true;
  in.pdo_long = true;
  in.sync_misfits = true;
  in.configuration_refused = true;
  EXPECT_EQ(BoardMonitor{}.step({}, in),
            only(Fault::configuration_refused) | only(Fault::emergency_stop) | only(Fault::hardware) |
                only(Fault::bus_off) | only(Fault::can_passive) | only(Fault::can_overrun) |
                only(Fault::heartbeat_lost) | only(Fault::setpoint_timeout) | only(Fault::pdo_short) |
                only(Fault::pdo_long) | only(Fault::sync_refused));
}

TEST(BoardMonitor, RaisesLateTicksOnEndInTheTickOfTheirLimit) {
  config::BoardSettings settings;
  settings.overrun_limit_ticks = 5;
  BoardMonitor::Input in;
  in.tick_late = true;
  EXPECT_EQ(board_tick(Fault::tick_overrun, in, settings), 5);
}

TEST(BoardMonitor, CountsTheTicksThatWereLeftOutWhereTimeIsWhatCounts) {
  config::BoardSettings settings;
  settings.supply_low_kPa = 500.0F;
  settings.supply_ticks = 10;
  settings.setpoint_watchdog_ticks = 10;
  settings.overrun_limit_ticks = 10;
  const BoardMonitor::Input in{.ticks = 4, .tick_late = true, .supply_V = 4.9F, .setpoints_needed = true};
  EXPECT_EQ(board_tick(Fault::setpoint_timeout, in, settings), 3) << "12 of 10 have passed";
  EXPECT_EQ(board_tick(Fault::supply_low, in, settings), 4)
      << "13: the first says nothing of those before it";
  EXPECT_EQ(board_tick(Fault::tick_overrun, in, settings), 10) << "as often as it was late";
}

TEST(BoardMonitor, RaisesALowOrUnreadableSupplyThatLasts) {
  config::BoardSettings settings;
  settings.supply_low_kPa = 500.0F;
  settings.supply_ticks = 6;
  BoardMonitor::Input in;
  for (const float supply_V : {4.9F, kNaN}) {
    in.supply_V = supply_V;
    EXPECT_EQ(board_tick(Fault::supply_low, in, settings), 6) << supply_V << " V";
  }
  in.supply_V = 5.1F;
  EXPECT_EQ(board_tick(Fault::supply_low, in, settings), 0);
  settings.supply_low_kPa = 0.0F;
  in.supply_V = kNaN;
  EXPECT_EQ(board_tick(Fault::supply_low, in, settings), 0) << "not watched";
}

TEST(SetpointNews, AreOfNowWithinTheWatchdogsTicksAndThroughoutAnActiveInWhichTheyCame) {
  SetpointNews news;
  news.step(false, false, 10, 1);
  EXPECT_FALSE(news.is_of_now()) << "none has ever come";
  for (int tick = 0; tick < 25; ++tick) {
    news.step(tick == 0, false, 10, 1);
    EXPECT_EQ(news.is_of_now(), tick < 10) << "tick " << tick << " after it, not ACTIVE";
  }
  for (int tick = 0; tick < 25; ++tick) {
    news.step(false, true, 10, 1);
    EXPECT_FALSE(news.is_of_now()) << "ACTIVE makes nothing new";
  }
  for (int tick = 0; tick < 25; ++tick) {
    news.step(tick == 0, true, 10, 1);
    EXPECT_TRUE(news.is_of_now()) << "tick " << tick << " after it, ACTIVE";
  }
  news.step(false, false, 10, 1);
  EXPECT_FALSE(news.is_of_now()) << "of an ACTIVE that is over";
  news.step(true, false, 10, 1);
  news.step(false, false, 10, 9);
  EXPECT_TRUE(news.is_of_now());
  news.step(true, false, 10, 1);
  news.step(false, false, 10, 10);
  EXPECT_FALSE(news.is_of_now()) << "with the ticks that were left out";
  SetpointNews unwatched;
  unwatched.step(false, false, 0, 1);
  EXPECT_TRUE(unwatched.is_of_now()) << "nobody watches";
}

TEST(BoardMonitor, RaisesASetpointTimeoutInTheTickOfItsLimitAndOnlyWhenNeeded) {
  config::BoardSettings settings;
  settings.setpoint_watchdog_ticks = 10;
  BoardMonitor::Input in;
  in.setpoints_needed = true;
  EXPECT_EQ(board_tick(Fault::setpoint_timeout, in, settings), 10);
  in.setpoints_needed = false;
  EXPECT_EQ(board_tick(Fault::setpoint_timeout, in, settings), 0);
  in.setpoints_needed = true;
  settings.setpoint_watchdog_ticks = 0;
  EXPECT_EQ(board_tick(Fault::setpoint_timeout, in, settings), 0) << "switched off";
}

TEST(BoardMonitor, IsFedBySetpointsEvenWhenTheirCounterWrapsRound) {
  config::BoardSettings settings;
  settings.setpoint_watchdog_ticks = 3;
  BoardMonitor monitor;
  BoardMonitor::Input in;
  in.setpoints_needed = true;
  in.setpoint_count = 0xFFFFFFF0U;
  for (int tick = 0; tick < 60; ++tick) {
    if (tick % 2 == 0) ++in.setpoint_count;
    EXPECT_EQ(monitor.step(settings, in), 0U) << "tick " << tick;
  }
}

}  // namespace
}  // namespace plenum::safety
