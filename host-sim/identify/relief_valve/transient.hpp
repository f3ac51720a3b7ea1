// A recorded transient of a relief valve, and what the grey-box model predicts for it.
#pragma once

#include <vector>

#include "host-sim/plant/relief_valve/grey_box.hpp"

namespace plenum::host::identify::relief_valve {

/// Pressure difference and flow through the valve, sampled at equal steps.
struct Transient {
  double step_s = 0.0;
  std::vector<double> pressure_Pa{};  ///< > 0
  std::vector<double> flow_m3_s{};    ///< > 0, as many
};

/// Throws std::invalid_argument naming the field and the sample.
void validate(const Transient& transient);

/// Derivative by the parabola through three neighbouring samples (the ends: through the first or last three);
/// at least three samples [unit/s].
std::vector<double> parabolic_rate(const std::vector<double>& samples, double step_s);

/// Pressure [Pa] of the model driven by the recorded flow, from rest at its first sample, at every sample.
std::vector<double> predict_pressure(const plant::relief_valve::GreyBoxConfig& valve,
                                     const Transient& transient);

/// Integral of (P recorded - P model)^2 over the record [Pa2 s], (4.5).
double performance_index(const plant::relief_valve::GreyBoxConfig& valve, const Transient& transient);

struct PredictionError {
  double worst = 0.0;  ///< largest |P model - P| / P; NaN where one is
  double final = 0.0;  ///< (P model - P) / P, mean of the last tenth of the record
};
PredictionError prediction_error(const std::vector<double>& predicted_Pa, const Transient& transient);

}  // namespace plenum::host::identify::relief_valve
