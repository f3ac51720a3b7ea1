// The 9-parameter model computed in intervals: every number on the way, for all parameter sets and states of a box at once.
#pragma once

#include <span>
#include <utility>

namespace ranges {

using Bounds = std::pair<double, double>;

struct States {
  Bounds pressure_kPa, command_V, volume_mL, speed_mL_s;
};

struct Found {
  double largest = 0;  ///< magnitude of any number on the way, the model's tables included
  Bounds end_kPa, mean_kPa;
};

/// A tick of tassa9, over commands of 0 to 10 V. `parameters`: of config::ModelKind::tassa9.
Found tick(std::span<const Bounds> parameters, const States& states);

}  // namespace ranges
