#include "firmware/control/supply_line.hpp"

namespace plenum::control {
namespace {

using numeric::abs;
using numeric::clamp;
using numeric::max;
using numeric::min;

/// Of Newton's method, and what it needs not come nearer to.
constexpr int kRefinements = 12;
constexpr Scalar kClose = Scalar(1e-5);

/// Of a step: with the flow at its beginning, then with that in the mean.
constexpr int kPasses = 2;

/// [1] A droop beyond is none of a line from which a chamber can be regulated; nor is a supply that a sensor says to be off so far.
constexpr Scalar kMostDroop = Scalar(0.8);
constexpr Scalar kMostOff = Scalar(0.5);

SupplyLine::While lasting(Scalar ticks, Scalar recovery_ticks) noexcept {
  if (!(ticks > Scalar(0))) return {.left = Scalar(1), .weight = Scalar(0)};
  if (!(recovery_ticks * Scalar(numeric::kDecayHigh) > ticks)) return {};
  const Scalar x = ticks / recovery_ticks;
  return {.left = Scalar(1) - numeric::decay(x), .weight = x * numeric::phi_2(x, numeric::phi_1(x))};
}

}  // namespace

void SupplyLine::configure(const Config& config, Scalar part_ticks) noexcept {
  supply_kPa_ = config.supply_kPa;
  by_flow_ = config.resistance_s_L > Scalar(0) ? config.resistance_s_L / config.supply_kPa : Scalar(0);
  followed_share_ = config.followed_share;
  tick_ = lasting(Scalar(1), config.recovery_ticks);
  part_ = lasting(part_ticks, config.recovery_ticks);
  rest_ = lasting(Scalar(1) - part_ticks, config.recovery_ticks);
  droop_ = Scalar(0);
  at_rest_ = Scalar(1);
}

void SupplyLine::measured(Scalar supply_kPa) noexcept {
  if (!(followed_share_ > Scalar(0))) return;
  at_rest_ = Scalar(1) + followed_share_ * clamp(supply_kPa / supply_kPa_ - Scalar(1), -kMostOff, kMostOff);
}

Scalar SupplyLine::mean(const While& span, const PressureModel& model, Scalar pressure_kPa,
                        const Opening& open, const ChamberMotion& motion) const noexcept {
  const Scalar by_flow = span.weight * by_flow_;
  const Scalar unloaded = at_rest_ - (Scalar(1) - span.weight) * droop_;
  const Scalar stalled = pressure_kPa / supply_kPa_;
  Scalar low = min(unloaded, stalled), high = max(unloaded, stalled);
  ChamberMotion with = motion;
  with.supply = clamp(supply(), low, high);
  for (int i = 0; i < kRefinements; ++i) {
    const Draw drawn = model.draw(pressure_kPa, open, model.moving(with));
    const Scalar above = with.supply - unloaded + by_flow * drawn.flow_kPa_L_s;
    (above > Scalar(0) ? high : low) = with.supply;
    const Scalar next = with.supply - above / (Scalar(1) + by_flow * max(drawn.by_supply_kPa_L_s, Scalar(0)));
    const bool close = abs(next - with.supply) < kClose;
    with.supply = next >= low && next <= high ? next : Scalar(0.5) * (low + high);
    if (close) break;
  }
  return with.supply;
}

Prediction SupplyLine::drawn_step(const While& span, Scalar ticks, const PressureModel& model,
                                  Scalar pressure_kPa, const Opening& open,
                                  const ChamberMotion& motion) noexcept {
  Prediction predicted{.end_kPa = pressure_kPa, .mean_kPa = pressure_kPa};
  if (!(ticks > Scalar(0))) return predicted;
  ChamberMotion with = motion;
  Moving by_then;
  for (int i = 0; i < kPasses; ++i) {
    with.supply = mean(span, model, predicted.mean_kPa, open, motion);
    by_then = model.moving(with);
    predicted = model.step(pressure_kPa, open, by_then, ticks);
  }
  pass(span, model.draw(predicted.mean_kPa, open, by_then).flow_kPa_L_s);
  return predicted;
}

void SupplyLine::pass(const While& span, Scalar flow_kPa_L_s) noexcept {
  const Scalar drawn = by_flow_ * flow_kPa_L_s;
  droop_ = clamp(drawn + span.left * (droop_ - drawn), -kMostDroop, kMostDroop);
}

}  // namespace plenum::control
