#include "host-sim/identify/profile.hpp"

#include <exception>
#include <optional>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify {

Tassa9Fit fit_tassa9_profiled(const std::vector<trace::Log>& logs, const trace::RigDescription& rig,
                              const FitOptions& options) {
  std::optional<Tassa9Fit> best;
  std::exception_ptr first_reason;
  for (const double width_V : kKinkWidths_V) {
    FitOptions tried = options;
    tried.c_gamma_V = width_V;
    try {
      Tassa9Fit fit = fit_tassa9(logs, rig, tried);
      if (!best || fit.rms_free_run_kPa < best->rms_free_run_kPa) best = std::move(fit);
    } catch (const CannotIdentify&) {
      if (!first_reason) first_reason = std::current_exception();
    }
  }
  if (!best) std::rethrow_exception(first_reason);
  return *best;
}

}  // namespace plenum::host::identify
