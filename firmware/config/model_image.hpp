// The bytes of one chamber's model, as they cross the bus and lie in the parameter store.
//
// Little endian, no padding:
//   0  u32  magic "PLM1"            16  f32  fit error, RMS of the next-tick prediction [kPa]
//   4  u32  schema hash of the kind 20  u32  valve serial number (0: not stated)
//   8  u16  model kind              24  u32  sensor serial number (0: not stated)
//  10  u16  parameter count n       28  f32  parameters[n]
//  12  u32  fit date [s since 1970] 28+4n u32 CRC-32 (IEEE 802.3) of all bytes before it
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace plenum::config {

enum class ModelKind : std::uint16_t { none = 0, tassa9 = 1 };

inline constexpr std::size_t kMaxParameters = 32;
inline constexpr std::size_t kMaxImageBytes = 28 + 4 * kMaxParameters + 4;

/// One chamber's model as numbers. Parameters are in the order and units of `parameter_schema(kind)`.
struct ModelParameters {
  ModelKind kind = ModelKind::none;
  std::uint32_t fit_date_s = 0;
  float fit_error_kPa = 0.0F;
  std::uint32_t valve_serial = 0;
  std::uint32_t sensor_serial = 0;
  std::uint16_t count = 0;
  std::array<float, kMaxParameters> value{};
};

/// One parameter of a kind: its name with unit, and its open or closed range.
struct ParameterSpec {
  const char* name;   ///< as in the model file, with unit
  float low;          ///< smallest admissible value
  float high;         ///< largest admissible value
};

/// The parameters of a kind in image order; empty for a kind this firmware does not know.
std::span<const ParameterSpec> parameter_schema(ModelKind kind) noexcept;

/// FNV-1a of the kind, the parameter names and the ranges: two programs agree on it or refuse each other.
std::uint32_t schema_hash(ModelKind kind) noexcept;

enum class ImageError : std::uint8_t {
  none, too_short, bad_magic, unknown_kind, schema_mismatch, wrong_count, wrong_size, bad_crc, not_finite, out_of_range,
  not_admissible  ///< each value is in range, but together they are refused (see validate())
};

/// Why an image was refused: the error, and which parameter (index into the schema) with its range.
struct ImageVerdict {
  ImageError error = ImageError::none;
  std::uint8_t parameter = 0;
  float value = 0.0F;
  float low = 0.0F;
  float high = 0.0F;
  explicit operator bool() const noexcept { return error == ImageError::none; }
};

const char* describe(ImageError error) noexcept;

/// Checks kind, count, finiteness, ranges and the joint conditions of the kind.
ImageVerdict validate(const ModelParameters& parameters) noexcept;

/// Writes the image. Returns its size; 0 when `bytes` is too small or the kind is unknown.
std::size_t encode(const ModelParameters& parameters, std::span<std::uint8_t> bytes) noexcept;

/// Reads and validates an image; `parameters` is written only when the verdict is good.
ImageVerdict decode(std::span<const std::uint8_t> bytes, ModelParameters& parameters) noexcept;

}  // namespace plenum::config
