#include "host-sim/identify/chamber/next_tick.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/identify/chamber/chamber_scene.hpp"

namespace plenum::host::identify::chamber {
namespace {

TEST(NextTick, OfTheModelThatMadeTheRecordIsExact) {
  const Scene scene = chamber_scene(jumping_V(400), 30e-6);
  EXPECT_LT(next_tick_rms_Pa(scene, 0, scene.nominal), 0.5);
}

TEST(NextTick, OfASealedChamberErrsByTheNoiseOfBothRows) {
  Scene scene = chamber_scene(std::vector<double>(4000, 5.0), 0.0);
  effects::Figures sealed = scene.nominal;
  sealed[effects::kInletLeak] = sealed[effects::kExhaustLeak] = 0.0;
  sealed[effects::kTransition] = 1e-15;
  Record& record = scene.records.front();
  record.measured_Pa.assign(record.rows(), 3e5);
  constexpr double kNoise_Pa = 100.0;
  std::mt19937 bits(4);
  std::normal_distribution<double> noise(0.0, kNoise_Pa);
  for (double& p : record.measured_Pa) p += noise(bits);
  EXPECT_NEAR(next_tick_rms_Pa(scene, 0, sealed), std::sqrt(2.0) * kNoise_Pa, 0.05 * kNoise_Pa);
}

/// The row before the next says nothing of where a spool is on its way: from that row alone a spool of 10 Hz would miss kilopascals.
TEST(NextTick, OfAModelWithMemoryThatMadeTheRecordIsExact) {
  Scene scene = chamber_scene(jumping_V(400), 30e-6);
  constexpr effects::EffectSet kSpool = effects::EffectSet{1} << effects::kIdSpoolLag;
  effects::Figures lagging = scene.nominal;
  lagging[effects::kFirstFigure[effects::kIdSpoolLag]] = 0.1;  // s
  Record& record = scene.records.front();
  record.measured_Pa = run(scene, record, kSpool, lagging, {3e5});
  EXPECT_LT(next_tick_rms_Pa(scene, kSpool, lagging), 0.5);
  EXPECT_GT(next_tick_rms_Pa(scene, 0, scene.nominal), 1000.0);
}

TEST(NextTick, ShowsAGainThatIsTooLargeInProportion) {
  const Scene scene = chamber_scene(jumping_V(400), 30e-6);
  const auto with_gain = [&](double factor) {
    effects::Figures figures = scene.nominal;
    figures[effects::kInletGain] *= factor;
    return next_tick_rms_Pa(scene, 0, figures);
  };
  EXPECT_GT(with_gain(1.01), 10.0);
  EXPECT_NEAR(with_gain(1.02) / with_gain(1.01), 2.0, 0.05);
}

}  // namespace
}  // namespace plenum::host::identify::chamber
