// A command column that is not what acted, and effects that must not be taken for one.
#include "host-sim/diagnose/command_check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "host-sim/trace/input_error.hpp"
#include "tests/identify/chamber/chamber_scene.hpp"

namespace plenum::host::diagnose {
namespace {

using identify::chamber::chamber_scene;
using identify::chamber::jumping_V;
using identify::chamber::Scene;
using testing::HasSubstr;

std::string refusal(const Scene& scene) {
  try {
    require_acting_command(scene, fit(scene, 0, scene.nominal, {}), 1);
  } catch (const trace::InputError& error) {
    return error.what();
  }
  return {};
}

/// A chamber of 2000 rows whose readings its own commands have made.
Scene recorded() {
  Scene scene = chamber_scene(jumping_V(2000), 30e-6);
  scene.noise_Pa = 50.0;
  return scene;
}

TEST(ActingCommand, IsTakenAsItIsLogged) {
  EXPECT_EQ(refusal(recorded()), "");
}

TEST(ActingCommand, OfAnotherSignIsRefused) {
  Scene scene = recorded();
  for (double& u : scene.records[0].drive.command_V) u = 10.0 - u;
  EXPECT_THAT(refusal(scene), HasSubstr("chamber: column command_V seems to have the other sign"));
}

TEST(ActingCommand, WrittenARowOrTwoLateIsRefused) {
  for (const std::size_t late : {1U, 2U}) {
    Scene scene = recorded();
    std::vector<double>& command_V = scene.records[0].drive.command_V;
    command_V.insert(command_V.begin(), late, command_V.front());
    command_V.resize(command_V.size() - late);
    EXPECT_THAT(refusal(scene), HasSubstr(late == 1 ? "to be one row late" : "to be 2 rows late"));
  }
}

TEST(ActingCommand, BesideAPressureWrittenEarlyIsNotBlamedButThePressureIs) {
  for (const std::size_t early : {1U, 2U}) {
    Scene scene = recorded();
    std::vector<double>& measured_Pa = scene.records[0].measured_Pa;
    measured_Pa.erase(measured_Pa.begin(), measured_Pa.begin() + static_cast<std::ptrdiff_t>(early));
    measured_Pa.resize(scene.records[0].drive.command_V.size(), measured_Pa.back());
    EXPECT_THAT(refusal(scene),
                HasSubstr(early == 1 ? "column pressure_Pa seems to be one row early: one row later"
                                     : "to be 2 rows early"));
  }
}

TEST(ActingCommand, BesideAVolumeWrittenEarlyIsNotBlamedButTheVolumeIs) {
  for (const int halves : {1, 2, 4}) {
    Scene scene = recorded();
    effects::Drive& drive = scene.records[0].drive;
    const auto steps = static_cast<std::ptrdiff_t>(halves * drive.timing.steps / 2);
    const std::size_t all = drive.volume_m3.size();
    drive.volume_m3.erase(drive.volume_m3.begin(), drive.volume_m3.begin() + steps);
    drive.volume_m3.resize(all, drive.volume_m3.back());
    EXPECT_THAT(refusal(scene),
                HasSubstr(halves == 1   ? "column volume_m3 seems to be half a row early: half a row later"
                          : halves == 2 ? "to be one row early"
                                        : "to be 2 rows early"));
  }
}

TEST(ActingCommand, IsNotBlamedForItsSignWhereALagWouldLookAlike) {
  std::vector<double> sine_V;
  for (int row = 0; row < 2000; ++row) {
    sine_V.push_back(5.0 + 0.6 * std::sin(2.0 * std::numbers::pi * 1.25 * 0.01 * row));
  }
  Scene scene = chamber_scene(sine_V, 30e-6);
  scene.noise_Pa = 50.0;
  std::vector<double>& command_V = scene.records[0].drive.command_V;
  std::rotate(command_V.begin(), command_V.end() - 30, command_V.end());
  EXPECT_EQ(refusal(scene), "")
      << "late by three eighths of a period, which its mirror image follows only roughly";
  EXPECT_GT(fit(scene, 0, scene.nominal, {}).rms_Pa(), 5.0 * scene.noise_Pa) << "else nothing was asked";
  std::rotate(command_V.begin(), command_V.end() - 10, command_V.end());
  EXPECT_THAT(refusal(scene), HasSubstr("the other sign, or to be late by half a period"));
}

TEST(ActingCommand, IsTakenFromAMachineThatIsLateSticksOrLags) {
  struct Effect {
    effects::Id id;
    double first;
  };
  for (const Effect& effect : {Effect{effects::kIdDeadTime, 0.03}, Effect{effects::kIdValveHysteresis, 0.3},
                               Effect{effects::kIdSpoolLag, 0.1}, Effect{effects::kIdSensorLag, 0.05},
                               Effect{effects::kIdSensorLag, 0.01}, Effect{effects::kIdTubeDynamics, 2.0},
                               Effect{effects::kIdNullDrift, 0.4}}) {
    Scene scene = recorded();
    effects::Figures figures = scene.nominal;
    figures[effects::kFirstFigure[effect.id]] = effect.first;
    scene.records[0].measured_Pa =
        run(scene, scene.records[0], effects::EffectSet{1} << effect.id, figures, {3e5});
    EXPECT_EQ(refusal(scene), "") << effects::kCatalogue[effect.id]->id;
    EXPECT_GT(fit(scene, 0, scene.nominal, {}).rms_Pa(), 5.0 * scene.noise_Pa) << "else nothing was asked";
  }
}

/// The valve is shut but for a little every other second.
TEST(ActingCommand, AndItsVolumeAreTakenWhereThePressureLagsAfterAVolumeThatMovesMuch) {
  std::vector<double> command_V;
  for (int row = 0; row < 2000; ++row)
    command_V.push_back(row % 200 < 10 ? 5.15 : row % 200 < 20 ? 4.85 : 5.0);
  for (const auto& [effect, first] :
       {std::pair{effects::kIdSensorLag, 0.01}, {effects::kIdTubeDynamics, 3.0}}) {
    Scene scene = chamber_scene(command_V, 60e-6);
    scene.noise_Pa = 50.0;
    effects::Figures figures = scene.nominal;
    figures[effects::kFirstFigure[effect]] = first;
    scene.records[0].measured_Pa =
        run(scene, scene.records[0], effects::EffectSet{1} << effect, figures, {3e5});
    EXPECT_EQ(refusal(scene), "") << effects::kCatalogue[effect]->id;
    EXPECT_GT(fit(scene, 0, scene.nominal, {}).rms_Pa(), 5.0 * scene.noise_Pa) << "else nothing was asked";
  }
}

}  // namespace
}  // namespace plenum::host::diagnose
