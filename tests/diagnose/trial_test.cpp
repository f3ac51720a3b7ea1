#include "host-sim/diagnose/trial.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plenum::host::diagnose {
namespace {

constexpr double kCorrelatedRows = 50.0;

/// Of 3000 rows fitted and as many held out, of which `judged` judge, with this mean square error.
Trial trial_of(std::size_t judged, double mean_square_Pa2) {
  Trial trial;
  trial.fit.rows = 3000;
  trial.heldout_rows = judged;
  trial.rows = 6000;
  trial.heldout_squares = mean_square_Pa2 * static_cast<double>(judged);
  trial.joint_squares = mean_square_Pa2 * static_cast<double>(3000 + judged);
  trial.variables = 8;
  return trial;
}

// Schwarz's criterion has no unit only between trials of as many rows: a null that wanders, judged by half of the rows held out, was
// preferred for the rows that it lacked.
TEST(Evidence, DependsOnTheErrorAndNotOnHowManyRowsJudge) {
  EXPECT_DOUBLE_EQ(trial_of(1500, 4e4).evidence(kCorrelatedRows),
                   trial_of(3000, 4e4).evidence(kCorrelatedRows));
  EXPECT_LT(trial_of(1500, 8e4).evidence(kCorrelatedRows), trial_of(3000, 4e4).evidence(kCorrelatedRows));
}

TEST(Evidence, DiffersByTheLogarithmOfTheErrorsForEachPieceWhateverTheUnit) {
  const double pieces = 6000.0 / kCorrelatedRows;
  for (const double unit : {1.0, 1e-6}) {
    EXPECT_NEAR(trial_of(3000, 1e4 * unit).evidence(kCorrelatedRows) -
                    trial_of(1500, 4e4 * unit).evidence(kCorrelatedRows),
                0.5 * pieces * std::log(4.0), 1e-9);
  }
}

}  // namespace
}  // namespace plenum::host::diagnose
