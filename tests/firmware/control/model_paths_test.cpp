// What the regulator takes of a model for valve and sensor.
#include "firmware/control/model_paths.hpp"

#include <gtest/gtest.h>

#include "tests/firmware/scalars.hpp"

namespace plenum::control {
namespace {

constexpr Scalar kOwn_ticks = Scalar(0.3F);

config::ModelParameters nine_parameters(config::ModelKind kind, float dead_time_s) {
  config::ModelParameters model;
  model.kind = kind;
  model.count = static_cast<std::uint16_t>(config::required_count(kind));
  model.value[model.count++] = dead_time_s;
  return model;
}

config::ModelParameters grey_box() {
  config::ModelParameters model;
  model.kind = config::ModelKind::greybox;
  model.count = config::kGreyboxParameters;
  return model;
}

TEST(ModelPaths, ANineParameterModelStatesItsDeadTime) {
  for (const config::ModelKind kind : {config::ModelKind::tassa9, config::ModelKind::tassa9r}) {
    const ModelPaths paths = paths_of(nine_parameters(kind, 0.025F), kOwn_ticks);
    EXPECT_NEAR(real(paths.valve.dead_ticks), 2.5, 2e-3);
    EXPECT_EQ(paths.valve.lag_ticks, Scalar(0));
    EXPECT_EQ(paths.valve.play_V, Scalar(0));
    EXPECT_EQ(paths.sensor_lag_ticks, Scalar(0));
  }
}

TEST(ModelPaths, OfAModelThatLeavesItsDeadTimeOutTheRegulatorsOwnStands) {
  config::ModelParameters model = nine_parameters(config::ModelKind::tassa9, 0.025F);
  --model.count;
  EXPECT_EQ(paths_of(model, kOwn_ticks).valve.dead_ticks, kOwn_ticks);
  model = nine_parameters(config::ModelKind::tassa9, 0.0F);
  EXPECT_EQ(paths_of(model, kOwn_ticks).valve.dead_ticks, Scalar(0)) << "it states a prompt valve";
}

// A double pole at w = 2 pi f is two lags of 1/w, 1/(pi f) in all: half of it a lag, half a delay.
TEST(ModelPaths, ASpoolOfAGreyBoxIsHalfALagAndHalfADelay) {
  config::ModelParameters model = grey_box();
  model.value[config::kDeadTime] = 0.01F;
  model.value[config::kSpoolPeriod] = 0.1F;
  model.value[config::kSpoolDamping] = 1.0F;
  model.value[config::kHysteresis] = 0.2F;
  model.value[config::kSensorLag] = 0.03F;
  const ModelPaths paths = paths_of(model, kOwn_ticks);
  const double late_ticks = 10.0 / 3.14159265;
  EXPECT_NEAR(real(paths.valve.lag_ticks), late_ticks / 2, 5e-3);
  EXPECT_NEAR(real(paths.valve.dead_ticks), 1.0 + late_ticks / 2, 5e-3);
  EXPECT_NEAR(real(paths.valve.play_V), 0.2, 1e-4);
  EXPECT_NEAR(real(paths.sensor_lag_ticks), 3.0, 5e-3);
}

TEST(ModelPaths, AGreyBoxStatesItsSuppliesLineOrLeavesItOut) {
  config::ModelParameters model = grey_box();
  model.value[config::kSupply] = 620.0F;
  model.value[config::kSupplyResistance] = 0.5F;
  model.value[config::kSupplyRecovery] = 0.2F;
  model.value[config::kSupplyFollowed] = 0.9F;
  const SupplyLine::Config line = paths_of(model, kOwn_ticks).supply;
  EXPECT_NEAR(real(line.supply_kPa), 620.0, 1e-3);
  EXPECT_NEAR(real(line.resistance_s_L), 0.5, 1e-6);
  EXPECT_NEAR(real(line.recovery_ticks), 20.0, 1e-3);
  EXPECT_NEAR(real(line.followed_share), 0.9, 1e-6);
  EXPECT_EQ(paths_of(nine_parameters(config::ModelKind::tassa9, 0.0F), kOwn_ticks).supply.resistance_s_L,
            Scalar(0));
}

}  // namespace
}  // namespace plenum::control
