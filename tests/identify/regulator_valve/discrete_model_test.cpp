#include "host-sim/identify/regulator_valve/discrete_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace plenum::host::identify::regulator_valve {
namespace {

using plant::regulator_valve::ThirdOrder;

const ThirdOrder kSlow{
    .gain_Pa_m_s3 = 3.6e12, .square_1_s = 210.0, .linear_1_s2 = 4000.0, .constant_1_s3 = 24000.0};

// Forward Euler on the three states of (28) is what (32) abbreviates.
TEST(RegulatorValveDiscretisation, IsForwardEulerOnTheContinuousModelWithTwoSamplesLess) {
  const double t = 0.002;
  const DiscreteModel model = discretise(kSlow, t);
  double p = 0.0;
  double dp = 0.0;
  double ddp = 0.0;
  std::vector<double> euler{0.0};
  const double x_p = 0.25e-3;
  for (int k = 0; k < 1000; ++k) {
    const double dddp =
        kSlow.gain_Pa_m_s3 * x_p - kSlow.square_1_s * ddp - kSlow.linear_1_s2 * dp - kSlow.constant_1_s3 * p;
    p += t * dp;
    dp += t * ddp;
    ddp += t * dddp;
    euler.push_back(p);
  }
  const std::vector<double> run =
      free_run(model, std::vector<double>(1001, x_p), std::vector<double>(1001, 0.0));
  // free_run() answers at k = 3 to the screw at 2; Euler's third sample is the first that moves
  for (std::size_t k = 3; k < 1001; ++k) ASSERT_NEAR(run[k], euler[k], 1e-6) << k;
}

TEST(RegulatorValveDiscretisation, ReadingBackUndoesIt) {
  const ThirdOrder back = read_back(discretise(kSlow, 0.005));
  EXPECT_NEAR(back.gain_Pa_m_s3 / kSlow.gain_Pa_m_s3, 1.0, 1e-12);
  EXPECT_NEAR(back.square_1_s, 210.0, 1e-9);
  EXPECT_NEAR(back.linear_1_s2, 4000.0, 1e-6);
  EXPECT_NEAR(back.constant_1_s3, 24000.0, 1e-4);
}

TEST(RegulatorValveDiscretisation, MapsEveryPoleToOnePlusItsPartOfTheSample) {
  const double t = 0.005;
  const auto continuous = poles(kSlow);
  const auto discrete = poles(discretise(kSlow, t));
  for (const auto& s : continuous) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& z : discrete) nearest = std::min(nearest, std::abs(z - (1.0 + s * t)));
    EXPECT_LT(nearest, 1e-9) << s;
  }
}

TEST(RegulatorValveDiscretisation, AStableModelMayBecomeUnstable) {
  const ThirdOrder fast{
      .gain_Pa_m_s3 = 1e12, .square_1_s = 704.0, .linear_1_s2 = 155772.0, .constant_1_s3 = 6400.0};
  EXPECT_TRUE(stable(fast));
  EXPECT_FALSE(stable(discretise(fast, 0.005)));
  EXPECT_TRUE(stable(discretise(fast, 0.001)));
}

TEST(RegulatorValveDiscretisation, KeepsTheStaticGain) {
  EXPECT_NEAR(discretise(kSlow, 0.005).static_gain_Pa_m(), kSlow.static_gain_Pa_m(), 1e-3);
}

TEST(RegulatorValveDiscretisation, SlowestTimeConstantIsThatOfAKnownPole) {
  // (z - 0.95)(z - 0.8)(z + 0.3)
  const DiscreteModel model{.b_Pa_m = 1.0, .a = {-1.45, 0.235, 0.228}, .sample_s = 0.005};
  EXPECT_NEAR(slowest_time_constant_s(model), -0.005 / std::log(0.95), 1e-9);
  // (s + 10)(s + 20)(s + 180)
  EXPECT_NEAR(slowest_time_constant_s(ThirdOrder{1.0, 210.0, 5600.0, 36000.0}), 0.1, 1e-9);
  EXPECT_TRUE(std::isinf(slowest_time_constant_s(DiscreteModel{.b_Pa_m = 1.0, .a = {-2.5, 1.0, 0.0}})));
}

TEST(RegulatorValveDiscretisation, RefusesBadInput) {
  EXPECT_THROW(discretise(kSlow, 0.0), std::invalid_argument);
  EXPECT_THROW(read_back({.sample_s = -1.0}), std::invalid_argument);
  EXPECT_THROW(free_run({}, {0.0, 0.0}, {0.0, 0.0}), std::invalid_argument);
  EXPECT_THROW(free_run({}, {0.0, 0.0, 0.0}, {0.0, 0.0}), std::invalid_argument);
}

}  // namespace
}  // namespace plenum::host::identify::regulator_valve
