#include "host-sim/identify/regulator_valve/fit_measure.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify::regulator_valve {
namespace {

TEST(FitMeasure, Is100WhereTheyAgreeAnd0AtTheMean) {
  EXPECT_EQ(fit_percent({1.0, 2.0, 3.0}, {1.0, 2.0, 3.0}), 100.0);
  EXPECT_EQ(fit_percent({1.0, 2.0, 3.0}, {2.0, 2.0, 2.0}), 0.0);
}

TEST(FitMeasure, IsWorkedByHand) {
  // |y^ - y| = sqrt(0.25 + 0.25) = 0.7071, |y - 2| = sqrt 2
  EXPECT_NEAR(fit_percent({1.0, 2.0, 3.0}, {1.5, 2.0, 2.5}), 50.0, 1e-12);
}

TEST(FitMeasure, DoesNotDependOnTheUnitNorTheOrigin) {
  const double plain = fit_percent({1.0, 4.0, 2.0}, {1.2, 3.5, 2.2});
  EXPECT_NEAR(fit_percent({1010.0, 1040.0, 1020.0}, {1012.0, 1035.0, 1022.0}), plain, 1e-10);
}

TEST(FitMeasure, CannotTellOfAMeasurementThatNeverChanges) {
  EXPECT_THROW(fit_percent({2.0, 2.0}, {2.0, 1.0}), CannotIdentify);
  // the mean of three is not 0.1 to the last bit
  EXPECT_THROW(fit_percent({0.1, 0.1, 0.1}, {0.1, 0.2, 0.1}), CannotIdentify);
}

TEST(FitMeasure, RefusesUnequalOrNoLengths) {
  EXPECT_THROW(fit_percent({2.0, 1.0}, {2.0}), std::invalid_argument);
  EXPECT_THROW(fit_percent({}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace plenum::host::identify::regulator_valve
