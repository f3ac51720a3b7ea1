// What the 9-parameter model and its repaired form have in common: of a command alone the steady state of a volume at rest
// and the opening of the valve, in closed form and tabulated over the command range; of a volume the factor that both
// divide by.
//
//   u^ = u - c1                                                                   (10a)
//   s0 = c_b + c_s g(c2 u^ + c3 u^ u^ u^),   g(x) = x/sqrt(x^2 + 1)                (8), (10b), (10c)
//   k  = sqrt(u^ u^ + c_gamma^2) - c_gamma + c9 + c8 u^                           (9), (10d)
//   c_b = (P_c + P_r)/2,  c_s = (P_c - P_r)/2
//
// Units: u [V]; s0, P [kPa]; k [V]; c1 [V], c2 [1/V], c3 [1/V^3], c8 [1], c9, c_gamma [V].
//
// Source: Modeling and Identification of Pneumatic Actuators, section IV.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/config/limits.hpp"
#include "firmware/numeric/scalar.hpp"

namespace plenum::control {

using numeric::Scalar;

/// 1 + c6 v of (10e) and (R1). The sensor's volume may be off by its noise near an empty chamber: the factor stays positive.
inline Scalar volume_factor(Scalar c6_per_mL, Scalar volume_mL) noexcept {
  constexpr Scalar kSmallest = Scalar(1e-3);
  return numeric::max(Scalar(1) + c6_per_mL * volume_mL, kSmallest);
}

/// h/(1 + c6 v) [s], as the factor of a rate. With c6 v up to a million it is below what a resolution of 2^-32 can tell, so it
/// is held times a power of two: in float that changes no bit.
class TickPerVolume {
 public:
  explicit TickPerVolume(Scalar volume_factor) noexcept
      : scaled_s_(numeric::near_ratio(kScaledTick_s, volume_factor)) {}

  /// rate h/(1 + c6 v)
  Scalar of(Scalar rate) const noexcept { return numeric::shifted_down<kScaleBits>(rate * scaled_s_); }

 private:
  /// The largest power with which c7 = 1e6 1/(V s) stays below 2^31 in an empty chamber.
  static constexpr int kScaleBits = 17;
  static constexpr Scalar kScaledTick_s = Scalar(config::kTick_s) * Scalar(1 << kScaleBits);

  Scalar scaled_s_;
};

class CommandCurve {
 public:
  struct Figures {
    Scalar c1 = 5, c2 = 1, c3 = 0, c8 = 0, c9 = 1, c_gamma = 1;
    Scalar supply_kPa = 100, ambient_kPa = 100;
  };
  struct Point {
    Scalar steady_kPa;  ///< s0
    Scalar opening_V;   ///< k
  };
  /// Derivatives of a point by the command.
  struct Slopes {
    Scalar steady_kPa_V;
    Scalar opening;
  };
  struct Tangent {
    Point at;
    Slopes by_V;
  };

  static constexpr std::size_t kNodes = 32;  ///< a multiple of kLanes
  /// What is computed for every node lies in lanes, to be computed side by side: lane k holds kPerLane nodes that follow
  /// each other, and the first of each lane come first.
  static constexpr std::size_t kLanes = numeric::kLanes;
  static constexpr std::size_t kPerLane = kNodes / kLanes;
  static_assert(kPerLane * kLanes == kNodes && kPerLane <= 32);
  static constexpr std::size_t place(std::size_t node) noexcept {
    return kLanes * (node % kPerLane) + node / kPerLane;
  }
  /// A quantity at every node.
  template <class Number>
  using At = std::array<Number, kNodes>;
  /// Commands in rising order; the nodes beyond an end of the command range lie on it.
  struct Nodes {
    At<Scalar> command_V{};
    At<Scalar> steady_kPa{};  ///< these two in lanes
    At<numeric::PartOf<Scalar>> opening{};
    Scalar opening_unit_V = 1;  ///< in which `opening` is
    At<Slopes> by_V{};
    std::uint64_t apart = 0;  ///< bit i: nodes i and i + 1 differ

    Point point(std::size_t place) const noexcept {
      return {.steady_kPa = steady_kPa[place], .opening_V = Scalar(opening[place]) * opening_unit_V};
    }
  };

  /// Takes over admissible figures and tabulates them over the command range [V], low < high.
  void configure(const Figures& figures, Scalar command_low_V, Scalar command_high_V) noexcept;

  const Nodes& nodes() const noexcept { return nodes_; }
  Scalar span_kPa() const noexcept { return Scalar(2) * c_s_; }

  Point at(Scalar command_V) const noexcept {
    const Scalar u = command_V - of_.c1;  // (10a)
    const Scalar x = argument(u);
    const Scalar g = x * numeric::inverse_sqrt(x * x + Scalar(1));  // (8)
    const Scalar root = numeric::sqrt(u * u + of_.c_gamma * of_.c_gamma);
    return {.steady_kPa = c_b_ + c_s_ * g, .opening_V = root - of_.c_gamma + of_.c9 + of_.c8 * u};
  }

  Tangent tangent(Scalar command_V) const noexcept {
    const Scalar u = command_V - of_.c1;
    const Scalar x = argument(u);
    const Scalar inverse_root = numeric::inverse_sqrt(x * x + Scalar(1));
    const Scalar root = numeric::sqrt(u * u + of_.c_gamma * of_.c_gamma);
    // g' = (x^2+1)^(-3/2)
    const Scalar g_by_u = (of_.c2 + Scalar(3) * of_.c3 * u * u) * inverse_root * inverse_root * inverse_root;
    return {.at = {.steady_kPa = c_b_ + c_s_ * (x * inverse_root),
                   .opening_V = root - of_.c_gamma + of_.c9 + of_.c8 * u},
            .by_V = {.steady_kPa_V = c_s_ * g_by_u, .opening = u / root + of_.c8}};
  }

 private:
  /// Of (10b). With the largest c2 and c3 it comes to half a million; from 2^11 on g is 1 but for 2^-23.
  Scalar argument(Scalar u) const noexcept {
    constexpr Scalar kMost = Scalar(2048);
    return numeric::clamp((of_.c2 + of_.c3 * u * u) * u, -kMost, kMost);
  }

  Figures of_;
  Scalar c_b_ = 100, c_s_ = 0;
  Nodes nodes_;
};

}  // namespace plenum::control
