#include "host-sim/plant/regulator_valve/linear_model.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <complex>

#include "host-sim/plant/regulator_valve/valve.hpp"

namespace plenum::host::plant::regulator_valve {
namespace {

// Unit step response of c / (s^3 + ...) by residues.
class StepResponse {
 public:
  explicit StepResponse(const ThirdOrder& c) : gain_(c.gain_Pa_m_s3), static_gain_(c.static_gain_Pa_m()) {
    Eigen::Matrix3d companion;
    companion << -c.square_1_s, -c.linear_1_s2, -c.constant_1_s3, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0;
    poles_ = companion.eigenvalues();
  }
  double operator()(double t_s) const {
    std::complex<double> sum = static_gain_;
    for (int i = 0; i < 3; ++i) {
      std::complex<double> denominator = poles_[i];
      for (int j = 0; j < 3; ++j)
        if (j != i) denominator *= poles_[i] - poles_[j];
      sum += gain_ / denominator * std::exp(poles_[i] * t_s);
    }
    return sum.real();
  }

 private:
  double gain_;
  double static_gain_;
  Eigen::Vector3cd poles_;
};

TEST(RegulatorValveLinearModel, StaticGainIsThatOfTheSpringOverTheDiaphragm) {
  const ValveConfig c = bench_valve();
  EXPECT_NEAR(linear_pressurisation(c).static_gain_Pa_m(), 1.56e8, 1e-3);
  EXPECT_NEAR(linear_exhaustion(c, 2.5e5).static_gain_Pa_m(), 1.56e8, 1e-3);
}

TEST(RegulatorValveLinearModel, BlockedRangeIsThatOfEq10) {
  const BlockedRange range = blocked_range(bench_valve());
  // printed with the ratio rounded to 0.528, which is 5e-4 off
  EXPECT_NEAR(range.low_Pa, 1e5 / 0.528, 6e-4 * range.low_Pa);
  EXPECT_NEAR(range.high_Pa, 8e5 * 0.528, 6e-4 * range.high_Pa);
  EXPECT_NEAR(range.low_Pa * range.high_Pa, 1e5 * 8e5, 1e-3);
}

// In the blocked range pressurisation is linear, so the plant has a closed form while the inlet is open.
TEST(RegulatorValveLinearModel, PressurisationOfThePlantIsTheClosedForm) {
  const ValveConfig config = bench_valve();
  const StepResponse step(linear_pressurisation(config));
  Valve valve(config, 1.15e-3 + 0.9e-3, 1e5 + 1.56e8 * 1.15e-3);  // at rest, the inlet about to open
  const double start = valve.state().pressure_Pa;
  valve.advance(valve.screw_m() + 0.25e-3, 1e-9);
  for (int k = 1; k <= 400; ++k) {
    valve.advance(valve.screw_m(), 0.005);
    EXPECT_NEAR(valve.state().pressure_Pa - start, 0.25e-3 * step(0.005 * k), 0.05) << k * 5 << " ms";
  }
}

// Exhaustion is linearised: what is left out goes with the square of the step.
TEST(RegulatorValveLinearModel, ExhaustionOfThePlantTendsToTheLinearModelWithTheSquareOfTheStep) {
  const ValveConfig config = bench_valve();
  const double rest = 3e5;
  const StepResponse step(linear_exhaustion(config, rest));
  const auto worst = [&](double step_m) {
    Valve valve(config, (rest - 1e5) / 1.56e8, rest);
    valve.advance(valve.screw_m() - step_m, 1e-9);
    double error = 0.0;
    for (int k = 1; k <= 400; ++k) {
      valve.advance(valve.screw_m(), 0.005);
      error = std::max(error, std::abs(valve.state().pressure_Pa - rest + step_m * step(0.005 * k)));
    }
    return error;
  };
  const double at_10um = worst(10e-6);
  const double at_20um = worst(20e-6);
  EXPECT_LT(at_10um, 0.01 * 1.56e8 * 10e-6);
  EXPECT_NEAR(at_20um / at_10um, 4.0, 0.1);
}

}  // namespace
}  // namespace plenum::host::plant::regulator_valve
