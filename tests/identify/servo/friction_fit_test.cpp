#include "host-sim/identify/servo/friction_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/plant/random.hpp"
#include "tests/identify/servo/pulled_records.hpp"

namespace plenum::host::identify::servo {
namespace {

constexpr double kArea_m2 = 4.9e-4;

// Rows of two records that follow (23) exactly, at speeds from 1 to 50 mm/s in both directions.
std::vector<std::vector<SlidingRow>> exact(double stribeck_N, double slowest_m_s) {
  std::vector<std::vector<SlidingRow>> records(2);
  for (std::size_t r = 0; r < 2; ++r) {
    const double pressure_Pa = r == 0 ? 1e5 : 5e5;
    const double coulomb_N = r == 0 ? 4.0 : 8.0;
    for (double speed = slowest_m_s; speed <= 50e-3; speed += 1e-3) {
      for (const double s : {1.0, -1.0}) {
        const double force_N = kArea_m2 * pressure_Pa + 0.7 +
                               s * (coulomb_N + stribeck_N * std::exp(-speed / 5e-3) + 30.0 * speed);
        records[r].push_back({0.0, 0.02, s * speed, pressure_Pa, force_N});
      }
    }
  }
  return records;
}

TEST(FrictionFit, FindsTheFiguresThatMadeTheRows) {
  const FrictionFit fit = fit_friction(exact(3.0, 1e-3), {true, 5e-3});
  EXPECT_NEAR(fit.area_m2, kArea_m2, 1e-12);
  EXPECT_NEAR(fit.zero_N, 0.7, 1e-9);
  EXPECT_NEAR(fit.coulomb_N[0], 4.0, 1e-9);
  EXPECT_NEAR(fit.coulomb_N[1], 8.0, 1e-9);
  EXPECT_NEAR(fit.viscous_N_s_m, 30.0, 1e-7);
  EXPECT_NEAR(fit.stribeck_N, 3.0, 1e-9);
  EXPECT_LT(fit.rms_N, 1e-10);
  EXPECT_GT(fit.stribeck_shape, 0.1);
}

TEST(FrictionFit, OneRecordWillDoWhereTheAreaIsKnown) {
  const std::vector<std::vector<SlidingRow>> records = exact(0.0, 1e-3);
  const FrictionFit fit = fit_friction(std::span(records).first(1), {.viscous = true, .area_m2 = kArea_m2});
  EXPECT_EQ(fit.area_m2, kArea_m2);
  EXPECT_EQ(fit.area_error_m2, 0.0);
  EXPECT_NEAR(fit.zero_N, 0.7, 1e-9);
  EXPECT_NEAR(fit.coulomb_N[0], 4.0, 1e-9);
}

TEST(FrictionFit, StandardErrorsAreTheScatterOfManyRecordings) {
  constexpr int kTimes = 300;  // tells a deviation to 4 %
  const std::vector<std::vector<SlidingRow>> truth = exact(0.0, 1e-3);
  const FrictionFit right = fit_friction(truth);
  plant::Random random(4);
  double area = 0.0;
  double zero = 0.0;
  double coulomb = 0.0;
  double told_area = 0.0;
  double told_zero = 0.0;
  double told_coulomb = 0.0;
  for (int i = 0; i < kTimes; ++i) {
    std::vector<std::vector<SlidingRow>> noisy = truth;
    for (std::vector<SlidingRow>& record : noisy)
      for (SlidingRow& row : record) row.force_N += 0.5 * random.gaussian();
    const FrictionFit fit = fit_friction(noisy);
    area += std::pow(fit.area_m2 - right.area_m2, 2) / kTimes;
    zero += std::pow(fit.zero_N - right.zero_N, 2) / kTimes;
    coulomb += std::pow(fit.coulomb_N[1] - right.coulomb_N[1], 2) / kTimes;
    told_area += fit.area_error_m2 / kTimes;
    told_zero += fit.zero_error_N / kTimes;
    told_coulomb += fit.coulomb_error_N[1] / kTimes;
  }
  EXPECT_NEAR(told_area / std::sqrt(area), 1.0, 0.15);
  EXPECT_NEAR(told_zero / std::sqrt(zero), 1.0, 0.15);
  EXPECT_NEAR(told_coulomb / std::sqrt(coulomb), 1.0, 0.15);
}

TEST(FrictionFit, StribeckShapeFallsWithTheSlowestSpeed) {
  const double slow = fit_friction(exact(3.0, 1e-3), {true, 5e-3}).stribeck_shape;
  const double fast = fit_friction(exact(3.0, 25e-3), {true, 5e-3}).stribeck_shape;
  EXPECT_LT(fast, 0.7 * slow);
}

TEST(FrictionFit, GatheredRowsGiveTheSameFigures) {
  std::vector<std::vector<SlidingRow>> records = exact(0.0, 4.5e-3);
  const FrictionFit rows = fit_friction(records);
  for (std::vector<SlidingRow>& record : records) record = gathered(record, 5e-3, 1);
  const FrictionFit means = fit_friction(records);  // exact: without F_s the form is linear in v and p
  EXPECT_NEAR(means.area_m2, rows.area_m2, 1e-12);
  EXPECT_NEAR(means.coulomb_N[1], rows.coulomb_N[1], 1e-9);
  EXPECT_NEAR(means.viscous_N_s_m, rows.viscous_N_s_m, 1e-7);
  EXPECT_EQ(means.samples, rows.samples);
}

TEST(FrictionFit, SlopeOfAStraightPullIsItsVelocity) {
  PulledRecord record;
  for (int i = 0; i < 200; ++i) {
    record.time_s.push_back(0.01 * i);
    record.position_m.push_back(2e-3 + 12e-3 * 0.01 * i);
    record.pressure_Pa.push_back(1e5);
    record.force_N.push_back(50.0);
  }
  for (std::size_t i = 100; i < 200; ++i) record.time_s[i] += 0.1;  // a gap, across which no slope is drawn
  const std::vector<SlidingRow> rows = sliding_rows(record, SlidingWindow{});
  EXPECT_EQ(rows.size(), 160u);
  for (const SlidingRow& row : rows) EXPECT_NEAR(row.velocity_m_s, 12e-3, 1e-9);
}

TEST(FrictionFit, SaysWhatOneDirectionOrOneRecordCannotTell) {
  std::vector<std::vector<SlidingRow>> records = exact(0.0, 1e-3);
  EXPECT_THROW(fit_friction(std::span(records).first(1)), CannotIdentify);
  std::erase_if(records[1], [](const SlidingRow& row) { return row.velocity_m_s < 0.0; });
  try {
    fit_friction(records);
    FAIL() << "one direction was accepted";
  } catch (const CannotIdentify& e) {
    EXPECT_NE(std::string(e.what()).find("record 1 slides in one direction"), std::string::npos) << e.what();
  }
}

std::string refusal(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::exception& e) {
    return e.what();
  }
  return "nothing was refused";
}

TEST(FrictionFit, RefusesWhatHasNoVelocity) {
  PulledRecord record{{0.0, 0.01, 0.02}, {0.01, 0.011, 0.012}, {1e5, 1e5, 1e5}, {50.0, 50.0, 50.0}};
  EXPECT_THROW(sliding_rows(record, {.half_width = 0}), std::invalid_argument);
  EXPECT_NE(refusal([&] { sliding_rows(record, {.half_width = 0}); }).find("half_width = 0"),
            std::string::npos);
  EXPECT_EQ(sliding_rows(record, {.half_width = 1}).size(), 1u);
  EXPECT_THROW(sliding_rows(PulledRecord{}, {}), std::invalid_argument);
  EXPECT_NE(refusal([] { sliding_rows(PulledRecord{}, {}); }).find("no samples"), std::string::npos);
}

TEST(FrictionFit, RefusesIntervalsWithoutWidth) {
  const std::vector<SlidingRow> rows = exact(0.0, 1e-3).front();
  for (const double width_m_s : {0.0, -1e-3, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(gathered(rows, width_m_s, 1), std::invalid_argument);
    EXPECT_NE(refusal([&] { gathered(rows, width_m_s, 1); }).find("width_m_s"), std::string::npos);
  }
}

TEST(FrictionFit, SaysThatRowsAreTooFew) {
  std::vector<std::vector<SlidingRow>> records = exact(0.0, 1e-3);
  std::vector<std::vector<SlidingRow>> few = records;
  for (std::vector<SlidingRow>& record : few) record.resize(2);
  EXPECT_THROW(fit_friction(few, {false, {}}), CannotIdentify);
  EXPECT_NE(refusal([&] {
              fit_friction(few, {false, {}});
            }).find("4 samples for 4 coefficients"),
            std::string::npos);
  records[1].clear();
  EXPECT_THROW(fit_friction(records), CannotIdentify);
  EXPECT_NE(refusal([&] { fit_friction(records); }).find("record 1 has no rows"), std::string::npos);
}

TEST(MeasuredFriction, CoulombFrictionIsHalfTheGapBetweenTheDirectionsAndGrowsWithPressure) {
  const std::vector<std::vector<SlidingRow>> records = pulled_rows();
  const FrictionFit fit = fit_friction(records, {false, {}});
  EXPECT_GT(fit.samples, 25000.0);
  EXPECT_LT(fit.rms_N, 0.6);
  EXPECT_NEAR(fit.area_m2, 491e-6, 6e-6);  // a bore of 25 mm
  for (std::size_t r = 0; r < records.size(); ++r) {
    double force[2] = {0.0, 0.0};
    double count[2] = {0.0, 0.0};
    for (const SlidingRow& row : records[r]) {
      const int side = row.velocity_m_s > 0.0 ? 0 : 1;
      force[side] += row.force_N - fit.area_m2 * row.pressure_Pa;
      count[side] += 1.0;
    }
    EXPECT_NEAR(fit.coulomb_N[r], 0.5 * (force[0] / count[0] - force[1] / count[1]), 0.2) << "record " << r;
    EXPECT_GT(fit.coulomb_N[r], r > 0 ? fit.coulomb_N[r - 1] + 0.5 : 0.0);
  }
  EXPECT_NEAR(fit.coulomb_N[3] / fit.coulomb_N[0], 2.0, 0.1);
}

TEST(MeasuredFriction, CannotTellViscousOrStribeckFrictionFromCoulombs) {
  // 4 to 16 mm/s: what the fit then finds is no friction
  const std::vector<std::vector<SlidingRow>> records = pulled_rows();
  const double plain_N = fit_friction(records, {false, {}}).rms_N;
  const FrictionFit viscous = fit_friction(records);
  EXPECT_LT(viscous.coulomb_N[0], 0.0);
  EXPECT_GT(viscous.rms_N, 0.9 * plain_N);
  for (const double v_s : {0.5e-3, 1e-3, 2e-3, 5e-3, 10e-3}) {
    const FrictionFit stribeck = fit_friction(records, {false, v_s});
    EXPECT_LT(stribeck.stribeck_N, 0.0) << "v_s = " << v_s << " m/s";
    EXPECT_GT(stribeck.rms_N, 0.9 * plain_N) << "v_s = " << v_s << " m/s";
  }
}

}  // namespace
}  // namespace plenum::host::identify::servo
