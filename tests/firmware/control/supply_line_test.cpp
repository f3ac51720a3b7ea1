// The supply's line against its own equation in closed form.
#include "firmware/control/supply_line.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/firmware/scalars.hpp"

namespace plenum::control {
namespace {

constexpr double kSupply_kPa = 700.0;
constexpr double kResistance_s_L = 0.5;

SupplyLine line_of(double recovery_ticks, double followed_share = 0.0, double part_ticks = 0.4) {
  SupplyLine line;
  line.configure({.supply_kPa = Scalar(kSupply_kPa),
                  .resistance_s_L = Scalar(kResistance_s_L),
                  .recovery_ticks = static_cast<Scalar>(recovery_ticks),
                  .followed_share = static_cast<Scalar>(followed_share)},
                 static_cast<Scalar>(part_ticks));
  return line;
}

TEST(SupplyLine, IsTheModelsWhileNothingIsDrawnOrMeasured) {
  SupplyLine line = line_of(5.0);
  EXPECT_EQ(line.supply(), Scalar(1));
  line.pass(line.tick(), Scalar(0));
  EXPECT_EQ(line.supply(), Scalar(1));
}

TEST(SupplyLine, OfAModelThatSaysNothingOfItDoesNotDroop) {
  SupplyLine line;
  line.configure({.supply_kPa = Scalar(kSupply_kPa)}, Scalar(0.3));
  EXPECT_FALSE(line.droops());
  line.measured(Scalar(400));
  EXPECT_EQ(line.supply(), Scalar(1)) << "and heeds no sensor";
}

TEST(SupplyLine, DroopsByItsResistanceAndRecoversAsAnExponential) {
  constexpr double kFlow_kPa_L_s = 140.0;  // a droop of 70 kPa, a tenth
  for (const double recovery_ticks : {0.5, 2.0, 30.0, 300.0}) {
    SupplyLine line = line_of(recovery_ticks);
    double droop = 0.0;
    for (int k = 0; k < 40; ++k) {
      const double flow_kPa_L_s = k < 20 ? kFlow_kPa_L_s : 0.0;
      const double steady = kResistance_s_L / kSupply_kPa * flow_kPa_L_s;
      for (const double ticks : {1.0, 0.4}) {
        const SupplyLine::While& span = ticks < 1.0 ? line.part() : line.tick();
        const double left = std::exp(-ticks / recovery_ticks);
        const double mean = steady + (droop - steady) * (1.0 - left) * recovery_ticks / ticks;
        EXPECT_NEAR(real(line.mean(span, static_cast<Scalar>(flow_kPa_L_s))), 1.0 - mean, 2e-6);
        line.pass(span, static_cast<Scalar>(flow_kPa_L_s));
        droop = steady + (droop - steady) * left;
        EXPECT_NEAR(real(line.supply()), 1.0 - droop, 2e-6) << "tick " << k << ", " << recovery_ticks;
      }
    }
  }
}

/// A port that lets c (S - 1/2)^(1/2) through into a chamber of half the supply's pressure, and out of it what moves nothing.
class Root final : public PressureModel {
 public:
  explicit Root(double c) : c_(c) {}
  Opening opening(Scalar) const noexcept override { return {}; }
  Moving moving(const ChamberMotion& motion) const noexcept override { return {.first = motion.supply}; }
  Prediction step(Scalar pressure_kPa, const Opening&, const Moving&, Scalar) const noexcept override {
    return {.end_kPa = pressure_kPa, .mean_kPa = pressure_kPa};
  }
  Inverse inverse(Scalar, Scalar, const Moving&, Scalar) const noexcept override { return {}; }
  Draw draw(Scalar, const Opening&, const Moving& moves) const noexcept override {
    const double over = std::max(real(moves.first) - 0.5, 1e-8);
    return {static_cast<Scalar>(c_ * std::sqrt(over)), static_cast<Scalar>(0.5 * c_ / std::sqrt(over))};
  }

 private:
  double c_;
};

/// [1] By halving, of a chamber of 350 kPa behind a root: m = c (S - 1/2)^(1/2).
double halved(double by_flow) {
  double low = 0.5, high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (middle - 1.0 + by_flow * std::sqrt(middle - 0.5) > 0.0 ? high : low) = middle;
  }
  return low;
}

TEST(SupplyLine, FindsTheFlowThatItsOwnDroopLeaves) {
  for (const double recovery_ticks : {0.0, 1.0, 20.0}) {
    for (const double c : {10.0, 1e3, 1e5}) {
      const SupplyLine line = line_of(recovery_ticks);
      const double w = recovery_ticks > 0.0 ? 1.0 + std::expm1(-1.0 / recovery_ticks) * recovery_ticks : 1.0;
      const Scalar got = line.mean(line.tick(), Root(c), Scalar(0.5 * kSupply_kPa), {}, {});
      EXPECT_NEAR(real(got), halved(w * kResistance_s_L / kSupply_kPa * c), 0x1p-13)
          << c << " kPa L/s, " << recovery_ticks << " ticks";
    }
  }
}

TEST(SupplyLine, FollowsWhatIsMeasuredByItsShare) {
  SupplyLine line = line_of(5.0, 0.8);
  line.measured(Scalar(560));  // a fifth less
  EXPECT_NEAR(real(line.supply()), 1.0 - 0.8 * 0.2, 1e-6);
  line.reset();
  EXPECT_NEAR(real(line.supply()), 0.84, 1e-6) << "what is measured does not end with a droop";
  line.measured(Scalar(1e9));
  EXPECT_NEAR(real(line.supply()), 1.4, 1e-6) << "no supply is off by more than a half";
  line.measured(Scalar(1e-6));
  EXPECT_NEAR(real(line.supply()), 0.6, 1e-6);
}

TEST(SupplyLine, StaysBoundedWhateverIsDrawn) {
  SupplyLine line = line_of(0.0);
  for (const double flow_kPa_L_s : {1e9, -1e9}) {
    line.pass(line.tick(), static_cast<Scalar>(flow_kPa_L_s));
    EXPECT_LE(std::abs(real(line.supply()) - 1.0), 0.8 + 1e-6);
  }
}

}  // namespace
}  // namespace plenum::control
