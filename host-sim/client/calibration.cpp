#include "host-sim/client/calibration.hpp"

#include <fmt/format.h>

#include <string>

#include "firmware/canopen/objects.hpp"
#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/settings.hpp"

namespace plenum::host::client {
namespace {

namespace object = canopen::object;

constexpr std::uint8_t kGain = 1;
constexpr std::uint8_t kOffset = 2;

std::uint16_t settings_of(std::uint8_t chamber) {
  return object::nth(object::kChamberSettings, chamber);
}

/// The board judges each against the other as it stands: where it refuses the first, the other may make room for it.
void write(Session& session, std::uint8_t chamber, const PressureCalibration& wanted) {
  const auto gain = [&] {
    session.write(settings_of(chamber), kGain, static_cast<float>(wanted.gain_kPa_per_V));
  };
  const auto offset = [&] {
    session.write(settings_of(chamber), kOffset, static_cast<float>(wanted.offset_kPa));
  };
  try {
    gain();
  } catch (const SdoAbort&) {
    offset();
    gain();
    return;
  }
  offset();
}

}  // namespace

/// p = (z - offset + gain_error ambient)/(1 + gain_error), z = now.offset + now.gain V.
PressureCalibration corrected(const PressureCalibration& now, const SensorError& error) {
  const double span = 1.0 + error.gain_error;
  return {.gain_kPa_per_V = now.gain_kPa_per_V / span,
          .offset_kPa = (now.offset_kPa - error.offset_kPa + error.gain_error * error.ambient_kPa) / span};
}

PressureCalibration read_calibration(Session& session, std::uint8_t chamber) {
  return {.gain_kPa_per_V = static_cast<double>(session.read<float>(settings_of(chamber), kGain)),
          .offset_kPa = static_cast<double>(session.read<float>(settings_of(chamber), kOffset))};
}

PressureCalibration write_calibration(Session& session, std::uint8_t chamber,
                                      const PressureCalibration& wanted) {
  const std::uint16_t status = session.status_word();
  if (is_regulating(status)) {
    throw Refused(
        fmt::format("node {}: chamber {}: the board regulates (status word {:04X}h), expected it at rest: "
                    "a pressure that jumps would move its valves",
                    session.node_id(), chamber + 1, status));
  }
  session.take_to_init();
  const PressureCalibration before = read_calibration(session, chamber);
  try {
    write(session, chamber, wanted);
  } catch (const SdoAbort&) {
    const std::string why = last_refusal(session, chamber + 1U);
    write(session, chamber, before);
    if (why.empty()) throw;
    throw Refused(fmt::format("node {}: chamber {}: {}", session.node_id(), chamber + 1, why));
  }
  return read_calibration(session, chamber);
}

}  // namespace plenum::host::client
