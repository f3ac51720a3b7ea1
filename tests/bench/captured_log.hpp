// A chamber of a recording over the bus as a log.
#pragma once

#include <cstddef>
#include <vector>

#include "host-sim/client/capture.hpp"
#include "host-sim/trace/log.hpp"

namespace plenum::bench {

inline host::trace::Log log_of(const std::vector<host::client::CapturedRow>& rows, std::size_t chamber) {
  host::trace::Log log;
  for (const host::client::CapturedRow& row : rows) {
    log.time_s.push_back(row.time_s);
    log.command_V.push_back(row.sample[chamber].command_V);
    log.pressure_Pa.push_back(row.sample[chamber].actual_Pa);
    log.volume_m3.push_back(row.sample[chamber].volume_m3);
  }
  return log;
}

}  // namespace plenum::bench
