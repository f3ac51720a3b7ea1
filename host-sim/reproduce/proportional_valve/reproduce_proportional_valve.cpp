#include "host-sim/reproduce/proportional_valve/reproduce_proportional_valve.hpp"

#include "host-sim/reproduce/proportional_valve/parts.hpp"

namespace plenum::host::reproduce::proportional_valve {

std::vector<Part> reproduce_proportional_valve(const Progress& progress) {
  constexpr double kSetPoints = 416.0;  // 104, on four rigs
  constexpr double kFits = 0.9;         // of the time
  double done = 0.0;
  const auto row_done = [&] {
    done += 1.0;
    if (progress) progress(kFits * done / kSetPoints);
  };
  IdentifiedValve valve;
  for (const double conductance_W_K : kWalls_W_K) valve.walled.push_back({conductance_W_K, {}});
  for (const Series& series : all_series()) {
    valve.prompt.push_back(identify_series(series, {}, row_done));
    valve.lagging.push_back(identify_series(series, rig_with_spool(), row_done));
    for (WalledRig& rig : valve.walled)
      rig.series.push_back(identify_series(series, rig_with_wall(rig.conductance_W_K), row_done));
  }
  std::vector<Part> parts = {flow_function_part(), vessel_part(),
                             tables_part(),        cracking_part(),
                             rate_fit_part(valve), pressure_fit_part(valve),
                             error_part(valve),    verification_part(valve),
                             leak_part()};
  if (progress) progress(1.0);
  return parts;
}

}  // namespace plenum::host::reproduce::proportional_valve
