#include "host-sim/plant/converter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace plenum::host::plant {
namespace {

struct Measured {
  double mean = 0.0, deviation = 0.0;
};
template <class Draw>
Measured measure(int n, Draw draw) {
  double sum = 0.0, square = 0.0;
  for (int i = 0; i < n; ++i) {
    const double x = draw();
    sum += x;
    square += x * x;
  }
  const double mean = sum / n;
  return {mean, std::sqrt(std::max(square / n - mean * mean, 0.0))};
}

TEST(Random, IsTheSameOnEveryMachine) {
  // the reference algorithms of splitmix64 and xoshiro256++, computed apart with arbitrary-precision integers
  Random random(0);
  EXPECT_EQ(random.bits(), 0x53175d61490b23dfULL);
  EXPECT_EQ(random.bits(), 0x61da6f3dc380d507ULL);
  EXPECT_EQ(random.bits(), 0x5c0fdf91ec9a7bfcULL);
}

TEST(Random, GaussianHasUnitMoments) {
  Random random(7);
  double fourth = 0.0;
  const Measured m = measure(200000, [&] {
    const double x = random.gaussian();
    fourth += x * x * x * x / 200000.0;
    return x;
  });
  EXPECT_NEAR(m.mean, 0.0, 0.009);
  EXPECT_NEAR(m.deviation, 1.0, 0.007);
  EXPECT_NEAR(fourth, 3.0, 0.09);
}

TEST(Random, StreamsDifferAndDoNotDependOnWhatWasDrawn) {
  Random root(11);
  Random first = root.split(0);
  root.bits();
  EXPECT_EQ(root.split(0).bits(), first.bits());
  EXPECT_NE(Random(11).split(0).bits(), Random(11).split(1).bits());
  EXPECT_NE(Random(11).split(0).bits(), Random(12).split(0).bits());
}

TEST(AveragingAdc, HasTheMomentsOfBruteForceSampling) {
  for (const double sigma : {0.15, 0.3, 0.5, 1.0, 3.0}) {  // in steps
    for (const double offset : {0.0, 0.2, 0.45}) {         // of the input from a code, in steps
      const double q = 10.0 / 4096.0;
      const double input_V = q * (1000.0 + offset);
      AveragingAdc adc({0.0, 10.0, 12, sigma * q, 200}, Random(3));
      Random noise(5);
      const Measured got = measure(4000, [&] { return adc.read_V(input_V) / q; });
      const Measured brute = measure(4000, [&] {
        double sum = 0.0;
        for (int i = 0; i < 200; ++i) sum += std::round(1000.0 + offset + sigma * noise.gaussian());
        return sum / 200.0;
      });
      EXPECT_NEAR(got.mean, brute.mean, 0.004 + 0.09 * brute.deviation)
          << "sigma " << sigma << ", offset " << offset;
      EXPECT_NEAR(got.deviation, brute.deviation, 0.06 * brute.deviation + 1e-9)
          << "sigma " << sigma << ", offset " << offset;
    }
  }
}

TEST(AveragingAdc, WithoutNoiseRoundsToTheNearestCodeEveryTime) {
  AveragingAdc adc({-10.0, 10.0, 16, 0.0, 200}, Random(1));
  const double q = 20.0 / 65536.0;
  EXPECT_DOUBLE_EQ(adc.read_V(q * 12.4), q * 12.0);
  EXPECT_DOUBLE_EQ(adc.read_V(q * 12.6), q * 13.0);
}

TEST(AveragingAdc, ClipsToItsCodes) {
  AveragingAdc adc({0.0, 10.0, 16, 1e-3, 200}, Random(1));
  EXPECT_EQ(adc.read_V(-5.0), 0.0);
  EXPECT_DOUBLE_EQ(adc.read_V(50.0), 10.0 - adc.step_V());
  EXPECT_THROW(AveragingAdc({0.0, 0.0, 16, 0.0, 200}, Random(1)), std::invalid_argument);
}

TEST(Dac, RoundsHoldsAndClips) {
  Dac dac(12);
  const double q = 10.0 / 4095.0;
  EXPECT_DOUBLE_EQ(dac.write_V(5.0), q * 2048.0);
  EXPECT_DOUBLE_EQ(dac.output_V(), q * 2048.0);
  EXPECT_DOUBLE_EQ(dac.write_V(std::numeric_limits<double>::quiet_NaN()), q * 2048.0);
  EXPECT_DOUBLE_EQ(dac.write_V(12.0), 10.0);
  EXPECT_EQ(dac.write_V(-1.0), 0.0);
}

}  // namespace
}  // namespace plenum::host::plant
