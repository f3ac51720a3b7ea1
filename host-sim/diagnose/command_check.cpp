#include "host-sim/diagnose/command_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "host-sim/diagnose/other_reading.hpp"
#include "host-sim/identify/sign_of_command.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::diagnose {
namespace {

using identify::chamber::Fit;
using identify::chamber::Record;
using identify::chamber::Scene;

constexpr std::size_t kMostRowsOff = 2;  ///< a command late, or a pressure early
/// Of two readings that err alike the first is told: a pressure that is early is a late command where the volume rests.
constexpr double kClearlyLess = 0.9;
constexpr double kRests = 1e-3;  ///< swing of a volume that compresses nothing

template <class Alter>
Scene altered(Scene scene, Alter&& alter) {
  for (Record& record : scene.records) alter(record);
  return scene;
}

/// Another reading of the logs, and what the valve recalibrated errs by under it.
struct Found {
  double rms_Pa;
  std::string what, expected;
};

/// The volumes half a row, one or two later, whichever errs least. A pressure that lags or stands behind a hose is late after the
/// volume, too: where one of those errs no more, the volume is not blamed, and the error is as logged.
Found later_volume(const Scene& scene, double as_logged_Pa, const ErrorOf& error_of) {
  Found best{as_logged_Pa, {}, {}};
  if (std::ranges::all_of(scene.records, [](const Record& r) { return volume_swing(r) < kRests; }))
    return best;
  const auto take = [&](int halves, const char* rows) {
    const double rms_Pa = error_of(altered(scene, [&](Record& record) {
      std::vector<double>& volume_m3 = record.drive.volume_m3;
      const auto steps = static_cast<std::size_t>(halves * record.drive.timing.steps / 2);
      volume_m3.insert(volume_m3.begin(), steps, volume_m3.front());
      volume_m3.resize(volume_m3.size() - steps);
    }));
    if (rms_Pa < kClearlyLess * best.rms_Pa)
      best = {rms_Pa, fmt::format("volume_m3 seems to be {} early: {} later", rows, rows),
              "in each row the volume at its time"};
  };
  take(1, "half a row");
  take(2, "one row");
  take(4, "2 rows");
  if (!far_better(best.rms_Pa, as_logged_Pa)) return best;
  for (const std::size_t late : {effects::kIdSensorLag, effects::kIdTubeDynamics}) {
    if (fit(scene, effects::EffectSet{1} << late, scene.nominal, {}).rms_Pa() < best.rms_Pa / kClearlyLess)
      return {as_logged_Pa, {}, {}};
  }
  return best;
}

}  // namespace

void require_acting_command(const Scene& scene, const Fit& recalibrated) {
  require_acting_command(scene, recalibrated.rms_Pa(), fitted_anew(0, recalibrated.rms_Pa()));
}

void require_acting_command(const Scene& scene, double as_logged_Pa, const ErrorOf& error_of) {
  if (is_near_noise(as_logged_Pa, scene)) return;
  Found best{as_logged_Pa, {}, {}};
  const auto take = [&](Found found) {
    if (found.rms_Pa < kClearlyLess * best.rms_Pa) best = std::move(found);
  };
  const double twice_null_V = scene.nominal[effects::kOpenAbove] + scene.nominal[effects::kExhaustBelow];
  const bool late_as_turned = std::ranges::all_of(scene.records, [](const Record& record) {
    return identify::turned_is_late(record.drive.command_V, record.drive.timing.tick_s);
  });
  Found turned{error_of(altered(scene,
                                [&](Record& record) {
                                  for (double& u : record.drive.command_V) u = twice_null_V - u;
                                })),
               fmt::format("command_V seems to have the other sign{}: by {:g} V less the command",
                           late_as_turned ? ", or to be late by half a period, which looks alike here" : "",
                           twice_null_V),
               "a command that fills the chamber where it is above valve.open_above_V"};
  // one that is only late is not followed to the noise by its mirror image
  if (!late_as_turned || is_near_noise(turned.rms_Pa, scene)) take(std::move(turned));
  for (std::size_t shift = 1; shift <= kMostRowsOff; ++shift) {
    const std::string rows = shift == 1 ? "one row" : fmt::format("{} rows", shift);
    take({error_of(altered(scene,
                           [&](Record& record) {
                             std::vector<double>& command_V = record.drive.command_V;
                             command_V.erase(command_V.begin(),
                                             command_V.begin() + static_cast<std::ptrdiff_t>(shift));
                             command_V.resize(record.rows(), command_V.back());
                           })),
          fmt::format("command_V seems to be {} late: {} earlier", rows, rows),
          "in each row the command held from its time to the next row's"});
    take({error_of(altered(scene,
                           [&](Record& record) {
                             std::vector<double>& measured_Pa = record.measured_Pa;
                             measured_Pa.insert(measured_Pa.begin(), shift, measured_Pa.front());
                             measured_Pa.resize(measured_Pa.size() - shift);
                             record.settled_rows += shift;
                           })),
          fmt::format("pressure_Pa seems to be {} early: {} later", rows, rows),
          "in each row the pressure at its time"});
  }
  take(later_volume(scene, as_logged_Pa, error_of));
  if (!far_better(best.rms_Pa, as_logged_Pa)) return;
  throw trace::InputError(fmt::format(
      "{}: column {} the valve recalibrated errs by {:.3g} kPa, as logged by {:.3g} kPa; "
      "expected {}",
      scene.records.front().name, best.what, 1e-3 * best.rms_Pa, 1e-3 * as_logged_Pa, best.expected));
}

}  // namespace plenum::host::diagnose
