#include "host-sim/effects/lanes.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

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

Lanes<0> lanes_of(const std::vector<double>& values, std::size_t first) {
  Lanes<0> lanes;
  for (std::size_t i = 0; i < kLanes; ++i) set_lane(lanes, static_cast<int>(i), values[first + i]);
  return lanes;
}

TEST(Exponential, OfALaneIsThatOfItsNumber) {
  const std::vector<double> z = arguments();
  for (std::size_t first = 0; first + kLanes <= z.size(); first += kLanes) {
    const Lanes<0> lanes = lanes_of(z, first);
    const Exponential<Lanes<0>> eight = exponential(lanes);
    for (int i = 0; i < kLanes; ++i) {
      const Exponential<double> one = exponential(lane(lanes, i));
      EXPECT_DOUBLE_EQ(lane(eight.e, i), one.e);
      EXPECT_DOUBLE_EQ(lane(eight.phi_1, i), one.phi_1);
      EXPECT_DOUBLE_EQ(lane(eight.phi_2, i), one.phi_2);
    }
  }
}

TEST(WrightOmega, SolvesItsEquationFromNothingToABillion) {
  std::vector<double> x;
  for (double at = -24.0; at < 30.0; at += 0.07) x.push_back(at);
  for (double at = 30.0; at < 1e9; at *= 1.3) x.push_back(at);
  for (std::size_t first = 0; first + kLanes <= x.size(); first += kLanes) {
    const Lanes<0> eight = wright_omega(lanes_of(x, first));
    for (int i = 0; i < kLanes; ++i) {
      const double at = x[first + static_cast<std::size_t>(i)];
      for (const double y : {lane(eight, i), wright_omega(at)}) {
        // an error of y by a share e leaves (1 + y) e of the equation
        EXPECT_NEAR(y + std::log(y), at, 1e-9 * (1.0 + y)) << "x = " << at;
      }
    }
  }
  EXPECT_EQ(wright_omega(-24.001), 0.0);
}

TEST(Logarithm, AgreesWithTheLibraryOverAllNormalNumbers) {
  std::vector<double> x{1.0,
                        0.5,
                        2.0,
                        std::sqrt(0.5),
                        std::sqrt(2.0),
                        std::numeric_limits<double>::min(),
                        std::numeric_limits<double>::max(),
                        1.0 - 1e-16};
  for (double up = 1.0; up < 1e300; up *= 1.13) {
    x.push_back(up);
    x.push_back(1.0 / up);
  }
  for (std::size_t first = 0; first + kLanes <= x.size(); first += kLanes) {
    const Lanes<0> ours = logarithm(lanes_of(x, first));
    for (std::size_t i = 0; i < kLanes; ++i) {
      const double is = std::log(x[first + i]);
      EXPECT_NEAR(lane(ours, static_cast<int>(i)), is, 2e-10 * (1.0 + std::abs(is))) << "of " << x[first + i];
    }
  }
}

TEST(Power, AgreesWithTheLibraryUpToE7) {
  std::vector<double> x;
  for (double up = 1.0; up <= 1e6; up *= 1.1) {
    x.push_back(up);
    x.push_back(1.0 / up);
  }
  for (const double a : {-1.0, -0.6, 0.0, 0.35, 0.5, 1.0, 1.3, 2.0}) {
    for (std::size_t first = 0; first + kLanes <= x.size(); first += kLanes) {
      const Lanes<0> eight = power(lanes_of(x, first), Lanes<0>(a));
      for (std::size_t i = 0; i < kLanes; ++i) {
        const double base = x[first + i], z = a * std::log(base);
        if (z > 7.0) continue;
        const double is = z < -24.0 ? 0.0 : std::pow(base, a);
        EXPECT_NEAR(power(base, a), is, 2e-7 * is + 4e-11) << base << "^" << a;
        EXPECT_NEAR(lane(eight, static_cast<int>(i)), is, 2e-7 * is + 4e-11) << base << "^" << a;
      }
    }
  }
}

TEST(Lanes, EachTakesItsOwnBranch) {
  Lanes<0> a, b;
  for (int i = 0; i < kLanes; ++i) {
    set_lane(a, i, i - 3.0);
    set_lane(b, i, 0.5);
  }
  EXPECT_TRUE(any(a < b));
  EXPECT_FALSE(any(a < Lanes<0>(-3.0)));
  EXPECT_TRUE(any(a < Lanes<0>(-2.9))) << "of one lane alone";
  EXPECT_TRUE(any(a > Lanes<0>(3.9))) << "the last";
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
