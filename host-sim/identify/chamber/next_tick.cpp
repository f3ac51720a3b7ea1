#include "host-sim/identify/chamber/next_tick.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace plenum::host::identify::chamber {
namespace {

constexpr std::size_t kRows = 3;  // of a run: before, known, predicted
constexpr double kStep_Pa = 100.0;
constexpr double kLeast_Pa = 1000.0;
/// Of the reading by the pressure at the tick's beginning: below it the beginning leaves no trace, whichever it was.
constexpr double kLeastSlope = 1e-3;

}  // namespace

double next_tick_rms_Pa(const Scene& scene, effects::EffectSet on, const effects::Figures& figures) {
  double squares = 0.0;
  double rows = 0.0;
  std::array<double, kRows * effects::kLanes> readings{};
  for (const Record& record : scene.records) {
    const auto steps = static_cast<std::size_t>(record.drive.timing.steps);
    effects::Drive drive{{}, {}, record.drive.timing};
    for (std::size_t k = 1; k + 1 < record.fitted_rows; ++k) {
      const auto tick = static_cast<std::ptrdiff_t>(k - 1);
      const auto volume = record.drive.volume_m3.begin() + tick * static_cast<std::ptrdiff_t>(steps);
      drive.command_V.assign(record.drive.command_V.begin() + tick,
                             record.drive.command_V.begin() + tick + kRows);
      drive.volume_m3.assign(volume, volume + static_cast<std::ptrdiff_t>(2 * steps + 1));
      const std::vector<double>& supply_Pa = record.drive.supply_Pa;
      if (!supply_Pa.empty()) drive.supply_Pa.assign(supply_Pa.begin() + tick, supply_Pa.begin() + tick + 2);
      double start_Pa = record.measured_Pa[k];
      for (int pass = 0; pass < 3; ++pass) {
        const std::array<effects::Run, 2> runs{{{figures, {start_Pa}}, {figures, {start_Pa + kStep_Pa}}}};
        effects::free_run(scene.around, drive, on | scene.known, runs, readings);
        const double* const known = readings.data() + effects::kLanes;
        const double slope = (known[1] - known[0]) / kStep_Pa;
        if (slope < kLeastSlope || pass == 2) break;
        start_Pa = std::max(start_Pa - (known[0] - record.measured_Pa[k]) / slope, kLeast_Pa);
      }
      const double error = readings[2 * std::size_t{effects::kLanes}] - record.measured_Pa[k + 1];
      squares += error * error;
      rows += 1.0;
    }
  }
  return std::sqrt(squares / rows);
}

double tick_change_rms_Pa(const Scene& scene) {
  double squares = 0.0;
  double rows = 0.0;
  for (const Record& record : scene.records) {
    const effects::Start start = estimate_start(scene, record, 0, scene.nominal);
    const std::vector<double> reading_Pa = run(scene, record, 0, scene.nominal, start);
    for (std::size_t k = record.settled_rows; k < record.fitted_rows; ++k) {
      const double change_Pa =
          reading_Pa[k] - record.measured_Pa[k] - (reading_Pa[k - 1] - record.measured_Pa[k - 1]);
      squares += change_Pa * change_Pa;
      rows += 1.0;
    }
  }
  return std::sqrt(squares / rows);
}

}  // namespace plenum::host::identify::chamber
