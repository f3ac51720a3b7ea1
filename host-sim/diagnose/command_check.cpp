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

/// Of the noise: what a mirror image that looks like a lag has to come to.
constexpr double kNearNoise = 5.0;
constexpr std::size_t kMostRowsLate = 2;

template <class Alter>
double rms_Pa_of(Scene scene, Alter&& alter) {
  for (Record& record : scene.records) alter(record.drive.command_V);
  return fit(scene, 0, scene.nominal, {}).rms_Pa();
}

}  // namespace

void require_acting_command(const Scene& scene, const Fit& recalibrated) {
  if (!errs_far_beyond_noise(scene, recalibrated)) return;
  const double as_logged_Pa = recalibrated.rms_Pa();
  struct Found {
    double rms_Pa;
    std::string what, expected;
  };
  Found best{as_logged_Pa, {}, {}};
  const auto take = [&](Found found) {
    if (found.rms_Pa < best.rms_Pa) best = std::move(found);
  };
  const double twice_null_V = scene.nominal[effects::kOpenAbove] + scene.nominal[effects::kExhaustBelow];
  const bool late_as_turned = std::ranges::all_of(scene.records, [](const Record& record) {
    return identify::turned_is_late(record.drive.command_V, record.drive.timing.tick_s);
  });
  Found turned{rms_Pa_of(scene,
                         [&](std::vector<double>& command_V) {
                           for (double& u : command_V) u = twice_null_V - u;
                         }),
               fmt::format("to have the other sign{}: by {:g} V less the command",
                           late_as_turned ? ", or to be late by half a period, which looks alike here" : "",
                           twice_null_V),
               "a command that fills the chamber where it is above valve.open_above_V"};
  // one that is only late is not followed to the noise by its mirror image
  if (!late_as_turned || turned.rms_Pa < kNearNoise * scene.noise_Pa) take(std::move(turned));
  for (std::size_t late = 1; late <= kMostRowsLate; ++late) {
    const double rms_Pa = rms_Pa_of(scene, [&](std::vector<double>& command_V) {
      const double last_V = command_V.back();
      command_V.erase(command_V.begin(), command_V.begin() + static_cast<std::ptrdiff_t>(late));
      command_V.insert(command_V.end(), late, last_V);
    });
    const std::string rows = late == 1 ? "one row" : fmt::format("{} rows", late);
    take({rms_Pa, fmt::format("to be {} late: {} earlier", rows, rows),
          "in each row the command held from its time to the next row's"});
  }
  if (!far_better(best.rms_Pa, as_logged_Pa)) return;
  throw trace::InputError(fmt::format(
      "{}: column command_V seems {} the valve recalibrated errs by {:.3g} kPa, as logged by {:.3g} kPa; "
      "expected {}",
      scene.records.front().name, best.what, 1e-3 * best.rms_Pa, 1e-3 * as_logged_Pa, best.expected));
}

}  // namespace plenum::host::diagnose
