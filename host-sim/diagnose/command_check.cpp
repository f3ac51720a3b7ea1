#include "host-sim/diagnose/command_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "host-sim/diagnose/other_reading.hpp"
#include "host-sim/identify/in_parallel.hpp"
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

/// Another reading of a log.
struct Reading {
  std::function<void(Record&)> alter;
  std::string what, expected;
  double rms_Pa = 0.0;  ///< what the valve recalibrated errs by under it
};

Scene altered(Scene scene, const Reading& reading) {
  for (Record& record : scene.records) reading.alter(record);
  return scene;
}

/// By commands mirrored about `twice_null_V`/2.
Reading turned(double twice_null_V, bool late_as_turned) {
  return {[=](Record& record) {
            for (double& u : record.drive.command_V) u = twice_null_V - u;
          },
          fmt::format("command_V seems to have the other sign{}: by {:g} V less the command",
                      late_as_turned ? ", or to be late by half a period, which looks alike here" : "",
                      twice_null_V),
          "a command that fills the chamber where it is above valve.open_above_V"};
}

Reading command_earlier(std::size_t shift, const std::string& rows) {
  return {[=](Record& record) {
            std::vector<double>& command_V = record.drive.command_V;
            command_V.erase(command_V.begin(), command_V.begin() + static_cast<std::ptrdiff_t>(shift));
            command_V.resize(record.rows(), command_V.back());
          },
          fmt::format("command_V seems to be {} late: {} earlier", rows, rows),
          "in each row the command held from its time to the next row's"};
}

Reading pressure_later(std::size_t shift, const std::string& rows) {
  return {[=](Record& record) {
            std::vector<double>& measured_Pa = record.measured_Pa;
            measured_Pa.insert(measured_Pa.begin(), shift, measured_Pa.front());
            measured_Pa.resize(measured_Pa.size() - shift);
            record.settled_rows += shift;
          },
          fmt::format("pressure_Pa seems to be {} early: {} later", rows, rows),
          "in each row the pressure at its time"};
}

Reading volume_later(int halves, const std::string& rows) {
  return {[=](Record& record) {
            std::vector<double>& volume_m3 = record.drive.volume_m3;
            const auto steps = static_cast<std::size_t>(halves * record.drive.timing.steps / 2);
            volume_m3.insert(volume_m3.begin(), steps, volume_m3.front());
            volume_m3.resize(volume_m3.size() - steps);
          },
          fmt::format("volume_m3 seems to be {} early: {} later", rows, rows),
          "in each row the volume at its time"};
}

/// A pressure that lags or stands behind a hose is late after the volume, too.
bool a_lag_errs_no_more(const Scene& scene, double rms_Pa) {
  constexpr std::array kLate{effects::kIdSensorLag, effects::kIdTubeDynamics};
  return std::ranges::any_of(kLate, [&](std::size_t late) {
    return fit(scene, effects::EffectSet{1} << late, scene.nominal, {}).rms_Pa() < rms_Pa / kClearlyLess;
  });
}

}  // namespace

void require_acting_command(const Scene& scene, const Fit& recalibrated, unsigned threads) {
  require_acting_command(scene, recalibrated.rms_Pa(), fitted_anew(0, recalibrated.rms_Pa()), threads);
}

void require_acting_command(const Scene& scene, double as_logged_Pa, const ErrorOf& error_of,
                            unsigned threads) {
  if (is_near_noise(as_logged_Pa, scene)) return;
  const bool late_as_turned = std::ranges::all_of(scene.records, [](const Record& record) {
    return identify::turned_is_late(record.drive.command_V, record.drive.timing.tick_s);
  });
  std::vector<Reading> readings{
      turned(scene.nominal[effects::kOpenAbove] + scene.nominal[effects::kExhaustBelow], late_as_turned)};
  for (std::size_t shift = 1; shift <= kMostRowsOff; ++shift) {
    const std::string rows = shift == 1 ? "one row" : fmt::format("{} rows", shift);
    readings.push_back(command_earlier(shift, rows));
    readings.push_back(pressure_later(shift, rows));
  }
  const std::size_t first_of_volume = readings.size();
  if (std::ranges::any_of(scene.records, [](const Record& r) { return volume_swing(r) >= kRests; })) {
    readings.push_back(volume_later(1, "half a row"));
    readings.push_back(volume_later(2, "one row"));
    readings.push_back(volume_later(4, "2 rows"));
  }
  identify::in_parallel(readings.size(), threads,
                        [&](std::size_t i) { readings[i].rms_Pa = error_of(altered(scene, readings[i])); });
  const auto clearly_least = [&](std::size_t first, std::size_t last) {
    const Reading* best = nullptr;
    for (std::size_t i = first; i < last; ++i) {
      if (readings[i].rms_Pa < kClearlyLess * (best == nullptr ? as_logged_Pa : best->rms_Pa))
        best = &readings[i];
    }
    return best;
  };
  // one that is only late is not followed to the noise by its mirror image
  const std::size_t first = late_as_turned && !is_near_noise(readings.front().rms_Pa, scene) ? 1 : 0;
  const Reading* best = clearly_least(first, first_of_volume);
  const Reading* const volume = clearly_least(first_of_volume, readings.size());
  if (volume != nullptr && (best == nullptr || volume->rms_Pa < kClearlyLess * best->rms_Pa) &&
      !(far_better(volume->rms_Pa, as_logged_Pa) && a_lag_errs_no_more(scene, volume->rms_Pa))) {
    best = volume;
  }
  if (best == nullptr || !far_better(best->rms_Pa, as_logged_Pa)) return;
  throw trace::InputError(fmt::format(
      "{}: column {} the valve recalibrated errs by {:.3g} kPa, as logged by {:.3g} kPa; "
      "expected {}",
      scene.records.front().name, best->what, 1e-3 * best->rms_Pa, 1e-3 * as_logged_Pa, best->expected));
}

}  // namespace plenum::host::diagnose
