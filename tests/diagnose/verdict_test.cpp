// The table of host-sim/diagnose/README.md, row by row: pressures in units of a floor of 100 Pa.
#include "host-sim/diagnose/verdict.hpp"

#include <gtest/gtest.h>

namespace plenum::host::diagnose {
namespace {

constexpr double kFloor_Pa = 100.0;

GapErrors errors(double as_configured, double recalibrated, double with_effects) {
  return {.as_configured_Pa = as_configured * kFloor_Pa,
          .recalibrated_Pa = recalibrated * kFloor_Pa,
          .recalibrated_fitted_Pa = recalibrated * kFloor_Pa,
          .with_effects_Pa = with_effects * kFloor_Pa,
          .noise_floor_Pa = kFloor_Pa};
}

TEST(Verdict, NoneIsWithinTwelvePercentOfTheNoiseAsConfigured) {
  EXPECT_EQ(verdict_of(errors(1.11, 1.0, 1.0), Best::no_effect), Verdict::none);
  EXPECT_EQ(verdict_of(errors(1.06, 1.04, 0.84), Best::alone), Verdict::none)
      << "though an effect goes below it";
  EXPECT_EQ(verdict_of(errors(1.13, 1.0, 1.0), Best::no_effect), Verdict::calibration);
}

TEST(Verdict, AnEffectThatClosesTooLittleChangesNothing) {
  EXPECT_EQ(verdict_of(errors(1.11, 1.0, 0.7), Best::alone), Verdict::none);  // nothing was to close
  EXPECT_EQ(verdict_of(errors(50.0, 1.29, 1.2), Best::alone), Verdict::calibration);
}

TEST(Verdict, CalibrationIsNearTheNoiseWithoutAnEffect) {
  EXPECT_EQ(verdict_of(errors(50.0, 1.29, 1.29), Best::no_effect), Verdict::calibration);
  EXPECT_EQ(verdict_of(errors(50.0, 1.31, 1.31), Best::no_effect), Verdict::unexplained);
  GapErrors held_out = errors(50.0, 2.2, 2.2);  // what the fitted rows leave unknown of the figures
  held_out.recalibrated_fitted_Pa = 1.1 * kFloor_Pa;
  EXPECT_EQ(verdict_of(held_out, Best::no_effect), Verdict::calibration);
}

TEST(Verdict, UnexplainedIsAGapThatNoiseAndUnknownFiguresDoNotMake) {
  GapErrors left = errors(50.0, 2.4, 2.4);
  left.gap_p_value = 0.009;
  EXPECT_EQ(verdict_of(left, Best::no_effect), Verdict::unexplained);
  left.gap_p_value = 0.011;
  EXPECT_EQ(verdict_of(left, Best::no_effect), Verdict::calibration);
}

TEST(Verdict, NoEffectIsNamedWhereTheErrorIsLikelyWithoutAGap) {
  GapErrors unknown =
      errors(50.0, 30.0, 1.0);  // the fitted rows leave figures unknown, which the effect stands in for
  unknown.gap_p_value = 0.051;
  EXPECT_EQ(verdict_of(unknown, Best::alone), Verdict::calibration);
  EXPECT_EQ(verdict_of(unknown, Best::has_rivals), Verdict::calibration);
  unknown.gap_p_value = 0.049;
  EXPECT_EQ(verdict_of(unknown, Best::alone), Verdict::explained);
}

TEST(Verdict, ExplainedComesNearTheNoiseOrClosesNineTenthsAndLeavesLessThanTwiceTheNoise) {
  EXPECT_EQ(verdict_of(errors(50.0, 3.0, 1.29), Best::alone), Verdict::explained);
  EXPECT_EQ(verdict_of(errors(50.0, 21.0, 1.99), Best::alone), Verdict::explained);
  EXPECT_EQ(verdict_of(errors(50.0, 8.0, 1.75), Best::alone), Verdict::partly_explained);   // 89 % closed
  EXPECT_EQ(verdict_of(errors(50.0, 21.0, 2.01), Best::alone), Verdict::partly_explained);  // 95 % closed
}

TEST(Verdict, UnexplainedIsWhatNoEffectClosesByMoreThanAThird) {
  EXPECT_EQ(verdict_of(errors(50.0, 21.0, 13.9), Best::alone), Verdict::partly_explained);
  EXPECT_EQ(verdict_of(errors(50.0, 21.0, 14.1), Best::alone), Verdict::unexplained);
  EXPECT_EQ(verdict_of(errors(50.0, 21.0, 14.1), Best::has_rivals), Verdict::unexplained);
}

TEST(Verdict, RivalsAreAmbiguousOnlyWhereTheyCloseTheGap) {
  EXPECT_EQ(verdict_of(errors(50.0, 21.0, 1.9), Best::has_rivals), Verdict::ambiguous);
  EXPECT_EQ(verdict_of(errors(50.0, 21.0, 11.0), Best::has_rivals), Verdict::partly_explained);
}

TEST(ClosedFraction, IsOfWhatIsAboveTheFloorAndNothingWhereNothingIs) {
  EXPECT_DOUBLE_EQ(closed_fraction(errors(50.0, 21.0, 6.0)), 0.75);
  EXPECT_EQ(closed_fraction(errors(50.0, 21.0, 0.9)), 1.0);
  EXPECT_EQ(closed_fraction(errors(50.0, 21.0, 22.0)), 0.0);
  EXPECT_EQ(closed_fraction(errors(50.0, 0.99, 0.98)), 0.0);
}

}  // namespace
}  // namespace plenum::host::diagnose
