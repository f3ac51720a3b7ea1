// What a set of effects achieves: fitted to the rows that are fitted, judged by those held out.
//
//   evidence = -N/(2 c) ln(S/n) - k/2 ln(N/c)
//
// S sum of squared errors over fitted and held-out rows of the fit to both (joint_squares: figures that the fitted rows leave
// unknown must not decide what the held-out rows say), n their number, N all rows there are, c rows for one independent piece
// of information in the error, N/c held within 20 to 200, k variables of the trial: Schwarz's criterion for a free run, whose
// errors are correlated. Differences of evidence are logarithms of odds. The held-out rows have a veto besides: an effect
// that, fitted without them, lowers their error neither as it foretells them nor, by most, what of it no unknown figure accounts for
// (judged_Pa) does not enter.
#pragma once

#include <vector>

#include "host-sim/identify/chamber/fit.hpp"

namespace plenum::host::diagnose {

using identify::chamber::Fit;
using identify::chamber::Record;
using identify::chamber::Scene;

/// Independent pieces of information in a log. Not more: no model is exact, and what all leave out would decide between
/// rivals whose errors differ by a hundredth.
inline constexpr double kLeastPieces = 20.0;
inline constexpr double kMostPieces = 200.0;
/// An effect enters a set for this much evidence beyond its parameters' price, and for this share of the squares: less
/// can be clutter (jitter, ripple) that one of fourteen effects happens to fit. An effect as large as the noise, the
/// least that is called detectable, takes away half.
inline constexpr double kWorthEntering = 6.0;
inline constexpr double kLeastShare = 0.15;
/// What is most of the squares that a set leaves above the noise on the held-out rows: an effect that closes less is the form of the
/// others, which no catalogue holds exactly.
inline constexpr double kMostOfRest = 0.6;

/// A record with the row from which its errors count as held out.
struct HeldOut {
  Record record;
  std::size_t first = 1;
  /// Whether it continues a fitted record (its start is that record's) or begins anew.
  int continues = -1;
};

/// Which rows are fitted, and which judge.
struct Split {
  Scene fitted;
  std::vector<HeldOut> heldout;
  std::vector<Record> heldout_as_fitted;
};
Split split_of(const Scene& scene, const std::vector<HeldOut>& heldout);
/// Of the rows held out every other second shows the way of the null, and those between judge.
Split followed(Split split);

/// What a set of effects achieves.
struct Trial {
  effects::EffectSet on = 0;
  Fit fit;
  double heldout_squares = 0.0;
  std::size_t heldout_rows = 0;
  /// N above, of every trial the same: also of a null that wanders, whose way half of the rows held out show.
  std::size_t rows = 0;
  double joint_squares = 0.0;   ///< over fitted and held-out rows of the fit to both
  double judged_squares = 0.0;  ///< JointSquares::judged()
  /// Of figures and warmths: start pressures and stamp, which every trial has, do not count.
  std::size_t variables = 0;

  double joint_mean_square() const;  ///< S/n above
  double heldout_Pa() const;
  /// Of the error on the held-out rows, that which the figures left unknown by the fitted rows do not account for. Where those make
  /// far more of it than an effect closes, what two sets foretell is a matter of chance, and this is none.
  double judged_Pa() const;
  bool valid() const;
  /// `correlated_rows`: c above.
  double evidence(double correlated_rows) const;
};

Trial tried(const Split& rows, Fit fit);
/// The valve's figures fitted, no effect added.
Trial recalibrated(const Scene& scene, const std::vector<HeldOut>& heldout);

/// Rows for one piece of information in a trial's error on fitted rows.
double correlation(const Scene& scene, const Trial& trial);
bool worth_entering(const Trial& with, const Trial& base, double correlated_rows, double noise_Pa);
/// What a set closes of the squares above the noise that a smaller set leaves, 0 to 1; from RMS errors on held-out rows.
double share_of_rest(double with_Pa, double without_Pa, double noise_Pa);
/// The same of what they foretell or, where it is more, of what no unknown figure accounts for.
double share_of_rest(const Trial& with, const Trial& without, double noise_Pa);

/// The start of a held-out record's run.
effects::Start heldout_start(const Scene& scene, const HeldOut& held, const Fit& fit);
/// Readings of a trial's model over held-out records.
std::vector<double> heldout_reading(const Scene& scene, const HeldOut& held, const Fit& fit);

inline effects::EffectSet bit(std::size_t effect) {
  return effects::EffectSet{1} << effect;
}
/// Whether the null has a way that each log shows for itself.
bool wanders(const Fit& fit);
/// The effects of a set, in the catalogue's order.
std::vector<std::size_t> members(effects::EffectSet on);

}  // namespace plenum::host::diagnose
