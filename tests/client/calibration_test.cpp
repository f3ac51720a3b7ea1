// The correction of a pressure sensor's calibration, against the sensor's own equation.
#include "host-sim/client/calibration.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <rapidcheck/gtest.h>

#include "tests/client/board_on_bus.hpp"

namespace plenum::host::client {
namespace {

constexpr std::uint8_t kChamber = 2;

RC_GTEST_PROP(Calibration, CorrectedASensorReadsThePressureThatIsThere, ()) {
  const auto between = [](double low, double high) {
    return low + (high - low) * 1e-6 * *rc::gen::inRange(0, 1'000'001);
  };
  const PressureCalibration now{.gain_kPa_per_V = between(10, 500), .offset_kPa = between(-200, 200)};
  const SensorError error{
      .offset_kPa = between(-100, 100), .gain_error = between(-0.3, 0.3), .ambient_kPa = between(80, 110)};
  const double true_kPa = between(0, 1000);
  const double shown_kPa = true_kPa + error.offset_kPa + error.gain_error * (true_kPa - error.ambient_kPa);
  const double sensor_V = (shown_kPa - now.offset_kPa) / now.gain_kPa_per_V;
  const PressureCalibration then = corrected(now, error);
  RC_ASSERT(std::fabs(then.offset_kPa + then.gain_kPa_per_V * sensor_V - true_kPa) < 1e-9);
}

TEST(Calibration, IsThatOfTheOneChamber) {
  BoardOnBus world;
  Session session(world, 5);
  world.run_ticks(2);
  const PressureCalibration took = write_calibration(session, kChamber, {101.5, -4.25});
  EXPECT_EQ(took.gain_kPa_per_V, 101.5);
  EXPECT_EQ(took.offset_kPa, -4.25);
  EXPECT_EQ(world.settings.chamber(kChamber).pressure_gain_kPa_per_V, 101.5F);
  EXPECT_EQ(world.settings.chamber(kChamber).pressure_offset_kPa, -4.25F);
  EXPECT_EQ(world.settings.chamber(kChamber + 1).pressure_gain_kPa_per_V, 100.0F);
}

TEST(Calibration, StaysAsItIsWhileTheBoardRegulates) {
  BoardOnBus world;
  Session session(world, 5);
  session.enable();
  EXPECT_THROW(write_calibration(session, kChamber, {101.5, -4.25}), Refused);
  session.disable();
  EXPECT_EQ(read_calibration(session, kChamber).gain_kPa_per_V, 100.0);
}

TEST(Calibration, IsWholeOrAsItWas) {
  BoardOnBus world;
  Session session(world, 5);
  world.run_ticks(2);
  EXPECT_THROW(write_calibration(session, kChamber, {101.5, -2001.0}), SdoAbort) << "beyond 2400h:2";
  try {
    write_calibration(session, kChamber, {101.5, -400.0});
    FAIL() << "the sensor would end below the over-pressure";
  } catch (const Refused& refused) {
    EXPECT_THAT(refused.what(), ::testing::HasSubstr("chamber 3: over_pressure_kPa = 900, expected 800 to"));
  }
  EXPECT_EQ(read_calibration(session, kChamber).gain_kPa_per_V, 100.0);
  EXPECT_EQ(read_calibration(session, kChamber).offset_kPa, 0.0);
}

}  // namespace
}  // namespace plenum::host::client
