// A recording over the bus as the log of one of its chambers.
#pragma once

#include <cstddef>
#include <vector>

#include "host-sim/client/capture.hpp"
#include "host-sim/trace/log.hpp"

namespace plenum::host::tools {

/// With its reference where the recording followed one, and the supply where every row has it.
inline trace::Log log_of(const std::vector<client::CapturedRow>& rows, std::size_t chamber,
                         bool with_reference = false) {
  trace::Log log;
  for (const client::CapturedRow& row : rows) {
    log.time_s.push_back(row.time_s);
    log.command_V.push_back(row.sample[chamber].command_V);
    log.pressure_Pa.push_back(row.sample[chamber].actual_Pa);
    log.volume_m3.push_back(row.sample[chamber].volume_m3);
    if (with_reference) log.reference_Pa.push_back(row.reference_Pa[chamber]);
    if (row.supply_Pa) log.supply_Pa.push_back(*row.supply_Pa);
  }
  if (log.supply_Pa.size() != rows.size()) log.supply_Pa.clear();
  return log;
}

}  // namespace plenum::host::tools
