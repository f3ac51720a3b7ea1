#include "host-sim/reproduce/proportional_valve/experiment.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "host-sim/identify/orifice/vessel_run.hpp"
#include "host-sim/reproduce/proportional_valve/identified_valve.hpp"

namespace plenum::host::reproduce::proportional_valve {
namespace {

using identify::orifice::Flow;
using ::testing::SizeIs;

const Series& channel_a_inlet() {
  return all_series()[0];
}

TEST(Series, EveryTableHas26MeasuredRowsInStepsOfTwoTenthsOfAVolt) {
  for (const Series& series : all_series()) {
    const std::vector<Row> rows = measured_rows(series);
    EXPECT_THAT(rows, SizeIs(26)) << "Table " << series.number;
    EXPECT_NEAR(rows.back().command_V - rows.front().command_V, 5.0, 1e-12) << "Table " << series.number;
  }
}

TEST(Experiment, StartsFromTheSameVesselAndEndsAtRestOnTheCrackingRatio) {
  for (const Series& series : all_series()) {
    for (const Row& row : measured_rows(series)) {
      const Experiment experiment = measure(series, row.command_V);
      const bool charge = series.flow == Flow::kCharge;
      // The other half cycle leaves it where the open valve's own cracking ratio does.
      EXPECT_NEAR(experiment.vessel_truth_Pa.front(), charge ? 1.012e5 : 7e5, 300.0)
          << "Table " << series.number << ", " << row.command_V << " V";
      const double rest_Pa =
          charge ? row.truth.cracking_ratio * kSupply_Pa : kAmbient_Pa / row.truth.cracking_ratio;
      EXPECT_NEAR(experiment.vessel_truth_Pa.back(), rest_Pa, 0.01 * rest_Pa)
          << "Table " << series.number << ", " << row.command_V << " V";
    }
  }
}

TEST(Experiment, TenCyclesLeaveAThirdOfTheNoiseOfOne) {
  const Experiment experiment = measure(channel_a_inlet(), 10.0, {.periodic_V = 0.0});
  double square = 0.0;
  const std::size_t rows = experiment.vessel_truth_Pa.size();
  for (std::size_t i = 0; i < rows; ++i)
    square += std::pow(experiment.record.vessel_Pa[i] - experiment.vessel_truth_Pa[i], 2.0);
  const double sample_noise_Pa = 2e-3 / (kMillivoltPerKilopascal * 1e-6);
  // the deviation of `rows` draws is known to 1/sqrt(2 rows)
  EXPECT_NEAR(std::sqrt(square / static_cast<double>(rows)), sample_noise_Pa / std::sqrt(10.0),
              4.0 * sample_noise_Pa / std::sqrt(20.0 * static_cast<double>(rows)));
}

TEST(Experiment, DependsOnTheSeedAloneAndNotOnWhatWasMeasuredBefore) {
  const Experiment first = measure(channel_a_inlet(), 7.0);
  measure(channel_a_inlet(), 8.0);
  EXPECT_EQ(measure(channel_a_inlet(), 7.0).record.vessel_Pa, first.record.vessel_Pa);
  EXPECT_NE(measure(channel_a_inlet(), 7.0, {.seed = 6}).record.vessel_Pa, first.record.vessel_Pa);
}

TEST(Experiment, SpoolDelaysTheVessel) {
  const Experiment prompt = measure(channel_a_inlet(), 7.2);
  RigOptions options;
  options.spool = plant::SpoolConfig{65.0, 0.7};
  const Experiment lagging = measure(channel_a_inlet(), 7.2, options);
  constexpr std::size_t kRow = 30;
  EXPECT_GT(prompt.vessel_truth_Pa[kRow] - lagging.vessel_truth_Pa[kRow], 2e4);
  EXPECT_NEAR(prompt.vessel_truth_Pa.back(), lagging.vessel_truth_Pa.back(), 100.0);
}

TEST(Experiment, SineSwingsTheVesselAndRepeats) {
  const SineExperiment sine = measure_sine(plant::MpyeChannel::a);
  ASSERT_THAT(sine.vessel_Pa, SizeIs(500));
  const auto [low, high] = std::minmax_element(sine.vessel_Pa.begin(), sine.vessel_Pa.end());
  EXPECT_GT(*high - *low, 4e5);
  EXPECT_NEAR(sine.vessel_Pa.front(), sine.vessel_Pa.back(), 0.02 * kSupply_Pa);
}

// The look-up model, given tables without error, is the plant: it was written a second time, with another
// integrator.
TEST(SineModel, WithTheTruthForTablesFollowsThePlant) {
  IdentifiedSeries identified[2] = {{all_series()[0], {}}, {all_series()[1], {}}};
  for (IdentifiedSeries& series : identified) {
    const double rate_of_area =
        identify::orifice::choked_rate_of_area_1_s_m2(papers_vessel(series.series.flow)).value();
    for (const Row& row : measured_rows(series.series)) {
      IdentifiedRow truth{row, {}, {}};
      truth.rate_fit.choked_rate_1_s.value = rate_of_area * row.truth.area_m2;
      truth.rate_fit.critical_ratio.value = row.truth.critical_ratio;
      truth.rate_fit.cracking_ratio.value = row.truth.cracking_ratio;
      truth.rate_fit.subsonic_index.value = row.truth.subsonic_index;
      series.rows.push_back(truth);
    }
  }
  const SineExperiment sine = measure_sine(plant::MpyeChannel::a);
  const std::vector<double> run = simulate_sine(identified[0], identified[1], sine);
  EXPECT_LT(identify::orifice::mean_absolute_error(run, sine.vessel_Pa), 250.0);
}

}  // namespace
}  // namespace plenum::host::reproduce::proportional_valve
