#include "host-sim/identify/regulator_valve/piecewise.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/identify/regulator_valve/made_branch.hpp"

namespace plenum::host::identify::regulator_valve {
namespace {

// Rising p = 1.5e8 (x - 0.9 mm), falling p = 1.5e8 x.
PiecewiseModel known() {
  return {.rising = {made::known_model(), 1.9e-3, 1.5e5},
          .falling = {made::known_model(), 1.0e-3, 1.5e5},
          .dead_band_m = 0.9e-3};
}

std::vector<double> held(std::initializer_list<double> positions_m) {
  std::vector<double> screw_m;
  for (const double x : positions_m) screw_m.insert(screw_m.end(), 600, x);
  return screw_m;
}

TEST(Piecewise, SettlesOnTheRisingLineThenStaysThenOnTheFallingLine) {
  const std::vector<double> p =
      predict(known(), held({1.5e-3, 2.1e-3, 1.25e-3, 0.8e-3, 1.65e-3, 2.0e-3}), 0.9e5);
  EXPECT_NEAR(p[599], 0.9e5, 1.0);                                          // at rest on the rising line
  EXPECT_NEAR(p[1199], 1.5e8 * 1.2e-3, 1.0);                                // rising
  for (std::size_t k = 1200; k < 1800; ++k) EXPECT_EQ(p[k], p[1200]) << k;  // 0.85 mm back: within the band
  EXPECT_NEAR(p[2399], 1.5e8 * 0.8e-3, 1.0);                                // falling
  for (std::size_t k = 2400; k < 3000; ++k) EXPECT_EQ(p[k], p[2400]) << k;  // 0.85 mm up again: within
  EXPECT_NEAR(p[3599], 1.5e8 * 1.1e-3, 1.0);                                // rising
}

TEST(Piecewise, StopsWhereItIsWhenTheScrewTurnsIntoTheBand) {
  std::vector<double> screw_m = held({1.5e-3, 2.1e-3});
  screw_m.resize(610);
  screw_m.insert(screw_m.end(), 300, 2.0e-3);  // 10 samples after the step up
  const std::vector<double> p = predict(known(), screw_m, 0.9e5);
  EXPECT_GT(p[611], 0.95e5);
  EXPECT_LT(p[611], 1.5e5);
  for (std::size_t k = 611; k < p.size(); ++k) EXPECT_EQ(p[k], p[610]) << k;
}

TEST(Piecewise, AFallAcrossTheWholeBandIsRunByTheFallingModelFromThePressureThatWas) {
  for (const double band_m : {0.9e-3, 0.0}) {
    PiecewiseModel model = known();
    model.dead_band_m = band_m;
    model.falling.model.a = {-1.2, 0.1, 0.15};
    std::vector<double> screw_m(10, 2.1e-3);  // still rising fast when the screw goes down
    screw_m.resize(200, 0.7e-3);
    const std::vector<double> p = predict(model, screw_m, 0.9e5);
    std::vector<double> deviation(190, 0.7e-3 - 1.0e-3);
    deviation.insert(deviation.begin(), 3, 0.0);
    deviation[2] = 0.7e-3 - 1.0e-3;
    const std::vector<double> run =
        free_run(model.falling.model, deviation, std::vector<double>(193, p[10] - 1.5e5));
    ASSERT_GT(p[10], 1.0e5);
    for (std::size_t k = 10; k < 200; ++k) ASSERT_NEAR(p[k], run[k - 8] + 1.5e5, 1e-6) << k << ", " << band_m;
  }
}

TEST(Piecewise, WithoutADeadBandAndOneModelItIsThatModel) {
  PiecewiseModel model = known();
  model.dead_band_m = 0.0;
  model.falling = model.rising;
  std::vector<double> screw_m = held({1.5e-3, 2.1e-3});
  const std::vector<double> p = predict(model, screw_m, 0.9e5);
  for (double& x : screw_m) x -= 1.9e-3;
  std::vector<double> past(screw_m.size(), 0.9e5 - 1.5e5);
  const std::vector<double> run = free_run(made::known_model(), screw_m, past);
  for (std::size_t k = 3; k < p.size(); ++k) EXPECT_NEAR(p[k], run[k] + 1.5e5, 1e-6) << k;
}

TEST(Piecewise, RefusesADeadBandBelowZero) {
  PiecewiseModel model = known();
  model.dead_band_m = -1e-3;
  EXPECT_THROW(predict(model, {0.0}, 0.0), std::invalid_argument);
  EXPECT_TRUE(predict(known(), {}, 0.0).empty());
}

}  // namespace
}  // namespace plenum::host::identify::regulator_valve
