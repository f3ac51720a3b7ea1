// The command that takes the pressure to a target in one tick, of a model whose tick depends on the command through
// CommandCurve alone.
//
// Such a model is a Law: one tick with pressure and motion put in, so that a command is all that is left open.
//   Response response(Scalar opening_V)                            what the rise needs of the time
//   Scalar rise_kPa(CommandCurve::Point, Response)                 p(t+h) - p(t)
//   Scalar slope_kPa_V(CommandCurve::Tangent, Response)            and its derivative by the command: unless_limited()
//   void misses(nodes, wanted_kPa, response, miss_kPa)             at every node the response, and the rise less the one wanted,
//                                                                  without a branch
//
// README.md of this room says why it looks at a table first. At most kExtremumSteps + kRefinements evaluations of the rise
// with its slope, besides those at the nodes.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "firmware/control/command_curve.hpp"
#include "firmware/control/pressure_model.hpp"

namespace plenum::control {

using AtNodes = CommandCurve::At<Scalar>;  // here in lanes

/// Bit i: node i misses above. The lanes run side by side, each through its nodes from the last to the first.
inline std::uint64_t nodes_above(const AtNodes& miss_kPa) noexcept {
  constexpr std::size_t kLanes = CommandCurve::kLanes;
  std::array<std::uint32_t, kLanes> lane{};
  for (std::size_t first = CommandCurve::kNodes; first > 0; first -= kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      lane[k] = lane[k] + lane[k] + (miss_kPa[first - kLanes + k] > Scalar(0) ? 1U : 0U);
    }
  }
  std::uint64_t nodes = 0;
  for (std::size_t k = 0; k < kLanes; ++k) nodes |= std::uint64_t{lane[k]} << (k * CommandCurve::kPerLane);
  return nodes;
}

/// The first of the nodes that come closest, where they miss on one side all: above (x > 0) or not.
inline std::size_t nearest_node(const AtNodes& miss_kPa, bool above) noexcept {
  constexpr std::size_t kLanes = CommandCurve::kLanes, kPerLane = CommandCurve::kPerLane;
  const auto first_of = [&miss_kPa](auto nearer) noexcept {
    std::array<Scalar, kLanes> nearest;
    std::array<std::uint32_t, kLanes> at{};  // of the lane's nodes
    for (std::size_t k = 0; k < kLanes; ++k) nearest[k] = miss_kPa[k];
    for (std::uint32_t i = 1; i < kPerLane; ++i) {
      for (std::size_t k = 0; k < kLanes; ++k) {
        const Scalar other = miss_kPa[kLanes * i + k];
        const std::uint32_t mask = nearer(other, nearest[k]) ? ~0U : 0U;  // lanes have no branches
        nearest[k] = nearer(other, nearest[k]) ? other : nearest[k];
        at[k] = (i & mask) | (at[k] & ~mask);
      }
    }
    std::size_t lane = 0;
    for (std::size_t k = 1; k < kLanes; ++k) lane = nearer(nearest[k], nearest[lane]) ? k : lane;
    return lane * kPerLane + at[lane];
  };
  return above ? first_of([](Scalar a, Scalar b) noexcept { return a < b; })
               : first_of([](Scalar a, Scalar b) noexcept { return a > b; });
}

/// `slope` where no product that it is made of was limited; else the steepest to its side, which is known to be none.
inline Scalar unless_limited(bool limited, Scalar slope) noexcept {
  constexpr Scalar kLimit = Scalar(1 << kSteepest);
  if (!limited) return slope;
  return slope < Scalar(0) ? -kLimit : kLimit;
}
inline bool is_limited(Scalar product) noexcept {
  return numeric::abs(product) >= Scalar(1 << kSteepest);
}

template <class Law>
class InverseSearch {
 public:
  InverseSearch(const CommandCurve& curve, const Law& law, Scalar pressure_kPa, Scalar target_kPa) noexcept
      : curve_(curve), law_(law), target_kPa_(target_kPa), wanted_kPa_(target_kPa - pressure_kPa) {}

  Inverse find(Scalar near_V) const noexcept;

  static constexpr int kRefinements = 12;
  static constexpr int kExtremumSteps = 4;

 private:
  static constexpr std::size_t kNodes = CommandCurve::kNodes;
  /// A crossing is found when the pressure misses its target by less than this: a hundredth of a 16 bit
  /// converter's step over 1000 kPa, far below the noise of any sensor.
  static constexpr Scalar kCrossing_kPa = Scalar(2e-4);
  /// Where no command reaches the target, the limit of the range on its side is taken when it comes as close as
  /// the closest command but for this share of P_c - P_r. The flow of a valve rises with its command; that s of
  /// a moving volume, or a small r, ranks another command first by a little is the formula's doing (c4 v'
  /// shifts s of an open exhaust too).
  static constexpr Scalar kLimitServes = Scalar(0.01);
  /// [bits, V] A step of 2^this leaves every bracket.
  static constexpr int kBeyond = 4;
  /// Commands nearer to each other than this are one: two units in the last place of a float at 8 V.
  static constexpr Scalar kSameCommand_V = Scalar(2e-6);

  /// How far a command misses the wanted rise, and how that changes with the command.
  struct Miss {
    Scalar command_V;
    Scalar kPa;
    Scalar by_V;
  };

  Miss miss(Scalar command_V) const noexcept {
    const CommandCurve::Tangent of = curve_.tangent(command_V);
    const typename Law::Response response = law_.response(of.at.opening_V);
    return {.command_V = command_V,
            .kPa = law_.rise_kPa(of.at, response) - wanted_kPa_,
            .by_V = law_.slope_kPa_V(of, response)};
  }
  Miss refine(Miss low, Miss high) const noexcept;
  Miss closest(Miss best, Miss other) const noexcept;
  std::size_t crossing(const AtNodes& miss_kPa, Scalar near_V) const noexcept;
  std::size_t beside(std::size_t node, bool above) const noexcept;

  const CommandCurve& curve_;
  const Law& law_;
  Scalar target_kPa_;
  Scalar wanted_kPa_;
};

/// The zero of the miss between two commands at which its signs differ. A command that comes as near where the slope has the other
/// sign is not it: near the null the pressure may fall before it rises.
template <class Law>
typename InverseSearch<Law>::Miss InverseSearch<Law>::refine(Miss low, Miss high) const noexcept {
  const bool rises = high.kPa > low.kPa;
  const auto serves = [rises](const Miss& here) noexcept {
    return numeric::abs(here.kPa) <= kCrossing_kPa &&
           (rises ? !(here.by_V < Scalar(0)) : !(here.by_V > Scalar(0)));
  };
  Miss best = numeric::abs(low.kPa) < numeric::abs(high.kPa) ? low : high;
  if (serves(best)) return best;
  // First the zero of the cubic that has the commands of both ends and the slopes there, as a function of the
  // miss; slopes that would make it turn back are limited (Fritsch and Carlson 1980).
  const Scalar width_V = high.command_V - low.command_V;
  const Scalar rise = high.kPa - low.kPa;
  const Scalar t = -low.kPa / rise;
  const Scalar rest = Scalar(1) - t;
  const auto as_secant = [rise, width_V](const Miss& end) noexcept {
    return numeric::clamp(numeric::ratio_within<2>(rise, end.by_V * width_V), Scalar(0), Scalar(3));
  };
  const Scalar slope_low = as_secant(low), slope_high = as_secant(high);
  const Scalar share =
      t * (t * (Scalar(3) - Scalar(2) * t) + slope_low * rest * rest - slope_high * t * rest);
  Scalar command_V = low.command_V + numeric::clamp(share, Scalar(0.001), Scalar(0.999)) * width_V;
  // Then Newton's method inside the bracket. Where a step would leave it, the step from its other end is
  // taken (at r = 0, on one side of a corner, there is no slope); where that leaves it too, or a step did not
  // halve the miss, the bracket is halved. A step is not tried out when the curvature leaves nothing to gain.
  Scalar before_kPa = numeric::max(numeric::abs(low.kPa), numeric::abs(high.kPa));
  for (int i = 0; i < kRefinements; ++i) {
    const Miss here = miss(command_V);
    if (numeric::abs(here.kPa) < numeric::abs(best.kPa)) best = here;
    const bool as_low = (here.kPa > Scalar(0)) == (low.kPa > Scalar(0));
    const Miss& ahead = as_low ? high : low;
    const Scalar step_V = numeric::ratio_within<kBeyond>(-here.kPa, here.by_V);
    const Scalar room_V = ahead.command_V - command_V;
    const Scalar part = numeric::ratio_within<1>(step_V, room_V);
    const bool inside = part > Scalar(0) && part < Scalar(1);
    const bool exact = !is_limited(here.by_V);
    if (inside && exact &&
        numeric::abs((ahead.by_V - here.by_V) * part * step_V) <= Scalar(2) * kCrossing_kPa) {
      return {.command_V = command_V + step_V, .kPa = Scalar(0), .by_V = here.by_V};
    }
    if (serves(here)) return here;
    Scalar next_V = command_V + step_V;
    if (!inside) next_V = ahead.command_V - numeric::ratio_within<kBeyond>(ahead.kPa, ahead.by_V);
    const bool still_inside =
        (next_V - command_V) * room_V > Scalar(0) && (ahead.command_V - next_V) * room_V > Scalar(0);
    if (!still_inside || numeric::abs(here.kPa) > Scalar(0.5) * before_kPa)
      next_V = command_V + Scalar(0.5) * room_V;
    if (numeric::abs(next_V - command_V) < kSameCommand_V) break;
    (as_low ? low : high) = here;
    before_kPa = numeric::abs(here.kPa);
    command_V = next_V;
  }
  return best;
}

/// No command tabulated crosses the target. `best` comes nearest, and the miss shrinks from there towards
/// `other`, where it is larger again: an extremum between the two comes closer, or crosses. Then the target is met on either side
/// of it, on one of them where the pressure rises.
template <class Law>
typename InverseSearch<Law>::Miss InverseSearch<Law>::closest(Miss best, Miss other) const noexcept {
  Miss near = best;
  for (int i = 0; i < kExtremumSteps; ++i) {
    // The zero of the slope, by secants.
    const Scalar zero_at = numeric::ratio_within<1>(near.by_V, near.by_V - other.by_V);
    const Scalar share = numeric::clamp(zero_at, Scalar(0.1), Scalar(0.9));
    const Miss here = miss(near.command_V + share * (other.command_V - near.command_V));
    if ((here.kPa > Scalar(0)) != (best.kPa > Scalar(0))) {
      const bool onwards = near.command_V < other.command_V;
      return here.kPa > Scalar(0) ? refine(onwards ? near : other, here)
                                  : refine(here, onwards ? other : near);
    }
    if (numeric::abs(here.kPa) < numeric::abs(best.kPa)) best = here;
    ((here.by_V > Scalar(0)) == (near.by_V > Scalar(0)) ? near : other) = here;
    if (numeric::abs(here.by_V * (other.command_V - near.command_V)) < kCrossing_kPa) break;
  }
  return best;
}

/// The node below the crossing that inverse() is to answer with; kNodes when no two nodes lie on either side.
template <class Law>
std::size_t InverseSearch<Law>::crossing(const AtNodes& miss_kPa, Scalar near_V) const noexcept {
  const std::uint64_t above = nodes_above(miss_kPa);
  const std::uint64_t rising = ~above & above >> 1U & curve_.nodes().apart;
  const std::uint64_t falling = above & ~(above >> 1U) & curve_.nodes().apart;
  const auto& node_V = curve_.nodes().command_V;
  std::size_t chosen = kNodes;
  Scalar chosen_V = 0;  // its distance
  for (std::uint64_t left = rising != 0 ? rising : falling; left != 0; left &= left - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(left));
    const Scalar distance_V =
        numeric::max(numeric::max(node_V[i] - near_V, near_V - node_V[i + 1]), Scalar(0));
    if (chosen < kNodes && !(distance_V < chosen_V)) continue;
    chosen = i;
    chosen_V = distance_V;
  }
  return chosen;
}

/// The next node above or below that is not at the same command; `node` itself at the end of the range.
template <class Law>
std::size_t InverseSearch<Law>::beside(std::size_t node, bool above) const noexcept {
  const auto& node_V = curve_.nodes().command_V;
  std::size_t i = node;
  while (node_V[i] == node_V[node]) {
    if (i == (above ? kNodes - 1 : 0)) return node;
    i = above ? i + 1 : i - 1;
  }
  return i;
}

template <class Law>
Inverse InverseSearch<Law>::find(Scalar near_V) const noexcept {
  const CommandCurve::Nodes& nodes = curve_.nodes();

  // How far each tabulated command misses. p(t+h) rises with the command almost everywhere, but near the null
  // the rate may fall faster than s rises: up to a few stretches of either slope, told apart here by their signs at
  // the nodes.
  CommandCurve::At<typename Law::Response> response;
  AtNodes miss_kPa;
  law_.misses(nodes, wanted_kPa_, response, miss_kPa);
  const auto at_node = [&](std::size_t i) noexcept -> Miss {
    const std::size_t k = CommandCurve::place(i);
    const CommandCurve::Tangent of{nodes.point(k), nodes.by_V[i]};
    return {.command_V = nodes.command_V[i], .kPa = miss_kPa[k], .by_V = law_.slope_kPa_V(of, response[k])};
  };

  Miss found{};
  bool saturated = false;
  if (const std::size_t below = crossing(miss_kPa, near_V); below < kNodes) {
    found = refine(at_node(below), at_node(below + 1));
  } else {
    const std::size_t nearest = nearest_node(miss_kPa, miss_kPa[0] > Scalar(0));
    found = at_node(nearest);
    const bool short_of = !(found.kPa > Scalar(0));
    const std::size_t other = beside(nearest, (found.by_V > Scalar(0)) == short_of);
    if (other != nearest && found.by_V != Scalar(0)) found = closest(found, at_node(other));
    saturated = numeric::abs(found.kPa) > kCrossing_kPa && (found.kPa < Scalar(0)) == short_of;
    // Out of reach: full opening on the side of the target, the strongest that any valve can do.
    const std::size_t limit = short_of ? kNodes - 1 : 0;
    const Scalar limit_kPa = miss_kPa[CommandCurve::place(limit)];
    if (saturated && found.command_V != nodes.command_V[limit] &&
        numeric::abs(limit_kPa) <= numeric::abs(found.kPa) + kLimitServes * curve_.span_kPa()) {
      found = at_node(limit);
    }
  }
  return {.command_V = found.command_V,
          .reached_kPa = target_kPa_ + found.kPa,
          .by_command_kPa_V = found.by_V,
          .saturated = saturated};
}

}  // namespace plenum::control
