#include "host-sim/blind/truth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "host-sim/blind/true_volume.hpp"

namespace plenum::host::blind {
namespace {

constexpr double kTau = 2.0 * std::numbers::pi;
constexpr double kSettle_s = 0.5;
constexpr double kViscosity_Pa_s = 1.82e-5;  // of air at 20 degC
/// Lag of the LuGre spool's spring against its damping: short against a tick, long against a step.
constexpr double kLuGreLag_s = 1e-4;
constexpr double kLuGreSpeed_V_s = 5.0;

constexpr std::size_t kMostStates = 48;
using State = std::array<double, kMostStates>;
constexpr std::size_t kAbsent = kMostStates;
/// Of the wall's temperature, and its inverse: the gas in a chamber is not hotter, not colder. The flow of (4) takes away more or
/// less than the gas's own enthalpy, so that behind a wall that hardly conducts the mass could come to nothing in minutes.
constexpr double kHottest = 4.0;

/// Flow per area over the upstream pressure's share: the constants of (1c).
struct Gas {
  double alpha;  // (11), C = 1
  double beta;   // (12), C = 1
  double ratio;  // 1/theta of (13)
};

Gas gas_at(double temperature_K) {
  const double rt = kGasConstant_J_kg_K * temperature_K;
  return {std::sqrt(2.0 / rt * kKappa / (kKappa - 1.0)),
          std::sqrt(kKappa / rt * std::pow(2.0 / (kKappa + 1.0), (kKappa + 1.0) / (kKappa - 1.0))),
          std::pow(2.0 / (kKappa + 1.0), kKappa / (kKappa - 1.0))};
}

/// z of (1c), upstream >= downstream. sqrt(r^(2/k) - r^((k+1)/k)) = r^(1/k) sqrt(1 - r^((k-1)/k)).
double thin_plate(const Gas& gas, double up_Pa, double down_Pa) {
  const double r = down_Pa / up_Pa;
  if (r <= gas.ratio) return gas.beta * up_Pa;
  if (r >= 1.0) return 0.0;
  const double log_r = std::log(r);
  return gas.alpha * up_Pa * std::exp(log_r / kKappa) *
         std::sqrt(-std::expm1(log_r * (kKappa - 1.0) / kKappa));
}

double ellipse(const FlowFunction& law, const Gas& gas, double up_Pa, double down_Pa) {
  const double r = down_Pa / up_Pa;
  if (r <= law.critical_ratio) return gas.beta * up_Pa;
  if (r >= law.cracking_ratio) return 0.0;
  const double q = (r - law.critical_ratio) / (law.cracking_ratio - law.critical_ratio);
  return gas.beta * up_Pa * std::pow(1.0 - q * q, law.subsonic_index);
}

double one_way(const Gas& gas, const FlowFunction* law, double up_Pa, double down_Pa) {
  const double plate = thin_plate(gas, up_Pa, down_Pa);
  if (law == nullptr) return plate;
  if (law->law == FlowFunction::Law::kDischarge) {
    return plate * (1.0 + law->rise * (gas.ratio - down_Pa / up_Pa));
  }
  return plate + law->share * (ellipse(*law, gas, up_Pa, down_Pa) - plate);
}

double flux(const Gas& gas, const FlowFunction* law, double up_Pa, double down_Pa) {
  return up_Pa >= down_Pa ? one_way(gas, law, up_Pa, down_Pa) : -one_way(gas, law, down_Pa, up_Pa);
}

double smax(double x) {
  return 0.5 * (std::sqrt(x * x + 1.0) + x);
}

double shaped(const AreaShape& shape, double opening_V) {
  if (opening_V <= 0.0) return opening_V;
  constexpr double kPieces = 6.0;
  const double s = opening_V / shape.reach_V;
  if (s >= 1.0) return shape.reach_V * (shape.values[6] + (s - 1.0) * shape.slopes[6]);
  const double at = s * kPieces;
  const auto i = static_cast<std::size_t>(at);
  const double x = at - static_cast<double>(i);
  const double y0 = shape.values[i], y1 = shape.values[i + 1];
  const double m0 = shape.slopes[i] / kPieces, m1 = shape.slopes[i + 1] / kPieces;
  const double value =
      y0 + x * (m0 + x * (3.0 * (y1 - y0) - 2.0 * m0 - m1 + x * (2.0 * (y0 - y1) + m0 + m1)));
  return shape.reach_V * value;
}

double drift_V(const NullDrift& drift, double time_s) {
  const double t = std::max(time_s, 0.0);
  switch (drift.course) {
    case NullDrift::Course::kWarmUp:
      return drift.size_V * -std::expm1(-t / drift.time_s);
    case NullDrift::Course::kRamp:
      return drift.size_V * std::min(t / drift.time_s, 1.0);
    case NullDrift::Course::kWander:
      break;
  }
  double sum = 0.0;
  for (std::size_t i = 0; i < drift.phase.size(); ++i) {
    const double rate = kTau * (1.0 + 0.7 * static_cast<double>(i)) / drift.time_s;
    sum += (std::sin(rate * t + drift.phase[i]) - std::sin(drift.phase[i])) / (1.0 + static_cast<double>(i));
  }
  return drift.size_V * sum;
}

/// Evenly spread in [0, 1), a function of seed and number.
double spread(std::uint64_t seed, std::uint64_t number) {
  return Random(seed, number).uniform();
}

/// z after u moved by `du`, exactly: dz/ds = 1 - (z/z_max)^2 while z grows away from 0, 1 while it comes back.
double bouc_wen(const BoucWen& law, double z, double du) {
  const double direction = du < 0.0 ? -1.0 : 1.0;
  double left = std::abs(du);
  if (law.half_width_V <= 0.0 || left == 0.0) return law.half_width_V <= 0.0 ? 0.0 : z;
  double toward = direction * z;  // z along the movement
  if (toward < 0.0) {
    const double back = std::min(left, -toward);
    toward += back;
    left -= back;
  }
  const double share = std::min(toward / law.half_width_V, 1.0);
  toward = law.half_width_V * std::tanh(std::atanh(share) + left / law.half_width_V);
  return direction * toward;
}

class Integrator {
 public:
  explicit Integrator(const Machine& machine)
      : machine_(machine),
        d_(machine.departures),
        rig_(machine.rig),
        gas_(gas_at(rig_.gas.temperature_K)),
        elasticity_(kKappa * kGasConstant_J_kg_K * rig_.gas.temperature_K),
        law_(d_.flow_function ? &*d_.flow_function : nullptr),
        true_volume_(machine) {
    const auto claim = [this](bool wanted, std::size_t count = 1) {
      const std::size_t first = wanted ? states_ : kAbsent;
      if (wanted) states_ += count;
      return first;
    };
    chamber_ = claim(true);
    spool_ = claim(d_.spool_lag.has_value(), 3);
    supply_ = claim(d_.reservoir || d_.regulator);
    manifold_ = claim(d_.silencer && d_.silencer->manifold_m3 > 0.0);
    mass_ = claim(d_.wall_heat.has_value());
    sensor_ = claim(d_.sensor_lag.has_value(), 2);
    line_ = claim(d_.tube.has_value(), d_.tube ? 2 * d_.tube->cells : 0);
    if (states_ > kMostStates) throw std::invalid_argument("tube: too many cells, expected 18 at most");
  }

  void start(double pressure_Pa, double command_V, double time_s) {
    volume_ = true_volume_.at(time_s);
    y_.fill(0.0);
    y_[chamber_] = pressure_Pa;
    command_V_ = command_V;
    stepper_V_ = slide_V_ = command_V;
    if (spool_ != kAbsent) y_[spool_] = y_[spool_ + 1] = command_V;
    if (supply_ != kAbsent) y_[supply_] = rig_.supply.pressure_Pa;
    if (manifold_ != kAbsent) y_[manifold_] = rig_.ambient.pressure_Pa;
    if (mass_ != kAbsent) {
      y_[mass_] = mass_at_wall_kg(pressure_Pa);
    }
    if (sensor_ != kAbsent) y_[sensor_] = pressure_Pa;
    if (line_ != kAbsent) {
      for (std::size_t i = 0; i < d_.tube->cells; ++i) y_[line_ + 2 * i] = pressure_Pa;
    }
  }

  /// One step of `h` seconds from `time_s` under one command.
  void step(double time_s, double h, double command_V) {
    prepare(time_s, h, command_V);
    const TrueVolume::Moment middle = true_volume_.rigid() ? volume_ : true_volume_.at(time_s + 0.5 * h);
    const TrueVolume::Moment end = true_volume_.rigid() ? volume_ : true_volume_.at(time_s + h);
    State k1, k2, k3, k4, y;
    slope(y_, volume_, k1);
    for (std::size_t i = 0; i < states_; ++i) y[i] = y_[i] + 0.5 * h * k1[i];
    slope(y, middle, k2);
    for (std::size_t i = 0; i < states_; ++i) y[i] = y_[i] + 0.5 * h * k2[i];
    slope(y, middle, k3);
    for (std::size_t i = 0; i < states_; ++i) y[i] = y_[i] + h * k3[i];
    slope(y, end, k4);
    for (std::size_t i = 0; i < states_; ++i) y_[i] += h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
    volume_ = end;
    if (mass_ != kAbsent) {
      const double at_wall_kg = mass_at_wall_kg(y_[chamber_]);
      y_[mass_] = std::clamp(y_[mass_], at_wall_kg / kHottest, at_wall_kg * kHottest);
    }
  }

  double sensed_Pa() const {
    const double p = sensor_ == kAbsent ? y_[chamber_] : y_[sensor_];
    return d_.sensor_bias ? d_.sensor_bias->offset_Pa + d_.sensor_bias->gain * p : p;
  }

 private:
  /// Of the chamber's gas at the wall's temperature.
  double mass_at_wall_kg(double pressure_Pa) const {
    return pressure_Pa * volume_.value_m3 / (kGasConstant_J_kg_K * rig_.gas.temperature_K);
  }

  /// What is held over a step: sources, drift, and laws without a rate of their own.
  void prepare(double time_s, double h, double command_V) {
    const double middle_s = time_s + 0.5 * h;
    if (d_.missed_steps) command_V = stepped(*d_.missed_steps, time_s, command_V);
    if (d_.bouc_wen) hysteresis_V_ = bouc_wen(*d_.bouc_wen, hysteresis_V_, command_V - command_V_);
    command_V_ = command_V;
    held_V_ = d_.lugre ? slid(*d_.lugre, h, command_V) : command_V - hysteresis_V_;
    drift_V_ = d_.null_drift ? drift_V(*d_.null_drift, middle_s) : 0.0;
    source_Pa_ = rig_.supply.pressure_Pa;
    const Clutter& clutter = machine_.clutter;
    if (clutter.ripple_Pa != 0.0) {
      source_Pa_ += clutter.ripple_Pa * std::sin(kTau * clutter.ripple_Hz * middle_s + clutter.ripple_phase);
    }
    if (d_.supply_pulsation) {
      const SupplyPulsation& pulse = *d_.supply_pulsation;
      const double stroke = std::sin(kTau * pulse.frequency_Hz * middle_s + pulse.phase);
      const double breath = 1.0 + 0.4 * std::sin(kTau * 0.17 * middle_s + 2.0 * pulse.phase);
      source_Pa_ *= 1.0 - pulse.share * breath * stroke * stroke;
    }
    if (d_.neighbour) {
      const double turn = middle_s / d_.neighbour->period_s + d_.neighbour->phase;
      if (turn - std::floor(turn) < d_.neighbour->duty) source_Pa_ -= d_.neighbour->drop_Pa;
    }
    if (d_.sticking_flapper) {
      const double gauge_Pa = y_[chamber_] - rig_.ambient.pressure_Pa;
      if (gauge_Pa > d_.sticking_flapper->break_Pa) flapper_open_ = true;
      if (gauge_Pa < d_.sticking_flapper->close_Pa) flapper_open_ = false;
    }
    seal_m2_ = 0.0;
    if (d_.lifting_seal && time_s >= 0.0) {
      const auto stretch = static_cast<std::uint64_t>(time_s / d_.lifting_seal->period_s);
      if (spread(d_.lifting_seal->seed, stretch) < d_.lifting_seal->duty) seal_m2_ = d_.lifting_seal->area_m2;
    }
  }

  /// The spool's mean over a step. Bristles follow exactly for the speed of a substep, so that jumps of the
  /// command cannot make them stiff; the spring is explicit, its lag of 30 substeps.
  double slid(const LuGre& law, double h, double command_V) {
    if (law.half_width_V <= 0.0) return command_V;
    constexpr int kSubsteps = 16;
    const double dt = h / kSubsteps;
    const double z0 = 0.5 * law.half_width_V;
    double sum = 0.0;
    for (int i = 0; i < kSubsteps; ++i) {
      const double speed = (command_V - slide_V_ - law.half_width_V * bristle_V_ / z0) / kLuGreLag_s;
      if (std::abs(speed) < 1e-7) return slide_V_;  // it has come to rest
      const double slow = speed / kLuGreSpeed_V_s;
      const double reach = z0 * (1.0 + law.stribeck * std::exp(-slow * slow));
      bristle_V_ += (std::copysign(reach, speed) - bristle_V_) * -std::expm1(-std::abs(speed) * dt / reach);
      sum += slide_V_ + 0.5 * dt * speed;
      slide_V_ += dt * speed;
    }
    return sum / kSubsteps;
  }

  double stepped(const MissedSteps& law, double time_s, double command_V) {
    const auto ms = static_cast<long long>(std::floor(time_s * 1e3 + 0.5));
    if (ms == last_ms_) return stepper_V_;
    last_ms_ = ms;
    const bool crossed = (command_V - 5.0) * (last_asked_V_ - 5.0) < 0.0;
    last_asked_V_ = command_V;
    if (crossed) lost_V_ = 0.0;
    const double wanted = command_V - lost_V_ - stepper_V_;
    if (std::abs(wanted) < 0.5 * law.step_V) return stepper_V_;
    const double move = wanted > 0.0 ? law.step_V : -law.step_V;
    if (spread(law.seed, static_cast<std::uint64_t>(ms + 1000)) < law.missed) {
      lost_V_ += move;
    } else {
      stepper_V_ += move;
    }
    return stepper_V_;
  }

  void slope(const State& y, const TrueVolume::Moment& volume, State& dy) const {
    const double p = y[chamber_];
    double x = held_V_;
    if (spool_ != kAbsent) x = spool_slope(y, x, dy);
    x += drift_V_;

    const auto& valve = rig_.valve;
    const double c = valve.discharge_coefficient;
    const double inlet_m2 = area(x - valve.open_above_V, valve.inlet_area_per_V_m2, valve.inlet_leak_m2);
    const double exhaust_m2 =
        flapper_open_ ? area(valve.exhaust_below_V - x, valve.exhaust_area_per_V_m2, valve.exhaust_leak_m2)
                      : 0.0;
    const double port_Pa = line_ == kAbsent ? p : y[line_];

    const double supply_Pa = supply_ == kAbsent ? source_Pa_ : y[supply_];
    const double in = c * inlet_m2 * flux(gas_, law_, supply_Pa, port_Pa);
    const double out = exhaust(y, c * exhaust_m2, port_Pa, dy);
    if (supply_ != kAbsent) dy[supply_] = supply_slope(supply_Pa, in);

    double into_chamber = line_ == kAbsent ? in - out : line_slope(y, in - out, p, dy);
    if (d_.chamber_leak || seal_m2_ > 0.0) into_chamber -= leak(p);
    double rate =
        elasticity_ / volume.value_m3 * into_chamber - kKappa * volume.rate_m3_s / volume.value_m3 * p;
    if (mass_ != kAbsent) {
      dy[mass_] = into_chamber;
      rate += (kKappa - 1.0) / volume.value_m3 * heat_W(p, volume.value_m3, y[mass_]);
    }
    dy[chamber_] = rate;
    if (sensor_ != kAbsent) sensor_slope(y, p, dy);
  }

  double area(double opening_V, double gain, double leak_m2) const {
    return port_area(d_.area_shape ? shaped(*d_.area_shape, opening_V) : opening_V, gain, leak_m2,
                     rig_.valve.transition_m2);
  }

  double spool_slope(const State& y, double command_V, State& dy) const {
    const SpoolLag& law = *d_.spool_lag;
    const double w = kTau * law.natural_frequency_Hz;
    dy[spool_] = 10.0 * w * (command_V - y[spool_]);
    dy[spool_ + 1] = std::clamp(y[spool_ + 2], -law.slew_V_s, law.slew_V_s);
    const double push = w * w * (y[spool_] - y[spool_ + 1]) - 2.0 * law.damping * w * y[spool_ + 2];
    const double q = dy[spool_ + 1] / law.slew_V_s;
    dy[spool_ + 2] = push * y[spool_ + 2] > 0.0 ? push * (1.0 - q * q * q * q) : push;
    return y[spool_ + 1];
  }

  /// Mass flow out through the exhaust port of conductance `area_m2` (coefficient included).
  double exhaust(const State& y, double area_m2, double port_Pa, State& dy) const {
    const double ambient_Pa = rig_.ambient.pressure_Pa;
    if (!d_.silencer) return area_m2 * flux(gas_, law_, port_Pa, ambient_Pa);
    const double g = d_.silencer->conductance_kg_s_Pa;
    if (manifold_ != kAbsent) {
      const double out = area_m2 * flux(gas_, law_, port_Pa, y[manifold_]);
      // Laminar within 0.2 % of ambient, so that the root has a slope.
      const double squares = y[manifold_] * y[manifold_] - ambient_Pa * ambient_Pa;
      const double through = g * squares / std::sqrt(std::abs(squares) + 4e-3 * ambient_Pa * ambient_Pa);
      dy[manifold_] = elasticity_ / d_.silencer->manifold_m3 * (out - through);
      return out;
    }
    return port_Pa > ambient_Pa ? series(area_m2, g, port_Pa, ambient_Pa)
                                : area_m2 * flux(gas_, law_, port_Pa, ambient_Pa);
  }

  /// Port and silencer in series without volume between: the back pressure at which both pass the same.
  double series(double area_m2, double g, double port_Pa, double ambient_Pa) const {
    const auto behind = [&](double flow) {
      return std::sqrt(ambient_Pa * ambient_Pa + flow * flow / (g * g));
    };
    const auto port = [&](double back_Pa) { return area_m2 * flux(gas_, law_, port_Pa, back_Pa); };
    const double most = port(ambient_Pa);
    // The flow f solves port(behind(f)) = f; port falls and behind grows: one root in [0, most]. Regula falsi after
    // Illinois; choked ports are found at once.
    double low = 0.0, high = most;
    double at_low = most, at_high = behind(most) < port_Pa ? port(behind(most)) - most : -most;
    if (at_high > -1e-9 * most) return most;
    double flow = high;
    for (int i = 0; i < 30; ++i) {
      flow = (low * at_high - high * at_low) / (at_high - at_low);
      const double back = behind(flow);
      const double at = (back < port_Pa ? port(back) : 0.0) - flow;
      if (std::abs(at) < 1e-8 * most) break;
      if (at > 0.0) {
        low = flow;
        at_low = at;
        at_high *= 0.5;
      } else {
        high = flow;
        at_high = at;
        at_low *= 0.5;
      }
    }
    return flow;
  }

  double supply_slope(double supply_Pa, double drawn) const {
    if (d_.regulator) {
      return (source_Pa_ - d_.regulator->droop_Pa_s_kg * drawn - supply_Pa) / d_.regulator->time_s;
    }
    const double fed =
        rig_.valve.discharge_coefficient * d_.reservoir->feed_m2 * flux(gas_, nullptr, source_Pa_, supply_Pa);
    return elasticity_ / d_.reservoir->volume_m3 * (fed - drawn);
  }

  /// Cells of the line from the valve to the chamber; returns the flow into the chamber.
  double line_slope(const State& y, double from_valve, double chamber_Pa, State& dy) const {
    const Tube& tube = *d_.tube;
    const double dx = tube.length_m / static_cast<double>(tube.cells);
    const double bore_m2 = 0.25 * std::numbers::pi * tube.bore_m * tube.bore_m;
    const double rt = elasticity_ / kKappa;
    double entering = from_valve;
    for (std::size_t i = 0; i < tube.cells; ++i) {
      const std::size_t at = line_ + 2 * i;
      const double pressure = y[at], flow = y[at + 1];
      const double next = i + 1 < tube.cells ? y[at + 2] : chamber_Pa;
      const double density = 0.5 * (pressure + next) / rt;
      dy[at] = elasticity_ / (bore_m2 * dx) * (entering - flow);
      const double drag = 32.0 * kViscosity_Pa_s / (density * tube.bore_m * tube.bore_m) +
                          tube.friction * std::abs(flow) / (2.0 * density * bore_m2 * tube.bore_m);
      dy[at + 1] = bore_m2 / dx * (pressure - next) - drag * flow;
      entering = flow;
    }
    return entering;
  }

  double leak(double p) const {
    const double ambient_Pa = rig_.ambient.pressure_Pa;
    double hole_m2 = seal_m2_, capillary = 0.0;
    if (d_.chamber_leak) {
      hole_m2 += d_.chamber_leak->hole_m2;
      capillary = d_.chamber_leak->capillary_kg_s_Pa * (p * p - ambient_Pa * ambient_Pa) / (2.0 * ambient_Pa);
    }
    return capillary + (hole_m2 > 0.0
                            ? rig_.valve.discharge_coefficient * hole_m2 * flux(gas_, nullptr, p, ambient_Pa)
                            : 0.0);
  }

  double heat_W(double p, double v, double mass) const {
    const WallHeat& law = *d_.wall_heat;
    const double gas_K = p * v / (mass * kGasConstant_J_kg_K);
    return law.conductance_W_K * std::pow(p / rig_.ambient.pressure_Pa, law.exponent) *
           (v / machine_.motion.mean_m3) * (rig_.gas.temperature_K - gas_K);
  }

  void sensor_slope(const State& y, double p, State& dy) const {
    const SensorLag& law = *d_.sensor_lag;
    const double w = 1.0 / law.time_s;
    if (law.damping == 0.0) {
      dy[sensor_] = w * (p - y[sensor_]);
      dy[sensor_ + 1] = 0.0;
      return;
    }
    dy[sensor_] = y[sensor_ + 1];
    dy[sensor_ + 1] = w * w * (p - y[sensor_]) - 2.0 * law.damping * w * y[sensor_ + 1];
  }

  const Machine& machine_;
  const Departures& d_;
  const trace::RigDescription& rig_;
  Gas gas_;
  double elasticity_;  // kappa R T
  const FlowFunction* law_;

  std::size_t states_ = 0;
  std::size_t chamber_, spool_, supply_, manifold_, mass_, sensor_, line_;
  State y_{};
  TrueVolume true_volume_;
  TrueVolume::Moment volume_{};

  double command_V_ = 0.0;  // last step's
  double hysteresis_V_ = 0.0;
  double slide_V_ = 0.0, bristle_V_ = 0.0;
  double held_V_ = 0.0;
  double drift_V_ = 0.0;
  double source_Pa_ = 0.0;
  double seal_m2_ = 0.0;
  bool flapper_open_ = true;
  double stepper_V_ = 0.0, lost_V_ = 0.0, last_asked_V_ = 5.0;
  long long last_ms_ = -1'000'000;
};

/// The command that acts: each row's from its own late moment on.
class Late {
 public:
  Late(const Machine& machine, double step_s, long steps_a_tick)
      : clutter_(machine.clutter),
        takes_numbers_(machine.departures.missed_steps.has_value()),
        step_s_(step_s),
        steps_a_tick_(static_cast<double>(steps_a_tick)) {
    const double delay_s = machine.departures.dead_time ? machine.departures.dead_time->delay_s : 0.0;
    delay_ = delay_s / step_s;
    if (std::abs(delay_ - std::round(delay_)) < 1e-6) delay_ = std::round(delay_);
  }

  void ask(double command_V) {
    const double lsb = takes_numbers_ ? 0.0 : clutter_.command_lsb_V;
    const double jitter = clutter_.jitter_s / step_s_ * spread(clutter_.seed, given_.size());
    given_.push_back(lsb > 0.0 ? lsb * std::round(command_V / lsb) : command_V);
    from_.push_back(static_cast<double>(given_.size() - 1) * steps_a_tick_ + delay_ + jitter);
  }

  /// The command from `at` on and the moment up to which it acts, `until` at the latest; both in steps.
  std::pair<double, double> from(double at, double until) {
    while (at_ + 1 < given_.size() && from_[at_ + 1] <= at) ++at_;
    return {given_[at_], at_ + 1 < given_.size() ? std::min(from_[at_ + 1], until) : until};
  }

 private:
  const Clutter& clutter_;
  bool takes_numbers_;  // a stepper's drive has no DAC
  double step_s_;
  double steps_a_tick_;
  double delay_;
  std::size_t at_ = 0;
  std::vector<double> given_;
  std::vector<double> from_;  // in steps; before the first it acts too
};

long whole_steps(double time_s, double step_s, const char* what) {
  const double steps = time_s / step_s;
  if (std::abs(steps - std::round(steps)) > 1e-6) {
    throw std::invalid_argument(
        fmt::format("{}: {} s is no multiple of the step, expected one of {} s", what, time_s, step_s));
  }
  return std::lround(steps);
}

}  // namespace

double thin_plate_flux(double upstream_Pa, double downstream_Pa, double temperature_K) {
  return flux(gas_at(temperature_K), nullptr, upstream_Pa, downstream_Pa);
}

double port_area(double opening_V, double area_per_V_m2, double leak_m2, double transition_m2) {
  return leak_m2 + transition_m2 * smax((area_per_V_m2 * opening_V - leak_m2) / transition_m2);
}

double Motion::at(double time_s) const {
  double sum = 1.0;
  for (const Tone& tone : tones) {
    if (tone.share != 0.0) sum += tone.share * std::sin(kTau * tone.frequency_Hz * time_s + tone.phase);
  }
  return mean_m3 * sum;
}

double Motion::rate(double time_s) const {
  double sum = 0.0;
  for (const Tone& tone : tones) {
    const double w = kTau * tone.frequency_Hz;
    if (tone.share != 0.0) sum += tone.share * w * std::cos(w * time_s + tone.phase);
  }
  return mean_m3 * sum;
}

Rows simulate(const Machine& machine, std::size_t rows, const Driver& driver, double step_s) {
  const double tick_s = 1.0 / machine.rig.sampling.rate_Hz;
  const long steps = whole_steps(tick_s, step_s, "tick");
  const long averaged = whole_steps(machine.rig.sampling.pressure_average_s, step_s, "averaging time");
  const auto settle_ticks = static_cast<long>(std::ceil(kSettle_s / tick_s));

  Late late(machine, step_s, steps);
  Integrator integrator(machine);
  Rows out;
  out.command_V.push_back(driver(0, machine.initial_Pa));
  late.ask(out.command_V.back());
  const auto begin = -static_cast<double>(settle_ticks * steps);
  integrator.start(machine.initial_Pa, late.from(begin, 0.0).first, begin * step_s);

  for (long tick = -settle_ticks; tick < static_cast<long>(rows); ++tick) {
    if (tick >= 0) {
      const double time_s = static_cast<double>(tick) * tick_s;
      out.volume_m3.push_back(machine.motion.at(time_s));
      if (tick > 0) {
        out.command_V.push_back(driver(static_cast<std::size_t>(tick), out.pressure_Pa.back()));
        late.ask(out.command_V.back());
      }
    }
    if (tick + 1 == static_cast<long>(rows)) break;  // the last row's tick ends in no row
    double sum = 0.0;
    for (long s = 0; s < steps; ++s) {
      const long n = tick * steps + s;
      const bool counts = s >= steps - averaged;
      if (counts) sum += 0.5 * integrator.sensed_Pa();
      // A command that changes within a step parts it: no step straddles a jump.
      for (double at = static_cast<double>(n), end = at + 1.0; at < end;) {
        const auto [command_V, until] = late.from(at, end);
        integrator.step(at * step_s, (until - at) * step_s, command_V);
        at = until;
      }
      if (counts) sum += 0.5 * integrator.sensed_Pa();
    }
    if (tick + 1 >= 0) {
      out.pressure_Pa.push_back(averaged > 0 ? sum / static_cast<double>(averaged) : integrator.sensed_Pa());
    }
  }
  return out;
}

Driver replay(const std::vector<double>& command_V) {
  return [&command_V](std::size_t row, double) { return command_V[row]; };
}

}  // namespace plenum::host::blind
