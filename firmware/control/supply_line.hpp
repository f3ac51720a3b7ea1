// The supply at a chamber's valve: it droops while the chamber draws from it, and follows what a sensor says of the line.
//
//   tau s' = r m - s,   S = S_0 - s,   S_0 = 1 + g (P_m/P_c - 1)                 (L1)
//
// S pressure of the supply at the valve, of that of the model, P_c; s droop, likewise; m flow through the inlet [kPa L/s], as it
// enters (G1); r = R/P_c, R resistance of the line [s/L]: the droop [kPa] for each kPa L/s; tau [ticks] in which the vessel behind
// the resistance recovers, 0: at once; P_m what the board's supply sensor says [kPa], g the share of its difference to P_c that
// the valve sees. Over t ticks of an even flow, with E = e^(-t/tau) and w = 1 - (1 - E) tau/t,
//   s at the end = E s + (1 - E) r m,   s in the mean = (1 - w) s + w r m        (L2)
// and a model is told the mean. The flow depends on it in turn,
//   S = S_0 - (1 - w) s - w r m(S)                                               (L3)
// whose right side falls with S: between S at no flow and p/P_c, where none flows, lies its only solution, of a line as narrow as
// the valve as well. By Newton's method, which along one chord of phi is exact.
//
// Source: flow characteristic of a pressure regulator, its droop ("Pressure regulator valve", section III), with a vessel behind
// it.
#pragma once

#include <cstdint>

#include "firmware/config/seal.hpp"
#include "firmware/control/pressure_model.hpp"

namespace plenum::control {

class SupplyLine {
 public:
  struct Config {
    Scalar supply_kPa = 0;      ///< P_c
    Scalar resistance_s_L = 0;  ///< R; 0: no droop
    Scalar recovery_ticks = 0;  ///< tau
    Scalar followed_share = 0;  ///< g; 0: the sensor is not heeded
  };

  /// So long a flow lasts, as (L2) needs it.
  struct While {
    Scalar left = 0;    ///< E
    Scalar weight = 1;  ///< w
  };

  /// `part_ticks`: of a tick, for part(), and for rest() what it leaves. Nothing is drawn, no sensor has spoken.
  void configure(const Config& config, Scalar part_ticks) noexcept;

  /// Nothing has been drawn for long.
  void reset() noexcept { droop_ = Scalar(0); }

  /// P_m, above 0, over the tick that passes next.
  void measured(Scalar supply_kPa) noexcept;

  /// Else flows need not be asked for.
  bool droops() const noexcept { return by_flow_ > Scalar(0); }

  const While& tick() const noexcept { return tick_; }
  const While& part() const noexcept { return part_; }
  const While& rest() const noexcept { return rest_; }

  /// S now.
  Scalar supply() const noexcept { return at_rest_ - droop_; }
  /// S in the mean over a while, by (L3), at this pressure of the chamber [kPa].
  Scalar mean(const While& span, const PressureModel& model, Scalar pressure_kPa, const Opening& open,
              const ChamberMotion& motion) const noexcept;
  /// The same by (L2), of a mean flow [kPa L/s].
  Scalar mean(const While& span, Scalar flow_kPa_L_s) const noexcept {
    return at_rest_ - (droop_ + span.weight * (by_flow_ * flow_kPa_L_s - droop_));
  }
  /// As PressureModel::step() over a while of so many ticks, behind this line, which has given then what flowed. `moves`: of the
  /// motion, with the supply() of now.
  Prediction step(const While& span, Scalar ticks, const PressureModel& model, Scalar pressure_kPa,
                  const Opening& open, const ChamberMotion& motion, const Moving& moves) noexcept {
    return droops() ? drawn_step(span, ticks, model, pressure_kPa, open, motion)
                    : model.step(pressure_kPa, open, moves, ticks);
  }
  /// A while passes with this mean flow [kPa L/s].
  void pass(const While& span, Scalar flow_kPa_L_s) noexcept;

  /// Of what configure() alone writes: config/seal.hpp.
  std::uint64_t sum_of_constants() const noexcept {
    return config::sum_of_object(by_flow_) + config::sum_of_object(supply_kPa_) +
           config::sum_of_object(followed_share_) + config::sum_of_object(tick_) +
           config::sum_of_object(part_) + config::sum_of_object(rest_);
  }
  std::uint64_t sum_of_estimates() const noexcept {
    return config::sum_of_object(droop_) + config::sum_of_object(at_rest_);
  }

 private:
  Prediction drawn_step(const While& span, Scalar ticks, const PressureModel& model, Scalar pressure_kPa,
                        const Opening& open, const ChamberMotion& motion) noexcept;

  Scalar by_flow_ = 0;  ///< r [s/(kPa L)]
  Scalar supply_kPa_ = 0;
  Scalar followed_share_ = 0;
  While tick_, part_, rest_;
  Scalar droop_ = 0;    ///< s
  Scalar at_rest_ = 1;  ///< S_0
};

}  // namespace plenum::control
