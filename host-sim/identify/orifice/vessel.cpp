#include "host-sim/identify/orifice/vessel.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "host-sim/plant/orifice.hpp"
#include "host-sim/plant/refuse.hpp"

namespace plenum::host::identify::orifice {
namespace {

void validate_column(const char* name, const std::vector<double>& pressures_Pa, std::size_t rows) {
  if (pressures_Pa.size() != rows)
    throw std::invalid_argument(fmt::format("vessel record, column {}: {} rows, expected {} as in time_s",
                                            name, pressures_Pa.size(), rows));
  for (std::size_t i = 0; i < rows; ++i) {
    if (!(std::isfinite(pressures_Pa[i]) && pressures_Pa[i] > 0.0))
      throw std::invalid_argument(
          fmt::format("vessel record, column {}, row {}: {} Pa, expected an absolute pressure above 0", name,
                      i + 1, pressures_Pa[i]));
  }
}

}  // namespace

std::optional<double> choked_rate_of_area_1_s_m2(const Vessel& vessel) {
  plant::validate(vessel.gas);
  plant::require_within("vessel flow_exponent", vessel.flow_exponent, 1.0, vessel.gas.kappa);
  plant::require_above("vessel discharge_coefficient", vessel.discharge_coefficient, 0.0);
  if (!vessel.volume_m3) return std::nullopt;
  plant::require_above("vessel volume_m3", *vessel.volume_m3, 0.0);
  const double RT = vessel.gas.specific_gas_constant_J_kg_K() * vessel.gas.temperature_K;
  return vessel.discharge_coefficient * plant::choked_flow_function(vessel.gas.kappa) * vessel.flow_exponent *
         std::sqrt(2.0 * RT) / *vessel.volume_m3;
}

void validate(const VesselRecord& record, std::size_t least_rows) {
  const std::size_t rows = record.time_s.size();
  if (rows < least_rows)
    throw std::invalid_argument(fmt::format("vessel record: {} rows, expected {} or more", rows, least_rows));
  for (std::size_t i = 0; i < rows; ++i) {
    const bool rises = i == 0 || record.time_s[i] > record.time_s[i - 1];
    if (!(std::isfinite(record.time_s[i]) && rises))
      throw std::invalid_argument(
          fmt::format("vessel record, column time_s, row {}: {} s, expected a time after the row before",
                      i + 1, record.time_s[i]));
  }
  validate_column("vessel_Pa", record.vessel_Pa, rows);
  validate_column("far_Pa", record.far_Pa, rows);
}

double pressure_ratio(const VesselRecord& record, std::size_t i) {
  return record.flow == Flow::kCharge ? record.vessel_Pa[i] / record.far_Pa[i]
                                      : record.far_Pa[i] / record.vessel_Pa[i];
}

}  // namespace plenum::host::identify::orifice
