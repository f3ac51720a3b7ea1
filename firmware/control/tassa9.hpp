// The 9-parameter model of chamber pressure.
//
//   p' = (s - p) r                                                                (6), (10f)
//   u^ = u - c1                                                                   (10a)
//   s  = c_b + c_s g(c2 u^ + c3 u^ u^ u^) + c4 v',   g(x) = x/sqrt(x^2 + 1)        (8), (10b), (10c)
//   k  = sqrt(u^ u^ + c_gamma^2) - c_gamma + c9 + c8 u^                           (9), (10d)
//   r  = (c7 k + c5 v') / (1 + c6 v)                                              (10e)
//   p(t+h) = s + (p(t) - s) e^(-r h)                                              (7)
//   mean of p over the tick = s + (p(t) - s) (1 - e^(-r h))/(r h)                 integral of (7)
//   c_b = (P_c + P_r)/2,  c_s = (P_c - P_r)/2,  c_gamma = 0.1 V in the paper
//
// Units: p, s, P [kPa]; u [V]; v [mL]; v' [mL/s]; h [s]; c1 [V], c2 [1/V], c3 [1/V^3], c4 [kPa s/mL],
// c5 [1/mL], c6 [1/mL], c7 [1/(V s)], c8 [1], c9 [V].
//
// Valid for every parameter set that config::validate() admits: k > 0 for every command, s rises with the
// command.
//
// r > 0 is what (6) asks for, but (10e) does not give it: of a chamber that shrinks fast behind a nearly
// sealed valve c7 k + c5 v' < 0. The published formula then drives p away from s, so that compression would
// empty a chamber whose pressure lies below s. Where (10e) is negative, r = 0 here: what remains of the
// compression is the regulator's to learn.
//
// Source: Modeling and Identification of Pneumatic Actuators, section IV.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/control/pressure_model.hpp"

namespace plenum::control {

class Tassa9 final : public PressureModel {
 public:
  /// Parameters in image order: c1..c9, c_gamma, P_c, P_r (config::parameter_schema(ModelKind::tassa9)).
  static constexpr std::size_t kParameters = 12;

  /// Takes over an admissible parameter set and tabulates s and k over the command range [V], low < high.
  void configure(std::span<const Scalar, kParameters> parameters, Scalar command_low_V,
                 Scalar command_high_V) noexcept;

  Prediction step(Scalar pressure_kPa, Scalar command_V, const ChamberMotion& motion,
                  Scalar ticks) const noexcept override;
  Gradient derivatives(Scalar pressure_kPa, Scalar command_V,
                       const ChamberMotion& motion) const noexcept override;

  /// At most kExtremumSteps + kRefinements evaluations of (7) with its slope, besides the tabulated nodes.
  Inverse inverse(Scalar pressure_kPa, Scalar target_kPa, const ChamberMotion& motion,
                  Scalar near_V) const noexcept override;

  static constexpr std::size_t kNodes = 32;  ///< a multiple of 4
  static constexpr int kRefinements = 12;
  static constexpr int kExtremumSteps = 4;

 private:
  /// s without its c4 v' and k: what depends on the command alone.
  struct Curve {
    Scalar steady_kPa;
    Scalar opening_V;
  };
  Curve curve(Scalar command_V) const noexcept;

  /// And their derivatives by the command.
  struct Slopes {
    Scalar steady_kPa_V;
    Scalar opening;
  };
  struct CurveAndSlopes {
    Curve curve;
    Slopes by_V;
  };
  CurveAndSlopes curve_and_slopes(Scalar command_V) const noexcept;

  /// (10c), (10e) and (7) with the motion of this tick put in, so that a command is all that is left open.
  struct Tick {
    Scalar pressure_kPa;
    Scalar steady_shift_kPa;  ///< c4 v'
    Scalar rate_gain;         ///< c7 h / (1 + c6 v)
    Scalar rate_shift;        ///< c5 v' h / (1 + c6 v)
  };
  Tick tick(Scalar pressure_kPa, const ChamberMotion& motion) const noexcept;

  /// How far a command misses the wanted rise, and how that changes with the command.
  struct Miss {
    Scalar command_V;
    Scalar kPa;
    Scalar by_V;
  };
  static Scalar slope(const Tick& tick, const CurveAndSlopes& at, Scalar done) noexcept;
  Miss miss(const Tick& tick, Scalar wanted_kPa, Scalar command_V) const noexcept;
  Miss refine(const Tick& tick, Scalar wanted_kPa, Miss low, Miss high) const noexcept;
  Miss closest(const Tick& tick, Scalar wanted_kPa, Miss best, Miss other) const noexcept;

  std::size_t crossing(const std::array<Scalar, kNodes>& miss_kPa, Scalar near_V) const noexcept;
  std::size_t beside(std::size_t node, bool above) const noexcept;

  Scalar c1_ = 5, c2_ = 1, c3_ = 0, c4_ = 0, c5_ = 0, c6_ = 0, c7_ = 1, c8_ = 0, c9_ = 1, c_gamma_ = 1;
  Scalar c_b_ = 100, c_s_ = 0;
  std::array<Scalar, kNodes> node_V_{};
  std::array<Scalar, kNodes> node_steady_kPa_{};  ///< these two in lanes: tassa9.cpp
  std::array<Scalar, kNodes> node_opening_V_{};
  std::array<Slopes, kNodes> node_slopes_{};
  std::uint64_t apart_ = 0;  ///< bit i: nodes i and i + 1 differ
};

}  // namespace plenum::control
