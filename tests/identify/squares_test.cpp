#include "host-sim/identify/squares.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "host-sim/identify/cannot_identify.hpp"
#include "tests/identify/chamber_of_record.hpp"

namespace plenum::host::identify {
namespace {

TEST(Ticks, VolumeAndItsRateAtMidTickAreExactForACubicEvenAtTheEnds) {
  const auto cubic = [](double t) { return 100.0 + 40.0 * t - 300.0 * t * t + 900.0 * t * t * t; };
  const auto slope = [](double t) { return 40.0 - 600.0 * t + 2700.0 * t * t; };
  Recording recording;
  recording.volume_mL = cubic;
  recording.rows = 30;
  const Ticks ticks = lay_out({record(recording)});
  for (std::size_t k = 0; k < 29; ++k) {
    const double middle_s = 0.01 * (static_cast<double>(k) + 0.5);
    EXPECT_NEAR(ticks.volume_mL[k], cubic(middle_s), 1e-9) << "[mL], row " << k;
    EXPECT_NEAR(ticks.volume_rate_mL_s[k], slope(middle_s), 1e-7) << "[mL/s], row " << k;
  }
}

TEST(Ticks, ACommandActsByItsSharesWhenTheValveIsLate) {
  trace::Log log = record({});
  const auto sent = [&](std::size_t row) { return log.command_V[row]; };
  const Ticks prompt = lay_out({log});
  EXPECT_EQ(prompt.command_V, log.command_V);
  const Ticks late = lay_out({log, log}, 0.0225);
  const std::size_t second = late.begin[1];
  for (const std::size_t first : {std::size_t{0}, second}) {
    EXPECT_EQ(late.command_V[first], sent(0)) << "as before the log";
    for (std::size_t k = 3; k < log.size(); ++k) {
      ASSERT_EQ(late.early_V[first + k], sent(k - 3)) << "row " << k;
      ASSERT_EQ(late.late_V[first + k], sent(k - 2)) << "row " << k;
      ASSERT_NEAR(late.command_V[first + k], 0.25 * sent(k - 3) + 0.75 * sent(k - 2), 1e-12) << "row " << k;
    }
  }
}

// 0.29/0.01 is a little below 29: no part of a tick is left to act in.
TEST(Ticks, WholeTicksAreWholeWhateverTheirRounding) {
  const trace::Log log = record({});
  for (int ticks = 0; ticks <= 40; ++ticks) {
    const Ticks late = lay_out({log}, ticks / 100.0);
    ASSERT_EQ(late.early, 0.0) << ticks << " ticks";
    ASSERT_EQ(late.command_V[50], log.command_V[50 - static_cast<std::size_t>(ticks)]) << ticks << " ticks";
  }
}

TEST(Ticks, RefusesLogsThatDoNotGoTogether) {
  trace::Log log = record({});
  EXPECT_THROW(lay_out({}), CannotIdentify);
  trace::Log other = log;
  other.period_s = 0.02;
  EXPECT_THROW(lay_out({log, other}), CannotIdentify);
  other = log;
  other.pressure_average_s = 0.0;
  EXPECT_THROW(lay_out({log, other}), CannotIdentify);
  other = log;
  other.pressure_average_s = 0.03;
  EXPECT_THROW(lay_out({other}), CannotIdentify);
  other = log;
  for (const double slow : {3e-4, 9e-3}) {
    other.period_s = log.period_s * (1.0 + slow);
    EXPECT_EQ(lay_out({log, other}).period_s, log.period_s) << "a recorder's clock that is slow by " << slow;
  }
  other.period_s = 1.02 * log.period_s;
  EXPECT_THAT(
      [&] {
        lay_out({log, other});
      },
      testing::ThrowsMessage<CannotIdentify>(
          testing::AllOf(testing::HasSubstr("within 1 %"), testing::HasSubstr("resample"))));
  Recording brief;
  brief.rows = kFewestRows - 1;
  EXPECT_THROW(lay_out({record(brief)}), CannotIdentify);
}

struct Case {
  double average_s;
  Form form;
};

/// A bench on two logs of odd lengths, so that blocks, stretches and log ends all fall differently.
class Squares : public testing::TestWithParam<Case> {
 protected:
  Squares() {
    Recording recording;
    recording.volume_mL = moving_volume_mL;
    recording.noise_kPa = 2.0;
    recording.rows = 613;
    const trace::Log first = record(recording);
    recording.rows = 331;
    recording.seed = 2;
    ticks_ = lay_out({first, record(recording)});
    ticks_.average_s = GetParam().average_s;
    bench_.ticks = &ticks_;
    bench_.mean_volume_mL = 120.0;
    bench_.supply_kPa = 620.0;
    bench_.ambient_kPa = 101.325;
    bench_.stretch = 97;
    bench_.form = GetParam().form;
    Tassa9 model;
    model.c = {5.1, 0.7, 1.3, -0.05, 0.3, 0.4, 400.0, 0.2, 0.15};
    if (!has_parameter(bench_.form, kC4)) model.c[kC4] = 0.0;
    shape_ = to_shape(model, bench_.mean_volume_mL);
  }

  SteadyAndRate at(const Shape& q, std::size_t row) const {
    return steady_and_rate(to_model(q, bench_), ticks_.command_V[row], ticks_.volume_mL[row],
                           ticks_.volume_rate_mL_s[row]);
  }

  /// One-step errors, spelled out tick by tick with the functions of tassa9.hpp.
  Eigen::VectorXd one_step_errors(const Shape& q) const {
    std::vector<double> errors;
    for (std::size_t log = 0; log + 1 < ticks_.begin.size(); ++log) {
      for (std::size_t i = ticks_.begin[log] + 1; i + 1 < ticks_.begin[log + 1]; ++i) {
        const double start = end_from_mean(at(q, i - 1), ticks_.pressure_kPa[i], 0.01, ticks_.average_s);
        errors.push_back(step(at(q, i), start, 0.01, ticks_.average_s).mean_kPa - ticks_.pressure_kPa[i + 1]);
      }
    }
    return Eigen::Map<Eigen::VectorXd>(errors.data(), static_cast<Eigen::Index>(errors.size()));
  }

  /// Free-run errors, the start pressure of each stretch by a linear least-squares solver.
  Eigen::VectorXd free_run_errors(const Shape& q) const {
    std::vector<double> errors;
    for (std::size_t log = 0; log + 1 < ticks_.begin.size(); ++log) {
      const std::size_t last = ticks_.begin[log + 1] - 1;
      for (std::size_t first = ticks_.begin[log]; first < last; first += bench_.stretch) {
        const std::size_t n = std::min(bench_.stretch, last - first);
        const auto run = [&](double p) {
          Eigen::VectorXd y(static_cast<Eigen::Index>(n));
          for (std::size_t k = 0; k < n; ++k) {
            const Step next = step(at(q, first + k), p, 0.01, ticks_.average_s);
            y[static_cast<Eigen::Index>(k)] = next.mean_kPa - ticks_.pressure_kPa[first + k + 1];
            p = next.end_kPa;
          }
          return y;
        };
        const Eigen::VectorXd at_zero = run(0.0);
        const Eigen::VectorXd by_start = run(1.0) - at_zero;
        const Eigen::VectorXd left = at_zero + by_start * by_start.colPivHouseholderQr().solve(-at_zero)[0];
        errors.insert(errors.end(), left.begin(), left.end());
      }
    }
    return Eigen::Map<Eigen::VectorXd>(errors.data(), static_cast<Eigen::Index>(errors.size()));
  }

  Shape moved(Eigen::Index i, double by) const {
    Shape q = shape_;
    q[i] += by;
    return q;
  }

  Ticks ticks_;
  Bench bench_;
  Shape shape_;
};

TEST_P(Squares, OneStepGramMatchesTheErrorsSpelledOutAndTheirDifferences) {
  const Eigen::VectorXd errors = one_step_errors(shape_);
  EXPECT_EQ(count_rows(Error::one_step, bench_).rows, static_cast<std::size_t>(errors.size()));
  Eigen::MatrixXd full(errors.size(), static_cast<Eigen::Index>(kFree) + 1);
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(kFree); ++i) {
    const double h = 1e-6 * std::max(0.1, std::abs(shape_[i]));
    full.col(i) = (one_step_errors(moved(i, h)) - one_step_errors(moved(i, -h))) / (2 * h);
  }
  full.col(kFree) = errors;
  const Gram expected = full.transpose() * full;
  const Gram got = gram(Error::one_step, shape_, bench_);
  for (Eigen::Index i = 0; i < expected.rows(); ++i) {
    for (Eigen::Index j = 0; j < expected.cols(); ++j) {
      EXPECT_NEAR(got(i, j), expected(i, j), 1e-5 * std::sqrt(expected(i, i) * expected(j, j)))
          << i << " " << j;
    }
  }
  EXPECT_NEAR(sum_of_squares(Error::one_step, shape_, bench_), errors.squaredNorm(),
              1e-9 * errors.squaredNorm());
}

TEST_P(Squares, FreeRunSumMatchesTheErrorsSpelledOutAndItsGradientTheirDifferences) {
  const double squares = free_run_errors(shape_).squaredNorm();
  EXPECT_NEAR(sum_of_squares(Error::free_run, shape_, bench_), squares, 1e-9 * squares) << "[kPa^2]";
  const Gram got = gram(Error::free_run, shape_, bench_);
  EXPECT_NEAR(got(kFree, kFree), squares, 1e-9 * squares) << "[kPa^2]";
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(kFree); ++i) {
    const double h = 1e-5 * std::max(0.1, std::abs(shape_[i]));
    const double slope =
        (free_run_errors(moved(i, h)).squaredNorm() - free_run_errors(moved(i, -h)).squaredNorm()) / (2 * h);
    EXPECT_NEAR(2.0 * got(i, kFree), slope, 1e-5 * std::sqrt(got(i, i) * squares)) << "shape parameter " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(AveragingTimesAndForms, Squares,
                         testing::Values(Case{0.0, Form::published}, Case{0.006, Form::published},
                                         Case{0.01, Form::published}, Case{0.0, Form::repaired},
                                         Case{0.006, Form::repaired}, Case{0.01, Form::repaired}));

TEST(Shape, IsTheModelAndItsSlopeMatchesDifferences) {
  Recording recording;
  Bench bench;
  bench.mean_volume_mL = 120.0;
  Tassa9 model;
  model.c = recording.c;
  const Shape q = to_shape(model, 120.0);
  const Tassa9 back = to_model(q, bench);
  const auto slope = model_by_shape(q, 120.0);
  for (Eigen::Index j = 0; j < static_cast<Eigen::Index>(kFree); ++j) {
    const auto k = static_cast<std::size_t>(j);
    EXPECT_NEAR(back.c[k], model.c[k], 1e-9 * std::abs(model.c[k])) << "c" << j + 1;
    const double h = 1e-7;
    Shape up = q, down = q;
    up[j] += h;
    down[j] -= h;
    for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(kFree); ++i) {
      const double difference = (to_model(up, bench).c[static_cast<std::size_t>(i)] -
                                 to_model(down, bench).c[static_cast<std::size_t>(i)]) /
                                (2 * h);
      EXPECT_NEAR(slope(i, j), difference, 1e-4 * (1.0 + std::abs(difference)))
          << "c" << i + 1 << " by " << j;
    }
  }
}

}  // namespace
}  // namespace plenum::host::identify
