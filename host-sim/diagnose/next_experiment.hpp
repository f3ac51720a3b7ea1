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
};

/// The input that parts the rivals best: each two of them are at a distance D, that of their readings over the noise after
/// the valve's figures and the starts of the one have been fitted to the other (linearised; the less of both ways round), and Phi(D/2)
/// is the probability that the nearer of the two is the true one, under noise alone. power is the mean of it over all pairs. An
/// input that parts every two in 19 of 20 cases goes before one that does not, then the greater power, then the greater least D;
/// `separates` names the rivals that are told from another in 19 of 20 cases. One rival, or none: the input that takes the chamber through the most even variety of regimes and volumes;
/// power 0, as nothing is parted. Throws as library().
NextExperiment next_experiment(const Scene& scene, const std::vector<Rival>& rivals);

}  // namespace plenum::host::diagnose
