// The next experiment, carried out: a log that cannot tell two causes apart names the input that does, and the log of that input is
// answered with the one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "host-sim/diagnose/diagnose.hpp"
#include "host-sim/diagnose/next_experiment.hpp"
#include "host-sim/plant/chamber.hpp"
#include "tests/diagnose/late_valve.hpp"

namespace plenum::host::diagnose {
namespace {

constexpr double kTick_s = 0.01, kNoise_Pa = 200.0, kVolume_m3 = 150e-6;
constexpr double kLate_s = 0.008;

/// A machine whose valve gets each command late, at `commands_V`, a tick each.
trace::Log log_of(const std::vector<double>& commands_V, const plant::VolumeMotion& volume, unsigned seed) {
  constexpr double kStep_s = 0.001;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise_Pa(0.0, kNoise_Pa);
  plant::ChamberPlant chamber(plant::ThinPlateValve({}), {}, volume);
  LateValve valve(kLate_s);
  trace::Log log;
  log.period_s = log.pressure_average_s = kTick_s;
  double mean_Pa = chamber.pressure_Pa();
  for (const double command_V : commands_V) {
    log.time_s.push_back(kTick_s * static_cast<double>(log.time_s.size()));
    log.command_V.push_back(command_V);
    log.pressure_Pa.push_back(mean_Pa + noise_Pa(random));
    log.volume_m3.push_back(chamber.volume_m3());
    mean_Pa = 0.0;
    for (int step = 0; step < 10; ++step) mean_Pa += 0.1 * chamber.advance(valve(command_V), kStep_s).mean_Pa;
  }
  return log;
}

/// As the input asks for it: at rest, or the sine of the library.
plant::VolumeMotion volume_of(const Stretch& stretch) {
  const auto [least_m3, most_m3] = std::ranges::minmax(stretch.drive.volume_m3);
  if (most_m3 - least_m3 < 1e-9) return plant::VolumeMotion(least_m3, {});
  return plant::VolumeMotion(0.5 * (least_m3 + most_m3),
                             {plant::VolumeSine{0.5 * (most_m3 - least_m3), 0.7, 0.0}});
}

TEST(Experiment, ThatIsCarriedOutNamesTheCauseThatTheLogAtHandCouldNotTell) {
  std::vector<double> slow_V;
  for (int tick = 0; tick < 2000; ++tick)
    slow_V.push_back(5.0 + 0.5 * std::sin(2.0 * std::numbers::pi * 0.8 * kTick_s * tick));
  const trace::Log log = log_of(slow_V, plant::VolumeMotion(kVolume_m3, {}), 1);
  const GapReport at_hand = diagnose({{"log", log}}, {}, {});
  ASSERT_EQ(at_hand.verdict, Verdict::ambiguous) << name_of(at_hand.verdict);
  ASSERT_TRUE(at_hand.next.has_value());
  EXPECT_GT(at_hand.next->power, 0.95);

  Scene scene = identify::chamber::make_scene({});
  add_record(scene, identify::chamber::make_record("log", log, kFittedShare));
  const std::vector<Excitation> inputs = library(scene);
  const auto planned = std::find_if(inputs.begin(), inputs.end(), [&](const Excitation& one) {
    return one.id == at_hand.next->excitation;
  });
  ASSERT_NE(planned, inputs.end());
  std::vector<NamedLog> logs;
  for (const Stretch& stretch : planned->stretches) {
    ASSERT_EQ(stretch.supply_Pa, scene.around.supply_Pa) << "one rig";
    logs.push_back({planned->id, log_of(stretch.drive.command_V, volume_of(stretch), 2)});
  }
  const GapReport told = diagnose(logs, {}, {});
  ASSERT_EQ(told.effects.size(), 1U) << name_of(told.verdict) << ", " << planned->id;
  EXPECT_EQ(told.effects.front().id, "dead_time");
  EXPECT_NEAR(told.effects.front().parameters.front().value, kLate_s, 2e-4) << "s";
}

}  // namespace
}  // namespace plenum::host::diagnose
