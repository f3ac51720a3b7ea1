// The flow of a valve port on a bench: samples, and how a law of it errs on them.
#pragma once

#include <cstddef>
#include <span>

namespace plenum::host::identify::servo {

struct FlowSample {
  double command_V = 0.0;
  double pressure_Pa = 0.0;  ///< of the chamber, absolute
  double flow_kg_s = 0.0;    ///< through the port, the way it is meant for
};

struct FlowError {
  double rms_kg_s = 0.0;
  double largest_kg_s = 0.0;     ///< largest error, by amount
  double full_scale_kg_s = 0.0;  ///< largest flow of the samples, by amount
  /// Samples predicted to flow by more than 1 % of full scale where the valve flows the other way or not at
  /// all.
  std::size_t wrong_way = 0;
};

/// `predicted_kg_s` is as long as `samples`, which are not empty.
FlowError flow_error(std::span<const FlowSample> samples, std::span<const double> predicted_kg_s);

/// Throws std::invalid_argument when a value is not finite.
void require_finite(std::span<const FlowSample> samples);

}  // namespace plenum::host::identify::servo
