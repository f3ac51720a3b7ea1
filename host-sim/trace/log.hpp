// A log in memory: one row a tick, uniform rate, SI units. The file format is a contract: README.md here.
#pragma once

#include <cstddef>
#include <numeric>
#include <string>
#include <vector>

namespace plenum::host::trace {

struct Log {
  double period_s = 0.01;  ///< time between rows
  /// A pressure is the mean over this time before its row; 0: an instant sample.
  double pressure_average_s = 0.01;
  std::vector<double> time_s;       ///< start of the tick
  std::vector<double> command_V;    ///< held from this row's time to the next row's
  std::vector<double> pressure_Pa;  ///< absolute
  std::vector<double> volume_m3;
  // optional columns: empty, or as long as time_s
  std::vector<double> supply_Pa;
  std::vector<double> position_m;
  std::vector<double> temperature_K;
  std::vector<double> reference_Pa;

  std::size_t size() const { return time_s.size(); }
  /// Not a number of a log without rows.
  double mean_volume_m3() const {
    return std::accumulate(volume_m3.begin(), volume_m3.end(), 0.0) / static_cast<double>(volume_m3.size());
  }
};

/// A log and what messages and pages call it: its file's name.
struct NamedLog {
  std::string name;
  Log log;
};

}  // namespace plenum::host::trace
