#include "host-sim/plant/spool.hpp"

#include <cmath>
#include <numbers>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant {
namespace {
constexpr double kAtRest_V = 1e-9;
constexpr double kSameDuration = 1e-13;  // equal parts of an interval differ by rounding
}  // namespace

Spool::Spool(const SpoolConfig& config, double command_V)
    : omega_rad_s_(2.0 * std::numbers::pi * config.natural_frequency_Hz),
      damping_ratio_(config.damping_ratio),
      effective_V_(command_V) {
  require_above("spool natural_frequency_Hz", config.natural_frequency_Hz, 0.0);
  require_above("spool damping_ratio", config.damping_ratio, 0.0);
  require_finite("spool command_V", command_V);
}

Spool::Transition Spool::transition(double t) const {
  const double sigma = damping_ratio_ * omega_rad_s_;
  const double square =
      (1.0 - damping_ratio_ * damping_ratio_) * omega_rad_s_ * omega_rad_s_;  // w_d^2, signed
  double C = 0.0;  // exp(-sigma t) C and exp(-sigma t) S: scaled together, so that the hyperbolic case cannot
                   // overflow
  double S = 0.0;
  if (std::abs(square) * t * t < 1e-6) {
    const double decay = std::exp(-sigma * t);
    const double s = square * t * t;
    C = decay * (1.0 - s / 2.0 * (1.0 - s / 12.0));
    S = decay * t * (1.0 - s / 6.0 * (1.0 - s / 20.0));
  } else if (square > 0.0) {
    const double decay = std::exp(-sigma * t);
    const double w_d = std::sqrt(square);
    C = decay * std::cos(w_d * t);
    S = decay * std::sin(w_d * t) / w_d;
  } else {
    const double w = std::sqrt(-square);
    const double slow =
        std::exp(-omega_rad_s_ * omega_rad_s_ / (sigma + w) * t);  // sigma - w, no digits lost
    const double fast = std::exp(-(sigma + w) * t);
    C = 0.5 * (slow + fast);
    S = 0.5 * (slow - fast) / w;
  }
  return {t, C + sigma * S, S, -omega_rad_s_ * omega_rad_s_ * S, C - sigma * S};
}

void Spool::advance(double command_V, double duration_s) {
  if (std::abs(latest_.duration_s - duration_s) > kSameDuration * duration_s)
    latest_ = transition(duration_s);
  const double error_V = effective_V_ - command_V;
  const double rate_V_s = rate_V_s_;
  effective_V_ = command_V + latest_.xx * error_V + latest_.xv * rate_V_s;
  rate_V_s_ = latest_.vx * error_V + latest_.vv * rate_V_s;
}

bool Spool::settled_on(double command_V) const {
  return std::abs(effective_V_ - command_V) < kAtRest_V && std::abs(rate_V_s_) < kAtRest_V * omega_rad_s_;
}

void Spool::settle(double command_V) {
  effective_V_ = command_V;
  rate_V_s_ = 0.0;
}

}  // namespace plenum::host::plant
