// `plenum identify --model greybox`: the fit of the chamber's physics, what it prints, its files and its page.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host-sim/tools/output.hpp"
#include "host-sim/trace/log.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::tools {

struct GreyboxRequest {
  trace::RigDescription rig;
  std::vector<trace::NamedLog> fitted;
  std::vector<trace::NamedLog> predicted;
  std::optional<unsigned> chamber;
  std::uint32_t date_s = 0;  ///< of the fit, since 1970
  std::string out;
  std::string report;  ///< empty: none
};

/// Returns the command's exit code.
int identify_greybox(const GreyboxRequest& request, const Output& output);

}  // namespace plenum::host::tools
