// The filter against the joint normal distribution of all readings and disturbances of a record, written out as one matrix.
#include "host-sim/diagnose/latent_filter.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

namespace plenum::host::diagnose {
namespace {

constexpr Eigen::Index kTicks = 14;
constexpr Eigen::Index kColumns = 3;
constexpr MarkovNoise kNoise{0.7, 0.025};
constexpr LatentFilter::Spread kSpread{150.0, 4000.0};

Record a_record() {
  Record record;
  record.drive.timing.tick_s = 0.01;
  std::mt19937 random(7);
  std::normal_distribution<double> unit;
  for (Eigen::Index row = 0; row <= kTicks; ++row) record.measured_Pa.push_back(3e5 + 2e3 * unit(random));
  record.fitted_rows = record.measured_Pa.size();
  return record;
}

/// Ticks of no chamber in particular.
Track a_track(const Record& record) {
  Track track(record);
  track.columns = kColumns;
  track.tangent.resize(2 * kColumns * kTicks);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> share(0.2, 1.0);
  std::normal_distribution<double> unit;
  for (Eigen::Index k = 0; k < kTicks; ++k) {
    track.about.d[static_cast<std::size_t>(k)] = 0.3 * unit(random);
    track.at_Pa.push_back(3e5 + 1e3 * unit(random));
    Linear linear;
    linear.by_pressure = {share(random), share(random)};
    linear.at = {3e5 + 1e3 * unit(random), 3e5 + 1e3 * unit(random)};
    track.linear.push_back(linear);
    track.by_d.push_back({900.0 * unit(random), 500.0 * unit(random)});
    track.sensor.push_back(100.0 * unit(random));
    track.rough.push_back(200.0 * share(random));
  }
  for (double& x : track.tangent) x = 300.0 * unit(random);
  return track;
}

/// Of the readings their distribution and its tangents, and how the disturbances go with them, by carrying every independent source of
/// chance along: the start's pressure and disturbance, then of each tick the drive of d, the roughness of p, that of y and the
/// reading's noise.
struct Joint {
  Eigen::MatrixXd by_source = Eigen::MatrixXd::Zero(kTicks, 2 + 4 * kTicks);
  Eigen::MatrixXd d_by_source = by_source;
  Eigen::MatrixXd tangent = Eigen::MatrixXd::Zero(kTicks, kColumns);
  Eigen::VectorXd error = Eigen::VectorXd::Zero(kTicks);
  Eigen::MatrixXd precision;

  explicit Joint(const Track& track) {
    const double keep = std::exp(-track.record->drive.timing.tick_s / kNoise.memory_s);
    const Eigen::Index sources = by_source.cols();
    Eigen::RowVectorXd p = Eigen::RowVectorXd::Zero(sources), d = p;
    Eigen::RowVectorXd p_by = Eigen::RowVectorXd::Zero(kColumns);
    double p_mean = track.begin_Pa;  // that of d is zero
    p[0] = kSpread.begin_Pa;
    d[1] = kNoise.size;
    for (Eigen::Index k = 0; k < kTicks; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const Linear& l = track.linear[i];
      const Outcome& by_d = track.by_d[i];
      const Eigen::Map<const Eigen::RowVectorXd> end(track.end_by(i), kColumns),
          reading(track.reading_by(i), kColumns);
      const double p_off = p_mean - track.at_Pa[i], d_off = -track.about.d[i];
      d_by_source.row(k) = d;
      by_source.row(k) = l.by_pressure.reading * p + by_d.reading * d;
      by_source(k, 2 + 4 * k) = 0.5 * track.rough[i];
      by_source(k, 3 + 4 * k) = kSpread.reading_Pa;
      tangent.row(k) = l.by_pressure.reading * p_by + reading;
      error[k] = track.record->measured_Pa[i + 1] -
                 (l.at.reading + track.sensor[i] + l.by_pressure.reading * p_off + by_d.reading * d_off);
      p = l.by_pressure.end * p + by_d.end * d;
      p[4 + 4 * k] = track.rough[i];
      p_by = l.by_pressure.end * p_by + end;
      p_mean = l.at.end + l.by_pressure.end * p_off + by_d.end * d_off;
      d *= keep;
      d[5 + 4 * k] = std::sqrt(1.0 - keep * keep) * kNoise.size;
    }
    precision = (by_source * by_source.transpose()).inverse();
  }
};

TEST(LatentFilter, CostIsThatOfTheReadingsJointDensity) {
  const Record record = a_record();
  const Track track = a_track(record);
  const Joint joint(track);
  const double expected =
      joint.error.dot(joint.precision * joint.error) - std::log(joint.precision.determinant());
  EXPECT_NEAR(cost_of(track, kNoise, kSpread), expected, 1e-9 * expected);
}

TEST(LatentFilter, RowsThatAreNotSettledCostNothing) {
  Record record = a_record();
  const Track track = a_track(record);
  LatentFilter filter(track, kNoise, kSpread);
  double late = 0.0;
  for (std::size_t k = 0; k < track.ticks(); ++k) {
    const double cost = filter.update(k).cost();
    if (k >= 4) late += cost;
    filter.advance(k);
  }
  record.settled_rows = 5;
  EXPECT_DOUBLE_EQ(cost_of(track, kNoise, kSpread), late);
}

TEST(LatentFilter, SmoothedDisturbanceIsItsMeanGivenAllReadings) {
  const Record record = a_record();
  const Track track = a_track(record);
  const Joint joint(track);
  const Eigen::VectorXd expected =
      joint.d_by_source * joint.by_source.transpose() * joint.precision * joint.error;
  const std::vector<double> smooth = smoothed_disturbance(track, kNoise, kSpread);
  ASSERT_EQ(smooth.size(), static_cast<std::size_t>(kTicks));
  for (Eigen::Index k = 0; k < kTicks; ++k) {
    EXPECT_NEAR(smooth[static_cast<std::size_t>(k)], expected[k], 1e-6 * kNoise.size) << "tick " << k;
  }
}

TEST(LatentFilter, GramIsThatOfTheTangentsWhitenedAllAtOnce) {
  const Record record = a_record();
  const Track track = a_track(record);
  const Joint joint(track);
  Eigen::MatrixXd all(kTicks, kColumns + 1);
  all << joint.tangent, joint.error;
  const Eigen::MatrixXd expected = all.transpose() * joint.precision * all;
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(kColumns + 1, kColumns + 1);
  add_gram(track, kNoise, kSpread, gram);
  for (Eigen::Index i = 0; i <= kColumns; ++i) {
    for (Eigen::Index j = i; j <= kColumns; ++j) {
      EXPECT_NEAR(gram(i, j), expected(i, j), 1e-9 * std::sqrt(expected(i, i) * expected(j, j)))
          << i << ", " << j;
    }
  }
}

}  // namespace
}  // namespace plenum::host::diagnose
