// Effects in a rig: off, on, and what a board's log shows of them.
#include "host-sim/rig/effects_chamber.hpp"

#include <gmock/gmock.h>

#include "host-sim/client/session.hpp"
#include "tests/rig/watched_rig.hpp"

namespace plenum::host::rig {
namespace {

using Wanted = std::map<std::string, std::map<std::string, double>>;

/// What `action` throws, as a text; empty when it does not.
template <class Action>
std::string refusal(Action&& action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

RigConfig quiet_rig(const Wanted& effects, unsigned chambers = 1) {
  trace::RigDescription description;
  description.sensor.pressure_noise_Pa = 0.0;
  description.effects = effects;
  return thin_plate_rig(description, {.chambers = chambers});
}

/// Ten seconds of excitation, every tick written down.
std::vector<std::vector<std::vector<Moment>>> excited(const RigConfig& config) {
  WatchedRig watched(config);
  client::Session session(watched, 1);
  session.write(canopen::object::kControlMode, 0, static_cast<std::int8_t>(-1));
  session.nmt(canopen::NmtCommand::start);
  session.enable();
  watched.wait(10.0);
  return watched.moments;
}

/// Half a step of the converter, for a reading and for its reference.
double quantum_Pa(const RigConfig& config) {
  const BoardConfig& board = config.board[0];
  return (board.adc.high_V - board.adc.low_V) / 65536.0 * board.chamber[0].pressure_Pa.per_V;
}

TEST(EffectsChamber, IsOfAThinPlateWithoutSpool) {
  RigConfig config = mpye_rig({.chambers = 1, .spool = false});
  config.board[0].chamber[0].effects = effects::ChamberEffects{};
  EXPECT_THAT(refusal([&] { Rig rig(config); }), ::testing::HasSubstr("thin-plate"));
  config = quiet_rig({{"dead_time", {{"delay_s", 0.01}}}});
  config.board[0].chamber[0].chamber.spool = plant::SpoolConfig{};
  EXPECT_THAT(refusal([&] { Rig rig(config); }), ::testing::HasSubstr("spool_lag"));
}

TEST(EffectsChamber, RigWithoutEffectsIsOfPlants) {
  Rig plain(quiet_rig({}));
  EXPECT_NO_THROW(plain.board(0).plant(0));
  Rig other(quiet_rig({{"dead_time", {}}}));
  EXPECT_THROW(other.board(0).plant(0), std::invalid_argument);
}

TEST(EffectsChamber, WithEffectsThatVanishFollowsThePlant) {
  const RigConfig config = quiet_rig({{"valve_hysteresis", {{"width_V", 0.0}}}}, 4);
  const auto moments = excited(config);
  auto plants = fresh_plants(config);
  for (std::size_t c = 0; c < 4; ++c) {
    double squares = 0.0;
    for (std::size_t k = 1; k < moments.size(); ++k) {
      plants[c].advance(moments[k - 1][0][c].command_V, kTick_s);
      ASSERT_NEAR(plants[c].volume_m3(), moments[k][0][c].volume_m3, 1e-15) << "m3, tick " << k;
      squares += std::pow(plants[c].pressure_Pa() - moments[k][0][c].pressure_Pa, 2);
    }
    EXPECT_LT(std::sqrt(squares / static_cast<double>(moments.size())), 10.0) << "Pa RMS, chamber " << c;
  }
}

TEST(EffectsChamber, ChambersOfABoardMoveAsTheyWouldAlone) {
  const RigConfig config = quiet_rig({{"spool_lag", {{"natural_frequency_Hz", 15.0}}},
                                      {"area_shape", {{"inlet_slope", 1.0}}},
                                      {"tube_dynamics", {{"length_m", 0.5}}}},
                                     8);
  const auto moments = excited(config);
  for (std::size_t c = 0; c < 8; ++c) {
    const ChamberConfig& chamber = config.board[0].chamber[c];
    EffectsChamber alone(chamber.valve, chamber.chamber, chamber.volume, *chamber.effects, kTick_s);
    for (std::size_t k = 1; k < moments.size(); ++k) {
      alone.advance(moments[k - 1][0][c].command_V);
      ASSERT_EQ(alone.pressure_Pa(), moments[k][0][c].pressure_Pa) << "Pa, tick " << k << " chamber " << c;
    }
  }
}

// A chamber whose motion is told late moves sooner than its log says, and what the rig does not log of it yet is no guess.
TEST(EffectsChamber, PositionToldLateIsTheChamberThatMovesSooner) {
  constexpr double kDelay_s = 0.0537, kHertz = 0.9;
  const plant::VolumeSine told{.amplitude_m3 = 45e-6, .frequency_Hz = kHertz, .phase_rad = 0.3};
  plant::VolumeSine sooner = told;
  sooner.phase_rad += 2.0 * std::numbers::pi * kHertz * kDelay_s;
  const plant::ChamberConfig config;
  const auto chamber = [&](const plant::VolumeSine& sine, const Wanted& effects) {
    return EffectsChamber(plant::ThinPlateValve({}), config, plant::VolumeMotion(150e-6, {{sine, {}, {}}}),
                          effects::chamber_effects(effects), kTick_s);
  };
  EffectsChamber late = chamber(told, {{"volume_error", {{"delay_s", kDelay_s}}}});
  EffectsChamber moved = chamber(sooner, {{"volume_error", {}}});
  for (int k = 0; k < 1000; ++k) {
    const double command_V = k < 50 ? 6.0 : 4.95;  // filled, then all but shut
    ASSERT_NEAR(late.advance(command_V) / moved.advance(command_V), 1.0, 2e-5) << "tick " << k;
  }
}

TEST(EffectsChamber, DeadTimeOfThirtyMillisecondsIsThePlantFedThreeTicksLate) {
  const RigConfig config = quiet_rig({{"dead_time", {{"delay_s", 0.03}}}});
  const auto moments = excited(config);
  auto plants = fresh_plants(config);
  double squares = 0.0;
  double swing_Pa = 0.0;
  for (std::size_t k = 1; k < moments.size(); ++k) {
    plants[0].advance(k < 4 ? 5.0 : moments[k - 4][0][0].command_V, kTick_s);
    squares += std::pow(plants[0].pressure_Pa() - moments[k][0][0].pressure_Pa, 2);
    swing_Pa = std::max(swing_Pa, moments[k][0][0].pressure_Pa);
  }
  EXPECT_GT(swing_Pa, 4e5) << "Pa: excited at all";
  EXPECT_LT(std::sqrt(squares / static_cast<double>(moments.size())), 10.0) << "Pa RMS";
}

/// What a sensor without lag or bias would have read of the first chamber, under the same commands.
std::vector<double> true_means_Pa(const RigConfig& config,
                                  const std::vector<std::vector<std::vector<Moment>>>& moments) {
  const ChamberConfig& chamber = config.board[0].chamber[0];
  EffectsChamber alone(chamber.valve, chamber.chamber, chamber.volume, {}, kTick_s);
  std::vector<double> means_Pa{alone.resting_reading_Pa()};
  for (std::size_t k = 1; k < moments.size(); ++k)
    means_Pa.push_back(alone.advance(moments[k - 1][0][0].command_V));
  return means_Pa;
}

TEST(EffectsChamber, SensorBiasShowsInEveryReadingFromTheFirst) {
  const RigConfig config = quiet_rig({{"sensor_bias", {{"offset_kPa", 7.0}, {"gain_error", 0.02}}}});
  const auto moments = excited(config);
  const std::vector<double> means_Pa = true_means_Pa(config, moments);
  for (std::size_t k = 0; k < moments.size(); ++k) {
    ASSERT_NEAR(static_cast<double>(moments[k][0][0].image.actual_Pa),
                means_Pa[k] + 7000.0 + 0.02 * (means_Pa[k] - 101325.0), 0.6 * quantum_Pa(config))
        << "Pa, tick " << k;
  }
}

TEST(EffectsChamber, SensorLagIsReadLateByItsTimeConstant) {
  const RigConfig config = quiet_rig({{"sensor_lag", {{"time_constant_s", 0.1}}}});
  const auto moments = excited(config);
  const std::vector<double> means_Pa = true_means_Pa(config, moments);
  const auto reading_Pa = [&](std::size_t k) {
    return static_cast<double>(moments[k][0][0].image.actual_Pa);
  };
  // tau (y_1 - y_0) = int (p - y); the mean of y over a tick is y half a tick before its end
  double integral = 0.0;
  for (std::size_t k = 1; k + 1 < moments.size(); ++k) {
    integral += kTick_s * (means_Pa[k] - reading_Pa(k));
    const double end_Pa = 0.5 * (reading_Pa(k) + reading_Pa(k + 1));
    ASSERT_NEAR(integral / 0.1, end_Pa - reading_Pa(0), 1000.0) << "Pa, tick " << k;
  }
}

}  // namespace
}  // namespace plenum::host::rig
