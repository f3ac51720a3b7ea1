// Which input parts causes that answer alike on the logs at hand: the next experiment, from a library of safe ones.
//
// Every input is an open-loop command about the valve's null, of 20 to 40 s. Its strokes are those of the first log,
// or, where that log hardly opened the valve, up to twice as much; never beyond twice the null's voltage.
#pragma once

#include <string>
#include <vector>

#include "host-sim/diagnose/gap_report.hpp"
#include "host-sim/identify/chamber/fit.hpp"

namespace plenum::host::diagnose {

using identify::chamber::Scene;

/// A stretch of an experiment that begins at rest at ambient pressure.
struct Stretch {
  effects::Drive drive;
  double supply_Pa = 0.0;
};

struct Excitation {
  std::string id;
  std::string title;     ///< reads on after "under"
  std::string sentence;  ///< what to do
  std::vector<Stretch> stretches;
};

/// The inputs for this chamber, those that need no more than the valve first. Throws std::invalid_argument if the
/// scene has no log.
std::vector<Excitation> library(const Scene& scene);

/// A cause as it was fitted to the logs.
struct Rival {
  std::string id;
  effects::EffectSet on = 0;
  effects::Figures figures{};
  std::size_t variables = 0;  ///< of its trial
};

/// Probability that the true one of two rivals is named alone by a log of `rows`: under white noise, `apart` times which is the RMS of
/// what the other leaves of it at best, the logarithm of their odds (trial.hpp) is nearly normal, about
/// m = n/2 ln(1 + apart^2) + price/2 ln n with a deviation of n apart/((1 + apart^2) sqrt(rows)), where n is the least of rows and
/// kMostPieces and `price` the number of variables that the other has more. Named alone it is where they exceed those of kNamedAlone.
double named_alone(double apart, double rows, double price);

/// The input that parts the rivals best: of each two of them the readings of the one are what the other's are fitted to, by the valve's
/// figures and the starts (linearised); what is left is what named_alone() is of, the mean of both ways round. power is the
/// mean of that over all pairs. An input that parts every two in 19 of 20 cases goes before one that does not, then the greater
/// power, then the greater of what the nearest two differ by; `separates` names the rivals that are told from another in 19 of 20 cases. One rival, or none: the input that takes the chamber through the most even variety of regimes and volumes;
/// power 0, as nothing is parted. Throws as library().
NextExperiment next_experiment(const Scene& scene, const std::vector<Rival>& rivals);

}  // namespace plenum::host::diagnose
