// Gauge pressure that no range shows, and effects that must not be taken for it.
#include "host-sim/diagnose/reference_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "host-sim/trace/input_error.hpp"
#include "tests/identify/chamber/chamber_scene.hpp"

namespace plenum::host::diagnose {
namespace {

using identify::chamber::chamber_scene;
using identify::chamber::Fit;
using identify::chamber::jumping_V;
using identify::chamber::Record;
using identify::chamber::Scene;
using testing::HasSubstr;

std::string refusal(const Scene& scene, effects::EffectSet on = 0) {
  try {
    require_absolute_pressures(scene, fit(scene, on, scene.nominal, {}), 1);
  } catch (const trace::InputError& error) {
    return error.what();
  }
  return {};
}

bool far_beyond_noise(const Scene& scene) {
  return fit(scene, 0, scene.nominal, {}).rms_Pa() > 5.0 * scene.noise_Pa;
}

double ambient_Pa(const Scene& scene) {
  return scene.around.ambient_Pa;
}

/// Commands that fill a little and empty more for a quarter of a second each: the pressure stays between ambient and supply.
std::vector<double> about_the_middle_V(std::size_t rows) {
  std::vector<double> command_V = jumping_V(rows);
  for (std::size_t row = 0; row < rows; ++row) {
    const double opening_V = 0.1 + 0.15 * std::abs(command_V[row] - 4.9);
    command_V[row] = row / 25 % 2 == 0 ? 5.0 + opening_V : 5.0 - 1.6 * opening_V;
  }
  return command_V;
}

Scene recorded(const std::vector<double>& command_V) {
  Scene scene = chamber_scene(command_V, 30e-6);
  scene.noise_Pa = 20.0;
  return scene;
}

Scene recorded() {
  return recorded(about_the_middle_V(2000));
}

TEST(AbsolutePressures, AreTakenAsTheyAre) {
  const Scene scene = recorded();
  const auto [least, most] = std::ranges::minmax(scene.records[0].measured_Pa);
  ASSERT_GT(least, 1.5 * ambient_Pa(scene)) << "else the range tells";
  ASSERT_LT(most, scene.around.supply_Pa - ambient_Pa(scene)) << "else the range tells";
  EXPECT_EQ(refusal(scene), "");
}

TEST(AbsolutePressures, ALogInGaugePressureIsRefused) {
  Scene scene = recorded();
  for (double& p : scene.records[0].measured_Pa) p -= ambient_Pa(scene);
  ASSERT_TRUE(far_beyond_noise(scene)) << "else nothing was asked";
  EXPECT_THAT(refusal(scene), HasSubstr("chamber: column pressure_Pa seems to be gauge pressure"));
}

TEST(AbsolutePressures, ASupplyInGaugePressureIsRefused) {
  Scene scene = recorded(jumping_V(2000));
  scene.around.supply_Pa -= ambient_Pa(scene);
  ASSERT_TRUE(far_beyond_noise(scene)) << "else nothing was asked";
  EXPECT_THAT(refusal(scene), HasSubstr("the rig's supply.pressure_Pa seems to be gauge pressure"));
}

TEST(AbsolutePressures, BothInGaugePressureAreRefused) {
  Scene scene = recorded();
  scene.around.supply_Pa -= ambient_Pa(scene);
  for (double& p : scene.records[0].measured_Pa) p -= ambient_Pa(scene);
  ASSERT_TRUE(far_beyond_noise(scene)) << "else nothing was asked";
  EXPECT_THAT(refusal(scene), HasSubstr("seem"));
}

TEST(AbsolutePressures, ALogInGaugePressureOfASlowSpoolIsRefusedBesideIt) {
  constexpr effects::EffectSet kSpool = effects::EffectSet{1} << effects::kIdSpoolLag;
  Scene scene = recorded();
  effects::Figures figures = scene.nominal;
  figures[effects::kFirstFigure[effects::kIdSpoolLag]] = 0.1;
  scene.records[0].measured_Pa = run(scene, scene.records[0], kSpool, figures, {3e5});
  EXPECT_EQ(refusal(scene, kSpool), "");
  for (double& p : scene.records[0].measured_Pa) p -= ambient_Pa(scene);
  for (const effects::EffectSet on : {effects::EffectSet{0}, kSpool}) {
    EXPECT_THAT(refusal(scene, on), HasSubstr("chamber: column pressure_Pa seems to be gauge pressure"))
        << "not the supply, too";
  }
}

TEST(AbsolutePressures, ASensorThatReadsLessByNearlyAmbientIsRefused) {
  const Scene scene = recorded();
  const auto answer = [&](double offset_kPa, effects::EffectSet on) -> std::string {
    Fit found;
    found.on = on;
    found.figures = scene.nominal;
    found.figures[effects::kFirstFigure[effects::kIdSensorBias]] = offset_kPa;
    try {
      require_no_offset_of_ambient(scene, found);
    } catch (const trace::InputError& error) {
      return error.what();
    }
    return {};
  };
  constexpr effects::EffectSet kBias = effects::EffectSet{1} << effects::kIdSensorBias;
  EXPECT_THAT(
      answer(-100.0, kBias),
      HasSubstr("chamber: column pressure_Pa seems to be gauge pressure: the sensor would read 100 kPa"));
  EXPECT_EQ(answer(-100.0, 0), "") << "not named";
  EXPECT_EQ(answer(-50.0, kBias), "");
  EXPECT_EQ(answer(100.0, kBias), "");
}

TEST(AbsolutePressures, ALogThatWouldComeAboveTheSupplyIsNotBlamed) {
  Scene scene = recorded(jumping_V(2000));
  ASSERT_GT(std::ranges::max(scene.records[0].measured_Pa), scene.around.supply_Pa - 0.5 * ambient_Pa(scene));
  for (double& p : scene.records[0].measured_Pa) p -= 0.3 * ambient_Pa(scene);
  ASSERT_TRUE(far_beyond_noise(scene)) << "else nothing was asked";
  EXPECT_EQ(refusal(scene), "");
}

TEST(AbsolutePressures, AreTakenFromASensorThatReadsWrongAndASupplyThatDroops) {
  struct Effect {
    effects::Id id;
    std::size_t parameter;
    double value;
  };
  for (const std::vector<double>& command_V : {jumping_V(2000), about_the_middle_V(2000)}) {
    for (const Effect& effect :
         {Effect{effects::kIdSensorBias, 0, -20.0}, Effect{effects::kIdSensorBias, 0, 20.0},
          Effect{effects::kIdSensorBias, 1, 0.05}, Effect{effects::kIdSensorBias, 1, -0.05},
          Effect{effects::kIdSupplyDroop, 0, 5.0}, Effect{effects::kIdSensorLag, 0, 0.05},
          Effect{effects::kIdDeadTime, 0, 0.03}, Effect{effects::kIdValveHysteresis, 0, 0.3}}) {
      Scene scene = recorded(command_V);
      effects::Figures figures = scene.nominal;
      figures[effects::kFirstFigure[effect.id] + effect.parameter] = effect.value;
      scene.records[0].measured_Pa =
          run(scene, scene.records[0], effects::EffectSet{1} << effect.id, figures, {3e5});
      EXPECT_EQ(refusal(scene), "") << effects::kCatalogue[effect.id]->id << " " << effect.value;
    }
  }
}

}  // namespace
}  // namespace plenum::host::diagnose
