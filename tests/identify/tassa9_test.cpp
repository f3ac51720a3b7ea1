#include "host-sim/identify/tassa9.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

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

TEST(Tassa9, OfTheRepairedFormTheFlowDrivesAndTheMovingVolumeCompresses) {
  Tassa9 model = example();
  model.form = Form::repaired;
  model.c[kC4] = 0.0;
  const double u = 5.3, v = 120.0, p = 330.0;
  const SteadyAndRate at_rest = steady_and_rate(model, u, v, 0.0);
  for (const double w : {-800.0, -90.0, 25.0, 700.0}) {
    const SteadyAndRate moving = steady_and_rate(model, u, v, w);
    const double flow = (at_rest.steady_kPa - p) * at_rest.rate_per_s;
    const double compressed = -model.c[4] * w * p / (1.0 + model.c[5] * v);
    EXPECT_NEAR((moving.steady_kPa - p) * moving.rate_per_s, flow + compressed, 1e-9 * p) << "v' " << w;
  }
}

TEST(Tassa9, OfTheRepairedFormThePressureIsRegularWhereTheSteadyStateIsNot) {
  Tassa9 model = example();
  model.form = Form::repaired;
  const double u = 5.05, v = 120.0, p = 330.0;
  const SteadyAndRate rest = steady_and_rate(model, u, v, 0.0);
  const double sealing = -rest.rate_per_s * (1.0 + model.c[5] * v) / model.c[4];  // a + c5 v' = 0
  const Step at_pole = step(steady_and_rate(model, u, v, sealing), p, 0.01, 0.01);
  EXPECT_NEAR(at_pole.end_kPa, p + 0.01 * rest.rate_per_s * rest.steady_kPa, 1e-5) << "[kPa]";
  EXPECT_NEAR(at_pole.mean_kPa, p + 0.005 * rest.rate_per_s * rest.steady_kPa, 1e-5) << "[kPa]";
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

TEST(Tassa9, TheDeadTimeIsTheLastOfTheImageAndMayBeLeftOut) {
  Tassa9 model = example();
  model.dead_time_s = 0.02;
  std::vector<double> image = model.image();
  EXPECT_EQ(image.back(), 0.02);
  EXPECT_EQ(Tassa9::from_image(image).dead_time_s, 0.02);
  image.pop_back();
  EXPECT_EQ(Tassa9::from_image(image).dead_time_s, 0.0);
  image.pop_back();
  EXPECT_THROW(Tassa9::from_image(image), std::invalid_argument);
}

TEST(Tassa9, TheImageOfTheRepairedFormHasNoC4) {
  const std::vector<double> image = {5.1, 0.7, 1.3, 0.3, 0.4, 90.0, 0.2, 0.15, 0.1, 620.0, 101.325, 0.01};
  const Tassa9 model = Tassa9::from_image(image, Form::repaired);
  EXPECT_EQ(model.c[kC4], 0.0);
  EXPECT_EQ(model.c[4], 0.3);
  EXPECT_EQ(model.image(), image);
  EXPECT_EQ(form_of(kind_of(Form::repaired)), Form::repaired);
  EXPECT_THROW(form_of("greybox"), std::invalid_argument);
}

}  // namespace
}  // namespace plenum::host::identify
