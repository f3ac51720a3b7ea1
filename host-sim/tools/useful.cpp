#include "host-sim/tools/useful.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::tools {
namespace {

constexpr double kUseful = 0.9;  ///< of what holding errs by

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

void require_useful(double rms_kPa, double held_rms_kPa, std::string_view held) {
  if (rms_kPa < kUseful * held_rms_kPa) return;
  throw identify::CannotIdentify(
      fmt::format("the model found errs {:.3g} times as much in free runs as holding the logs' {} does, "
                  "expected less: has "
                  "the command another sign, time or unit, or does something else move the pressure?",
                  rms_kPa / held_rms_kPa, held));
}

}  // namespace plenum::host::tools
