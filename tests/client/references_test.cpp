#include "host-sim/client/references.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace plenum::host::client {
namespace {

constexpr double kSpan_Pa = 600e3;

/// Of a chamber that follows to the letter.
Tracking tracking_of(const ReferenceShape& shape) {
  const std::vector<double> reference_Pa = references(shape, 1, 2.0).front();
  std::vector<CapturedRow> rows(reference_Pa.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    rows[k].reference_Pa[0] = reference_Pa[k];
    rows[k].sample[0].actual_Pa = reference_Pa[k];
  }
  return tracking(rows, 0, kSpan_Pa);
}

TEST(Tracking, OvershootAndSettlingAreOfStepsAndNotOfAFastSine) {
  const Tracking steps = tracking_of({.kind = ReferenceKind::steps, .amplitude_Pa = 200e3});
  EXPECT_EQ(steps.overshoot_Pa, 0.0);
  EXPECT_EQ(steps.settling_s, 0.0);
  // at 4 Hz a row is up to 50 kPa from the one before
  const Tracking sine =
      tracking_of({.kind = ReferenceKind::sine, .amplitude_Pa = 200e3, .frequency_Hz = 4.0});
  EXPECT_TRUE(std::isnan(sine.overshoot_Pa));
  EXPECT_TRUE(std::isnan(sine.settling_s));
}

}  // namespace
}  // namespace plenum::host::client
