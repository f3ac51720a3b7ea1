// Readings that do not come for a few ticks, too few for a fault: what carries a board over them.
#include <gtest/gtest.h>

#include "firmware/config/chamber_settings.hpp"
#include "tests/firmware/board/bench.hpp"

namespace plenum {
namespace {

using safety::State;
namespace object = canopen::object;

TEST(SilentSensor, ExcitationWithoutAFreshPressureShutsTheValveForThatTick) {
  Bench bench;
  bench.board.start();
  bench.session.write(object::kControlMode, 0, std::int8_t{-1});
  bench.put(0, {1, 0});
  bench.climb();
  for (int round = 0; round < 50; ++round) {
    bench.run(7);
    const float last_V = bench.analog_in.reading[0].mean_V;
    force(bench, 0, last_V, false);
    bench.tick();
    free_inputs(bench);
    EXPECT_EQ(bench.analog_out.held_V[0], 5.0F) << "V, chamber 1, which was not seen, round " << round;
    ASSERT_EQ(bench.state(), State::active);
  }
}

TEST(SilentSensor, APressureMissedForATickIsBridgedByTheModel) {
  Bench bench;
  bench.go_active(200.0);
  for (int t = 0; t < 40; ++t) {
    bench.setpoint_kPa += 3.0;
    if (t >= 20 && t < 22) force(bench, 0, bench.analog_in.reading[0].mean_V, false);
    bench.tick();
    free_inputs(bench);
    EXPECT_NEAR(bench.chamber[0].pressure_kPa, bench.chamber[1].pressure_kPa, 0.1)
        << "kPa, chamber 1 against chamber 2, which missed nothing, tick " << t;
    EXPECT_NEAR(bench.image().chamber[0].residual_Pa, bench.image().chamber[1].residual_Pa, 100.0F)
        << "Pa, tick " << t;
  }
}

/// Chambers 1 and 2 grow alike; of the first the position is missed for some ticks, and comes back.
void expect_bridged(int missed_ticks, double command_within_V) {
  Settings settings = bench_settings();
  for (config::ChamberSettings& chamber : settings.chamber) chamber.stale_limit_ticks = 0;
  Bench bench(settings);
  bench.go_active(300.0);
  for (int t = 0; t < 60; ++t) {
    for (Chamber& chamber : bench.chamber) chamber.volume_mL += 1.0;
    if (t >= 30 && t < 30 + missed_ticks) force(bench, kChambers, 0.0F, false);
    bench.tick();
    free_inputs(bench);
    EXPECT_NEAR(bench.image().chamber[0].command_V, bench.image().chamber[1].command_V, command_within_V)
        << "V, tick " << t << ", " << missed_ticks << " missed";
    if (t >= 30 && t < 30 + missed_ticks) continue;
    EXPECT_NEAR(1e6F * bench.image().chamber[0].volume_m3, 1e6F * bench.image().chamber[1].volume_m3, 0.6F)
        << "mL, tick " << t << ", " << missed_ticks << " missed: half a tick's motion, and no more";
  }
}

TEST(SilentSensor, APositionMissedForAFewTicksIsBridgedByItsMotion) {
  expect_bridged(0, 0.0);
  expect_bridged(1, 0.01);
  expect_bridged(4, 0.01);
}

TEST(SilentSensor, APositionMissedForLongIsAtRestAndKicksNothingAsItComesBack) {
  expect_bridged(12, 0.12);  // 0.1 V is what a motion that is not known takes
}

TEST(SilentSensor, AVolumeThatIsNotSeenGoesNoFurtherThanItsSensor) {
  Bench bench;
  bench.go_active(300.0);
  const float least_mL =
      config::volume_mL(bench_settings().chamber[0], bench_settings().chamber[0].position_valid_low_V);
  bench.chamber[0].volume_mL = 60.0;
  bench.run(100);
  for (int t = 0; t < 9; ++t) {
    bench.chamber[0].volume_mL -= 4.0;
    bench.tick();
  }
  for (int t = 0; t < 2; ++t) {
    force(bench, kChambers, 0.0F, false);
    bench.tick();
    EXPECT_GE(1e6F * bench.image().chamber[0].volume_m3, least_mL - 1e-3F) << "mL, tick " << t;
  }
}

}  // namespace
}  // namespace plenum
