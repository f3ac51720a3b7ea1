#include "host-sim/diagnose/look.hpp"

#include <algorithm>
#include <span>
#include <vector>

namespace plenum::host::diagnose {

using identify::chamber::Record;
using identify::chamber::Scene;

Scene coarse(const Scene& scene, double seconds) {
  Scene coarse = scene;
  for (Record& record : coarse.records) {
    const effects::Drive fine = record.drive;
    const auto rows = static_cast<std::size_t>(
        std::min(seconds / fine.timing.tick_s, static_cast<double>(record.fitted_rows)));
    std::vector<double> volume_m3(rows);
    for (std::size_t row = 0; row < rows; ++row) {
      volume_m3[row] = fine.volume_m3[row * static_cast<std::size_t>(fine.timing.steps)];
    }
    effects::Timing timing = fine.timing;
    timing.steps = fine.timing.steps / 2;
    record.drive = effects::make_drive(std::span(fine.command_V).first(rows), volume_m3, timing);
    record.drive.supply_Pa = fine.supply_Pa;
    record.measured_Pa.resize(rows);
    record.fitted_rows = rows;
  }
  return coarse;
}

}  // namespace plenum::host::diagnose
