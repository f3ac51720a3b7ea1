#include "host-sim/identify/tassa9.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace plenum::host::identify {
namespace {

Tassa9 example() {
  Tassa9 model;
  model.c = {5.1, 0.7, 1.3, -0.05, 0.3, 0.4, 90.0, 0.2, 0.15};
  model.supply_kPa = 620.0;
  return model;
}

TEST(Tassa9, AtTheNullAndAtRestItIsTheMiddlePressureAndTheLeak) {
  const Tassa9 model = example();
  const SteadyAndRate at = steady_and_rate(model, 5.1, 100.0, 0.0);
  EXPECT_DOUBLE_EQ(at.steady_kPa, (620.0 + 101.325) / 2) << "[kPa]";
  EXPECT_DOUBLE_EQ(at.rate_per_s, 90.0 * 0.15 / (1.0 + 0.4 * 100.0)) << "[1/s]";
}

TEST(Tassa9, FarFromTheNullTheSteadyPressureIsSupplyOrAmbient) {
  Tassa9 model = example();
  model.c[2] = 100.0;
  EXPECT_NEAR(steady_and_rate(model, 10.0, 100.0, 0.0).steady_kPa, 620.0, 1e-3) << "[kPa]";
  EXPECT_NEAR(steady_and_rate(model, 0.0, 100.0, 0.0).steady_kPa, 101.325, 1e-3) << "[kPa]";
}

TEST(Tassa9, DerivativesByParameterMatchCentralDifferences) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int trial = 0; trial < 200; ++trial) {
    Tassa9 model = example();
    for (double& c : model.c) c *= 1.0 + 0.3 * unit(random);
    const double u = 5.0 + 2.0 * unit(random), v = 150.0 + 100.0 * unit(random), w = 300.0 * unit(random);
    const SteadyAndRateByParameter d = by_parameter(model, u, v, w);
    for (std::size_t i = 0; i < kFree; ++i) {
      const double step = 1e-6 * std::max(0.1, std::abs(model.c[i]));
      Tassa9 up = model, down = model;
      up.c[i] += step;
      down.c[i] -= step;
      const SteadyAndRate a = steady_and_rate(up, u, v, w), b = steady_and_rate(down, u, v, w);
      EXPECT_NEAR(d.steady[i], (a.steady_kPa - b.steady_kPa) / (2 * step), 1e-5 * (1 + std::abs(d.steady[i])))
          << "c" << i + 1;
      EXPECT_NEAR(d.rate[i], (a.rate_per_s - b.rate_per_s) / (2 * step), 1e-5 * (1 + std::abs(d.rate[i])))
          << "c" << i + 1;
    }
  }
}

TEST(Tassa9, TheTickMeanIsTheIntegralOfTheExactSolution) {
  for (const double r : {-30.0, -1e-9, 0.0, 1e-6, 5.0, 400.0}) {
    for (const double a : {0.0, 0.004, 0.01}) {
      const SteadyAndRate at{300.0, r};
      const auto p = [&](double t) { return 300.0 + (450.0 - 300.0) * std::exp(-r * t); };
      const Step got = step(at, 450.0, 0.01, a);
      EXPECT_NEAR(got.end_kPa, p(0.01), 1e-10) << "r " << r;
      // Simpson's rule over the last a of the tick.
      double integral = p(0.01 - a) + p(0.01);
      constexpr int kPanels = 200;
      for (int i = 1; i < kPanels; ++i) integral += (i % 2 == 1 ? 4.0 : 2.0) * p(0.01 - a + a * i / kPanels);
      EXPECT_NEAR(got.mean_kPa, integral / (3.0 * kPanels), 1e-7) << "r " << r << " [1/s], a " << a << " [s]";
    }
  }
}

TEST(Tassa9, EndFromMeanUndoesStep) {
  for (const double r : {-20.0, 0.0, 3.0, 90.0}) {
    const Step got = step({250.0, r}, 480.0, 0.01, 0.01);
    EXPECT_NEAR(end_from_mean({250.0, r}, got.mean_kPa, 0.01, 0.01), got.end_kPa, 1e-10)
        << "r " << r << " [1/s]";
  }
}

TEST(Tassa9, TheImageIsInTheOrderOfTheBus) {
  const auto image = example().image();
  EXPECT_EQ(image[0], 5.1);
  EXPECT_EQ(image[8], 0.15);
  EXPECT_EQ(image[9], 0.1);
  EXPECT_EQ(image[10], 620.0);
  EXPECT_EQ(image[11], 101.325);
  EXPECT_EQ(Tassa9::from_image(image).image(), image);
}

}  // namespace
}  // namespace plenum::host::identify
