// How small an effect could have been seen beside those that were found.
#pragma once

#include <cstddef>
#include <vector>

#include "host-sim/diagnose/gap_report.hpp"
#include "host-sim/diagnose/trial.hpp"

namespace plenum::host::diagnose {

/// Standard errors at which a size is missed, and seen where there is none, once in twenty: 1.64 + 1.64.
inline constexpr double kShownErrors = 3.29;

/// Of each of `others`, which are not in `used`, the least size of its first parameter that would have shown in `scene` beside `used` and
/// against what that leaves, whose errors are correlated over so many rows: by what it shows at a typical size, then at the least so found,
/// since heat shows less the more there is.
std::vector<Detectable> detectable(const Scene& scene, const Fit& used,
                                   const std::vector<std::size_t>& others, double correlated_rows,
                                   unsigned threads);

}  // namespace plenum::host::diagnose
