#include "firmware/control/tassa9r.hpp"

#include "firmware/control/inverse_search.hpp"

namespace plenum::control {
namespace {

using numeric::clamp;

}  // namespace

void Tassa9r::configure(std::span<const Scalar, kParameters> parameters, Scalar command_low_V,
                        Scalar command_high_V) noexcept {
  c5_ = parameters[3];
  c6_ = parameters[4];
  c7_ = parameters[5];
  curve_.configure({.c1 = parameters[0],
                    .c2 = parameters[1],
                    .c3 = parameters[2],
                    .c8 = parameters[6],
                    .c9 = parameters[7],
                    .c_gamma = parameters[8],
                    .supply_kPa = parameters[9],
                    .ambient_kPa = parameters[10]},
                   command_low_V, command_high_V);
}

Moving Tassa9r::moving(const ChamberMotion& motion) const noexcept {
  const TickPerVolume per_volume(
      volume_factor(c6_, clamp(motion.volume_mL, -kMostVolume_mL, kMostVolume_mL)));
  const Scalar speed_mL_s = clamp(motion.volume_rate_mL_s, -kMostSpeed_mL_s, kMostSpeed_mL_s);
  return {.first = per_volume.of(c7_), .second = per_volume.of(c5_ * speed_mL_s)};
}

Tassa9r::Tick Tassa9r::tick(Scalar pressure_kPa, const Moving& moves) const noexcept {
  return {.pressure_kPa = clamp(pressure_kPa, Scalar(0), kMostPressure_kPa),
          .gain_per_V = moves.first,
          .moved = moves.second};
}

Scalar Tassa9r::within_range(Scalar command_V) const noexcept {
  const auto& node_V = curve_.nodes().command_V;
  return clamp(command_V, node_V.front(), node_V.back());
}

/// d rise / dx at a given F: d phi_1/dx = phi_2 - phi_1.
Scalar Tassa9r::Tick::by_x_kPa(CommandCurve::Point at, Scalar phi_1) const noexcept {
  const Scalar a = flow(at.opening_V);
  return speed_kPa(a, at.steady_kPa) * (numeric::phi_2(x(a), phi_1) - phi_1);
}

/// Of F phi_1(x), by the chain rule through s0 and through a.
Scalar Tassa9r::Tick::slope_kPa_V(const CommandCurve::Tangent& of, Scalar phi_1) const noexcept {
  const Scalar by_a_kPa = (of.at.steady_kPa - pressure_kPa) * phi_1 + by_x_kPa(of.at, phi_1);
  const Scalar by_opening_kPa = numeric::product_within<kSteepest>(by_a_kPa, gain_per_V);
  const Scalar by_steady_kPa_V =
      numeric::product_within<kSteepest>(flow(of.at.opening_V) * phi_1, of.by_V.steady_kPa_V);
  return unless_limited(is_limited(by_opening_kPa) || is_limited(by_steady_kPa_V),
                        by_steady_kPa_V + by_opening_kPa * of.by_V.opening);
}

Opening Tassa9r::opening(Scalar command_V) const noexcept {
  const CommandCurve::Point at = curve_.at(within_range(command_V));
  return {.first = at.steady_kPa, .second = at.opening_V};
}

Prediction Tassa9r::step(Scalar pressure_kPa, const Opening& open, const Moving& moves,
                         Scalar ticks) const noexcept {
  const Tick now = tick(pressure_kPa, moves);
  const Scalar flow = now.flow(open.second);
  const Scalar x = now.x(flow) * ticks;
  const Scalar phi_1 = numeric::phi_1(x);
  const Scalar speed_kPa = now.speed_kPa(flow, open.first) * ticks;
  return {.end_kPa = now.pressure_kPa + speed_kPa * phi_1,                       // (R3)
          .mean_kPa = now.pressure_kPa + speed_kPa * numeric::phi_2(x, phi_1)};  // (R4)
}

Inverse Tassa9r::inverse(Scalar pressure_kPa, Scalar target_kPa, const Moving& moves,
                         Scalar near_V) const noexcept {
  const Tick now = tick(pressure_kPa, moves);
  return InverseSearch<Tick>(curve_, now, now.pressure_kPa, target_kPa).find(near_V);
}

}  // namespace plenum::control
