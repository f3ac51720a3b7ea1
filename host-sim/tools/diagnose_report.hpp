// The page of a diagnosis: the gap, its cause, where it lies, and what these logs could not tell.
#pragma once

#include "host-sim/diagnose/gap_report.hpp"
#include "host-sim/report/page.hpp"

namespace plenum::host::tools {

report::Page diagnose_page(const diagnose::GapReport& report);

}  // namespace plenum::host::tools
