// The orifice of a vessel from a record of its pressure: A (or the choked rate), b, beta, a of (4), (6), (8).
//
//   rate fit      min sum [pdot_k - k p_u psi_e(p_d/p_u; b, a, beta)/psi_max]^2 on the filtered record, pdot
//                 its discrete derivative: the paper's method
//   pressure fit  min sum [p_k - p(t_k; k, b, beta, a, p_0)]^2 on the unfiltered record, p in free run from
//                 p_0, which is estimated too: maximum likelihood for white sensor noise
//
// The pressure fit starts where the rate fit ends. A moving average widens a fast charge (10 ms against the
// 60 ms in which the MPYE fills 0.4 L) and biases b and beta of the rate fit; the pressure fit has no filter.
// Both within bounds, by a trust-region method (bounded_squares.hpp).
//
// Source: "Parameter Identification and Evaluation of a Proportional Directional Flow Control Valve Model",
// Parameter Identification.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/estimate.hpp"
#include "host-sim/identify/orifice/vessel.hpp"
#include "host-sim/plant/orifice.hpp"

namespace plenum::host::identify::orifice {

/// The record does not show the flow's shape: with b, a and beta held the rest may be fitted.
class ShapeNotSeen : public CannotIdentify {
 public:
  using CannotIdentify::CannotIdentify;
};

/// The defaults are the paper's: window and bounds.
struct OrificeFitOptions {
  std::size_t moving_average_rows = 10;  ///< of the rate fit; 1: none
  bool pressure_fit = true;              ///< false: the paper's method alone
  /// a: held where given. Else the greatest ratio of the filtered record, 1 at most, from where the pressure
  /// fit moves it: a vessel that had not come to rest yet reads too low.
  std::optional<double> cracking_ratio{};
  std::optional<double> critical_ratio{};  ///< b: held where given
  std::optional<double> subsonic_index{};  ///< beta: held where given
  double most_critical_ratio = 0.528;      ///< b lies in 0 .. this, and below a
  double most_subsonic_index = 1.0;        ///< beta lies in 0 .. this
  double most_area_m2 = 1e-2;              ///< A lies in 0 .. this, where the volume is known
};

/// `options` with the flow's shape held at a thin plate's (a = 1, b = 0.528, beta = 1/2): what is left of a vessel whose
/// pressure ratio hardly changes is k.
OrificeFitOptions held_at_thin_plate(OrificeFitOptions options = {});

/// The standard error is infinite where the record does not see the parameter. The far pressure counts as exact and the errors
/// as white: true of the pressure fit where the model holds, an order of magnitude of the rate fit, whose filter ties
/// neighbours together.
struct OrificeParameter : Estimate {
  bool held = false;
  /// Free, not at a bound, and its standard error below a quarter: of itself (k, A, beta), of the most that b
  /// may be (b), of 1 - b (a).
  bool identified = false;
  std::string why_not{};  ///< in a few words, where not identified
};

struct OrificeFit {
  OrificeParameter choked_rate_1_s;         ///< k
  std::optional<OrificeParameter> area_m2;  ///< A; none where the vessel's volume is unknown
  OrificeParameter critical_ratio;          ///< b
  OrificeParameter cracking_ratio;          ///< a
  OrificeParameter subsonic_index;          ///< beta
  double start_Pa = 0.0;                    ///< p_0; of the rate fit the first pressure recorded
  double least_ratio = 0.0;                 ///< p_d/p_u that the record covers: nothing is known beyond
  double greatest_ratio = 0.0;
  double mean_absolute_error_Pa = 0.0;  ///< (9): free run from start_Pa against the unfiltered record
  double rms_error_Pa = 0.0;
  int iterations = 0;
  bool converged = false;
  std::string stop;  ///< why the last fit stopped

  /// The fitted port with k for its choked flow: free_run() takes it.
  plant::EllipsePort port_1_s() const {
    return {choked_rate_1_s.value, critical_ratio.value, cracking_ratio.value, subsonic_index.value};
  }
};

/// Fits one charge or discharge; `vessel` turns k into A and is not fitted. One thread. Throws
/// std::invalid_argument naming field, row or column for bad input, and CannotIdentify, in one line, where
/// the vessel does not move against its noise or moves the wrong way, where a flow shape is asked for of
/// pressure ratios that span less than 0.02, or where the record does not fix k.
OrificeFit fit_orifice(const VesselRecord& record, const Vessel& vessel,
                       const OrificeFitOptions& options = {});

}  // namespace plenum::host::identify::orifice
