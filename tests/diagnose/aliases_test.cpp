// What an excitation cannot tell apart.
#include "host-sim/diagnose/aliases.hpp"

#include <gmock/gmock.h>

#include "tests/identify/chamber/chamber_scene.hpp"

namespace plenum::host::diagnose {
namespace {

using identify::chamber::chamber_scene;
using identify::chamber::jumping_V;

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::Not;

std::vector<std::vector<std::string>> classes_of(double swing_m3) {
  Scene scene = chamber_scene(jumping_V(2000), swing_m3);
  scene.most_early_s = 1e-3;  // as a diagnosis has it: a variable more, of the log
  return alias_classes(scene, scene.nominal, {{.pressure_Pa = 3e5}});
}

// v enters (4) only as a_c/v and a_r/v while it rests: a volume error is a change of both gains and leaks.
TEST(AliasClasses, AtFixedVolumeAVolumeErrorIsCalibration) {
  const auto classes = classes_of(0.0);
  ASSERT_FALSE(classes.empty());
  EXPECT_EQ(classes.front().front(), "calibration");
  EXPECT_THAT(classes.front(), Contains("volume_error"));
}

// p'(t) is the valve's alone while the volume rests: a sensor that lags by tau and a command that is late by tau both read
// p - tau p'.
TEST(AliasClasses, AtFixedVolumeASmallDelayIsASmallSensorLag) {
  EXPECT_THAT(classes_of(0.0), Contains(AllOf(Contains("dead_time"), Contains("sensor_lag"))));
}

TEST(AliasClasses, AMovingVolumePartsBoth) {
  const auto classes = classes_of(45e-6);
  EXPECT_THAT(classes, Each(Not(AllOf(Contains("volume_error"), Contains("calibration")))));
  EXPECT_THAT(classes, Each(Not(AllOf(Contains("dead_time"), Contains("sensor_lag")))));
}

// The air of a short hose is added to the chamber's.
TEST(AliasClasses, AShortHoseIsADeadVolume) {
  EXPECT_THAT(classes_of(45e-6), Contains(AllOf(Contains("tube_dynamics"), Contains("volume_error"))));
}

TEST(AliasClasses, DoNotDependOnWhatWasMeasured) {
  Scene scene = chamber_scene(jumping_V(1000), 0.0);
  const auto classes = alias_classes(scene, scene.nominal, {{.pressure_Pa = 3e5}});
  for (double& p : scene.records[0].measured_Pa) p = 1e5;
  EXPECT_EQ(alias_classes(scene, scene.nominal, {{.pressure_Pa = 3e5}}), classes);
}

}  // namespace
}  // namespace plenum::host::diagnose
