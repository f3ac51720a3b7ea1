// The measured friction records of tests/data/friction_zillen.
#pragma once

#include <array>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "host-sim/identify/servo/friction_fit.hpp"

namespace plenum::host::identify::servo {

inline constexpr std::array<int, 4> kPulledAt_bar{1, 3, 5, 7};

inline PulledRecord pulled_record(int pressure_bar) {
  const std::string path = std::string(PLENUM_SOURCE_DIR) + "/tests/data/friction_zillen/O-ring_" +
                           std::to_string(pressure_bar) + "bar.csv";
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  PulledRecord record;
  std::string line;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::stringstream cells(line);
    std::array<double, 7> value{};
    std::string cell;
    for (double& v : value) {
      std::getline(cells, cell, ',');
      v = std::stod(cell);
    }
    record.time_s.push_back(1e-3 * value[0]);
    record.position_m.push_back(1e-3 * value[4]);
    record.pressure_Pa.push_back(1e5 * value[5]);
    record.force_N.push_back(value[6]);
  }
  return record;
}

inline std::vector<std::vector<SlidingRow>> pulled_rows() {
  std::vector<std::vector<SlidingRow>> records;
  for (const int bar : kPulledAt_bar) records.push_back(sliding_rows(pulled_record(bar), SlidingWindow{}));
  return records;
}

}  // namespace plenum::host::identify::servo
