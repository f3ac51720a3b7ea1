// The page of an acceptance test: what was measured beside its limits, and the curves behind it.
#pragma once

#include <span>
#include <string>

#include "host-sim/report/page.hpp"
#include "host-sim/tools/acceptance_run.hpp"

namespace plenum::host::tools {

/// `board`: who was tested, in a sentence.
report::Page acceptance_page(const std::string& board, const AcceptanceRun& run,
                             std::span<const client::Judged> judged);

}  // namespace plenum::host::tools
