#include "host-sim/identify/servo/flow_samples.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace plenum::host::identify::servo {

FlowError flow_error(std::span<const FlowSample> samples, std::span<const double> predicted_kg_s) {
  FlowError found;
  double squares = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double error = predicted_kg_s[i] - samples[i].flow_kg_s;
    squares += error * error;
    found.largest_kg_s = std::max(found.largest_kg_s, std::abs(error));
    found.full_scale_kg_s = std::max(found.full_scale_kg_s, std::abs(samples[i].flow_kg_s));
  }
  found.rms_kg_s = std::sqrt(squares / static_cast<double>(samples.size()));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (predicted_kg_s[i] * samples[i].flow_kg_s <= 0.0 &&
        std::abs(predicted_kg_s[i]) > 0.01 * found.full_scale_kg_s)
      ++found.wrong_way;
  }
  return found;
}

void require_finite(std::span<const FlowSample> samples) {
  for (const FlowSample& s : samples) {
    if (!std::isfinite(s.command_V) || !std::isfinite(s.pressure_Pa) || !std::isfinite(s.flow_kg_s))
      throw std::invalid_argument("flow sample: a value is not finite, expected finite numbers");
  }
}

}  // namespace plenum::host::identify::servo
