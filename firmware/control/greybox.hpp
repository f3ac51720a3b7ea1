// The chamber's physics, solved exactly over a tick in which command, volume and speed are held.
//
//   p' = f(p, u) = (C_c(u) phi(P_c, p) - C_r(u) phi(p, P_r) - C_l lambda(p) - n v' p) / (v + v_0)     (G1)
//   phi(a, b) = a psi(b/a) for a >= b, else -b psi(a/b)                                              (G2)
//   psi(r) = (1 + k (r* - r)) psi_0(r')^(2 beta),  r' = r* + (r - r_b)(1 - r*)/(r_a - r_b)           (G3)
//   psi_0(r) = sqrt((r^(2/1.4) - r^(2.4/1.4))/(r*^(2/1.4) - r*^(2.4/1.4))), r* = 0.528
//   psi_0 = 1 for r <= r_b (choked), 0 for r >= r_a (shut); between by kChords chords
//   lambda(p) = (p^2 - P_r^2)/(2 P_r), the laminar flow through a narrow gap, by chords between the same corners
//   C(u): config/valve_curve.hpp
//
// Units: p, P [kPa]; u [V]; v, v_0 [mL]; v' [mL/s]; C [mL/s]; n, r, k, beta [1]. A conductance is an effective area times
// what does not change: kappa R T/sqrt(T), the discharge coefficient, the units.
//
// With psi by chords f is a broken line in p: p psi(P/p) is linear in p where psi(r) is linear in r. Between two of its
// corners the pressure follows an exponential,
//   p(t) = p_0 + f(p_0) t phi_1(-J t),   J = df/dp,   phi_1(x) = (1 - e^-x)/x                          (G5)
// and it passes a corner at p_1 when J t = ln(1 + J (p_1 - p_0)/f(p_0)). f is one number at each pressure, so that the
// pressure goes one way and passes each corner at most once: the loop is bounded by the number of corners. Nothing is
// approximated in time: the step is stable however stiff, two steps of half a tick are one of a tick, and the end rises
// with the command because the flow does, at every pressure.
//
// C(u) is tabulated at kNodes commands and linear between them: that table is the model, in step() as in inverse(), so that
// no tick takes a root or a power. Where a curve falls beyond its largest opening (a polynomial of the opening does, past what it
// was fitted to) the port counts as saturated: the end goes on rising with the command, and the inverse has its answer.
//
// Source: (G1) is (4) of "Modeling and Identification of Pneumatic Actuators", psi_0 its thin plate (1): that is r_b = r*,
// r_a = 1, beta = 1/2, k = 0. The other figures carry ISO 6358's critical ratio and subsonic index, cracking and discharge
// of "Proportional directional flow control valve" (4)-(6) over to it.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "firmware/config/greybox_parameters.hpp"
#include "firmware/control/pressure_model.hpp"

namespace plenum::control {

class Greybox final : public PressureModel {
 public:
  using Parameter = config::GreyboxParameter;
  using enum config::GreyboxParameter;
  static constexpr std::size_t kParameters = config::kGreyboxParameters;

  /// Takes over an admissible parameter set, and tabulates f over pressure and C over the command range [V], low < high.
  void configure(std::span<const Scalar, kParameters> parameters, Scalar command_low_V,
                 Scalar command_high_V) noexcept;

  Prediction step(Scalar pressure_kPa, Scalar command_V, const ChamberMotion& motion,
                  Scalar ticks) const noexcept override;
  Gradient derivatives(Scalar pressure_kPa, Scalar command_V,
                       const ChamberMotion& motion) const noexcept override;
  /// For targets between ambient and supply. At most log2(kNodes) + kRefinements + 3 steps.
  Inverse inverse(Scalar pressure_kPa, Scalar target_kPa, const ChamberMotion& motion,
                  Scalar near_V) const noexcept override;

  static constexpr std::size_t kNodes = 64;
  static constexpr int kRefinements = 10;
  static constexpr std::size_t kChords = 13;
  /// Vacuum, and for each of both flows P, and r P and P/r for every end of a chord.
  static constexpr std::size_t kCorners = 1 + 2 * (1 + 2 * (kChords + 1));

 private:
  /// Of both ports: conductances C, flows phi(P_c, p) and phi(p, P_r), or slopes of either.
  struct Ports {
    Scalar inlet = 0;
    Scalar exhaust = 0;
  };
  /// From a corner of f to the next.
  struct Side {
    Ports at_corner;
    Ports slope;
    Scalar leak_mL_kPa_s = 0;  ///< C_l lambda at the corner
    Scalar leak_slope_mL_s = 0;
  };
  /// (G1) with all put in but the pressure and the command.
  struct Tick {
    Scalar pressure_kPa = 0;
    Scalar per_volume = 0;  ///< h/(v + v_0) [s/mL]
    Scalar moved_mL_s = 0;  ///< n v'
  };
  /// f, and its slope J, where the pressure is [kPa a tick; 1 a tick]; or how a change of something changes them.
  struct Rate {
    Scalar kPa = 0;
    Scalar slope = 0;
  };
  /// A part of a step between two corners.
  struct Piece {
    std::size_t side = 0;
    Scalar from_kPa = 0;
    Rate rate;         ///< at from_kPa
    Scalar ticks = 0;  ///< t of (G5)
    Scalar phi_1 = 0;
  };
  /// How far a command misses the target, and how that changes with the command.
  struct Miss {
    Scalar command_V = 0;
    Scalar kPa = 0;
    Scalar by_V = 0;
  };

  Tick tick(Scalar pressure_kPa, const ChamberMotion& motion) const noexcept;
  std::size_t side_of(Scalar pressure_kPa) const noexcept;
  Ports flows(std::size_t side, Scalar pressure_kPa) const noexcept;
  Rate net_flow(std::size_t side, const Ports& at, Scalar pressure_kPa) const noexcept;
  Rate rate(const Tick& tick, std::size_t side, const Ports& at, Scalar pressure_kPa) const noexcept;
  template <class Visit, class Enough>
  Scalar travel(const Tick& tick, const Ports& at, Scalar ticks, Visit&& visit,
                Enough&& enough) const noexcept;
  template <class Visit>
  Scalar travel(const Tick& tick, const Ports& at, Scalar ticks, Visit&& visit) const noexcept;
  Rate by_command(const Tick& tick, const Piece& piece, const Ports& slope) const noexcept;
  static Ports slope_between(const Ports& from, const Ports& to, Scalar width) noexcept;
  static Scalar carried(Scalar change_kPa, const Piece& piece, const Rate& by) noexcept;
  std::size_t segment(Scalar command_V) const noexcept;
  Ports conductances(std::size_t segment, Scalar command_V) const noexcept;
  Scalar end_at_node_kPa(const Tick& tick, std::size_t node) const noexcept;
  bool ends_above(const Tick& tick, std::size_t node, Scalar target_kPa) const noexcept;
  bool rises(const Tick& tick, std::size_t node) const noexcept;
  std::size_t extreme_node(const Tick& tick, Scalar sign) const noexcept;
  Miss miss(const Tick& tick, std::size_t segment, Scalar target_kPa, Scalar command_V) const noexcept;

  Scalar dead_volume_mL_ = 0, volume_exponent_ = 1, supply_kPa_ = 0, ambient_kPa_ = 0;
  std::array<Scalar, kCorners> corner_kPa_{};
  std::array<Side, kCorners> side_{};
  std::array<Scalar, kNodes> node_V_{};
  std::array<Ports, kNodes> node_{};
  std::array<Ports, kNodes - 1> slope_{};  ///< from a node to the next [mL/(s V)]
};

}  // namespace plenum::control
