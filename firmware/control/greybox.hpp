// The chamber's physics, solved exactly over a tick in which command, volume and speed are held.
//
//   p' = f(p, u) = (C_c(u) phi(S P_c, p) - C_r(u) phi(p, P_r) - C_l lambda(p) - n v' p) / (v + v_0)   (G1)
//   phi(a, b) = a psi(b/a) for a >= b, else -b psi(a/b)                                              (G2)
//   psi(r) = (1 + k (r* - r)) psi_0(r')^(2 beta),  r' = r* + (r - r_b)(1 - r*)/(r_a - r_b)           (G3)
//   psi_0(r) = sqrt((r^(2/1.4) - r^(2.4/1.4))/(r*^(2/1.4) - r*^(2.4/1.4))), r* = 0.528
//   psi_0 = 1 for r <= r_b (choked), 0 for r >= r_a (shut); between by kChords chords
//   lambda(p) = (p^2 - P_r^2)/(2 P_r), the laminar flow through a narrow gap, by chords between the corners of both phi, the last
//   of them to 10 MPa
//   C(u): config/valve_curve.hpp;   S: what the supply is of P_c over the tick (Moving, supply_line.hpp)
//
// Units: p, P [kPa]; u [V]; v, v_0 [mL]; v' [mL/s]; C [mL/s]; n, r, k, beta, S [1]. A conductance is an effective area times
// what does not change: kappa R T/sqrt(T), the discharge coefficient, the units.
//
// With psi by chords f is a broken line in p: p psi(P/p) is linear in p where psi(r) is linear in r, and of another supply,
// phi(S P, p) = S phi(P, p/S), the same line drawn larger. Between two of its corners the pressure follows an exponential,
//   p(t) = p_0 + f_0 t phi_1(-J t),   J = df/dp,   phi_1(x) = (1 - e^-x)/x                             (G5)
// and it passes the corner ahead, at p_1, after
//   t = (p_1 - p_0) ln(f_1/f_0)/(f_1 - f_0)
//     = 2 (p_1 - p_0)/(f_1 + f_0) artanh(z)/z,   z = (f_1 - f_0)/(f_1 + f_0)                           (G6)
// which takes no logarithm where z is small. f is one number at each pressure, so that the pressure goes one way and passes
// each corner at most once: the loop is bounded by the number of corners. Nothing is approximated in time: the step is stable
// however stiff, two steps of half a tick are one of a tick, and the end rises with the command because the flow does, at
// every pressure.
//
// The chords lie about the curve, not below it: what the flow errs on its way along a chord is nearly zero in the mean.
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

  using PressureModel::inverse;
  using PressureModel::step;
  Opening opening(Scalar command_V) const noexcept override;
  Moving moving(const ChamberMotion& motion) const noexcept override;
  Prediction step(Scalar pressure_kPa, const Opening& open, const Moving& moves,
                  Scalar ticks) const noexcept override;
  /// For targets between ambient and supply. At most kRefinements + 2 steps, and kGuesses on a straight line.
  Inverse inverse(Scalar pressure_kPa, Scalar target_kPa, const Moving& moves,
                  Scalar near_V) const noexcept override;

  Draw draw(Scalar pressure_kPa, const Opening& open, const Moving& moves) const noexcept override;

  static constexpr std::size_t kNodes = 64;
  static constexpr int kGuesses = 4;
  static constexpr int kSecants = 4;
  static constexpr int kRefinements = 24;  ///< the secants, and what searches a bracket of all nodes
  static constexpr std::size_t kChords = 10;
  /// Of phi(P, p) in p: 0, P, r P and P/r for every end of a chord, and the most that a pressure can be.
  static constexpr std::size_t kCorners = 3 + 2 * (kChords + 1);
  static constexpr std::size_t kSource =
      kChords + 2;  ///< the corner at P; beside it those of r_a, between which nothing flows

  // So that no number of a tick passes the range of a fixed-point one (tests/ranges):
  /// [1] So often a tick fills the smallest chamber through all ports as wide open as they get, and the gap. A smaller one counts as that
  /// one: the pressure ends where f is 0 in either, but for a valve that is as good as shut.
  static constexpr Scalar kMostFilled = Scalar(4096);
  static constexpr Scalar kLeastVolume_mL = Scalar(0.1);  ///< and none is smaller than this
  /// From there on the flow through the gap goes on straight.
  static constexpr Scalar kGap_kPa = Scalar(1e4);
  // And what leads to a next guess need be no more than, of a fixed-point number:
  static constexpr int kBeyond = 5;       ///< [bits, V] a step that leaves the range of the commands
  static constexpr int kMostFactor = 10;  ///< [bits] what was gained, of what was told
  static constexpr int kMostGain = 20;    ///< [bits, kPa] what is to be gained
  static constexpr Scalar kFarther_kPa = Scalar(1 << 14);  ///< a way within a tick
  static constexpr Scalar kMostFlow_kPa =
      Scalar(1 << 13);  ///< what a flow over its conductance changes on that way

 private:
  friend struct GreyboxTables;  ///< of whoever bounds what a scalar makes of them (host-sim/rounding)

  class FlowFunction;
  /// phi(P, p) of one P, a broken line in p.
  struct Curve {
    std::array<Scalar, kCorners> corner_kPa{};  ///< rising, from 0
    std::array<Scalar, kCorners> flow_kPa{};    ///< there
    std::array<Scalar, kCorners - 1> slope{};   ///< from a corner to the next

    void configure(const FlowFunction& flow, Scalar source_kPa) noexcept;
    /// From the last corner that is not above the pressure, but for the last of all.
    std::size_t side_of(Scalar pressure_kPa) const noexcept;
    Scalar at(std::size_t side, Scalar pressure_kPa) const noexcept;
    /// Of the curve drawn larger by `size`; the last one lies at the most that a pressure can be all the same.
    Scalar corner_at_kPa(std::size_t corner, Scalar size) const noexcept;
  };

  /// Of both ports: conductances C [L/s], or what the end of a tick gains by them [kPa s/L].
  struct Ports {
    Scalar inlet = 0;
    Scalar exhaust = 0;
  };
  /// Of a pressure: phi(S P_c, p), phi(P_r, p) [kPa], C_l lambda [kPa L/s]; or the slopes of these.
  struct Flows {
    Scalar inlet = 0;
    Scalar exhaust = 0;
    Scalar leak = 0;
  };
  /// Which side of each curve a pressure lies on.
  struct Sides {
    std::size_t inlet = 0;
    std::size_t exhaust = 0;
    bool operator==(const Sides&) const = default;
  };
  /// Of the sides about a pressure: where both go on straight.
  struct Stretch {
    Scalar low_kPa = 0;
    Scalar high_kPa = 0;
  };
  /// (G1) with all put in but the command.
  struct Tick {
    Scalar pressure_kPa = 0;
    Sides sides{};          ///< of the pressure
    Stretch between{};      ///< about it
    Flows flows{};          ///< at it
    Scalar supply = 1;      ///< S
    Scalar per_volume = 0;  ///< h/(v + v_0) [s/L]
    Scalar moved_L_s = 0;   ///< n v'
  };
  /// Nodes from the first to the last that may be answered with.
  struct Range {
    std::size_t first = 0;
    std::size_t last = kNodes - 1;
  };
  /// A command, and what the end gains by the conductances there.
  struct Guess {
    Scalar command_V = 0;
    Ports by;
  };
  struct Law;
  struct Passage;
  struct Rest;
  class MeanRise;
  class Bracket;
  template <bool up>
  class Way;

  Tick tick(Scalar pressure_kPa, const Moving& moves) const noexcept;
  Sides sides_of(Scalar pressure_kPa, Scalar supply) const noexcept;
  Stretch stretch(const Sides& sides, Scalar supply) const noexcept;
  Flows flows(const Sides& sides, const Stretch& between, Scalar pressure_kPa, Scalar supply) const noexcept;
  Flows slopes(const Sides& sides, const Stretch& between) const noexcept;
  template <bool up, class Visit>
  Scalar go(const Tick& tick, const Law& law, Scalar rate_kPa, Scalar ticks, Visit&& visit) const noexcept;
  template <class Visit>
  Scalar travel(const Tick& tick, const Ports& open, Scalar ticks, Visit&& visit) const noexcept;
  static Scalar gap_kPa(Scalar corner_kPa) noexcept { return numeric::min(corner_kPa, kGap_kPa); }
  std::size_t segment(Scalar command_V) const noexcept;
  Scalar slope_by(const Ports& by, std::size_t segment) const noexcept;
  Ports conductances(std::size_t segment, Scalar command_V) const noexcept;
  Range answers(const Tick& tick) const noexcept;
  Scalar gaining_V(const Range& among, const Ports& by, Scalar from_V, Scalar wanted_kPa) const noexcept;
  Guess guess(const Tick& tick, const Range& among, Scalar target_kPa, Scalar near_V) const noexcept;

  Scalar dead_volume_mL_ = 0, least_volume_mL_ = 1, volume_exponent_ = 1, supply_kPa_ = 0, ambient_kPa_ = 0;
  Scalar leak_L_s_kPa_ = 0;  ///< C_l/(2 P_r)
  Curve inlet_;              ///< of P_c
  Curve exhaust_;            ///< of P_r
  std::array<Scalar, kNodes> node_V_{};
  std::array<Ports, kNodes> node_{};
  std::array<Ports, kNodes - 1> slope_{};  ///< from a node to the next [L/(s V)]
};

}  // namespace plenum::control
