// The calibration of a board's pressure sensors (2400h + c, 1 and 2): absolute pressure = offset + gain x voltage.
#pragma once

#include <cstdint>

#include "host-sim/client/session.hpp"

namespace plenum::host::client {

struct PressureCalibration {
  double gain_kPa_per_V = 0.0;
  double offset_kPa = 0.0;  ///< absolute pressure at 0 V
};

/// By how much a sensor's reading z is off the pressure p: z = p + offset + gain_error (p - ambient), as `sensor_bias` of the
/// catalogue has it.
struct SensorError {
  double offset_kPa = 0.0;
  double gain_error = 0.0;   ///< above -1
  double ambient_kPa = 0.0;  ///< absolute
};

/// The calibration under which a sensor reads true that under `now` reads with this error.
PressureCalibration corrected(const PressureCalibration& now, const SensorError& error);

/// `chamber` from 0, here and below.
PressureCalibration read_calibration(Session& session, std::uint8_t chamber);

/// In force at the next tick's edge, kept only once the board stores its settings. Takes a board that is DISABLED to INIT,
/// where it takes settings. What is returned is what the board took: single precision. Throws Refused, and changes nothing, while
/// the board regulates or excites, and for numbers that contradict its other settings; SdoAbort.
PressureCalibration write_calibration(Session& session, std::uint8_t chamber,
                                      const PressureCalibration& wanted);

}  // namespace plenum::host::client
