#include "firmware/control/tassa9.hpp"

#include "firmware/control/inverse_search.hpp"

namespace plenum::control {
void Tassa9::configure(std::span<const Scalar, kParameters> parameters, Scalar command_low_V,
                       Scalar command_high_V) noexcept {
  c4_ = parameters[3];
  c5_ = parameters[4];
  c6_ = parameters[5];
  c7_ = parameters[6];
  curve_.configure({.c1 = parameters[0],
                    .c2 = parameters[1],
                    .c3 = parameters[2],
                    .c8 = parameters[7],
                    .c9 = parameters[8],
                    .c_gamma = parameters[9],
                    .supply_kPa = parameters[10],
                    .ambient_kPa = parameters[11]},
                   command_low_V, command_high_V);
}

Moving Tassa9::moving(const ChamberMotion& motion) const noexcept {
  const TickPerVolume per_volume(volume_factor(c6_, motion.volume_mL));
  return {.first = c4_ * motion.volume_rate_mL_s,
          .second = per_volume.of(c7_),
          .third = per_volume.of(c5_ * motion.volume_rate_mL_s)};
}

Tassa9::Tick Tassa9::tick(Scalar pressure_kPa, const Moving& moves) const noexcept {
  return {.pressure_kPa = pressure_kPa,
          .steady_shift_kPa = moves.first,
          .rate_gain = moves.second,
          .rate_shift = moves.third};
}

/// d rise / d(rh) = (s - p) e^-rh; where the exponent is limited, rh has no part in it.
Scalar Tassa9::Tick::by_rate_kPa(CommandCurve::Point at, Response done) const noexcept {
  const Scalar rh = rate(at.opening_V);
  const bool exponent_free = rh > Scalar(0) && rh < numeric::kDecayHigh;
  return exponent_free ? (steady_kPa(at) - pressure_kPa) * numeric::rest_of(done) : Scalar(0);
}

Scalar Tassa9::Tick::slope_kPa_V(const CommandCurve::Tangent& of, Response done) const noexcept {
  const Scalar by_opening_kPa = numeric::product_within<kSteepest>(by_rate_kPa(of.at, done), rate_gain);
  return unless_limited(is_limited(by_opening_kPa),
                        of.by_V.steady_kPa_V * done + by_opening_kPa * of.by_V.opening);
}

Opening Tassa9::opening(Scalar command_V) const noexcept {
  const CommandCurve::Point at = curve_.at(command_V);
  return {.first = at.steady_kPa, .second = at.opening_V};
}

Prediction Tassa9::step(Scalar pressure_kPa, const Opening& open, const Moving& moves,
                        Scalar ticks) const noexcept {
  const Tick now = tick(pressure_kPa, moves);
  const CommandCurve::Point at{.steady_kPa = open.first, .opening_V = open.second};
  const Scalar steady = now.steady_kPa(at);
  const Scalar rh = now.rate(at.opening_V) * ticks;
  const Tick::Response done = numeric::decay_part(rh);
  return {.end_kPa = pressure_kPa + (steady - pressure_kPa) * done,  // (7)
          .mean_kPa = steady + (pressure_kPa - steady) * numeric::mean_decay(rh, Scalar(done))};
}

Inverse Tassa9::inverse(Scalar pressure_kPa, Scalar target_kPa, const Moving& moves,
                        Scalar near_V) const noexcept {
  const Tick now = tick(pressure_kPa, moves);
  return InverseSearch<Tick>(curve_, now, pressure_kPa, target_kPa).find(near_V);
}

}  // namespace plenum::control
