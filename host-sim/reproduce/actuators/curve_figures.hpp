// Figures of curves that several parts ask for.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "host-sim/reproduce/actuators/illustrated.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::actuators {

/// Share of the variance of `truth` that `model` explains [%]; of one length.
inline double explained_percent(const std::vector<double>& model, const std::vector<double>& truth) {
  const double centre = mean(truth);
  double residual = 0.0;
  double variance = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    residual += (model[i] - truth[i]) * (model[i] - truth[i]);
    variance += (truth[i] - centre) * (truth[i] - centre);
  }
  return 100.0 * (1.0 - residual / variance);
}

/// Slope of a sigmoid over the command at its null, over its steepest slope from 3 to 7 V: below 1, a flat kink.
/// Central differences of 1 mV.
template <class Sigmoid>
double slope_at_null_over_steepest(const Sigmoid& s, double null_V) {
  constexpr double kStep_V = 1e-3;
  const auto slope = [&](double u) { return s(u + kStep_V) - s(u - kStep_V); };
  const double at_null = slope(null_V);
  double steepest = at_null;
  for (const double u : evenly(kLow_V, kHigh_V, 801)) steepest = greater_of(steepest, slope(u));
  return at_null / steepest;
}
/// Our reading of III.A's "flat kink": slope_at_null_over_steepest() is this at most.
inline constexpr double kFlatKink = 0.5;

}  // namespace plenum::host::reproduce::actuators
