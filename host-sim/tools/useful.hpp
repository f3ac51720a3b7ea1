// Whether a model that was fitted is one.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/trace/log.hpp"

namespace plenum::host::tools {

/// The RMS over all rows of the logs [kPa], from that of each.
double pooled_rms_kPa(const std::vector<trace::Log>& logs,
                      const std::function<double(const trace::Log&)>& rms_kPa);

/// What a fit errs by on the logs it was made from [kPa], RMS over all rows.
struct FitError {
  double model_kPa = 0.0;
  double held_kPa = 0.0;  ///< of whoever knows nothing and holds the logs'
  std::string_view held;  ///< means, or start pressures
};

/// A model that follows its own logs hardly better than whoever knows nothing is none, nor is one that follows the logs' mirror
/// images in the command far better: its command has another sign, if one of the logs can tell that from a lag
/// (identify/sign_of_command.hpp). `turned_kPa`: the error of a fit to those, asked for in doubt only. Throws CannotIdentify.
void require_useful(const FitError& error,
                    const std::function<double(const std::vector<trace::Log>&)>& turned_kPa,
                    const std::vector<trace::Log>& logs);

/// Throws CannotIdentify for a fit that did not converge, though its model was written to `out`. `stop`: why it stopped.
void require_converged(bool converged, const std::string& stop, const std::string& out);

}  // namespace plenum::host::tools
