// Whether a model that was fitted is one.
#pragma once

#include <functional>
#include <string_view>
#include <vector>

#include "host-sim/trace/log.hpp"

namespace plenum::host::tools {

/// The RMS over all rows of the logs [kPa], from that of each.
double pooled_rms_kPa(const std::vector<trace::Log>& logs,
                      const std::function<double(const trace::Log&)>& rms_kPa);

/// A model that follows the very logs that it was fitted to hardly better than whoever knows nothing, and holds their `held`, is none.
/// Throws CannotIdentify.
void require_useful(double rms_kPa, double held_rms_kPa, std::string_view held);

}  // namespace plenum::host::tools
