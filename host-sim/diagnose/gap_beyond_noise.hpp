// Whether there is a gap: an error beyond noise that the valve's figures do not follow though all rows show them.
#pragma once

#include <cstddef>
#include <vector>

#include "host-sim/diagnose/trial.hpp"

namespace plenum::host::diagnose {

/// The valve's figures fitted to all rows, those held out among them.
struct CalibratedToAll {
  Scene scene;
  Fit fit;
  std::vector<std::size_t> place;  ///< where in the scene the records held out are
};

/// `base`: fitted to the rows of `fitted` alone. A short log leaves some of its figures unknown, and it may be so far off that no
/// linearisation there finds what fits all of it; the data sheet is where the fit begins then.
CalibratedToAll calibrated_to_all(const Scene& fitted, const std::vector<HeldOut>& heldout, const Fit& base);

/// Probability that noise alone makes the valve's figures, fitted to the held-out rows too, err there as much as they do: what the
/// fitted rows leave unknown of the figures is no gap, and a supply's ripple, of which the best explanation's error on the fitted rows
/// of `scene` tells, is noise (identify/chamber/noise.hpp, probability_of_noise()).
double gap_p_value(const CalibratedToAll& all, const std::vector<HeldOut>& heldout, const Scene& scene,
                   const Fit& best, double noise_Pa);

}  // namespace plenum::host::diagnose
