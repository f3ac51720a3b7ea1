// The measured leaks of tests/data/leak_zillen.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "host-sim/identify/orifice/filter.hpp"
#include "host-sim/trace/recording.hpp"

namespace plenum::host::identify::orifice {

inline constexpr double kLeakAtmosphere_Pa = 101325.0;  // not recorded with the data

inline trace::Recording leak_file(const std::string& name, const std::vector<std::string>& columns) {
  std::vector<std::string> notices;
  return trace::read_recording(PLENUM_SOURCE_DIR "/tests/data/leak_zillen/" + name + ".csv", columns, {},
                               notices);
}

// From the row where the vessel has lost 3 % of its greatest pressure (before, it is still fed) where it
// loses that.
inline VesselRecord leak(const std::string& name) {
  const trace::Recording file = leak_file(name, {"t_s", "p_bar"});
  const std::vector<double>& gauge_bar = file["p_bar"];
  const double fed_bar = 0.97 * *std::max_element(gauge_bar.begin(), gauge_bar.end());
  std::size_t first = 0;
  if (gauge_bar.back() < fed_bar) {
    for (std::size_t i = 0; i < gauge_bar.size(); ++i) {
      if (gauge_bar[i] > fed_bar) first = i + 1;
    }
  }
  VesselRecord record{.flow = Flow::kDischarge,
                      .time_s = file["t_s"],
                      .vessel_Pa = gauge_bar,
                      .far_Pa = std::vector<double>(file.rows, kLeakAtmosphere_Pa)};
  for (double& p : record.vessel_Pa) p = kLeakAtmosphere_Pa + 1e5 * p;
  return rows_of(record, first, file.rows);
}

}  // namespace plenum::host::identify::orifice
