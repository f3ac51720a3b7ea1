// The 9-parameter model of chamber pressure, repaired: the moving volume acts where the physics puts it.
//
//   p' = (a s0(u) - (a + c5 v') p) / (1 + c6 v),   a = c7 k(u)                     (R1)
//   s0, k: command_curve.hpp
//
// That is p' = (s - p) r of (6) with
//   s = a s0 / (a + c5 v'),   r = (a + c5 v') / (1 + c6 v):                        (R2)
// steady state and rate divide by the same quantity, and c4 of (10c) has no work left. README.md derives it from (4).
//
// With u, v and v' held over the tick p' is linear in p. With x = h (a + c5 v')/(1 + c6 v) and F = h p' at its begin,
//   p(t+h) = p + F phi_1(x),   phi_1(x) = (1 - e^-x)/x                             (R3)
//   mean   = p + F phi_2(x),   phi_2(x) = (1 - phi_1(x))/x                         (R4)
// Both are regular at x = 0, where (R2) has its pole, and hold for either sign: a chamber that shrinks faster than its valve
// lets out (a + c5 v' < 0) is compressed, and (R3) follows it. x is bounded below by -numeric::kGrowthHigh: the pressure
// grows by e^4 in a tick at most.
//
// Units: p, s0 [kPa]; u [V]; k [V]; v [mL]; v' [mL/s]; h [s]; c5, c6 [1/mL]; c7 [1/(V s)].
//
// Valid for every parameter set that config::validate() admits: k > 0 for every command, s0 rises with the command.
// p(t+h) then rises with s0; with a it rises where p lies below s0 over the tick, and falls where it lies above:
//   dp(t+h)/da = h/(1 + c6 v) integral_0^1 e^(-x(1 - y)) (s0 - p(t + y h)) dy      (R5)
// So there may be several stretches of either slope near the null, as in the published form, and the same search finds
// the rising one.
//
// Source: Modeling and Identification of Pneumatic Actuators, (4) and section IV; the form is this project's.
#pragma once

#include <cstddef>
#include <span>

#include "firmware/control/command_curve.hpp"
#include "firmware/control/pressure_model.hpp"

namespace plenum::control {

class Tassa9r final : public PressureModel {
 public:
  /// Parameters in image order: c1, c2, c3, c5..c9, c_gamma, P_c, P_r (config::parameter_schema(ModelKind::tassa9r)).
  static constexpr std::size_t kParameters = 11;

  /// Takes over an admissible parameter set and tabulates s0 and k over the command range [V], low < high. Commands
  /// beyond it count as its ends.
  void configure(std::span<const Scalar, kParameters> parameters, Scalar command_low_V,
                 Scalar command_high_V) noexcept;

  using PressureModel::inverse;
  using PressureModel::step;
  Opening opening(Scalar command_V) const noexcept override;
  Moving moving(const ChamberMotion& motion) const noexcept override;
  Prediction step(Scalar pressure_kPa, const Opening& open, const Moving& moves,
                  Scalar ticks) const noexcept override;
  /// As InverseSearch.
  Inverse inverse(Scalar pressure_kPa, Scalar target_kPa, const Moving& moves,
                  Scalar near_V) const noexcept override;

 private:
  /// (R1) with the pressure and the motion of this tick put in: a Law of inverse_search.hpp.
  struct Tick {
    Scalar pressure_kPa;
    Scalar gain_per_V;  ///< h c7/(1 + c6 v)
    Scalar moved;       ///< h c5 v'/(1 + c6 v)

    Scalar flow(Scalar opening_V) const noexcept { return gain_per_V * opening_V; }  ///< h a/(1 + c6 v)
    /// `moved`, such that x stays above its bound.
    Scalar moved_beside(Scalar flow) const noexcept {
      return numeric::max(moved, -numeric::kGrowthHigh - flow);
    }
    Scalar x(Scalar flow) const noexcept { return flow + moved_beside(flow); }
    /// F
    Scalar speed_kPa(Scalar flow, Scalar steady_kPa) const noexcept {
      return flow * (steady_kPa - pressure_kPa) - moved_beside(flow) * pressure_kPa;
    }
    using Response = Scalar;
    Scalar response(Scalar opening_V) const noexcept { return numeric::phi_1(x(flow(opening_V))); }
    Scalar rise_kPa(CommandCurve::Point at, Scalar phi_1) const noexcept {
      return speed_kPa(flow(at.opening_V), at.steady_kPa) * phi_1;
    }
    void misses(const CommandCurve::Nodes& at, Scalar wanted_kPa, CommandCurve::At<Response>& phi_1,
                CommandCurve::At<Scalar>& miss_kPa) const noexcept {
      const Scalar gain = gain_per_V * at.opening_unit_V;
      CommandCurve::At<Scalar> flow;
      for (std::size_t i = 0; i < flow.size(); ++i) flow[i] = gain * at.opening[i];
      for (std::size_t i = 0; i < flow.size(); ++i) phi_1[i] = numeric::phi_1(x(flow[i]));
      for (std::size_t i = 0; i < flow.size(); ++i) {
        miss_kPa[i] = speed_kPa(flow[i], at.steady_kPa[i]) * phi_1[i] - wanted_kPa;
      }
    }
    Scalar by_x_kPa(CommandCurve::Point at, Scalar phi_1) const noexcept;
    Scalar slope_kPa_V(const CommandCurve::Tangent& of, Scalar phi_1) const noexcept;
  };
  Tick tick(Scalar pressure_kPa, const Moving& moves) const noexcept;
  Scalar within_range(Scalar command_V) const noexcept;

  CommandCurve curve_;
  Scalar c5_ = 0, c6_ = 0, c7_ = 1;
};

}  // namespace plenum::control
