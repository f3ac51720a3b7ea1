// Which equation of the recalibrated chamber errs, before any cause is named: stochastic grey-box modelling.
//
// One equation at a time is given a disturbance d, a first-order Markov process, and terms that an error of that equation
// could depend on:
//
//   command     areas at u + d             the command up to 11 ticks before, or a spool on its way; plays (hysteresis)
//   valve_area  areas (1 + d)              the opening of each port
//   mass_flow   flow - d |flow|            pressure ratio; pressure; a silencer; the flow before; a hose in series
//               or flow - d a phi(p, P_a)  pressure: a leak, by which nothing comes in
//   supply      P (1 + d)                  the flow drawn, now and up to a second before
//   energy      p' + d p                   the gas's temperature; the volume, its motion and its delay
//   sensor      reading + P d              lags of first order, the rise over a tick; the pressure
//
// An extended Kalman filter over the ticks, states p and d, whitens the readings and the tangents of these terms and of the
// valve's figures and of the stamp of the pressures, which stay free, so that calibration can neither hide a disturbance nor make one;
// Gauss-Newton with damping, a step being believed when the filter run anew has shown it. The evidence of an equation is the likelihood of
// the innovations less what its terms cost, each the logarithm of its expected over its estimated spread. A term never
// sees a reading before the filter does: a measured pressure's rate as a regressor explains everything.
// Source: Kristensen, Madsen and Jorgensen, Automatica 40 (2004), whose pinpointing is done by hand.
#pragma once

#include <string>
#include <vector>

#include "host-sim/identify/chamber/fit.hpp"

namespace plenum::host::diagnose {

using identify::chamber::Record;
using identify::chamber::Scene;

struct LatentTerm {
  std::string on;      ///< "the command before"
  double share = 0.0;  ///< of the disturbance's mean square
};

struct LatentEquation {
  effects::Equation equation{};
  double log_likelihood = 0.0;  ///< [nat]
  double probability = 0.0;
  double early_s = 0.0;  ///< by which the pressures are stamped early, if it is this equation
  double size = 0.0;     ///< RMS of the whole disturbance [unit]
  double rest = 0.0;     ///< RMS of what depends on none of the terms [unit]
  double memory_s = 0.0;
  std::string unit;
  std::vector<LatentTerm> terms;                 ///< largest first
  std::vector<std::vector<double>> disturbance;  ///< a record, a tick; smoothed [unit]
};

/// Most probable first; empty without a record of 50 rows. `records` may be fitted ones and held-out ones: nothing that
/// is judged later is learnt from them. Some two seconds of a core for 4000 rows.
std::vector<LatentEquation> latent(const Scene& scene, const std::vector<const Record*>& records,
                                   const effects::Figures& recalibrated, unsigned threads);

}  // namespace plenum::host::diagnose
