// The page of a fit: how well it predicts, its parameters, its curves, and what the logs could not tell.
#pragma once

#include <string>
#include <vector>

#include "host-sim/identify/fit.hpp"
#include "host-sim/report/page.hpp"
#include "host-sim/trace/log.hpp"

namespace plenum::host::tools {

using trace::NamedLog;

struct Identified {
  identify::Tassa9Fit fit;
  double stretch_s = 0.0;  ///< of the free runs that the fit was refined on; 0: it was not
  std::vector<NamedLog> fitted;
  std::vector<NamedLog> predicted;
  bool ventilator = false;  ///< the logs are of the RespiraWorks ventilator
};

report::Page identify_page(const Identified& identified);

}  // namespace plenum::host::tools
