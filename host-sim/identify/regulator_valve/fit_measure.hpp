// How well an estimate fits what was measured: fit = 100 (1 - |y^ - y| / |y - mean(y)|)              (V (39))
//
// 100 where they agree, 0 where the estimate is no better than the mean, below 0 where it is worse.
// Source: V: "Modeling and Parameter Identification of a Pneumatic Pressure Valve Using Least Squares and
// Particle Swarm Optimization Methods".
#pragma once

#include <vector>

namespace plenum::host::identify::regulator_valve {

/// (39) [%]. Throws std::invalid_argument for unequal or no lengths, CannotIdentify for a measurement that never
/// changes.
double fit_percent(const std::vector<double>& measured, const std::vector<double>& estimated);

}  // namespace plenum::host::identify::regulator_valve
