#include "host-sim/diagnose/reference_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "host-sim/diagnose/other_reading.hpp"
#include "host-sim/identify/in_parallel.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::diagnose {
namespace {

using identify::chamber::Fit;
using identify::chamber::Record;
using identify::chamber::Scene;

/// Of the supply: a sensor may read so much more of it.
constexpr double kReadsMore = 0.05;

/// Of ambient: beside a gain error the offset of a log in gauge pressure comes to a little less.
constexpr double kNearAmbient = 0.8;
constexpr std::size_t kOffset = effects::kFirstFigure[effects::kIdSensorBias];
static_assert(effects::kSensorBiasParameters[0].name == "offset_kPa");

/// What would be in gauge pressure.
struct Reading {
  bool log, supply;
  std::string_view what;
};
constexpr std::array<Reading, 3> kReadings{
    {{true, false, "column pressure_Pa seems"},
     {false, true, "the rig's supply.pressure_Pa seems"},
     {true, true, "column pressure_Pa and the rig's supply.pressure_Pa seem"}}};

Scene in_absolute(Scene scene, const Reading& reading) {
  const double ambient_Pa = scene.around.ambient_Pa;
  if (reading.supply) scene.around.supply_Pa += ambient_Pa;
  if (!reading.log) return scene;
  for (Record& record : scene.records) {
    for (double& p : record.measured_Pa) p += ambient_Pa;
  }
  return scene;
}

/// What the supply fills a chamber with, and a volume that moves may compress.
bool within_supply(const Scene& scene) {
  return std::ranges::all_of(scene.records, [&](const Record& record) {
    const double compressed = std::pow(1.0 + volume_swing(record), scene.around.gas.kappa);
    return std::ranges::max(record.measured_Pa) <= (1.0 + kReadsMore) * compressed * scene.around.supply_Pa;
  });
}

}  // namespace

void require_absolute_pressures(const Scene& scene, const Fit& found, unsigned threads) {
  require_absolute_pressures(scene, found.rms_Pa(), fitted_anew(found.on, found.rms_Pa()), threads);
}

void require_absolute_pressures(const Scene& scene, double as_written_Pa, const ErrorOf& error_of,
                                unsigned threads) {
  if (is_near_noise(as_written_Pa, scene)) return;
  std::array<double, kReadings.size()> rms_Pa{};
  identify::in_parallel(kReadings.size(), threads, [&](std::size_t i) {
    const Scene absolute = in_absolute(scene, kReadings[i]);
    rms_Pa[i] = kReadings[i].log && !within_supply(absolute) ? std::numeric_limits<double>::infinity()
                                                             : error_of(absolute);
  });
  double least_Pa = as_written_Pa;
  const Reading* best = nullptr;
  for (std::size_t i = 0; i < kReadings.size(); ++i) {
    // another effect may make both a little better than the one that is: both have to be far better than either
    const bool both = kReadings[i].log && kReadings[i].supply;
    if (rms_Pa[i] >= least_Pa || !far_better(rms_Pa[i], both ? least_Pa : as_written_Pa)) continue;
    least_Pa = rms_Pa[i];
    best = &kReadings[i];
  }
  if (best == nullptr) return;
  throw trace::InputError(fmt::format(
      "{}: {} to be gauge pressure: with ambient added the model fitted errs by {:.3g} kPa, as written by "
      "{:.3g} kPa; expected absolute pressure in Pa, ambient is {:.6g}",
      scene.records.front().name, best->what, 1e-3 * least_Pa, 1e-3 * as_written_Pa,
      scene.around.ambient_Pa));
}

void require_no_offset_of_ambient(const Scene& scene, const Fit& found) {
  if ((found.on & effects::EffectSet{1} << effects::kIdSensorBias) == 0) return;
  const double offset_Pa = 1e3 * found.figures[kOffset];
  if (offset_Pa > -kNearAmbient * scene.around.ambient_Pa) return;
  throw trace::InputError(
      fmt::format("{}: column pressure_Pa seems to be gauge pressure: the sensor would read {:.3g} kPa less "
                  "than the chamber has; "
                  "expected absolute pressure in Pa, ambient is {:.6g}",
                  scene.records.front().name, -1e-3 * offset_Pa, scene.around.ambient_Pa));
}

}  // namespace plenum::host::diagnose
