#include "host-sim/diagnose/latent.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <ostream>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/diagnose/latent_terms.hpp"
#include "tests/identify/chamber/chamber_scene.hpp"

namespace plenum::host::diagnose {
namespace {

using identify::chamber::chamber_scene;
using identify::chamber::jumping_V;
using identify::chamber::Record;

constexpr std::size_t kRows = 2500;
constexpr double kNoise_Pa = 100.0;
constexpr double kSwing_m3 = 45e-6;

void add_noise(Record& record, unsigned seed) {
  std::mt19937 bits(seed);
  std::normal_distribution<double> noise(0.0, kNoise_Pa);
  for (double& p : record.measured_Pa) p += noise(bits);
}

/// A third of jumps, a third of steps up and down within one port's range, a third of a chirp.
std::vector<double> mixed_V() {
  std::vector<double> command_V = jumping_V(kRows, 3);
  const auto u = [](std::size_t row) { return static_cast<double>(row); };
  for (std::size_t row = kRows / 3; row < 2 * kRows / 3; ++row) {
    const std::size_t step = row / 20 % 16;
    const double port = row / 320 % 2 == 0 ? 1.0 : -1.0;
    command_V[row] = 5.0 + port * (0.15 + 0.08 * u(step < 8 ? step : 16 - step));
  }
  for (std::size_t row = 2 * kRows / 3; row < kRows; ++row) {
    const double t = 0.01 * u(row - 2 * kRows / 3);
    command_V[row] = 5.0 + 0.6 * std::sin(2.0 * std::numbers::pi * (0.3 + 0.2 * t) * t);
  }
  return command_V;
}

/// The answer for a scene whose readings were made with this parameter of this effect.
std::vector<LatentEquation> with_effect(std::string_view id, double value, unsigned threads = 2) {
  Scene scene = chamber_scene(mixed_V(), kSwing_m3);
  scene.noise_Pa = kNoise_Pa;
  const std::size_t effect = effects::find(id).value();
  effects::Figures figures = scene.nominal;
  figures[effects::kFirstFigure[effect]] =
      effects::kCatalogue[effect]->parameters.front().coordinate_of(value);
  Record& record = scene.records.front();
  record.measured_Pa = run(scene, record, effects::EffectSet{1} << effect, figures, {3e5});
  add_noise(record, 5);
  return latent(scene, {&record}, scene.nominal, threads);
}

struct Injected {
  const char* effect;
  double value;
  const char* depends_on;
};
void PrintTo(const Injected& of, std::ostream* out) {
  *out << of.effect;
}

class Latent : public testing::TestWithParam<Injected> {};

TEST_P(Latent, BlamesTheEquationInWhichAnEffectWasInjectedAndSaysWhatItDependsOn) {
  const auto found = with_effect(GetParam().effect, GetParam().value);
  ASSERT_EQ(found.size(), 6U);
  const effects::Effect& effect = *effects::kCatalogue[effects::find(GetParam().effect).value()];
  EXPECT_EQ(effects::name_of(found[0].equation), effects::name_of(effect.equation));

  EXPECT_EQ(found[0].terms[0].on, GetParam().depends_on);
  EXPECT_GT(found[0].terms[0].share, 0.8);
}

INSTANTIATE_TEST_SUITE_P(Effects, Latent,
                         testing::Values(Injected{"spool_lag", 6.0, "the command before"},
                                         Injected{"dead_time", 0.008, "the command before"},
                                         Injected{"valve_hysteresis", 0.1, "the command's reversals"},
                                         Injected{"area_shape", 0.4, "the supply port's opening"},
                                         Injected{"chamber_leak", 2.0, "the pressure"},
                                         Injected{"supply_droop", 20.0, "the flow drawn"},
                                         Injected{"heat_transfer", 0.3, "the gas's temperature"},
                                         Injected{"sensor_lag", 0.008, "the pressure's rate"},
                                         Injected{"volume_error", 20.0, "the volume"},
                                         Injected{"sensor_bias", 5.0, "the pressure"}),
                         [](const auto& test) { return std::string(test.param.effect); });

/// Readings of a chamber whose valve was given something else than the log says.
TEST(Latent, RecoversADriftThatWasAddedToTheCommand) {
  Scene scene = chamber_scene(jumping_V(kRows), kSwing_m3);
  scene.noise_Pa = kNoise_Pa;
  Record& record = scene.records.front();
  const auto drift_V = [](std::size_t tick) {
    return 0.1 * std::sin(2.0 * std::numbers::pi * 0.0016 * static_cast<double>(tick));
  };
  Record drifted = record;
  for (std::size_t k = 0; k < kRows; ++k) drifted.drive.command_V[k] += drift_V(k);
  record.measured_Pa = run(scene, drifted, 0, scene.nominal, {3e5});
  add_noise(record, 6);
  const auto found = latent(scene, {&record}, scene.nominal, 2);
  ASSERT_EQ(found.size(), 6U);
  EXPECT_EQ(effects::name_of(found[0].equation), "command");
  EXPECT_EQ(found[0].unit, "V");
  EXPECT_EQ(found[0].terms[0].on, "time");
  // without what valve figures can take: a constant
  const std::vector<double>& d = found[0].disturbance.front();
  double mean = 0.0, squares = 0.0, count = 0.0;
  for (std::size_t k = 100; k + 100 < d.size(); ++k) {
    mean += d[k] - drift_V(k);
    squares += (d[k] - drift_V(k)) * (d[k] - drift_V(k));
    count += 1.0;
  }
  mean /= count;
  EXPECT_LT(std::sqrt(squares / count - mean * mean), 0.01) << "V of 0.07";
}

/// Gas that a piston moving in compresses above twice the supply's pressure, 0.9 times a second.
TEST(Latent, FollowsAPistonThatCompressesToMoreThanTwiceTheSupply) {
  std::vector<double> command_V(kRows), late_V(kRows);
  for (std::size_t row = 0; row < kRows; ++row) command_V[row] = row % 110 < 15 ? 5.8 : 5.0;
  late_V[0] = command_V[0];
  std::copy(command_V.begin(), command_V.end() - 1, late_V.begin() + 1);
  Scene scene = chamber_scene(late_V, 110e-6);
  scene.noise_Pa = kNoise_Pa;
  Record& record = scene.records.front();
  ASSERT_GT(*std::max_element(record.measured_Pa.begin(), record.measured_Pa.end()),
            2.2 * scene.around.supply_Pa);
  add_noise(record, 8);
  record.drive.command_V = command_V;
  const auto found = latent(scene, {&record}, scene.nominal, 2);
  ASSERT_EQ(found.size(), 6U);
  EXPECT_EQ(effects::name_of(found[0].equation), "command");
  EXPECT_GT(found[0].terms[0].share, 0.8);
  EXPECT_LT(found[0].rest, 0.02) << "V";
}

/// Whatever the calibration took it for: that takes what heat leaves for an early stamp.
TEST(Latent, FindsTheStampOfThePressuresItself) {
  Scene scene = chamber_scene(mixed_V(), kSwing_m3);
  scene.noise_Pa = kNoise_Pa;
  scene.most_early_s = 1e-3;
  Record& record = scene.records.front();
  effects::Figures figures = scene.nominal;
  figures[effects::kStampedEarly] = 0.4e-3;
  record.measured_Pa = run(scene, record, 0, figures, {3e5});
  add_noise(record, 9);
  figures[effects::kStampedEarly] = 1e-3;
  const auto found = latent(scene, {&record}, figures, 2);
  ASSERT_EQ(found.size(), 6U);
  for (const LatentEquation& e : found) {
    const bool may_be_late =
        effects::name_of(e.equation) == "command" || effects::name_of(e.equation) == "sensor";
    EXPECT_NEAR(e.early_s, 0.4e-3, may_be_late ? 0.4e-3 : 0.05e-3) << effects::name_of(e.equation);
    if (e.unit == "V") {
      EXPECT_LT(e.size, 0.005);
    }
    if (e.unit == "1/s") {
      EXPECT_LT(e.size, 0.02);
    }
  }
}

/// Half a second in two a gap by which 1 g/s is lost for each MPa: no function of the pressure, and none of the valve.
TEST(Latent, TellsALeakThatComesAndGoesFromHeat) {
  Scene scene = chamber_scene(jumping_V(kRows), kSwing_m3);
  scene.noise_Pa = kNoise_Pa;
  Record& record = scene.records.front();
  const std::size_t leak = effects::find("chamber_leak").value();
  effects::Figures leaky = scene.nominal;
  leaky[effects::kFirstFigure[leak]] = effects::kCatalogue[leak]->parameters.front().coordinate_of(1.0);
  constexpr std::size_t kStretch = 50;
  double begin_Pa = 3e5;
  for (std::size_t first = 0; first + 1 < kRows; first += kStretch) {
    const std::size_t last = std::min(first + kStretch, kRows - 1);
    const auto part = [&](const std::vector<double>& all, std::size_t per_row, std::size_t more) {
      return std::vector<double>(all.begin() + static_cast<std::ptrdiff_t>(first * per_row),
                                 all.begin() + static_cast<std::ptrdiff_t>(last * per_row + more));
    };
    Record stretch = record;
    stretch.drive.command_V = part(record.drive.command_V, 1, 1);
    stretch.drive.volume_m3 = part(record.drive.volume_m3, 4, 1);
    stretch.measured_Pa = part(record.measured_Pa, 1, 1);
    const bool open = first / kStretch % 4 == 0;
    const effects::EffectSet on = open ? effects::EffectSet{1} << leak : effects::EffectSet{0};
    const effects::Figures& figures = open ? leaky : scene.nominal;
    const std::vector<double> read = run(scene, stretch, on, figures, {begin_Pa});
    std::copy(read.begin() + 1, read.end(),
              record.measured_Pa.begin() + static_cast<std::ptrdiff_t>(first) + 1);
    stretch.drive.timing.average_s = 0.0;  // what the next stretch begins at is no mean
    begin_Pa = run(scene, stretch, on, figures, {begin_Pa}).back();
  }
  add_noise(record, 10);
  const auto found = latent(scene, {&record}, scene.nominal, 2);
  ASSERT_EQ(found.size(), 6U);
  EXPECT_EQ(effects::name_of(found[0].equation), "mass_flow");
  EXPECT_EQ(found[0].terms[0].on, "time");
}

TEST(Latent, TakesWhatComesInByALeakForNoneWhateverAQuietRecordHolds) {
  const Scene scene = chamber_scene(jumping_V(40), 0.0);
  const LatentScene rig(scene, {&scene.records.front()});
  const std::unique_ptr<LatentTerms> leak = leak_terms(rig);
  EXPECT_TRUE(leak->is_possible({{-1.0, 0.0, -1.0}}));
  EXPECT_TRUE(leak->is_possible({{-1.0, 0.0, -1.0}, {0.1, -0.1, 0.1}}));
  EXPECT_TRUE(leak->is_possible({{0.0, 0.0}}));
  EXPECT_FALSE(leak->is_possible({{-1.0, 1.0, -1.0}}));
}

/// 0.3 % of the volume, at 5 Hz, which the log's volume does not have: gas comes and goes, and none comes in by a leak.
TEST(Latent, TellsAVibrationOfTheVolumeFromALeak) {
  Scene scene = chamber_scene(jumping_V(kRows), 0.0);
  scene.noise_Pa = kNoise_Pa;
  Record& record = scene.records.front();
  std::vector<double> volume_m3;
  for (std::size_t row = 0; row < kRows; ++row)
    volume_m3.push_back(150e-6 *
                        (1.0 + 0.003 * std::sin(2.0 * std::numbers::pi * 0.05 * static_cast<double>(row))));
  Record vibrating = record;
  vibrating.drive = effects::make_drive(record.drive.command_V, volume_m3, record.drive.timing);
  record.measured_Pa = run(scene, vibrating, 0, scene.nominal, {3e5});
  add_noise(record, 11);
  const auto found = latent(scene, {&record}, scene.nominal, 2);
  ASSERT_EQ(found.size(), 6U);
  EXPECT_EQ(effects::name_of(found[0].equation), "energy");
}

TEST(Latent, FindsNoLargeDisturbanceWhereThereIsNone) {
  Scene scene = chamber_scene(jumping_V(kRows), kSwing_m3);
  scene.noise_Pa = kNoise_Pa;
  add_noise(scene.records.front(), 7);
  const auto found = latent(scene, {&scene.records.front()}, scene.nominal, 2);
  ASSERT_EQ(found.size(), 6U);
  for (const LatentEquation& e : found) {
    if (e.unit == "Pa") {
      EXPECT_LT(e.size, 5.0 * kNoise_Pa) << effects::name_of(e.equation);
    }
    if (e.unit == "V") {
      EXPECT_LT(e.size, 0.01);
    }
  }
}

TEST(Latent, AnswersTheSameWithOneThreadAndWithTwo) {
  const auto one = with_effect("supply_droop", 20.0, 1);
  const auto two = with_effect("supply_droop", 20.0, 2);
  double sum = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].equation, two[i].equation);
    EXPECT_EQ(one[i].log_likelihood, two[i].log_likelihood);
    sum += one[i].probability;
  }
  EXPECT_NEAR(sum, 1.0, 1e-12);
}

TEST(Latent, SaysNothingOfALogTooShort) {
  const Scene scene = chamber_scene(jumping_V(40), 0.0);
  EXPECT_TRUE(latent(scene, {&scene.records.front()}, scene.nominal, 1).empty());
}

}  // namespace
}  // namespace plenum::host::diagnose
