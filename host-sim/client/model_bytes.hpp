// A model as a person has it, in doubles, and as it crosses the bus.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace plenum::host::client {

/// The part of an image's header that is no parameter: how the model came to be.
struct ModelOrigin {
  double fit_error_kPa = 0.0;       ///< RMS of the next-tick prediction
  std::uint32_t fit_date_s = 0;     ///< since 1970; 0: not stated
  std::uint32_t valve_serial = 0;   ///< 0: not stated
  std::uint32_t sensor_serial = 0;  ///< 0: not stated
  double fixed_error_kPa = 0.0;     ///< bound of what fixed point makes of a tick's prediction; 0: not stated
};

struct DecodedModel {
  std::string kind;  ///< "tassa9", "tassa9r", "greybox"
  ModelOrigin origin;
  /// Image order. Each is the shortest decimal that rounds to the float of the image, so that encoding it
  /// again gives the same bytes.
  std::vector<double> parameters;
};

/// The image of a model, its parameters in image order, rounded to float. Not judged here: that is the board's part. Throws
/// std::invalid_argument for a kind that the images of this version do not know, or another number of parameters.
std::vector<std::uint8_t> encode_model(std::string_view kind, std::span<const double> parameters,
                                       const ModelOrigin& origin);

/// Throws ProtocolError saying what is wrong with the image.
DecodedModel decode_model(std::span<const std::uint8_t> image);

/// By how much the chamber's pressure sensor lags [s], as its model says; 0 where it says nothing of it.
double sensor_lag_s(const DecodedModel& model);

/// From a command to the valve's answer [s]: the dead time, and of a spool damping over pi times its natural frequency, the area
/// above its step response; 0 where the model says nothing of it.
double valve_delay_s(const DecodedModel& model);

}  // namespace plenum::host::client
