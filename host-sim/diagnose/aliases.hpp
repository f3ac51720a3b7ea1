// Effects that an excitation cannot tell apart, before the evidence is looked at.
//
//   s_i = S_i - N (N^T N)^-1 N^T S_i,   cos(i, k) = s_i.s_k / (|s_i| |s_k|)
//
// S_i sensitivity of the readings to the leading parameter of effect i, N sensitivities to the valve's figures and the
// start pressures, all at the recalibrated model. While small, effects whose |cos| is 1 are one effect for this log, and one of
// s_i = 0 is calibration. Sizes beyond that may part them: the search judges those. Source: collinearity of sensitivities,
// Brun, Reichert and Kuensch (2001).
#pragma once

#include <string>
#include <vector>

#include "host-sim/identify/chamber/fit.hpp"

namespace plenum::host::diagnose {

using identify::chamber::Scene;

/// Ids of two and more that share their readings, in the catalogue's order; "calibration" leads those that the valve's
/// figures take up entirely. Over the fitted rows; at `figures` and a start a record.
std::vector<std::vector<std::string>> alias_classes(const Scene& scene, const effects::Figures& figures,
                                                    const std::vector<effects::Start>& start);

}  // namespace plenum::host::diagnose
