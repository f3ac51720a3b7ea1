#include "host-sim/effects/lanes.hpp"

#include <gtest/gtest.h>

namespace plenum::host::effects {
namespace {

// In long double, which has three digits more: (e^z - 1)/z, and its series where that cancels.
struct Reference {
  long double e, phi_1, phi_2;
};
Reference reference(double at) {
  const auto z = static_cast<long double>(at);
  if (std::abs(at) < 0.5) {
    long double phi_2 = 0.0L;
    for (int k = 25; k >= 0; --k)
      phi_2 = phi_2 * z / (k + 3.0L) + 1.0L;  // nested: 1/2 (1 + z/3 (1 + z/4 (...
    phi_2 *= 0.5L;
    const long double phi_1 = 1.0L + z * phi_2;
    return {1.0L + z * phi_1, phi_1, phi_2};
  }
  const long double phi_1 = std::expm1(z) / z;
  return {std::exp(z), phi_1, (phi_1 - 1.0L) / z};
}

std::vector<double> arguments() {
  std::vector<double> z{0.0, -24.0, -23.999999, -24.000001, -32.0, -1e4};
  for (double far = 1e-12; far <= 1e4; far *= 1.07) z.push_back(-far);
  for (double far = 1e-12; far <= 2.0; far *= 1.07) z.push_back(far);
  z.push_back(2.0);
  return z;
}

TEST(Exponential, AgreesWithTheLibraryFromFarBelowZeroToTwo) {
  for (const double z : arguments()) {
    const Exponential<double> ours = exponential(z);
    const Reference is = reference(z);
    EXPECT_NEAR(ours.e, static_cast<double>(is.e), 1e-10 * std::max(1.0, static_cast<double>(is.e)))
        << "z = " << z;
    EXPECT_NEAR(ours.phi_1 / static_cast<double>(is.phi_1), 1.0, 1e-10) << "z = " << z;
    EXPECT_NEAR(ours.phi_2 / static_cast<double>(is.phi_2), 1.0, 1e-10) << "z = " << z;
  }
}

TEST(Exponential, OfALaneIsThatOfItsNumber) {
  const std::vector<double> z = arguments();
  for (std::size_t first = 0; first + kLanes <= z.size(); first += kLanes) {
    Lanes<0> lanes;
    for (int i = 0; i < kLanes; ++i) set_lane(lanes, i, z[first + static_cast<std::size_t>(i)]);
    const Exponential<Lanes<0>> eight = exponential(lanes);
    for (int i = 0; i < kLanes; ++i) {
      const Exponential<double> one = exponential(lane(lanes, i));
      EXPECT_DOUBLE_EQ(lane(eight.e, i), one.e);
      EXPECT_DOUBLE_EQ(lane(eight.phi_1, i), one.phi_1);
      EXPECT_DOUBLE_EQ(lane(eight.phi_2, i), one.phi_2);
    }
  }
}

TEST(Power, AgreesWithTheLibraryOverFourHundredfold) {
  for (double x = 0.05; x <= 20.0; x *= 1.1) {
    for (const double a : {-0.6, 0.0, 0.35, 0.5, 1.0, 1.3}) {
      EXPECT_NEAR(power(x, a) / std::pow(x, a), 1.0, 1e-7) << x << "^" << a;
    }
  }
}

TEST(Lanes, EachTakesItsOwnBranch) {
  Lanes<0> a, b;
  for (int i = 0; i < kLanes; ++i) {
    set_lane(a, i, i - 3.0);
    set_lane(b, i, 0.5);
  }
  const Lanes<0> chosen = select(a < b, a, 10.0 * b);
  for (int i = 0; i < kLanes; ++i) {
    const double x = i - 3.0;
    EXPECT_EQ(lane(chosen, i), x < 0.5 ? x : 5.0);
    EXPECT_EQ(lane(larger(a, b), i), std::max(x, 0.5));
    EXPECT_EQ(lane(smaller(a, b), i), std::min(x, 0.5));
    EXPECT_EQ(lane(magnitude(a), i), std::abs(x));
    EXPECT_EQ(lane(root(magnitude(a)), i), std::sqrt(std::abs(x)));
  }
}

}  // namespace
}  // namespace plenum::host::effects
