#include "host-sim/reproduce/actuators/physical_volume_rate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host-sim/plant/random.hpp"
#include "host-sim/reproduce/actuators/population.hpp"

namespace plenum::host::reproduce::actuators {
namespace {

PhysicalModel model_of_100_mL() {
  PhysicalModel model;
  model.at_rest.c = {4.9, 2.0, 10.0, 0.0, 0.0, 0.0, 5.0, 0.15, 0.06};
  model.at_rest.supply_kPa = 620.0;
  model.volume_mL = 100.0;
  return model;
}

double swinging_mL(double t) {
  return 100.0 + 30.0 * std::sin(2.0 * std::numbers::pi * 1.3 * t);
}

TEST(PhysicalVolumeRate, IsTheModelAtRestWhereNothingMoves) {
  const PhysicalModel model = model_of_100_mL();
  for (const double u : {3.0, 4.6, 5.0, 5.3, 7.0}) {
    const identify::SteadyAndRate expected = identify::steady_and_rate(model.at_rest, u, 100.0, 0.0);
    const identify::SteadyAndRate got = steady_and_rate(model, u, 100.0, 0.0);
    EXPECT_NEAR(got.steady_kPa, expected.steady_kPa, 1e-9) << u << " V";
    EXPECT_NEAR(got.rate_per_s, expected.rate_per_s, 1e-12) << u << " V";
    EXPECT_NEAR(steady_and_rate(model, u, 50.0, 0.0).rate_per_s, 2.0 * expected.rate_per_s, 1e-12)
        << u << " V";
  }
}

TEST(PhysicalVolumeRate, SealedGasIsCompressedAdiabatically) {
  PhysicalModel sealed = model_of_100_mL();
  sealed.at_rest.c[6] = 1e-9;
  constexpr double kStep_s = 1e-5;
  double p_kPa = 300.0;
  double t = 0.0;
  for (; t < 0.2; t += kStep_s) {
    const double middle = t + 0.5 * kStep_s;
    const double rate = 30.0 * 2.0 * std::numbers::pi * 1.3 * std::cos(2.0 * std::numbers::pi * 1.3 * middle);
    p_kPa =
        identify::step(steady_and_rate(sealed, 5.0, swinging_mL(middle), rate), p_kPa, kStep_s, 0.0).end_kPa;
  }
  EXPECT_NEAR(p_kPa * std::pow(swinging_mL(t) / 100.0, 1.4), 300.0, 1e-3);
}

TEST(PhysicalVolumeRate, DriftIsThatOfThePublishedFormOnAVolumeAtRest) {
  const trace::Log log = record_chamber(3, Motion::rest, 2000);
  PhysicalModel model = model_of_100_mL();
  model.volume_mL = 1e6 * log.volume_m3.front();
  const identify::Drift expected = identify::drift(log, model.at_rest, 12, 1.0);
  const identify::Drift got = drift(log, model, 12, 1.0);
  ASSERT_EQ(got.time_s.size(), expected.time_s.size());
  for (std::size_t k = 0; k < got.time_s.size(); k += 7) {
    EXPECT_NEAR(got.std_percent[k], expected.std_percent[k], 1e-6) << got.time_s[k] << " s";
    EXPECT_NEAR(got.mean_percent[k], expected.mean_percent[k], 1e-6) << got.time_s[k] << " s";
  }
  EXPECT_NEAR(got.worst_std_percent, expected.worst_std_percent, 1e-6);
}

/// What a chamber that obeys the model would have recorded: commands near the null, volume swinging.
trace::Log record_of(const PhysicalModel& truth) {
  plant::Random random(2);
  trace::Log log;
  for (int k = 0; k < 4000; ++k) {
    log.time_s.push_back(0.01 * k);
    log.command_V.push_back(k % 10 == 0 ? random.uniform(4.0, 6.0) : log.command_V.back());
    log.volume_m3.push_back(1e-6 * swinging_mL(0.01 * k));
    log.pressure_Pa.push_back(300e3);
  }
  const identify::Ticks ticks = identify::lay_out({log});
  double p_kPa = 300.0;
  for (std::size_t k = 0; k + 1 < log.size(); ++k) {
    const identify::Step next = identify::step(
        steady_and_rate(truth, ticks.command_V[k], ticks.volume_mL[k], ticks.volume_rate_mL_s[k]), p_kPa,
        0.01, 0.01);
    log.pressure_Pa[k + 1] = 1e3 * next.mean_kPa;
    p_kPa = next.end_kPa;
  }
  return log;
}

PhysicalModel some_start() {
  PhysicalModel start = model_of_100_mL();
  start.at_rest.c = {5.1, 1.0, 20.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.2};
  return start;
}

TEST(PhysicalVolumeRate, FitFindsTheModelThatMadeTheRecord) {
  const PhysicalModel truth = model_of_100_mL();
  const trace::Log log = record_of(truth);
  const PhysicalModel found = fit_next_pressure(log, some_start());
  for (const std::size_t i : {0U, 1U, 2U, 6U, 7U, 8U}) {
    EXPECT_NEAR(found.at_rest.c[i], truth.at_rest.c[i], 1e-3 * (1.0 + std::abs(truth.at_rest.c[i])))
        << "c" << i + 1;
  }
  EXPECT_LT(drift(log, found, 12, 1.0).worst_std_percent, 0.02);
}

TEST(PhysicalVolumeRate, FitKeepsTheRatePositiveThoughTheRecordAsksOtherwise) {
  PhysicalModel truth = model_of_100_mL();
  truth.at_rest.c[7] = 0.6;
  truth.at_rest.c[8] = 0.0;  // k falls to -0.02 V
  const PhysicalModel found = fit_next_pressure(record_of(truth), some_start());
  double least_per_s = 1.0;
  for (double u = 4.5; u < 5.5; u += 0.001) {
    least_per_s = std::min(least_per_s, steady_and_rate(found, u, 100.0, 0.0).rate_per_s);
  }
  EXPECT_GT(least_per_s, 0.0);
}

}  // namespace
}  // namespace plenum::host::reproduce::actuators
