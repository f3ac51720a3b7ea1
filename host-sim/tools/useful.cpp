#include "host-sim/tools/useful.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/sign_of_command.hpp"

namespace plenum::host::tools {
namespace {

constexpr double kUseful = 0.9;    ///< of what holding errs by
constexpr double kDoubtful = 0.5;  ///< likewise
/// Of the model's error: less with the command turned, and that is its sign. Such models of a turned thin-plate chamber err by half.
constexpr double kTurned = 0.7;

/// Mirrored about the middle of what all of them command, so that a valve's null stays within what is commanded.
std::vector<trace::Log> with_turned_commands(std::vector<trace::Log> logs) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const trace::Log& log : logs) {
    const auto [least, most] = std::ranges::minmax(log.command_V);
    low = std::min(low, least);
    high = std::max(high, most);
  }
  for (trace::Log& log : logs) {
    for (double& command_V : log.command_V) command_V = low + high - command_V;
  }
  return logs;
}

}  // namespace

double pooled_rms_kPa(const std::vector<trace::Log>& logs,
                      const std::function<double(const trace::Log&)>& rms_kPa) {
  double squares = 0.0, rows = 0.0;
  for (const trace::Log& log : logs) {
    squares += static_cast<double>(log.size()) * std::pow(rms_kPa(log), 2);
    rows += static_cast<double>(log.size());
  }
  return std::sqrt(squares / rows);
}

void require_useful(const FitError& error,
                    const std::function<double(const std::vector<trace::Log>&)>& turned_kPa,
                    const std::vector<trace::Log>& logs) {
  const double ratio = error.model_kPa / error.held_kPa;
  if (ratio < kDoubtful) return;
  const std::string found =
      fmt::format("the model found errs {:.3g} times as much in free runs as holding the logs' {} does",
                  ratio, error.held);
  const bool late_as_turned = std::ranges::all_of(
      logs, [](const trace::Log& log) { return identify::turned_is_late(log.command_V, log.period_s); });
  double turned_ratio = std::numeric_limits<double>::infinity();
  try {
    if (!late_as_turned) turned_ratio = turned_kPa(with_turned_commands(logs)) / error.held_kPa;
  } catch (const identify::CannotIdentify&) {  // then the sign is not what is wrong
  }
  if (turned_ratio < kTurned * ratio) {
    throw identify::CannotIdentify(
        fmt::format("{}, and {:.3g} times with the command turned about the middle of its range: has the "
                    "command another sign, expected more volts for more pressure?",
                    found, turned_ratio));
  }
  if (!(ratio < kUseful) && late_as_turned) {
    throw identify::CannotIdentify(fmt::format(
        "{}, expected less: does the pressure follow late, or a command of another sign? The command is "
        "its own mirror image within a second, so that both look alike: log steps of random height besides",
        found));
  }
  if (!(ratio < kUseful)) {
    throw identify::CannotIdentify(
        fmt::format("{}, expected less: has the command another time or unit, or does something else move "
                    "the pressure?",
                    found));
  }
}

void require_converged(bool converged, const std::string& stop, const std::string& out) {
  if (converged) return;
  throw identify::CannotIdentify(
      fmt::format("the fit {}, expected a minimum; {} is written with what it came to: judge it by its "
                  "errors, or fit logs that "
                  "move the chamber more",
                  stop, out));
}

}  // namespace plenum::host::tools
