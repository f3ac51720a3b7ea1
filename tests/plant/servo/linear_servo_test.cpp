#include "host-sim/plant/servo/linear_servo.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace plenum::host::plant::servo {
namespace {

using Complex = std::complex<double>;

ValvePair valves() {
  const ThinPlateValve valve(ThinPlateValveConfig{});
  return std::array<ThinPlateValve, 2>{valve, valve};
}

// Viscous friction alone, and the gas at constant temperature in its flow term, as (24)-(28) assume.
ServoCylinderConfig smooth(double gamma) {
  ServoCylinderConfig config;
  config.friction = {0.0, 0.0, 0.01, 80.0};
  config.law = MixedExponents{gamma, gamma, gamma};
  return config;
}

// x, xdot, P_1, P_2: without the masses, which nothing depends on at constant temperature
Eigen::Matrix4d four_states(const Eigen::Matrix<double, 6, 6>& full) {
  const std::array<Eigen::Index, 4> kept{kPosition, kVelocity, kPressure1, kPressure2};
  Eigen::Matrix4d small;
  for (Eigen::Index i = 0; i < 4; ++i)
    for (Eigen::Index j = 0; j < 4; ++j)
      small(i, j) = full(kept[static_cast<std::size_t>(i)], kept[static_cast<std::size_t>(j)]);
  return small;
}

TEST(LinearServo, OperatingPointIsAtRest) {
  for (const double x : {-0.06, 0.0, 0.08}) {
    const ServoCylinderConfig config = smooth(1.4);
    const OperatingPoint point = operating_point(config, valves(), x);
    ServoCylinderConfig at = config;
    at.initial_position_m = x;
    at.initial_pressure_1_Pa = point.pressure_1_Pa;
    at.initial_pressure_2_Pa = point.pressure_2_Pa;
    const CylinderVector rates =
        sliding_rates(at, valves(), five_three_commands_V(point.command_V), 0.0, initial_state(at));
    EXPECT_NEAR(rates[kVelocity], 0.0, 1e-6);
    EXPECT_NEAR(rates[kPressure1], 0.0, 1e-2);
    EXPECT_NEAR(rates[kPressure2], 0.0, 1e-2);
  }
}

TEST(LinearServo, PolesAreTheEigenvaluesOfTheNonlinearModelsJacobian) {
  for (const double gamma : {1.0, 1.4}) {
    for (const double x : {-0.06, 0.0, 0.08}) {
      const ServoCylinderConfig config = smooth(gamma);
      const OperatingPoint point = operating_point(config, valves(), x);
      const Eigen::Vector4cd ours = poles(linearise(config, valves(), point, gamma));
      Eigen::Vector4cd numerical =
          four_states(linearise_numerically(config, valves(), point).by_state).eigenvalues();
      std::sort(numerical.data(), numerical.data() + 4, [](const auto& a, const auto& b) {
        return std::abs(a.real() - b.real()) > 1e-3 ? a.real() < b.real() : a.imag() < b.imag();
      });
      const double largest = ours.cwiseAbs().maxCoeff();
      for (Eigen::Index i = 0; i < 4; ++i)
        EXPECT_NEAR(std::abs(ours[i] - numerical[i]), 0.0, 1e-5 * largest)
            << "gamma " << gamma << ", x = " << x << " m, pole " << i << ": " << ours[i] << " against "
            << numerical[i];
    }
  }
}

TEST(LinearServo, FrequencyResponseIsThatOfTheNonlinearModelsJacobian) {
  const ServoCylinderConfig config = smooth(1.4);
  const OperatingPoint point = operating_point(config, valves(), 0.03);
  const LinearServo servo = linearise(config, valves(), point, 1.4);
  const NumericalLinearisation numerical = linearise_numerically(config, valves(), point);
  for (double f = 0.01; f < 100.0; f *= 1.3) {
    const Complex s(0.0, 2.0 * std::numbers::pi * f);
    const Eigen::Matrix<Complex, 6, 6> resolvent =
        s * Eigen::Matrix<Complex, 6, 6>::Identity() - numerical.by_state.cast<Complex>();
    const Complex G = resolvent.partialPivLu().solve(numerical.by_command_V.cast<Complex>())[kPosition];
    const Complex G_d = -resolvent.partialPivLu().solve(numerical.by_force_N.cast<Complex>())[kPosition];
    EXPECT_NEAR(std::abs(command_response(servo, s) / G - 1.0), 0.0, 1e-4) << "f = " << f << " Hz";
    EXPECT_NEAR(std::abs(force_response(servo, s) / G_d - 1.0), 0.0, 1e-4) << "f = " << f << " Hz";
  }
}

TEST(LinearServo, WithoutLeaksAnEqualCylinderHasTheClosedFormResonance) {
  // C_p = 0: D = s^2 V^2 [M s^2 + F s + 2 gamma A^2 P / V]
  LinearServo servo;
  servo.area_1_m2 = servo.area_2_m2 = 7e-4;
  servo.volume_1_m3 = servo.volume_2_m3 = 9e-5;
  servo.pressure_1_Pa = servo.pressure_2_Pa = 4e5;
  servo.mass_kg = 5.0;
  servo.viscous_N_s_m = 80.0;
  const double omega2 = 2.0 * 1.4 * 7e-4 * 7e-4 * 4e5 / 9e-5 / 5.0;
  const auto D = characteristic_polynomial(servo);
  EXPECT_NEAR(D[0], 0.0, 1e-30);
  EXPECT_NEAR(D[1], 0.0, 1e-30);
  EXPECT_NEAR(D[2] / D[4], omega2, 1e-9 * omega2);
  EXPECT_NEAR(D[3] / D[4], 80.0 / 5.0, 1e-9);
}

TEST(LinearServo, SaysWhenNoCommandHoldsTheLoad) {
  ServoCylinderConfig config = smooth(1.4);
  config.external_force_N = 1e5;
  try {
    operating_point(config, valves(), 0.0);
    FAIL() << "a load beyond the supply was accepted";
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("no command"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace plenum::host::plant::servo
