#include "firmware/control/tassa9.hpp"

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

/// Distances of the tabulated commands from the null c1 [V]. Dense where the curves bend (c_gamma and the
/// flat kink are tenths of a volt wide), sparse where they are nearly straight; from there to the ends of the
/// command range the two outermost nodes are the ends themselves.
constexpr std::array<Scalar, (Tassa9::kNodes - 2) / 2> kDistances_V = {
    0.006F, 0.02F, 0.04F, 0.065F, 0.1F, 0.14F, 0.19F, 0.26F, 0.35F, 0.47F,
    0.62F,  0.8F,  1.05F, 1.4F,   1.8F, 2.4F,  3.2F,  4.3F,  6.0F};

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
  for (std::size_t i = 0; i < kNodes; ++i) {
    const Curve at_node = curve(node_V_[i]);
    node_steady_kPa_[i] = at_node.steady_kPa;
    node_opening_V_[i] = at_node.opening_V;
  }
}

Tassa9::Curve Tassa9::curve(Scalar command_V) const noexcept {
  const Scalar u = command_V - c1_;                       // (10a)
  const Scalar x = (c2_ + c3_ * u * u) * u;               // argument of (10b)
  const Scalar g = x / numeric::sqrt(x * x + Scalar(1));  // (8)
  const Scalar root = numeric::sqrt(u * u + c_gamma_ * c_gamma_);
  return {.steady_kPa = c_b_ + c_s_ * g, .opening_V = root - c_gamma_ + c9_ + c8_ * u};  // (10c), (9)
}

Tassa9::Tick Tassa9::tick(Scalar pressure_kPa, const ChamberMotion& motion) const noexcept {
  const Scalar per_volume = kTick_s / max(Scalar(1) + c6_ * motion.volume_mL, kSmallestVolumeFactor);
  return {.pressure_kPa = pressure_kPa,
          .steady_shift_kPa = c4_ * motion.volume_rate_mL_s,
          .rate_gain = c7_ * per_volume,
          .rate_shift = c5_ * motion.volume_rate_mL_s * per_volume};
}

Scalar Tassa9::rise(const Tick& tick, const Curve& curve) noexcept {
  const Scalar steady = curve.steady_kPa + tick.steady_shift_kPa;
  return (steady - tick.pressure_kPa) * numeric::decay(tick.rate_gain * curve.opening_V + tick.rate_shift);
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
  const Scalar u = command_V - c1_;
  const Scalar x = (c2_ + c3_ * u * u) * u;
  const Scalar inverse_root = Scalar(1) / numeric::sqrt(x * x + Scalar(1));
  const Scalar slope_x = c2_ + Scalar(3) * c3_ * u * u;
  const Scalar steady_by_u =
      c_s_ * slope_x * inverse_root * inverse_root * inverse_root;  // g' = (x^2+1)^(-3/2)
  const Scalar root = numeric::sqrt(u * u + c_gamma_ * c_gamma_);
  const Scalar opening_by_u = u / root + c8_;

  const Scalar steady = c_b_ + c_s_ * x * inverse_root + now.steady_shift_kPa;
  const Scalar rh = now.rate_gain * (root - c_gamma_ + c9_ + c8_ * u) + now.rate_shift;
  const Scalar done = numeric::decay(rh);
  const bool exponent_free = rh > Scalar(0) && rh < numeric::kDecayHigh;
  // d end / d(rh) = (s - p) e^-rh; zero where the exponent is limited
  const Scalar by_rh = exponent_free ? (steady - pressure_kPa) * (Scalar(1) - done) : Scalar(0);

  const Scalar volume_factor = Scalar(1) + c6_ * motion.volume_mL;
  const bool volume_free = volume_factor > kSmallestVolumeFactor;
  const Scalar rh_by_volume = volume_free ? -rh * c6_ / volume_factor : Scalar(0);
  const Scalar per_volume = kTick_s / max(volume_factor, kSmallestVolumeFactor);
  return {.by_pressure = Scalar(1) - done,
          .by_command_kPa_V = steady_by_u * done + by_rh * now.rate_gain * opening_by_u,
          .by_volume_kPa_mL = by_rh * rh_by_volume,
          .by_volume_rate_kPa_s_mL = c4_ * done + by_rh * c5_ * per_volume};
}

Scalar Tassa9::refine(const Tick& tick, Scalar wanted_kPa, Bracket bracket) const noexcept {
  // Regula falsi with the Illinois rule: an end that stays twice in a row counts half, so both ends close in.
  Scalar low_weight = bracket.low_kPa;
  Scalar high_weight = bracket.high_kPa;
  Scalar best_V = abs(bracket.low_kPa) < abs(bracket.high_kPa) ? bracket.low_V : bracket.high_V;
  Scalar best_kPa = min(abs(bracket.low_kPa), abs(bracket.high_kPa));
  int stayed = 0;
  for (int i = 0; i < kRefinements && best_kPa > kCrossing_kPa; ++i) {
    const Scalar fall = low_weight - high_weight;
    // Every third step halves the bracket, later every second: where r becomes 0 the curve has a corner, and
    // the bound on the bracket's width must not rest on its shape.
    const bool halve = (i < kRefinements / 4 ? i % 3 == 2 : i % 2 == 0) || fall == Scalar(0);
    const Scalar share = halve ? Scalar(0.5) : clamp(low_weight / fall, Scalar(0.01), Scalar(0.99));
    const Scalar middle_V = bracket.low_V + share * (bracket.high_V - bracket.low_V);
    const Scalar miss = rise(tick, middle_V) - wanted_kPa;
    if (abs(miss) < best_kPa) {
      best_kPa = abs(miss);
      best_V = middle_V;
    }
    if ((miss > Scalar(0)) == (bracket.low_kPa > Scalar(0))) {
      bracket.low_V = middle_V;
      low_weight = miss;
      if (stayed > 0) high_weight *= Scalar(0.5);
      stayed = 1;
    } else {
      bracket.high_V = middle_V;
      high_weight = miss;
      if (stayed < 0) low_weight *= Scalar(0.5);
      stayed = -1;
    }
  }
  return best_V;
}

Inverse Tassa9::inverse(Scalar pressure_kPa, Scalar target_kPa, const ChamberMotion& motion,
                        Scalar near_V) const noexcept {
  const Tick now = tick(pressure_kPa, motion);
  const Scalar wanted_kPa = target_kPa - pressure_kPa;

  // How far each tabulated command misses. p(t+h) rises with the command almost everywhere, but near the null
  // r may fall faster than s rises: up to a few stretches of either slope, told apart here by their signs at
  // the nodes.
  std::array<Scalar, kNodes> miss_kPa;
  for (std::size_t i = 0; i < kNodes; ++i) {
    miss_kPa[i] =
        rise(now, {.steady_kPa = node_steady_kPa_[i], .opening_V = node_opening_V_[i]}) - wanted_kPa;
  }

  std::size_t nearest = 0;        // node that comes closest
  std::size_t crossing = kNodes;  // bracket chosen: [crossing, crossing + 1]
  bool crossing_rises = false;
  Scalar crossing_distance_V = 0;
  for (std::size_t i = 0; i < kNodes; ++i) {
    if (abs(miss_kPa[i]) < abs(miss_kPa[nearest])) nearest = i;
    if (i + 1 == kNodes || node_V_[i] == node_V_[i + 1]) continue;
    const bool rises = miss_kPa[i] <= Scalar(0) && miss_kPa[i + 1] >= Scalar(0);
    const bool falls = miss_kPa[i] >= Scalar(0) && miss_kPa[i + 1] <= Scalar(0);
    if (!rises && !falls) continue;
    const Scalar distance_V = max(max(node_V_[i] - near_V, near_V - node_V_[i + 1]), Scalar(0));
    const bool better = crossing == kNodes || (rises && !crossing_rises) ||
                        (rises == crossing_rises && distance_V < crossing_distance_V);
    if (better) {
      crossing = i;
      crossing_rises = rises;
      crossing_distance_V = distance_V;
    }
  }

  const bool below = miss_kPa[nearest] < Scalar(0);
  const std::size_t limit = below ? kNodes - 1 : 0;
  Scalar command_V = node_V_[nearest];
  bool saturated = false;
  if (crossing < kNodes) {
    command_V =
        refine(now, wanted_kPa,
               {node_V_[crossing], node_V_[crossing + 1], miss_kPa[crossing], miss_kPa[crossing + 1]});
  } else {
    // No node on the other side of the target. An extremum between
    // nodes may still come closer, or reach it.
    saturated = true;
    // Nodes that the command range cut off lie on its ends: the neighbours are the nearest ones elsewhere.
    std::size_t below_node = nearest;
    std::size_t above_node = nearest;
    while (below_node > 0 && node_V_[below_node] == command_V) --below_node;
    while (above_node + 1 < kNodes && node_V_[above_node] == command_V) ++above_node;
    Scalar low_V = node_V_[below_node];
    Scalar high_V = node_V_[above_node];
    Scalar best_kPa = abs(miss_kPa[nearest]);
    for (int i = 0; i < kExtremumSteps && saturated; ++i) {
      // The larger side of the best point so far is probed; golden section keeps the ratio of the two.
      const bool probe_high = high_V - command_V > command_V - low_V;
      const Scalar probe_V = command_V + Scalar(0.381966) * ((probe_high ? high_V : low_V) - command_V);
      const Scalar miss = rise(now, probe_V) - wanted_kPa;
      if ((miss < Scalar(0)) != below) {
        const Scalar here = rise(now, command_V) - wanted_kPa;
        command_V = probe_high ? refine(now, wanted_kPa, {command_V, probe_V, here, miss})
                               : refine(now, wanted_kPa, {probe_V, command_V, miss, here});
        saturated = false;
      } else if (abs(miss) < best_kPa) {
        (probe_high ? low_V : high_V) = command_V;
        command_V = probe_V;
        best_kPa = abs(miss);
      } else {
        (probe_high ? high_V : low_V) = probe_V;
      }
    }
    // Out of reach: full opening on the side of the target, the strongest that any valve can do.
    const bool limit_serves = abs(miss_kPa[limit]) <= best_kPa + kLimitServes * Scalar(2) * c_s_;
    if (saturated && limit_serves) command_V = node_V_[limit];
  }
  return {.command_V = command_V, .reached_kPa = pressure_kPa + rise(now, command_V), .saturated = saturated};
}

}  // namespace plenum::control
