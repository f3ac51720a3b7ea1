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

#include <cstddef>
#include <span>

#include "firmware/control/command_curve.hpp"
#include "firmware/control/pressure_model.hpp"

namespace plenum::control {

class Tassa9 final : public PressureModel {
 public:
  /// Parameters in image order: c1..c9, c_gamma, P_c, P_r (config::parameter_schema(ModelKind::tassa9); the dead time is the
  /// valve's: model_paths.hpp).
  static constexpr std::size_t kParameters = 12;

  /// Takes over an admissible parameter set and tabulates s and k over the command range [V], low < high.
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
  /// (10c), (10e) and (7) with the pressure and the motion of this tick put in: a Law of inverse_search.hpp.
  struct Tick {
    Scalar pressure_kPa;
    Scalar steady_shift_kPa;  ///< c4 v'
    Scalar rate_gain;         ///< c7 h / (1 + c6 v)
    Scalar rate_shift;        ///< c5 v' h / (1 + c6 v)

    Scalar rate(Scalar opening_V) const noexcept { return rate_gain * opening_V + rate_shift; }  ///< r h
    Scalar steady_kPa(CommandCurve::Point at) const noexcept { return at.steady_kPa + steady_shift_kPa; }
    using Response = numeric::PartOf<Scalar>;
    Response response(Scalar opening_V) const noexcept { return numeric::decay_part(rate(opening_V)); }
    Scalar rise_kPa(CommandCurve::Point at, Response done) const noexcept {
      return (steady_kPa(at) - pressure_kPa) * done;
    }
    void misses(const CommandCurve::Nodes& at, Scalar wanted_kPa, CommandCurve::At<Response>& done,
                CommandCurve::At<Scalar>& miss_kPa) const noexcept {
      numeric::decays(rate_gain * at.opening_unit_V, rate_shift, at.opening, done);
      numeric::shares(at.steady_kPa, steady_shift_kPa - pressure_kPa, done, wanted_kPa, miss_kPa);
    }
    Scalar by_rate_kPa(CommandCurve::Point at, Response done) const noexcept;
    Scalar slope_kPa_V(const CommandCurve::Tangent& of, Response done) const noexcept;
  };
  Tick tick(Scalar pressure_kPa, const Moving& moves) const noexcept;

  CommandCurve curve_;
  Scalar c4_ = 0, c5_ = 0, c6_ = 0, c7_ = 1;
};

}  // namespace plenum::control
