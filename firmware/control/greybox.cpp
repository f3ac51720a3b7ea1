#include "firmware/control/greybox.hpp"

#include <algorithm>

#include "firmware/config/limits.hpp"
#include "firmware/config/valve_curve.hpp"

namespace plenum::control {
namespace {

using numeric::abs;
using numeric::clamp;
using numeric::max;
using numeric::min;

constexpr Scalar kTick_s = Scalar(config::kTick_s);

/// What is beyond these is no pressure, volume or speed of a chamber; within them nothing overflows.
constexpr Scalar kMostPressure_kPa = Scalar(1e5);
constexpr Scalar kLeastVolume_mL = Scalar(0.1);
constexpr Scalar kMostVolume_mL = Scalar(1e7);
constexpr Scalar kMostSpeed_mL_s = Scalar(1e7);

/// A hundredth of a 16 bit converter's step over 1000 kPa, far below the noise of any sensor.
constexpr Scalar kClose_kPa = Scalar(2e-4);

/// Of f, from a corner to the next: where it would come to rest on its way it does not pass.
constexpr Scalar kMostSlowed = Scalar(-0.9999999);

/// Share of the time left that a corner must be reached in to be passed beyond the reach of rounding.
constexpr Scalar kSurely = Scalar(0.999);

/// Below this slope Newton's step is left to the bracket.
constexpr Scalar kLeastSlope_kPa_V = Scalar(1e-6);

/// (r - r_b)/(r_a - r_b) at the ends of the chords: sines of equal angles, between which all chords of an ellipse err alike
/// (0.2 %), the last one halved because an index below 1/2 falls steeper still.
constexpr std::array<Scalar, Greybox::kChords + 1> kChordEnd = {
    0.0F,        0.13052619F, 0.25881905F, 0.38268343F, 0.5F,        0.60876143F, 0.70710678F,
    0.79335334F, 0.86602540F, 0.92387953F, 0.96592583F, 0.99144486F, 0.99785892F, 1.0F};

/// Arguments of smax() at which C(u) is tabulated, dense where it bends; and openings [V], for what the ports do further.
constexpr std::array<Scalar, 15> kBend = {-12.0F, -5.0F, -2.6F, -1.6F, -1.0F, -0.6F, -0.25F, 0.0F,
                                          0.25F,  0.6F,  1.0F,  1.6F,  2.6F,  5.0F,  12.0F};
constexpr std::array<Scalar, 16> kOpening_V = {0.12F, 0.3F, 0.5F, 0.75F, 1.05F, 1.4F, 1.8F, 2.25F,
                                               2.75F, 3.3F, 4.0F, 4.8F,  5.7F,  6.7F, 7.8F, 9.0F};
static_assert(2 + 2 * (kBend.size() + kOpening_V.size()) == Greybox::kNodes);

constexpr Scalar kThinPlateCritical = Scalar(0.5282818);

/// psi_0 of (G3), for a ratio between the critical one and 1.
Scalar thin_plate(Scalar ratio) noexcept {
  constexpr Scalar kChoked = Scalar(0.06698485);  // of the difference below, at the critical ratio
  const Scalar difference =
      numeric::power(ratio, Scalar(2.0 / 1.4)) - numeric::power(ratio, Scalar(2.4 / 1.4));
  return numeric::sqrt(max(difference, Scalar(0)) / kChoked);
}

/// (G3) by its chords, and (G2) from it.
class FlowFunction {
 public:
  explicit FlowFunction(std::span<const Scalar, Greybox::kParameters> of) noexcept
      : discharge_slope_(of[Greybox::kDischargeSlope]) {
    const Scalar width = of[Greybox::kCrackingRatio] - of[Greybox::kCriticalRatio];
    for (std::size_t i = 0; i < ratio_.size(); ++i) {
      ratio_[i] = of[Greybox::kCriticalRatio] + width * kChordEnd[i];
      const Scalar as_plate =
          thin_plate(kThinPlateCritical + (Scalar(1) - kThinPlateCritical) * kChordEnd[i]);
      share_[i] = as_plate > Scalar(0)
                      ? numeric::power(min(as_plate, Scalar(1)), Scalar(2) * of[Greybox::kSubsonicIndex])
                      : Scalar(0);
      share_[i] *= discharge(ratio_[i]);
    }
  }

  Scalar ratio(std::size_t end) const noexcept { return ratio_[end]; }

  /// phi(a, b)
  Scalar flow(Scalar from_kPa, Scalar to_kPa) const noexcept {
    return from_kPa >= to_kPa ? from_kPa * psi(to_kPa / from_kPa) : -to_kPa * psi(from_kPa / to_kPa);
  }
  /// (1 + k (r* - r)), which is psi where the flow is choked
  Scalar discharge(Scalar ratio) const noexcept {
    return Scalar(1) + discharge_slope_ * (kThinPlateCritical - ratio);
  }

 private:
  Scalar psi(Scalar ratio) const noexcept {
    if (ratio <= ratio_.front()) return discharge(ratio);
    if (ratio >= ratio_.back()) return Scalar(0);
    std::size_t i = 1;
    while (i + 1 < ratio_.size() && ratio_[i] < ratio) ++i;
    const Scalar along = (ratio - ratio_[i - 1]) / (ratio_[i] - ratio_[i - 1]);
    return share_[i - 1] + along * (share_[i] - share_[i - 1]);
  }

  Scalar discharge_slope_ = 0;
  std::array<Scalar, Greybox::kChords + 1> ratio_{};
  std::array<Scalar, Greybox::kChords + 1> share_{};
};

/// The opening at which the argument of smax() is `x`, were the area linear.
Scalar opening_V(const config::ValveCurve& port, Scalar x) noexcept {
  return (x * port.transition_mL_s + port.leak_mL_s) / port.gain_mL_s_V;
}

/// std::sort would call itself: a stack of a depth that the values decide.
template <std::size_t count>
void sort(std::array<Scalar, count>& values) noexcept {
  std::make_heap(values.begin(), values.end());
  std::sort_heap(values.begin(), values.end());
}

/// Index of the last of sorted values that is not above `value`; 0 when all are.
template <std::size_t count>
std::size_t last_not_above(const std::array<Scalar, count>& sorted, Scalar value) noexcept {
  const auto above = std::upper_bound(sorted.begin() + 1, sorted.end(), value);
  return static_cast<std::size_t>(above - sorted.begin()) - 1;
}

/// ln(1 + y)/y, 1 at y = 0, for 1 + y > 0.
Scalar log_ratio(Scalar y) noexcept {
  if (abs(y) < Scalar(0.03)) {
    return Scalar(1) - y * (Scalar(0.5) - y * (Scalar(1.0 / 3) - y * (Scalar(0.25) - y * Scalar(0.2))));
  }
  return numeric::log(Scalar(1) + y) / y;
}

}  // namespace

void Greybox::configure(std::span<const Scalar, kParameters> parameters, Scalar command_low_V,
                        Scalar command_high_V) noexcept {
  dead_volume_mL_ = parameters[kDeadVolume];
  volume_exponent_ = parameters[kVolumeExponent];

  const FlowFunction flow(parameters);
  supply_kPa_ = parameters[kSupply];
  ambient_kPa_ = parameters[kAmbient];
  std::size_t corner = 0;
  corner_kPa_[corner++] = Scalar(0);
  for (const Scalar fixed_kPa : {supply_kPa_, ambient_kPa_}) {
    corner_kPa_[corner++] = fixed_kPa;
    for (std::size_t end = 0; end <= kChords; ++end) {
      corner_kPa_[corner++] = fixed_kPa * flow.ratio(end);
      corner_kPa_[corner++] = fixed_kPa / flow.ratio(end);
    }
  }
  sort(corner_kPa_);
  const Scalar leak_mL_s_kPa = Scalar(0.5) * parameters[kChamberLeak] / ambient_kPa_;
  for (std::size_t i = 0; i < kCorners; ++i) {
    const Scalar here_kPa = corner_kPa_[i];
    const Scalar next_kPa = corner_kPa_[std::min(i + 1, kCorners - 1)];
    Side& side = side_[i];
    side.at_corner = {flow.flow(supply_kPa_, here_kPa), flow.flow(here_kPa, ambient_kPa_)};
    side.leak_mL_kPa_s = leak_mL_s_kPa * (here_kPa + ambient_kPa_) * (here_kPa - ambient_kPa_);
    side.leak_slope_mL_s = leak_mL_s_kPa * (here_kPa + next_kPa);
  }
  // beyond the last corner the chamber's own pressure chokes both flows
  side_.back().slope = {-flow.discharge(Scalar(0)), flow.discharge(Scalar(0))};
  for (std::size_t i = 0; i + 1 < kCorners; ++i) {
    side_[i].slope =
        slope_between(side_[i].at_corner, side_[i + 1].at_corner, corner_kPa_[i + 1] - corner_kPa_[i]);
  }

  const config::ValveCurve inlet = config::inlet_of(parameters);
  const config::ValveCurve exhaust = config::exhaust_of(parameters);
  std::size_t filled = 0;
  const auto add_opening = [&](Scalar of_inlet_V, Scalar of_exhaust_V) noexcept {
    node_V_[filled++] = parameters[kOpenAbove] + of_inlet_V;
    node_V_[filled++] = parameters[kExhaustBelow] - of_exhaust_V;
  };
  for (const Scalar x : kBend) add_opening(opening_V(inlet, x), opening_V(exhaust, x));
  for (const Scalar opening : kOpening_V) add_opening(opening, opening);
  node_V_[filled++] = command_low_V;
  node_V_[filled++] = command_high_V;
  for (Scalar& node : node_V_) node = clamp(node, command_low_V, command_high_V);
  sort(node_V_);
  for (std::size_t i = 0; i < kNodes; ++i) {
    node_[i] = {inlet.conductance_mL_s(node_V_[i] - parameters[kOpenAbove]),
                exhaust.conductance_mL_s(parameters[kExhaustBelow] - node_V_[i])};
  }
  // a port that has opened does not shut again as the command goes on: beyond its largest opening it is saturated
  for (std::size_t i = 1; i < kNodes; ++i) {
    node_[i].inlet = max(node_[i].inlet, node_[i - 1].inlet);
    node_[kNodes - 1 - i].exhaust = max(node_[kNodes - 1 - i].exhaust, node_[kNodes - i].exhaust);
  }
  for (std::size_t i = 0; i + 1 < kNodes; ++i) {
    slope_[i] = slope_between(node_[i], node_[i + 1], node_V_[i + 1] - node_V_[i]);
  }
}

/// Zero where two corners, or two commands, are one.
Greybox::Ports Greybox::slope_between(const Ports& from, const Ports& to, Scalar width) noexcept {
  if (width <= Scalar(0)) return {};
  return {(to.inlet - from.inlet) / width, (to.exhaust - from.exhaust) / width};
}

Greybox::Tick Greybox::tick(Scalar pressure_kPa, const ChamberMotion& motion) const noexcept {
  const Scalar volume_mL = clamp(motion.volume_mL + dead_volume_mL_, kLeastVolume_mL, kMostVolume_mL);
  return {.pressure_kPa = clamp(pressure_kPa, Scalar(0), kMostPressure_kPa),
          .per_volume = kTick_s / volume_mL,
          .moved_mL_s = volume_exponent_ * clamp(motion.volume_rate_mL_s, -kMostSpeed_mL_s, kMostSpeed_mL_s)};
}

/// From the last corner that is not above the pressure, which is not below the first: vacuum.
std::size_t Greybox::side_of(Scalar pressure_kPa) const noexcept {
  return last_not_above(corner_kPa_, pressure_kPa);
}

Greybox::Ports Greybox::flows(std::size_t side, Scalar pressure_kPa) const noexcept {
  const Side& of = side_[side];
  const Scalar along_kPa = pressure_kPa - corner_kPa_[side];
  return {of.at_corner.inlet + of.slope.inlet * along_kPa,
          of.at_corner.exhaust + of.slope.exhaust * along_kPa};
}

/// Into the chamber, and its slope: (G1) for a chamber of 1 mL that rests.
Greybox::Rate Greybox::net_flow(std::size_t side, const Ports& at, Scalar pressure_kPa) const noexcept {
  const Ports flow = flows(side, pressure_kPa);
  const Ports& slope = side_[side].slope;
  return {.kPa = at.inlet * flow.inlet - at.exhaust * flow.exhaust,
          .slope = at.inlet * slope.inlet - at.exhaust * slope.exhaust};
}

/// (G1)
Greybox::Rate Greybox::rate(const Tick& tick, std::size_t side, const Ports& at,
                            Scalar pressure_kPa) const noexcept {
  const Rate flow = net_flow(side, at, pressure_kPa);
  const Side& of = side_[side];
  const Scalar leak = of.leak_mL_kPa_s + of.leak_slope_mL_s * (pressure_kPa - corner_kPa_[side]);
  return {.kPa = (flow.kPa - leak - tick.moved_mL_s * pressure_kPa) * tick.per_volume,
          .slope = (flow.slope - of.leak_slope_mL_s - tick.moved_mL_s) * tick.per_volume};
}

/// Goes from piece to piece; returns the pressure at the end [kPa], or the corner that is `enough`.
template <class Visit, class Enough>
Scalar Greybox::travel(const Tick& tick, const Ports& at, Scalar ticks, Visit&& visit,
                       Enough&& enough) const noexcept {
  Piece piece;
  piece.side = side_of(tick.pressure_kPa);
  piece.from_kPa = tick.pressure_kPa;
  Scalar left = ticks;
  for (std::size_t passed = 0; passed < kCorners; ++passed) {
    piece.rate = rate(tick, piece.side, at, piece.from_kPa);
    const bool up = piece.rate.kPa > Scalar(0);
    const std::size_t ahead = piece.side + (up ? 1 : 0);
    const bool has_corner = ahead < kCorners && ahead > 0;
    const Scalar away_kPa = has_corner ? corner_kPa_[ahead] - piece.from_kPa : Scalar(0);
    // at the slower of its speeds here and at the corner it is there in time: no need of an exponential to say so
    const Scalar there = piece.rate.kPa + piece.rate.slope * away_kPa;
    const Scalar surely_kPa = kSurely * left * (up ? min(piece.rate.kPa, there) : max(piece.rate.kPa, there));
    if (!has_corner || !(up ? surely_kPa > away_kPa : surely_kPa < away_kPa)) {
      piece.ticks = left;
      piece.phi_1 = numeric::phi_1(-piece.rate.slope * left);
      const Scalar end_kPa = piece.from_kPa + piece.rate.kPa * left * piece.phi_1;
      if (!has_corner || (up ? end_kPa <= corner_kPa_[ahead] : end_kPa >= corner_kPa_[ahead])) {
        visit(piece);
        return end_kPa;
      }
    }
    const Scalar direct = away_kPa / piece.rate.kPa;  // [ticks], at the speed that it has here
    piece.ticks = min(direct * log_ratio(max(piece.rate.slope * direct, kMostSlowed)), left);
    piece.phi_1 = piece.ticks > Scalar(0) ? direct / piece.ticks : Scalar(1);
    visit(piece);
    if (enough(corner_kPa_[ahead])) return corner_kPa_[ahead];
    left -= piece.ticks;
    piece.from_kPa = corner_kPa_[ahead];
    piece.side = up ? ahead : ahead - 1;
  }
  return piece.from_kPa;
}

template <class Visit>
Scalar Greybox::travel(const Tick& tick, const Ports& at, Scalar ticks, Visit&& visit) const noexcept {
  return travel(tick, at, ticks, visit, [](Scalar) noexcept { return false; });
}

/// A change of the pressure, and of f by what `by` says of it, from the beginning of a piece to its end. f is continuous:
/// a corner passed sooner or later adds nothing.
Scalar Greybox::carried(Scalar change_kPa, const Piece& piece, const Rate& by) noexcept {
  const Scalar x = -piece.rate.slope * piece.ticks;
  const Scalar phi_2 = numeric::phi_2(x, piece.phi_1);
  // d phi_1/dx = phi_2 - phi_1
  const Scalar by_slope = piece.rate.kPa * piece.ticks * (piece.phi_1 - phi_2);
  return change_kPa * (Scalar(1) - x * piece.phi_1) +
         piece.ticks * (by.kPa * piece.phi_1 + by_slope * by.slope);
}

Greybox::Rate Greybox::by_command(const Tick& tick, const Piece& piece, const Ports& slope) const noexcept {
  const Rate flow = net_flow(piece.side, slope, piece.from_kPa);
  return {.kPa = flow.kPa * tick.per_volume, .slope = flow.slope * tick.per_volume};
}

/// The one whose first node is the last that is not above the command.
std::size_t Greybox::segment(Scalar command_V) const noexcept {
  return std::min(last_not_above(node_V_, command_V), kNodes - 2);
}

Greybox::Ports Greybox::conductances(std::size_t segment, Scalar command_V) const noexcept {
  const Scalar along_V = command_V - node_V_[segment];
  return {node_[segment].inlet + slope_[segment].inlet * along_V,
          node_[segment].exhaust + slope_[segment].exhaust * along_V};
}

Prediction Greybox::step(Scalar pressure_kPa, Scalar command_V, const ChamberMotion& motion,
                         Scalar ticks) const noexcept {
  const Scalar command = clamp(command_V, node_V_.front(), node_V_.back());
  const Tick now = tick(pressure_kPa, motion);
  Scalar risen_kPa_ticks = Scalar(0);
  const Scalar end_kPa =
      travel(now, conductances(segment(command), command), ticks, [&](const Piece& piece) noexcept {
        const Scalar phi_2 = numeric::phi_2(-piece.rate.slope * piece.ticks, piece.phi_1);
        const Scalar mean_kPa = piece.from_kPa - now.pressure_kPa + piece.rate.kPa * piece.ticks * phi_2;
        risen_kPa_ticks += mean_kPa * piece.ticks;
      });
  const Scalar risen_kPa = ticks > Scalar(0) ? risen_kPa_ticks / ticks : Scalar(0);
  return {.end_kPa = end_kPa, .mean_kPa = now.pressure_kPa + risen_kPa};
}

Gradient Greybox::derivatives(Scalar pressure_kPa, Scalar command_V,
                              const ChamberMotion& motion) const noexcept {
  const Scalar command = clamp(command_V, node_V_.front(), node_V_.back());
  const std::size_t in = segment(command);
  const Tick now = tick(pressure_kPa, motion);
  const Scalar by_volume = -now.per_volume / kTick_s;  // of the logarithm: f is as 1/(v + v_0)
  const Scalar by_speed = -volume_exponent_ * now.per_volume;
  Gradient by;
  by.by_pressure = Scalar(1);
  travel(now, conductances(in, command), Scalar(1), [&](const Piece& piece) noexcept {
    by.by_pressure = carried(by.by_pressure, piece, {});
    by.by_command_kPa_V = carried(by.by_command_kPa_V, piece, by_command(now, piece, slope_[in]));
    by.by_volume_kPa_mL =
        carried(by.by_volume_kPa_mL, piece, {piece.rate.kPa * by_volume, piece.rate.slope * by_volume});
    by.by_volume_rate_kPa_s_mL =
        carried(by.by_volume_rate_kPa_s_mL, piece, {piece.from_kPa * by_speed, by_speed});
  });
  return by;
}

Scalar Greybox::end_at_node_kPa(const Tick& tick, std::size_t node) const noexcept {
  return travel(tick, node_[node], Scalar(1), [](const Piece&) noexcept {});
}

/// Whether the end is above the target, by as little of the way as decides it: the pressure goes one way.
bool Greybox::ends_above(const Tick& tick, std::size_t node, Scalar target_kPa) const noexcept {
  const bool up = rises(tick, node);
  const bool above = tick.pressure_kPa > target_kPa;
  if (up == above) return above;
  const auto decided = [&](Scalar corner_kPa) noexcept { return (corner_kPa > target_kPa) == up; };
  return travel(
             tick, node_[node], Scalar(1), [](const Piece&) noexcept {}, decided) > target_kPa;
}

bool Greybox::rises(const Tick& tick, std::size_t node) const noexcept {
  return rate(tick, side_of(tick.pressure_kPa), node_[node], tick.pressure_kPa).kPa > Scalar(0);
}

/// Where the pressure rises fastest (sign 1) or falls fastest (sign -1).
std::size_t Greybox::extreme_node(const Tick& tick, Scalar sign) const noexcept {
  const std::size_t side = side_of(tick.pressure_kPa);
  std::size_t best = 0;
  Scalar best_kPa = sign * rate(tick, side, node_[0], tick.pressure_kPa).kPa;
  for (std::size_t i = 1; i < kNodes; ++i) {
    const Scalar kPa = sign * rate(tick, side, node_[i], tick.pressure_kPa).kPa;
    if (kPa > best_kPa) {
      best = i;
      best_kPa = kPa;
    }
  }
  return best;
}

Greybox::Miss Greybox::miss(const Tick& tick, std::size_t segment, Scalar target_kPa,
                            Scalar command_V) const noexcept {
  Miss made;
  made.command_V = command_V;
  made.kPa = travel(tick, conductances(segment, command_V), Scalar(1), [&](const Piece& piece) noexcept {
    made.by_V = carried(made.by_V, piece, by_command(tick, piece, slope_[segment]));
  });
  made.kPa -= target_kPa;
  return made;
}

/// The end rises with the command, so that there is one answer; but above the supply's pressure an open inlet empties the
/// chamber, below the ambient's an open exhaust fills it: there the limit is the valve as good as shut.
Inverse Greybox::inverse(Scalar pressure_kPa, Scalar target_kPa, const ChamberMotion& motion,
                         Scalar /*near_V*/) const noexcept {
  const Tick now = tick(pressure_kPa, motion);
  const auto out_of_reach = [&](std::size_t limit, Scalar reached_kPa) -> Inverse {
    return {.command_V = node_V_[limit],
            .reached_kPa = reached_kPa,
            .saturated = abs(reached_kPa - target_kPa) > kClose_kPa};
  };
  std::size_t low = now.pressure_kPa < ambient_kPa_ ? extreme_node(now, Scalar(-1)) : 0;
  std::size_t high = now.pressure_kPa > supply_kPa_ ? extreme_node(now, Scalar(1)) : kNodes - 1;
  if (now.pressure_kPa >= target_kPa || rises(now, low)) {
    const Scalar least_kPa = end_at_node_kPa(now, low);
    if (least_kPa >= target_kPa) return out_of_reach(low, least_kPa);
  }
  if (!ends_above(now, high, target_kPa)) return out_of_reach(high, end_at_node_kPa(now, high));
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (ends_above(now, middle, target_kPa) ? high : low) = middle;
  }

  // Newton's method; where it would leave the bracket, the bracket is halved
  Scalar low_V = node_V_[low], high_V = node_V_[low + 1];
  Miss best = miss(now, low, target_kPa, low_V);
  Miss here = best;
  for (int i = 0; i < kRefinements && abs(best.kPa) > kClose_kPa; ++i) {
    Scalar next_V = here.command_V - here.kPa / max(here.by_V, kLeastSlope_kPa_V);
    if (!(next_V > low_V && next_V < high_V)) next_V = Scalar(0.5) * (low_V + high_V);
    here = miss(now, low, target_kPa, next_V);
    (here.kPa > Scalar(0) ? high_V : low_V) = next_V;
    if (abs(here.kPa) < abs(best.kPa)) best = here;
  }
  return {.command_V = best.command_V, .reached_kPa = target_kPa + best.kPa, .saturated = false};
}

}  // namespace plenum::control
