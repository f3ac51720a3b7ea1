#include "host-sim/diagnose/latent.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <ostream>
#include <random>
#include <string>
#include <string_view>

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

TEST(Latent, FindsNoLargeDisturbanceWhereThereIsNone) {
  Scene scene = chamber_scene(jumping_V(kRows), kSwing_m3);
  scene.noise_Pa = kNoise_Pa;
  add_noise(scene.records.front(), 7);
  for (const LatentEquation& e : latent(scene, {&scene.records.front()}, scene.nominal, 2)) {
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
