// The bytes of one chamber's model, as they cross the bus and lie in the parameter store.
//
// Little endian, no padding:
//   0  u32  magic "PLM2"            20  u32  valve serial number (0: not stated)
//   4  u32  schema hash of the kind 24  u32  sensor serial number (0: not stated)
//   8  u16  model kind              28  f32  bound of what fixed point makes of a tick's prediction [kPa]
//  10  u16  parameter count n                (0: not stated)
//  12  u32  fit date [s since 1970] 32  f32  parameters[n]
//  16  f32  fit error, RMS of the   32+4n u32 CRC-32 (IEEE 802.3) of all bytes before it
//           next-tick prediction [kPa]
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/numeric/scalar.hpp"

namespace plenum::config {

enum class ModelKind : std::uint16_t { none = 0, tassa9 = 1, greybox = 2, tassa9r = 3 };

inline constexpr std::size_t kMaxParameters = 32;
inline constexpr std::size_t kImageHeaderBytes = 32;  ///< before the parameters
inline constexpr std::size_t kMaxImageBytes = kImageHeaderBytes + 4 * kMaxParameters + 4;

/// One chamber's model as numbers. Parameters are in the order and units of `parameter_schema(kind)`.
struct ModelParameters {
  ModelKind kind = ModelKind::none;
  std::uint32_t fit_date_s = 0;
  float fit_error_kPa = 0.0F;
  std::uint32_t valve_serial = 0;
  std::uint32_t sensor_serial = 0;
  float fixed_error_kPa = 0.0F;  ///< at most, of the end and the mean of a tick; computed by who uploads
  std::uint16_t count = 0;
  std::array<float, kMaxParameters> value{};
};

/// The values as the core computes with them.
std::array<numeric::Scalar, kMaxParameters> scalars(const ModelParameters& parameters) noexcept;

/// One parameter of a kind: its name with unit, and its closed range. An open bound of the paper is written
/// as the nearest value inside it that the model can still compute with.
struct ParameterSpec {
  const char* name;  ///< as in the model file, with unit
  float low;         ///< smallest admissible value
  float high;        ///< largest admissible value
};

/// The parameters of a kind in image order; empty for a kind this firmware does not know.
std::span<const ParameterSpec> parameter_schema(ModelKind kind) noexcept;

/// How many of them, from the first, an image must have. One that leaves out the others says nothing of them.
std::size_t required_count(ModelKind kind) noexcept;

/// FNV-1a of the kind, and of names and ranges of the parameters that it must have: two programs agree on it or refuse each other.
std::uint32_t schema_hash(ModelKind kind) noexcept;

enum class ImageError : std::uint8_t {
  none,
  too_short,
  bad_magic,
  unknown_kind,
  schema_mismatch,
  wrong_count,
  wrong_size,
  bad_crc,
  not_finite,
  out_of_range,
  not_admissible,   ///< each value is in range, but together they are refused (see validate())
  commit_pending,   ///< the slot takes no image until the next tick's edge (see ParameterSlots)
  no_such_chamber,  ///< the board has no chamber of that number
  predicts_worse,   ///< than the model in force, over the log that the board has of the chamber
  wrong_serial,     ///< the image is of another valve or sensor than the settings name
  staged_by_another,  ///< another master's upload session stands (see UploadSession), or its set is being staged
  inverse_fails,      ///< the model's inverse misses what it was asked for (control/inverse_check.hpp)
  no_authority  ///< by the model no command in the chamber's range raises the pressure, or none lowers it (likewise)
};

/// ImageVerdict::parameter when an error of the header is to blame, which is no parameter of the schema.
inline constexpr std::uint8_t kFitErrorField = 0xFF;
inline constexpr std::uint8_t kFixedErrorField = 0xFC;

/// ImageVerdict::parameter of `wrong_serial`: which of the header's serial numbers.
inline constexpr std::uint8_t kValveSerialField = 0xFE;
inline constexpr std::uint8_t kSensorSerialField = 0xFD;

/// Why an image was refused: the error, and which parameter (index into the schema) with its range.
struct ImageVerdict {
  ImageError error = ImageError::none;
  std::uint8_t parameter = 0;
  float value = 0.0F;
  float low = 0.0F;
  float high = 0.0F;
  explicit operator bool() const noexcept { return error == ImageError::none; }
};

/// One clause for a person: "is out of range". Never null.
const char* describe(ImageError error) noexcept;

/// Smallest excess of c9 over its bound [V]: k (9) of commands within 10 V of the null, computed in float, is
/// off by less than this (six roundings of numbers below 20 V, 2^-20 V at most each).
inline constexpr float kRateMargin_V = 1e-5F;

/// So far the ports of a grey-box model must open.
inline constexpr float kLeastOpening_V = 1.0F;

/// Full range of a valve command [V].
inline constexpr float kCommandSpan_V = 10.0F;

/// Checks kind, count, finiteness, ranges and the joint conditions of the kind.
///
/// Joint conditions of tassa9 and tassa9r (equations of "Modeling and Identification of Pneumatic Actuators"), each
/// answered with `not_admissible`, the parameter to blame and the range that the other parameters leave it:
///  - supply_kPa > ambient_kPa: c_s of (10c) must be positive;
///  - c9 > c_gamma (1 - sqrt(1 - c8^2)): the least value of k (9) over all commands is
///    c_gamma sqrt(1 - c8^2) - c_gamma + c9, and (6) requires a positive rate. kRateMargin_V keeps it so in
///    float;
///  - c3 >= -c2 / (3 x^2) with x = max(c1, 10 V - c1): the argument c2 x + c3 x^3 of (10b), x = u - c1, rises
///    over the whole command range 0..10 V. Table I asks for c3 > -1 "to maintain the monotonicity of s(u)",
///    which does not suffice for (10b) as printed: c2 = 1, c3 = -0.1 falls beyond |x| = 1.83 V. Both bounds
///    are checked.
///
/// Joint conditions of greybox (control/greybox.hpp), answered likewise:
///  - supply_kPa > ambient_kPa;
///  - cracking_ratio above critical_ratio by at least 0.05;
///  - each port (valve_curve.hpp) opens the farther the farther its command goes beyond its opening voltage, for
///    kLeastOpening_V at least: checked at each 0.1 V, the answer blames the port's slope, and `low` is the least that its
///    curve and bend leave it. Farther on a curve that falls counts as saturated.
ImageVerdict validate(const ModelParameters& parameters) noexcept;

/// Of validated parameters, for a chamber of `volume_mL` by its sensor: a grey-box model's dead volume leaves it a volume above
/// zero. Answered as a joint condition.
ImageVerdict validate_volume(const ModelParameters& parameters, float volume_mL) noexcept;

/// Pressures of the supply and of the ambient [kPa].
struct SupplyPressures {
  float supply_kPa;
  float ambient_kPa;
};

/// Of validated parameters of any kind but none.
SupplyPressures supply_of(const ModelParameters& parameters) noexcept;

/// Of validated parameters: from a command to the valve's motion [s]; none where the model says nothing of it.
std::optional<float> dead_time_s(const ModelParameters& parameters) noexcept;

/// Writes the image. Returns its size; 0 when `bytes` is too small, the kind is unknown or the count is none of
/// the kind's. Values are not judged: that is the reader's part.
std::size_t encode(const ModelParameters& parameters, std::span<std::uint8_t> bytes) noexcept;

/// The image that `bytes` begin with, by the length that its parameter count asks for; empty when they hold no whole image.
/// What is in it is not judged.
std::span<const std::uint8_t> first_image(std::span<const std::uint8_t> bytes) noexcept;

/// Reads and validates an image; `parameters` is written only when the verdict is good. Errors are looked for
/// in the order of ImageError; size errors answer with the size found in `value` and the size expected in
/// `low` and `high`.
ImageVerdict decode(std::span<const std::uint8_t> bytes, ModelParameters& parameters) noexcept;

}  // namespace plenum::config
