#include "host-sim/effects/free_run.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "host-sim/effects/free_run_kernel.hpp"
#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

constexpr EffectSet kAll = (EffectSet{1} << kEffects) - 1;

/// Eight chambers, no two alike in any figure that is found: each parameter between neutral and a tenth of the way to a bound.
std::vector<Run> different_runs() {
  std::mt19937 bits(11);
  const auto share = [&] { return static_cast<double>(bits()) / 4294967296.0; };
  std::vector<effects::Run> runs;
  for (int i = 0; i < kLanes; ++i) {
    effects::Run run{nominal(), {1.5e5 + 5e4 * i, 2e3 * i}};
    for (std::size_t k = 0; k < kValveFigures; ++k) run.figures[k] *= 1.0 + 0.01 * (share() - 0.5);
    for (std::size_t e = 0; e < kEffects; ++e) {
      std::size_t at = kFirstFigure[e];
      for (const Parameter& p : kCatalogue[e]->parameters) {
        const double to = p.neutral() < p.greatest() ? p.greatest() : p.least();
        run.figures[at++] = p.neutral() + 0.1 * share() * (to - p.neutral());
      }
    }
    constexpr std::size_t kKnot = kFirstFigure[kIdNullDrift] + kNullDriftParameters.size() - 1;
    static_assert(kNullDriftParameters.back().name == "knot_s");
    if (!runs.empty()) run.figures[kKnot] = runs.front().figures[kKnot];  // given, for all
    runs.push_back(run);
  }
  return runs;
}

void expect_lanes_equal_scalars(FreeRunKernel& kernel, EffectSet on) {
  const Drive drive = drive_of(jumping_command_V(500), swinging_volume(), 4);
  const std::vector<effects::Run> runs = different_runs();
  std::vector<double> readings(500 * kLanes);
  kernel({}, drive, on, runs, readings);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::vector<double> alone =
        run(on, runs[i].figures, drive, runs[i].start.pressure_Pa, {}, runs[i].start.warmth_Pa);
    for (std::size_t row = 0; row < alone.size(); ++row) {
      ASSERT_NEAR(readings[row * kLanes + i], alone[row], 1e-9 * alone[row])
          << "Pa, lane " << i << " row " << row << " effects " << on;
    }
  }
}

void expect_lanes_equal_scalars(FreeRunKernel& kernel) {
  expect_lanes_equal_scalars(kernel, 0);
  for (std::size_t i = 0; i < kEffects; ++i) expect_lanes_equal_scalars(kernel, EffectSet{1} << i);
  expect_lanes_equal_scalars(kernel, kAll);
}

TEST(FreeRun, LanesEqualScalarsOnAnyMachine) {
  expect_lanes_equal_scalars(free_run_any_machine);
}

#if defined(__x86_64__)
TEST(FreeRun, LanesEqualScalarsOnX86_64V3) {
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma") || !__builtin_cpu_supports("bmi2")) {
    GTEST_SKIP() << "this processor has no AVX2, FMA, BMI2";
  }
  expect_lanes_equal_scalars(free_run_x86_64_v3);
}

TEST(FreeRun, LanesEqualScalarsOnX86_64V4) {
  if (!__builtin_cpu_supports("avx512f") || !__builtin_cpu_supports("avx512dq") ||
      !__builtin_cpu_supports("avx512vl") || !__builtin_cpu_supports("avx512bw") ||
      !__builtin_cpu_supports("avx512cd")) {
    GTEST_SKIP() << "this processor has no AVX-512";
  }
  expect_lanes_equal_scalars(free_run_x86_64_v4);
}
#endif

TEST(FreeRun, SpareLanesRepeatTheFirstRunAndRowZeroIsTheStart) {
  const Drive drive = drive_of(jumping_command_V(50), swinging_volume(), 4);
  std::vector<effects::Run> runs = different_runs();
  runs.resize(3);
  std::vector<double> readings(50 * kLanes);
  free_run({}, drive, kAll, runs, readings);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(readings[i], runs[i].start.pressure_Pa) << "Pa";
  for (std::size_t row = 0; row < 50; ++row) {
    for (std::size_t i = 3; i < kLanes; ++i) EXPECT_EQ(readings[row * kLanes + i], readings[row * kLanes]);
  }
}

TEST(FreeRun, TakesAsManyRowsAsThereIsRoomFor) {
  const Drive drive = drive_of(jumping_command_V(50), swinging_volume(), 4);
  const std::vector<effects::Run> runs = different_runs();
  std::vector<double> whole(50 * kLanes);
  std::vector<double> beginning(20 * kLanes);
  free_run({}, drive, 0, runs, whole);
  free_run({}, drive, 0, runs, beginning);
  EXPECT_TRUE(std::equal(beginning.begin(), beginning.end(), whole.begin()));
}

TEST(MakeDrive, VolumeBetweenRowsIsThatOfAParabola) {
  std::vector<double> volume_m3;
  const auto parabola = [](double row) { return 2e-4 + 1e-6 * row - 3e-7 * row * row; };
  for (int row = 0; row < 10; ++row) volume_m3.push_back(parabola(row));
  const Drive drive = make_drive(std::vector<double>(10, 5.0), volume_m3, {.steps = 4});
  ASSERT_EQ(drive.volume_m3.size(), 9U * 4U + 1U);
  for (int i = 4; i <= 8 * 4; ++i) {
    EXPECT_NEAR(drive.volume_m3[static_cast<std::size_t>(i)], parabola(0.25 * i), 1e-18) << "m3, step " << i;
  }
  for (std::size_t row = 0; row < 10; ++row)
    EXPECT_EQ(drive.volume_m3[4 * row], volume_m3[row]) << "m3 at a row";
}

TEST(MakeDrive, VolumeOfASwingAtOneHertzIsRightToAMillionth) {
  std::vector<double> volume_m3;
  const auto swing = [](double t) { return 150e-6 + 45e-6 * std::sin(2.0 * std::numbers::pi * t); };
  for (int row = 0; row < 200; ++row) volume_m3.push_back(swing(0.01 * row));
  const Drive drive = make_drive(std::vector<double>(200, 5.0), volume_m3, {.steps = 4});
  for (std::size_t i = 4; i + 4 < drive.volume_m3.size(); ++i) {
    EXPECT_NEAR(drive.volume_m3[i] / swing(0.0025 * static_cast<double>(i)), 1.0, 1e-6) << "step " << i;
  }
}

}  // namespace
}  // namespace plenum::host::effects
