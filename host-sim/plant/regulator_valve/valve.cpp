#include "host-sim/plant/regulator_valve/valve.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "host-sim/plant/refuse.hpp"
#include "host-sim/plant/runge_kutta.hpp"

namespace plenum::host::plant::regulator_valve {
namespace {

constexpr double kStepOfMechanics = 0.1;  // longest step over the fastest time constant
constexpr double kStepOfVolume = 0.5;     // the same where both sides of a port are at one pressure
constexpr int kBisections = 40;           // of a step: 2^-40 = 1e-12

ThinPlate nozzle_of(const ValveConfig& config) {
  validate(config);
  return ThinPlate(thin_plate_constants(config.gas, 1.0));
}

// The port of the volume stands for a displacement of one millimetre, more than a turn of the knob gives it.
double longest_step_s(const ValveConfig& c) {
  const double mechanics_1_s = std::max(
      {c.plunger_damping_N_s_m / c.plunger_mass_kg, c.spool_damping_N_s_m / c.spool_mass_kg,
       std::sqrt(c.plunger_spring_N_m / c.plunger_mass_kg), std::sqrt(c.spool_spring_N_m / c.spool_mass_kg)});
  const double port_m2 = std::max(c.inlet_width_m, c.exhaust_width_m) * 1e-3;
  const double slope_s_m = nozzle_of(c).flux(c.supply_Pa, c.supply_Pa).by_first;
  const double volume_1_s = gamma_R_T_J_kg(c.gas) / c.volume_m3 * port_m2 * slope_s_m;
  return std::min(kStepOfMechanics / mechanics_1_s, kStepOfVolume / volume_1_s);
}

}  // namespace

Ports::Ports(const ValveConfig& config)
    : nozzle_(nozzle_of(config)),
      supply_Pa_(config.supply_Pa),
      ambient_Pa_(config.ambient_Pa),
      inlet_width_m_(config.inlet_width_m),
      exhaust_width_m_(config.exhaust_width_m),
      overlap_m_(overlap_m(config)) {}

double Ports::inlet_kg_s(double plunger_m, double pressure_Pa) const {
  const double open_m = plunger_m - overlap_m_;
  return open_m > 0.0 ? inlet_width_m_ * open_m * nozzle_.phi(supply_Pa_, pressure_Pa) : 0.0;
}

double Ports::exhaust_kg_s(double plunger_m, double pressure_Pa) const {
  return plunger_m < 0.0 ? exhaust_width_m_ * -plunger_m * nozzle_.phi(pressure_Pa, ambient_Pa_) : 0.0;
}

double plunger_at_rest_m(const ValveConfig& config, double screw_m, double pressure_Pa) {
  const double force_N =
      config.plunger_spring_N_m * screw_m + config.diaphragm_area_m2 * (config.ambient_Pa - pressure_Pa);
  const double spring_N_m = config.plunger_spring_N_m + (force_N >= 0.0 ? config.spool_spring_N_m : 0.0);
  return force_N / spring_N_m;
}

Valve::Valve(const ValveConfig& config, double screw_m, double pressure_Pa)
    : config_(config),
      ports_(config),
      filling_Pa_kg_(gamma_R_T_J_kg(config.gas) / config.volume_m3),
      longest_step_s_(longest_step_s(config)),
      screw_m_(screw_m) {
  require_finite("regulator valve screw_m", screw_m);
  require_within("regulator valve pressure_Pa", pressure_Pa, config.ambient_Pa, config.supply_Pa);
  state_.pressure_Pa = pressure_Pa;
  state_.plunger_m = plunger_at_rest_m(config, screw_m, pressure_Pa);
  joined_ = state_.plunger_m >= 0.0;
}

Valve::Vector Valve::slope(const Vector& y, double screw_m) const {
  const auto [x, v, p, supplied, vented] = y;
  const double mass = config_.plunger_mass_kg + (joined_ ? config_.spool_mass_kg : 0.0);
  const double damping = config_.plunger_damping_N_s_m + (joined_ ? config_.spool_damping_N_s_m : 0.0);
  const double spring = config_.plunger_spring_N_m + (joined_ ? config_.spool_spring_N_m : 0.0);
  const double force = -damping * v - spring * x + config_.diaphragm_area_m2 * (config_.ambient_Pa - p) +
                       config_.plunger_spring_N_m * screw_m;
  const double q_m = ports_.inlet_kg_s(x, p);
  const double q_e = ports_.exhaust_kg_s(x, p);
  return {v, force / mass, filling_Pa_kg_ * (q_m - q_e), q_m, q_e};
}

Valve::Vector Valve::stepped(const Vector& y, const Turn& turn, double t_s, double h_s) const {
  return runge_kutta_step(
      t_s, y, h_s, [&](double t, const Vector& at) { return slope(at, turn.from_m + turn.rate_m_s * t); });
}

void Valve::meet_or_part(Vector& y) {
  joined_ = !joined_;
  y[0] = 0.0;
  if (joined_) y[1] *= config_.plunger_mass_kg / (config_.plunger_mass_kg + config_.spool_mass_kg);
}

void Valve::advance(double screw_m, double duration_s) {
  require_finite("regulator valve screw_m", screw_m);
  require_above("regulator valve duration_s", duration_s, 0.0);
  const Turn turn{screw_m_, (screw_m - screw_m_) / duration_s};
  const auto crosses = [this](const Vector& y) { return joined_ ? y[0] < 0.0 : y[0] > 0.0; };
  const double steps = std::ceil(duration_s / longest_step_s_);
  const double longest_s = duration_s / steps;
  Vector y{state_.plunger_m, state_.plunger_m_s, state_.pressure_Pa, state_.supplied_kg, state_.vented_kg};
  double t_s = 0.0;
  while (duration_s - t_s > 1e-12 * duration_s) {
    double h_s = std::min(longest_s, duration_s - t_s);
    Vector next = stepped(y, turn, t_s, h_s);
    if (crosses(next)) {
      double low_s = 0.0;
      for (int i = 0; i < kBisections; ++i) {
        const double middle_s = 0.5 * (low_s + h_s);
        (crosses(stepped(y, turn, t_s, middle_s)) ? h_s : low_s) = middle_s;
      }
      next = stepped(y, turn, t_s, h_s);
      meet_or_part(next);
    }
    y = next;
    t_s += h_s;
  }
  screw_m_ = screw_m;
  state_ = {y[0], y[1], y[2], y[3], y[4]};
}

}  // namespace plenum::host::plant::regulator_valve
