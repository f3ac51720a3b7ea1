// A gap is what the valve's figures do not follow though all rows show them.
#include "host-sim/diagnose/gap_beyond_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/identify/chamber/chamber_scene.hpp"

namespace plenum::host::diagnose {
namespace {

constexpr std::size_t kRows = 2000, kFitted = 1200;
constexpr double kNoise_Pa = 100.0;

struct Recorded {
  Scene scene;
  std::vector<HeldOut> heldout;
};

/// A chamber whose exhaust, a fifth wider than its data sheet says, opens on the rows held out alone.
Recorded of_an_exhaust_that_is_seen_late(double dead_time_s) {
  std::vector<double> command_V = identify::chamber::jumping_V(kRows);
  for (std::size_t row = 0; row < kFitted; ++row)
    command_V[row] = 4.93 + 0.3 * std::abs(command_V[row] - 4.9);
  Recorded made{identify::chamber::chamber_scene(command_V, 30e-6), {}};
  Record& record = made.scene.records[0];
  made.scene.noise_Pa = kNoise_Pa;
  record.fitted_rows = kFitted;
  effects::Figures truth = made.scene.nominal;
  truth[effects::kExhaustGain] *= 1.2;
  truth[effects::kFirstFigure[effects::kIdDeadTime]] = dead_time_s;
  record.measured_Pa = run(made.scene, record, bit(effects::kIdDeadTime), truth, {3e5});
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise(0.0, kNoise_Pa);
  for (double& p : record.measured_Pa) p += noise(random);
  made.heldout = {{record, kFitted, 0}};
  return made;
}

CalibratedToAll to_all(const Recorded& made) {
  return calibrated_to_all(made.scene, made.heldout, recalibrated(made.scene, made.heldout).fit);
}

TEST(GapBeyondNoise, IsNoneWhereTheFittedRowsLeaveAFigureUnknown) {
  const Recorded made = of_an_exhaust_that_is_seen_late(0.0);
  const Trial base = recalibrated(made.scene, made.heldout);
  ASSERT_GT(base.heldout_Pa(), 5.0 * kNoise_Pa) << "else nothing is unknown";
  const CalibratedToAll all = to_all(made);
  EXPECT_NEAR(all.fit.rms_Pa(), kNoise_Pa, 0.05 * kNoise_Pa);
  EXPECT_GT(gap_p_value(all, made.heldout, made.scene, base.fit, kNoise_Pa), 0.05);
}

TEST(GapBeyondNoise, IsWhatNoFigureFollows) {
  const Recorded made = of_an_exhaust_that_is_seen_late(0.02);
  const Fit late = fit(made.scene, bit(effects::kIdDeadTime), made.scene.nominal, {});
  ASSERT_NEAR(late.rms_Pa(), kNoise_Pa, 0.05 * kNoise_Pa);
  EXPECT_EQ(gap_p_value(to_all(made), made.heldout, made.scene, late, kNoise_Pa), 0.001);
}

TEST(GapBeyondNoise, IsJudgedOnAnotherLogAsOnTheRestOfOne) {
  Recorded made = of_an_exhaust_that_is_seen_late(0.0);
  made.heldout[0].first = 1;
  made.heldout[0].continues = -1;
  const CalibratedToAll all = to_all(made);
  ASSERT_EQ(all.scene.records.size(), 2U);
  EXPECT_EQ(all.place, std::vector<std::size_t>{1});
  EXPECT_NEAR(all.fit.rms_Pa(), kNoise_Pa, 0.05 * kNoise_Pa);
}

}  // namespace
}  // namespace plenum::host::diagnose
