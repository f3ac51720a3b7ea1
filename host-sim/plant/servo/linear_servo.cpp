#include "host-sim/plant/servo/linear_servo.hpp"
#include "host-sim/plant/root_between.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace plenum::host::plant::servo {
namespace {

// The pressure at which a chamber neither fills nor empties.
double rest_pressure_Pa(const ServoCylinderConfig& config, const ValvePair& valves, int chamber,
                        double command_V) {
  return root_between(
      [&](double pressure_Pa) { return net_flow_kg_s(config, valves, chamber, command_V, pressure_Pa); },
      std::min(config.ambient_Pa, config.supply_Pa), std::max(config.ambient_Pa, config.supply_Pa));
}

OperatingPoint at_command(const ServoCylinderConfig& config, const ValvePair& valves, double position_m,
                          double command_V) {
  const Commands commands = five_three_commands_V(command_V);
  return {position_m, command_V, rest_pressure_Pa(config, valves, 0, commands[0]),
          rest_pressure_Pa(config, valves, 1, commands[1])};
}

CylinderVector state_of(const ServoCylinderConfig& config, const OperatingPoint& point) {
  ServoCylinderConfig at = config;
  at.initial_position_m = point.position_m;
  at.initial_pressure_1_Pa = point.pressure_1_Pa;
  at.initial_pressure_2_Pa = point.pressure_2_Pa;
  return initial_state(at);
}

using Polynomial = Eigen::VectorXd;  // coefficients of s^0, s^1, ..

Polynomial product(const Polynomial& a, const Polynomial& b) {
  Polynomial c = Polynomial::Zero(a.size() + b.size() - 1);
  for (Eigen::Index i = 0; i < a.size(); ++i) c.segment(i, b.size()) += a[i] * b;
  return c;
}

// Q_1 and Q_2 of (26)-(28)
std::array<Polynomial, 2> chamber_polynomials(const LinearServo& servo) {
  const double gRT = servo.gamma * servo.gas_constant_J_kg_K * servo.temperature_K;
  return {Eigen::Vector2d(gRT * servo.flow_pressure_1_kg_s_Pa, servo.volume_1_m3),
          Eigen::Vector2d(gRT * servo.flow_pressure_2_kg_s_Pa, servo.volume_2_m3)};
}

std::complex<double> value(const Polynomial& p, std::complex<double> s) {
  std::complex<double> sum = 0.0;
  for (Eigen::Index i = p.size(); i-- > 0;) sum = sum * s + p[i];
  return sum;
}

}  // namespace

OperatingPoint operating_point(const ServoCylinderConfig& config, const ValvePair& valves,
                               double position_m) {
  validate(config);
  const auto force_N = [&](double command_V) {
    return driving_force_N(config, state_of(config, at_command(config, valves, position_m, command_V)));
  };
  constexpr double kHighest_V = 10.0;
  if (force_N(0.0) > 0.0 || force_N(kHighest_V) < 0.0)
    throw std::invalid_argument("operating point: no command from 0 to 10 V holds the piston at rest");
  return at_command(config, valves, position_m, root_between(force_N, 0.0, kHighest_V));
}

LinearServo linearise(const ServoCylinderConfig& config, const ValvePair& valves, const OperatingPoint& point,
                      double gamma) {
  validate(config);
  const Commands commands = five_three_commands_V(point.command_V);
  const std::array<double, 2> pressure{point.pressure_1_Pa, point.pressure_2_Pa};
  std::array<double, 2> gain{};
  std::array<double, 2> leak{};
  for (std::size_t j = 0; j < 2; ++j) {
    const int chamber = static_cast<int>(j);
    const double du = 1e-4;
    gain[j] = (net_flow_kg_s(config, valves, chamber, commands[j] + du, pressure[j]) -
               net_flow_kg_s(config, valves, chamber, commands[j] - du, pressure[j])) /
              (2.0 * du);
    leak[j] = std::visit(
        [&](const auto& pair) {
          const PortFlows flows =
              pair[j].flows(pair[j].opening(commands[j]), pressure[j], config.supply_Pa, config.ambient_Pa);
          return flows.exhaust_slope_kg_s_Pa - flows.inlet_slope_kg_s_Pa;
        },
        valves);
  }
  LinearServo servo;
  servo.gamma = gamma;
  servo.gas_constant_J_kg_K = config.gas.specific_gas_constant_J_kg_K();
  servo.temperature_K = config.gas.temperature_K;
  servo.area_1_m2 = config.piston_area_1_m2;
  servo.area_2_m2 = config.piston_area_2_m2;
  servo.flow_gain_1_kg_s_V = gain[0];
  servo.flow_gain_2_kg_s_V = gain[1];  // port 2 sees the mirrored command: -C_f2 of (24)
  servo.flow_pressure_1_kg_s_Pa = leak[0];
  servo.flow_pressure_2_kg_s_Pa = leak[1];
  servo.volume_1_m3 = volume_of(config, 0, point.position_m, 0.0).volume_m3;
  servo.volume_2_m3 = volume_of(config, 1, point.position_m, 0.0).volume_m3;
  servo.pressure_1_Pa = point.pressure_1_Pa;
  servo.pressure_2_Pa = point.pressure_2_Pa;
  servo.mass_kg = config.moving_mass_kg;
  servo.viscous_N_s_m = config.friction.viscous_N_s_m;
  if (config.spool) {
    servo.valve_time_constant_s =
        2.0 * config.spool->damping_ratio / (2.0 * std::numbers::pi * config.spool->natural_frequency_Hz);
  }
  return servo;
}

Eigen::Matrix<double, 5, 1> characteristic_polynomial(const LinearServo& servo) {
  const auto [Q1, Q2] = chamber_polynomials(servo);
  const Eigen::Vector3d motion(0.0, servo.viscous_N_s_m, servo.mass_kg);  // s (M s + F)
  Polynomial D = product(motion, product(Q1, Q2));
  const double A1 = servo.area_1_m2;
  const double A2 = servo.area_2_m2;
  D.segment(1, 2) += servo.gamma * (A1 * A1 * servo.pressure_1_Pa * Q2 + A2 * A2 * servo.pressure_2_Pa * Q1);
  return D;
}

std::complex<double> command_response(const LinearServo& servo, std::complex<double> s) {
  const auto [Q1, Q2] = chamber_polynomials(servo);
  const double gRT = servo.gamma * servo.gas_constant_J_kg_K * servo.temperature_K;
  const Polynomial flow =
      servo.area_1_m2 * servo.flow_gain_1_kg_s_V * Q2 + servo.area_2_m2 * servo.flow_gain_2_kg_s_V * Q1;
  return gRT * servo.valve_gain * value(flow, s) /
         ((servo.valve_time_constant_s * s + 1.0) * value(characteristic_polynomial(servo), s));
}

std::complex<double> force_response(const LinearServo& servo, std::complex<double> s) {
  const auto [Q1, Q2] = chamber_polynomials(servo);
  return value(Q1, s) * value(Q2, s) / value(characteristic_polynomial(servo), s);
}

Eigen::Vector4cd poles(const LinearServo& servo) {
  const auto D = characteristic_polynomial(servo);
  Eigen::Matrix4d companion = Eigen::Matrix4d::Zero();
  companion.bottomLeftCorner<3, 3>().setIdentity();
  companion.col(3) = -D.head<4>() / D[4];
  Eigen::Vector4cd roots = companion.eigenvalues();
  std::sort(roots.data(), roots.data() + 4, [](const auto& a, const auto& b) {
    return a.real() != b.real() ? a.real() < b.real() : a.imag() < b.imag();
  });
  return roots;
}

PrintedDenominator as_printed(const LinearServo& servo, double alpha, std::complex<double> s) {
  const double gRT = servo.gamma * servo.gas_constant_J_kg_K * servo.temperature_K;
  const double A = servo.area_1_m2;
  const double Cp1 = servo.flow_pressure_1_kg_s_Pa;
  const double Cp2 = servo.flow_pressure_2_kg_s_Pa;
  return {s * (servo.mass_kg * s + servo.viscous_N_s_m) * (gRT * Cp1 + servo.volume_1_m3) *
              (gRT * Cp2 + servo.volume_2_m3 * s),
          alpha * servo.gamma * A * A * A * s *
              (gRT * (servo.pressure_1_Pa * Cp2 + servo.pressure_2_Pa * Cp1) +
               (servo.pressure_1_Pa * servo.volume_2_m3 + servo.pressure_2_Pa * servo.volume_1_m3) * s)};
}

NumericalLinearisation linearise_numerically(const ServoCylinderConfig& config, const ValvePair& valves,
                                             const OperatingPoint& point) {
  validate(config);
  const CylinderVector rest = state_of(config, point);
  const auto rates = [&](const CylinderVector& y, double command_V, double force_N) {
    ServoCylinderConfig pushed = config;
    pushed.external_force_N = config.external_force_N + force_N;
    return sliding_rates(pushed, valves, five_three_commands_V(command_V), 0.0, y);
  };
  CylinderVector step;  // small against what the flow and the volumes bend over, large against rounding
  step << 1e-6, 1e-4, 1.0, 1e-6 * rest[kMass1], 1.0, 1e-6 * rest[kMass2];
  NumericalLinearisation result;
  for (Eigen::Index i = 0; i < 6; ++i) {
    CylinderVector up = rest;
    CylinderVector down = rest;
    up[i] += step[i];
    down[i] -= step[i];
    result.by_state.col(i) =
        (rates(up, point.command_V, 0.0) - rates(down, point.command_V, 0.0)) / (2.0 * step[i]);
  }
  const double du = 1e-4;
  result.by_command_V =
      (rates(rest, point.command_V + du, 0.0) - rates(rest, point.command_V - du, 0.0)) / (2.0 * du);
  const double dF = 1.0;
  result.by_force_N = (rates(rest, point.command_V, dF) - rates(rest, point.command_V, -dF)) / (2.0 * dF);
  return result;
}

}  // namespace plenum::host::plant::servo
