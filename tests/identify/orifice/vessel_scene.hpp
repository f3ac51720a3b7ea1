// Records of vessels whose orifice is known, for the tests of its identification.
#pragma once

#include <cstdint>

#include "host-sim/identify/orifice/vessel.hpp"
#include "host-sim/identify/orifice/vessel_run.hpp"
#include "host-sim/plant/random.hpp"

namespace plenum::host::identify::orifice {

inline constexpr double kSupply_Pa = 7e5;
inline constexpr double kAmbient_Pa = 1e5;

/// `rows` rows, `step_s` apart, of a vessel behind `port_1_s` between 1 and 7 bar; white noise of `noise_Pa`.
inline VesselRecord record_of(const plant::EllipsePort& port_1_s, Flow flow, std::size_t rows, double step_s,
                              double noise_Pa = 0.0, std::uint64_t seed = 1) {
  // Only the step division of free_run() reads the record's own pressures: a fine grid of one value needs
  // none.
  constexpr std::size_t kFine = 20;
  const double start_Pa = flow == Flow::kCharge ? kAmbient_Pa : kSupply_Pa;
  const double far_Pa = flow == Flow::kCharge ? kSupply_Pa : kAmbient_Pa;
  VesselRecord fine{.flow = flow, .time_s = {}, .vessel_Pa = {}, .far_Pa = {}};
  for (std::size_t i = 0; i < (rows - 1) * kFine + 1; ++i) {
    fine.time_s.push_back(static_cast<double>(i) * step_s / kFine);
    fine.vessel_Pa.push_back(start_Pa);
    fine.far_Pa.push_back(far_Pa);
  }
  const std::vector<double> run = free_run(port_1_s, fine, start_Pa);
  plant::Random random(seed);
  VesselRecord record{.flow = flow, .time_s = {}, .vessel_Pa = {}, .far_Pa = {}};
  for (std::size_t i = 0; i < rows; ++i) {
    record.time_s.push_back(static_cast<double>(i) * step_s);
    record.vessel_Pa.push_back(run[i * kFine] + noise_Pa * random.gaussian());
    record.far_Pa.push_back(far_Pa);
  }
  return record;
}

}  // namespace plenum::host::identify::orifice
