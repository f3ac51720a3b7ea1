#include "firmware/control/tassa9.hpp"

#include <bit>

#include "firmware/config/limits.hpp"

namespace plenum::control {
namespace {

using numeric::abs;
using numeric::clamp;
using numeric::max;
using numeric::min;

constexpr Scalar kTick_s = Scalar(config::kTick_s);

/// The sensor's volume may be off by its noise near an empty chamber; the denominator of (10e) stays
/// positive.
constexpr Scalar kSmallestVolumeFactor = Scalar(1e-3);

/// A crossing is found when the pressure misses its target by less than this: a hundredth of a 16 bit
/// converter's step over 1000 kPa, far below the noise of any sensor.
constexpr Scalar kCrossing_kPa = Scalar(2e-4);

/// Where no command reaches the target, the limit of the range on its side is taken when it comes as close as
/// the closest command but for this share of P_c - P_r. The flow of a valve rises with its command; that s of
/// a moving volume, or a small r, ranks another command first by a little is the formula's doing (c4 v'
/// shifts s of an open exhaust too).
constexpr Scalar kLimitServes = Scalar(0.01);

/// Commands nearer to each other than this are one: two units in the last place of a float at 8 V.
constexpr Scalar kSameCommand_V = Scalar(2e-6);

/// What is computed for every node lies in lanes, to be computed side by side: lane k holds kPerLane nodes
/// that follow each other, and the first of each lane come first.
constexpr std::size_t kLanes = 4;
constexpr std::size_t kPerLane = Tassa9::kNodes / kLanes;
static_assert(kPerLane * kLanes == Tassa9::kNodes && kPerLane <= 32);

constexpr std::size_t place(std::size_t node) noexcept {
  return kLanes * (node % kPerLane) + node / kPerLane;
}

/// Distances of the tabulated commands from the null c1 [V]. Dense where the curves bend (c_gamma and the
/// flat kink are tenths of a volt wide), sparse where they are nearly straight; from there to the ends of the
/// command range the two outermost nodes are the ends themselves.
constexpr std::array<Scalar, (Tassa9::kNodes - 2) / 2> kDistances_V = {
    0.007F, 0.022F, 0.045F, 0.08F, 0.13F, 0.19F, 0.28F, 0.4F, 0.58F, 0.83F, 1.2F, 1.75F, 2.6F, 3.8F, 5.8F};

}  // namespace

void Tassa9::configure(std::span<const Scalar, kParameters> parameters, Scalar command_low_V,
                       Scalar command_high_V) noexcept {
  c1_ = parameters[0];
  c2_ = parameters[1];
  c3_ = parameters[2];
  c4_ = parameters[3];
  c5_ = parameters[4];
  c6_ = parameters[5];
  c7_ = parameters[6];
  c8_ = parameters[7];
  c9_ = parameters[8];
  c_gamma_ = parameters[9];
  c_b_ = (parameters[10] + parameters[11]) * Scalar(0.5);
  c_s_ = (parameters[10] - parameters[11]) * Scalar(0.5);

  constexpr std::size_t kHalf = kDistances_V.size();
  node_V_.front() = command_low_V;
  node_V_.back() = command_high_V;
  for (std::size_t i = 0; i < kHalf; ++i) {
    node_V_[kHalf - i] = clamp(c1_ - kDistances_V[i], command_low_V, command_high_V);
    node_V_[kHalf + 1 + i] = clamp(c1_ + kDistances_V[i], command_low_V, command_high_V);
  }
  apart_ = 0;
  for (std::size_t i = 0; i < kNodes; ++i) {
    const CurveAndSlopes at_node = curve_and_slopes(node_V_[i]);
    node_steady_kPa_[place(i)] = at_node.curve.steady_kPa;
    node_opening_V_[place(i)] = at_node.curve.opening_V;
    node_slopes_[i] = at_node.by_V;
    if (i + 1 < kNodes && node_V_[i] != node_V_[i + 1]) apart_ |= std::uint64_t{1} << i;
  }
}

Tassa9::Curve Tassa9::curve(Scalar command_V) const noexcept {
  const Scalar u = command_V - c1_;                       // (10a)
  const Scalar x = (c2_ + c3_ * u * u) * u;               // argument of (10b)
  const Scalar g = x / numeric::sqrt(x * x + Scalar(1));  // (8)
  const Scalar root = numeric::sqrt(u * u + c_gamma_ * c_gamma_);
  return {.steady_kPa = c_b_ + c_s_ * g, .opening_V = root - c_gamma_ + c9_ + c8_ * u};  // (10c), (9)
}

Tassa9::CurveAndSlopes Tassa9::curve_and_slopes(Scalar command_V) const noexcept {
  const Scalar u = command_V - c1_;
  const Scalar x = (c2_ + c3_ * u * u) * u;
  const Scalar inverse_root = Scalar(1) / numeric::sqrt(x * x + Scalar(1));
  const Scalar root = numeric::sqrt(u * u + c_gamma_ * c_gamma_);
  // g' = (x^2+1)^(-3/2)
  const Scalar g_by_u = (c2_ + Scalar(3) * c3_ * u * u) * inverse_root * inverse_root * inverse_root;
  return {
      .curve = {.steady_kPa = c_b_ + c_s_ * (x * inverse_root), .opening_V = root - c_gamma_ + c9_ + c8_ * u},
      .by_V = {.steady_kPa_V = c_s_ * g_by_u, .opening = u / root + c8_}};
}

Tassa9::Tick Tassa9::tick(Scalar pressure_kPa, const ChamberMotion& motion) const noexcept {
  const Scalar per_volume = kTick_s / max(Scalar(1) + c6_ * motion.volume_mL, kSmallestVolumeFactor);
  return {.pressure_kPa = pressure_kPa,
          .steady_shift_kPa = c4_ * motion.volume_rate_mL_s,
          .rate_gain = c7_ * per_volume,
          .rate_shift = c5_ * motion.volume_rate_mL_s * per_volume};
}

/// d rise / d u, rise = (s - p) done, done = 1 - e^-rh; where the exponent is limited, rh has no part in it.
Scalar Tassa9::slope(const Tick& tick, const CurveAndSlopes& at, Scalar done) noexcept {
  const Scalar rh = tick.rate_gain * at.curve.opening_V + tick.rate_shift;
  const bool exponent_free = rh > Scalar(0) && rh < numeric::kDecayHigh;
  const Scalar away_kPa = at.curve.steady_kPa + tick.steady_shift_kPa - tick.pressure_kPa;
  const Scalar by_rh_kPa = exponent_free ? away_kPa * (Scalar(1) - done) : Scalar(0);
  return at.by_V.steady_kPa_V * done + by_rh_kPa * tick.rate_gain * at.by_V.opening;
}

Tassa9::Miss Tassa9::miss(const Tick& tick, Scalar wanted_kPa, Scalar command_V) const noexcept {
  const CurveAndSlopes at = curve_and_slopes(command_V);
  const Scalar done = numeric::decay(tick.rate_gain * at.curve.opening_V + tick.rate_shift);
  const Scalar steady_kPa = at.curve.steady_kPa + tick.steady_shift_kPa;
  return {.command_V = command_V,
          .kPa = (steady_kPa - tick.pressure_kPa) * done - wanted_kPa,
          .by_V = slope(tick, at, done)};
}

Prediction Tassa9::step(Scalar pressure_kPa, Scalar command_V, const ChamberMotion& motion,
                        Scalar ticks) const noexcept {
  const Tick now = tick(pressure_kPa, motion);
  const Curve at = curve(command_V);
  const Scalar steady = at.steady_kPa + now.steady_shift_kPa;
  const Scalar rh = (now.rate_gain * at.opening_V + now.rate_shift) * ticks;
  const Scalar done = numeric::decay(rh);
  return {.end_kPa = pressure_kPa + (steady - pressure_kPa) * done,  // (7)
          .mean_kPa = steady + (pressure_kPa - steady) * numeric::mean_decay(rh, done)};
}

Gradient Tassa9::derivatives(Scalar pressure_kPa, Scalar command_V,
                             const ChamberMotion& motion) const noexcept {
  const Tick now = tick(pressure_kPa, motion);
  const CurveAndSlopes at = curve_and_slopes(command_V);
  const Scalar steady = at.curve.steady_kPa + now.steady_shift_kPa;
  const Scalar rh = now.rate_gain * at.curve.opening_V + now.rate_shift;
  const Scalar done = numeric::decay(rh);
  const bool exponent_free = rh > Scalar(0) && rh < numeric::kDecayHigh;
  // d end / d(rh) = (s - p) e^-rh; zero where the exponent is limited
  const Scalar by_rh = exponent_free ? (steady - pressure_kPa) * (Scalar(1) - done) : Scalar(0);

  const Scalar volume_factor = Scalar(1) + c6_ * motion.volume_mL;
  const bool volume_free = volume_factor > kSmallestVolumeFactor;
  const Scalar rh_by_volume = volume_free ? -rh * c6_ / volume_factor : Scalar(0);
  const Scalar per_volume = kTick_s / max(volume_factor, kSmallestVolumeFactor);
  return {.by_pressure = Scalar(1) - done,
          .by_command_kPa_V = slope(now, at, done),
          .by_volume_kPa_mL = by_rh * rh_by_volume,
          .by_volume_rate_kPa_s_mL = c4_ * done + by_rh * c5_ * per_volume};
}

/// The zero of the miss between two commands at which its signs differ.
Tassa9::Miss Tassa9::refine(const Tick& tick, Scalar wanted_kPa, Miss low, Miss high) const noexcept {
  Miss best = abs(low.kPa) < abs(high.kPa) ? low : high;
  if (abs(best.kPa) <= kCrossing_kPa) return best;
  // First the zero of the cubic that has the commands of both ends and the slopes there, as a function of the
  // miss; slopes that would make it turn back are limited (Fritsch and Carlson 1980).
  const Scalar width_V = high.command_V - low.command_V;
  const Scalar rise = high.kPa - low.kPa;
  const Scalar t = -low.kPa / rise;
  const Scalar rest = Scalar(1) - t;
  const Scalar slope_low = clamp(rise / (low.by_V * width_V), Scalar(0), Scalar(3));
  const Scalar slope_high = clamp(rise / (high.by_V * width_V), Scalar(0), Scalar(3));
  const Scalar share =
      t * (t * (Scalar(3) - Scalar(2) * t) + slope_low * rest * rest - slope_high * t * rest);
  Scalar command_V = low.command_V + clamp(share, Scalar(0.001), Scalar(0.999)) * width_V;
  // Then Newton's method inside the bracket. Where a step would leave it, the step from its other end is
  // taken (at r = 0, on one side of a corner, there is no slope); where that leaves it too, or a step did not
  // halve the miss, the bracket is halved. A step is not tried out when the curvature leaves nothing to gain.
  Scalar before_kPa = max(abs(low.kPa), abs(high.kPa));
  for (int i = 0; i < kRefinements; ++i) {
    const Miss here = miss(tick, wanted_kPa, command_V);
    if (abs(here.kPa) < abs(best.kPa)) best = here;
    if (abs(best.kPa) <= kCrossing_kPa) break;
    const bool as_low = (here.kPa > Scalar(0)) == (low.kPa > Scalar(0));
    const Miss& ahead = as_low ? high : low;
    const Scalar step_V = -here.kPa / here.by_V;
    const Scalar room_V = ahead.command_V - command_V;
    const Scalar part = step_V / room_V;
    const bool inside = part > Scalar(0) && part < Scalar(1);
    if (inside && abs((ahead.by_V - here.by_V) * part * step_V) <= Scalar(2) * kCrossing_kPa) {
      return {.command_V = command_V + step_V, .kPa = Scalar(0), .by_V = here.by_V};
    }
    Scalar next_V = command_V + step_V;
    if (!inside) next_V = ahead.command_V - ahead.kPa / ahead.by_V;
    const bool still_inside =
        (next_V - command_V) * room_V > Scalar(0) && (ahead.command_V - next_V) * room_V > Scalar(0);
    if (!still_inside || abs(here.kPa) > Scalar(0.5) * before_kPa) next_V = command_V + Scalar(0.5) * room_V;
    if (abs(next_V - command_V) < kSameCommand_V) break;
    (as_low ? low : high) = here;
    before_kPa = abs(here.kPa);
    command_V = next_V;
  }
  return best;
}

/// No command tabulated crosses the target. `best` comes nearest, and the miss shrinks from there towards
/// `other`, where it is larger again: an extremum between the two comes closer, or crosses.
Tassa9::Miss Tassa9::closest(const Tick& tick, Scalar wanted_kPa, Miss best, Miss other) const noexcept {
  Miss near = best;
  for (int i = 0; i < kExtremumSteps; ++i) {
    // The zero of the slope, by secants.
    const Scalar share = clamp(near.by_V / (near.by_V - other.by_V), Scalar(0.1), Scalar(0.9));
    const Miss here = miss(tick, wanted_kPa, near.command_V + share * (other.command_V - near.command_V));
    if ((here.kPa < Scalar(0)) != (best.kPa < Scalar(0))) {
      return here.command_V < near.command_V ? refine(tick, wanted_kPa, here, near)
                                             : refine(tick, wanted_kPa, near, here);
    }
    if (abs(here.kPa) < abs(best.kPa)) best = here;
    ((here.by_V > Scalar(0)) == (near.by_V > Scalar(0)) ? near : other) = here;
    if (abs(here.by_V * (other.command_V - near.command_V)) < kCrossing_kPa) break;
  }
  return best;
}

namespace {

using Nodes = std::array<Scalar, Tassa9::kNodes>;

/// Bit i: which(value of node i). The lanes run side by side, each through its nodes from the last to the
/// first.
template <class Which>
std::uint64_t nodes_where(const Nodes& value, Which which) noexcept {
  std::array<std::uint32_t, kLanes> lane{};
  for (std::size_t first = Tassa9::kNodes; first > 0; first -= kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      lane[k] = lane[k] + lane[k] + (which(value[first - kLanes + k]) ? 1U : 0U);
    }
  }
  std::uint64_t nodes = 0;
  for (std::size_t k = 0; k < kLanes; ++k) nodes |= std::uint64_t{lane[k]} << (k * kPerLane);
  return nodes;
}

/// The first of the nodes that come closest.
std::size_t nearest_node(const Nodes& miss_kPa) noexcept {
  std::array<Scalar, kLanes> least;  // squares: no branch, and no bit of a float is looked at
  least.fill(miss_kPa[0] * miss_kPa[0]);
  for (std::size_t first = 0; first < Tassa9::kNodes; first += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      least[k] = min(least[k], miss_kPa[first + k] * miss_kPa[first + k]);
    }
  }
  const Scalar best = min(min(least[0], least[1]), min(least[2], least[3]));
  const std::uint64_t where = nodes_where(miss_kPa, [best](Scalar x) noexcept { return x * x <= best; });
  return where == 0 ? 0 : static_cast<std::size_t>(std::countr_zero(where));
}

}  // namespace

/// The node below the crossing that inverse() is to answer with; kNodes when no two nodes lie on either side.
std::size_t Tassa9::crossing(const std::array<Scalar, kNodes>& miss_kPa, Scalar near_V) const noexcept {
  const std::uint64_t above = nodes_where(miss_kPa, [](Scalar x) noexcept { return x > Scalar(0); });
  const std::uint64_t rising = ~above & above >> 1U & apart_;
  const std::uint64_t falling = above & ~(above >> 1U) & apart_;
  std::size_t chosen = kNodes;
  Scalar chosen_V = 0;  // its distance
  for (std::uint64_t left = rising != 0 ? rising : falling; left != 0; left &= left - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(left));
    const Scalar distance_V = max(max(node_V_[i] - near_V, near_V - node_V_[i + 1]), Scalar(0));
    if (chosen < kNodes && !(distance_V < chosen_V)) continue;
    chosen = i;
    chosen_V = distance_V;
  }
  return chosen;
}

/// The next node above or below that is not at the same command; `node` itself at the end of the range.
std::size_t Tassa9::beside(std::size_t node, bool above) const noexcept {
  std::size_t i = node;
  while (node_V_[i] == node_V_[node]) {
    if (i == (above ? kNodes - 1 : 0)) return node;
    i = above ? i + 1 : i - 1;
  }
  return i;
}

Inverse Tassa9::inverse(Scalar pressure_kPa, Scalar target_kPa, const ChamberMotion& motion,
                        Scalar near_V) const noexcept {
  const Tick now = tick(pressure_kPa, motion);
  const Scalar wanted_kPa = target_kPa - pressure_kPa;

  // How far each tabulated command misses. p(t+h) rises with the command almost everywhere, but near the null
  // r may fall faster than s rises: up to a few stretches of either slope, told apart here by their signs at
  // the nodes.
  std::array<Scalar, kNodes> done;
  for (std::size_t i = 0; i < kNodes; ++i) {
    done[i] = numeric::decay(now.rate_gain * node_opening_V_[i] + now.rate_shift);
  }
  std::array<Scalar, kNodes> miss_kPa;
  for (std::size_t i = 0; i < kNodes; ++i) {
    const Scalar steady_kPa = node_steady_kPa_[i] + now.steady_shift_kPa;
    miss_kPa[i] = (steady_kPa - pressure_kPa) * done[i] - wanted_kPa;
  }
  const auto at_node = [&](std::size_t i) noexcept -> Miss {
    const std::size_t k = place(i);
    const CurveAndSlopes at{{node_steady_kPa_[k], node_opening_V_[k]}, node_slopes_[i]};
    return {.command_V = node_V_[i], .kPa = miss_kPa[k], .by_V = slope(now, at, done[k])};
  };

  Miss found{};
  bool saturated = false;
  if (const std::size_t below = crossing(miss_kPa, near_V); below < kNodes) {
    found = refine(now, wanted_kPa, at_node(below), at_node(below + 1));
  } else {
    const std::size_t nearest = nearest_node(miss_kPa);
    found = at_node(nearest);
    const bool short_of = found.kPa < Scalar(0);
    const std::size_t other = beside(nearest, (found.by_V > Scalar(0)) == short_of);
    if (other != nearest && found.by_V != Scalar(0)) found = closest(now, wanted_kPa, found, at_node(other));
    saturated = abs(found.kPa) > kCrossing_kPa && (found.kPa < Scalar(0)) == short_of;
    // Out of reach: full opening on the side of the target, the strongest that any valve can do.
    const std::size_t limit = short_of ? kNodes - 1 : 0;
    const Scalar limit_kPa = miss_kPa[place(limit)];
    if (saturated && abs(limit_kPa) <= abs(found.kPa) + kLimitServes * Scalar(2) * c_s_) {
      found = {.command_V = node_V_[limit], .kPa = limit_kPa, .by_V = Scalar(0)};
    }
  }
  return {.command_V = found.command_V, .reached_kPa = target_kPa + found.kPa, .saturated = saturated};
}

}  // namespace plenum::control
