#include "host-sim/plant/chamber.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant {
namespace {

// phi_k(z) = int_0^1 exp((1 - s) z) s^(k-1) / (k-1)! ds, and phi_1 at half the argument.
struct Phi {
  double half1, one, two, three, four;
};

Phi phi(double z) {
  Phi f{};
  if (std::abs(z) < 0.5) {
    // phi_4 by its series sum z^j / (j + 4)! (remainder below 1e-14), the others by phi_k = 1/k! + z
    // phi_(k+1); even and odd powers side by side
    const double z2 = z * z;
    const double even =
        1.0 / 24 + z2 * (1.0 / 720 + z2 * (1.0 / 40320 + z2 * (1.0 / 3628800 +
                                                               z2 * (1.0 / 479001600 + z2 / 87178291200.0))));
    const double odd =
        1.0 / 120 + z2 * (1.0 / 5040 + z2 * (1.0 / 362880 + z2 * (1.0 / 39916800 + z2 * (1.0 / 6227020800))));
    f.four = even + z * odd;
    f.three = 1.0 / 6.0 + z * f.four;
    f.two = 0.5 + z * f.three;
    f.one = 1.0 + z * f.two;
    f.half1 = 2.0 * f.one / (1.0 + std::sqrt(1.0 + z * f.one));
  } else {
    const double inverse = 1.0 / z;
    f.one = std::expm1(z) * inverse;
    f.two = (f.one - 1.0) * inverse;
    f.three = (f.two - 0.5) * inverse;
    f.four = (f.three - 1.0 / 6.0) * inverse;
    f.half1 = 2.0 * f.one / (1.0 + std::sqrt(std::max(1.0 + z * f.one, 0.0)));
  }
  return f;
}

struct Rate {
  double rate_Pa_s;
  double slope_1_s;
};

constexpr double kShortestStep = 1e-6;  // of the interval: taken whatever its error estimate
// The spool's own motion in one step is limited, because it crosses corners of the areas that the error
// estimate might not see; less so when it is near its end.
constexpr double kSpoolStep_rad = 0.6;
constexpr double kSpoolNearStep_rad = 1.5;
constexpr double kSpoolNear_V = 0.05;
constexpr double kCautious = 0.85;
constexpr double kGrowAtMost = 5.0;
constexpr double kShrinkAtMost = 0.1;

}  // namespace

ChamberPlant::ChamberPlant(const Valve& valve, const ChamberConfig& config, const VolumeMotion& volume)
    : valve_(valve),
      gas_(config.gas),
      volume_(volume),
      supply_Pa_(config.supply_Pa),
      ambient_Pa_(config.ambient_Pa),
      pressure_Pa_(config.initial_pressure_Pa),
      tolerance_Pa_(config.tolerance_Pa),
      command_V_(config.initial_command_V) {
  validate(gas_);
  require_above("chamber supply_Pa", supply_Pa_, 0.0);
  require_above("chamber ambient_Pa", ambient_Pa_, 0.0);
  require_above("chamber initial_pressure_Pa", pressure_Pa_, 0.0);
  require_above("chamber tolerance_Pa", tolerance_Pa_, 0.0);
  require_finite("chamber initial_command_V", command_V_);
  if (config.spool) spool_.emplace(*config.spool, config.initial_command_V);
}

void ChamberPlant::set_supply_Pa(double supply_Pa) {
  require_above("chamber supply_Pa", supply_Pa, 0.0);
  supply_Pa_ = supply_Pa;
}

void ChamberPlant::set_ambient_Pa(double ambient_Pa) {
  require_above("chamber ambient_Pa", ambient_Pa, 0.0);
  ambient_Pa_ = ambient_Pa;
}

void ChamberPlant::set_pressure_Pa(double pressure_Pa) {
  require_above("chamber pressure_Pa", pressure_Pa, 0.0);
  pressure_Pa_ = pressure_Pa;
}

Interval ChamberPlant::advance(double command_V, double duration_s) {
  require_finite("chamber command_V", command_V);
  require_above("chamber duration_s", duration_s, 0.0);
  return std::visit([&](const auto& valve) { return integrate(valve, command_V, duration_s); }, valve_);
}

template <class AnyValve>
Interval ChamberPlant::integrate(const AnyValve& valve, double command_V, double duration_s) {
  const FlowExponents n = valve.exponents();
  const double RT = gas_.specific_gas_constant_J_kg_K() * gas_.temperature_K;
  const double kappa = gas_.kappa;

  // (4a) and its slope, at a pressure, an opening and a volume
  const auto rate = [&](double p, const typename AnyValve::Opening& opening,
                        const VolumeState& volume) -> Rate {
    const PortFlows m = valve.flows(opening, p, supply_Pa_, ambient_Pa_);
    const double n_c = m.inlet_kg_s >= 0.0 ? n.entering : n.leaving;
    const double n_r = m.exhaust_kg_s >= 0.0 ? n.leaving : n.entering;
    const double inverse_v = 1.0 / volume.volume_m3;
    const double compression = kappa * volume.rate_m3_s * inverse_v;
    return {RT * inverse_v * (n_c * m.inlet_kg_s - n_r * m.exhaust_kg_s) - compression * p,
            RT * inverse_v * (n_c * m.inlet_slope_kg_s_Pa - n_r * m.exhaust_slope_kg_s_Pa) - compression};
  };

  const VolumeMotion::Interval motion(volume_, time_s_);
  if (spool_ && spool_->settled_on(command_V)) spool_->settle(command_V);
  const bool spool_moves = spool_ && !spool_->settled_on(command_V);

  double t = 0.0;
  double p = pressure_Pa_;
  double integral = 0.0;
  auto opening = valve.opening(spool_moves ? spool_->effective_V() : command_V);
  Rate start = rate(p, opening, motion.at(0.0));
  double wanted = next_step_s_;

  while (t < duration_s) {
    if (spool_moves) {
      const double step_rad = spool_->off_V(command_V) < kSpoolNear_V ? kSpoolNearStep_rad : kSpoolStep_rad;
      wanted = std::min(wanted, step_rad / spool_->natural_frequency_rad_s());
    }
    const double left = duration_s - t;
    // the rest in equal steps: no sliver at the end, and one length for the spool's closed form
    const double steps_left = std::ceil(left / wanted * (1.0 - 1e-9));
    const bool last = steps_left <= 1.0;
    const double h = last ? left : left / steps_left;
    ++steps_tried_;

    auto opening_2 = opening;
    auto opening_3 = opening;
    std::optional<Spool> spool_3;
    if (spool_moves) {
      spool_3 = spool_;
      spool_3->advance(command_V, 0.5 * h);
      opening_2 = valve.opening(spool_3->effective_V());
      spool_3->advance(command_V, 0.5 * h);
      opening_3 = valve.opening(spool_3->effective_V());
    }

    const double F = start.rate_Pa_s;
    const double J = start.slope_1_s;
    const Phi f = phi(h * J);
    const double p2 = p + 0.5 * h * f.half1 * F;
    double error = tolerance_Pa_ * 1e9;
    double p_next = 0.0;
    double area = 0.0;
    Rate end{};
    if (p2 > 0.0) {
      const double D2 = rate(p2, opening_2, motion.at(t + 0.5 * h)).rate_Pa_s - F - J * (p2 - p);
      const double p3 = p + h * (f.one * F + 2.0 * f.two * D2);
      if (p3 > 0.0) {
        const double D3 = rate(p3, opening_3, motion.at(t + h)).rate_Pa_s - F - J * (p3 - p);
        const double slope = 4.0 * D2 - D3;
        const double curve = 4.0 * (D3 - 2.0 * D2);
        p_next = p + h * (f.one * F + f.two * slope + f.three * curve);
        area = h * (p + h * (f.two * F + f.three * slope + f.four * curve));
        if (p_next > 0.0) {
          // what the interpolant's slope lacks at the end, damped by the stiffness found there: sees a port
          // that shut within the step, where the damping by J at the start would hide any error
          end = rate(p_next, opening_3, motion.at(t + h));
          const double lacking = end.rate_Pa_s - (F + J * (p_next - p) + D3);
          error =
              std::max(std::abs(p_next - p3), h * std::abs(lacking) / (1.0 + h * std::abs(end.slope_1_s)));
        }
      }
    }

    const double grow =
        error * 200.0 < tolerance_Pa_
            ? kGrowAtMost
            : std::clamp(kCautious * std::cbrt(tolerance_Pa_ / error), kShrinkAtMost, kGrowAtMost);
    if (error > tolerance_Pa_ && h > kShortestStep * duration_s) {
      wanted = h * grow;
      continue;
    }
    if (p_next <= 0.0) {  // only at the shortest step, where the linear part alone is accurate
      p_next = p * std::exp(std::min(h * F / p, 0.0));
      area = h * p;
      end = rate(p_next, opening_3, motion.at(t + h));
    }
    // a last step cut short says little about the size of the next: it may only raise it
    wanted = last ? std::max(wanted, h * grow) : h * grow;
    p = p_next;
    integral += area;
    t = last ? duration_s : t + h;
    if (spool_moves) {
      spool_ = spool_3;
      opening = opening_3;
    }
    start = end;
  }

  next_step_s_ = std::min(wanted, duration_s);
  pressure_Pa_ = p;
  command_V_ = command_V;
  time_s_ += duration_s;
  return {p, integral / duration_s};
}

}  // namespace plenum::host::plant
