#include "host-sim/diagnose/trial.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/identify/chamber/chamber_scene.hpp"

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

// The same rows, of which a null that wanders has some shown: whether they continue the fitted log or are another's.
TEST(Evidence, CountsAllRowsOfATrialWhoeverIsShownSomeOfThem) {
  const auto with_heldout = [](bool continues) {
    Scene scene = identify::chamber::chamber_scene(identify::chamber::jumping_V(1500), 30e-6);
    HeldOut held{.record = scene.records[0], .first = continues ? std::size_t{900} : std::size_t{1}};
    if (continues) {
      held.continues = 0;
      scene.records[0].fitted_rows = 900;
    }
    return split_of(scene, {held});
  };
  for (const bool continues : {false, true}) {
    const Split plain = with_heldout(continues);
    const Split shown = followed(plain);
    const effects::EffectSet null = bit(effects::kIdNullDrift);
    const Trial whole = tried(plain, fit(plain.fitted, 0, plain.fitted.nominal, {}, {.most_iterations = 2}));
    const Trial half = tried(
        shown, fit(shown.fitted, null, shown.fitted.nominal, {}, {.most_iterations = 2, .refined = null}));
    EXPECT_EQ(half.rows, whole.rows) << continues;
    EXPECT_LT(half.heldout_rows, whole.heldout_rows) << continues;
  }
}

}  // namespace
}  // namespace plenum::host::diagnose
