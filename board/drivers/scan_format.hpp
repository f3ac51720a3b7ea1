// A scan as the kernel stores it: one sample of every element that is switched on. Pure functions of what stands in
// `scan_elements/` (Documentation/ABI/testing/sysfs-bus-iio).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace plenum::board::drivers {

/// How a sample is stored.
struct SampleFormat {
  bool big_endian = false;
  bool is_signed = false;     ///< two's complement
  unsigned bits = 0;          ///< of the number
  unsigned storage_bits = 0;  ///< of what holds it
  unsigned repeat = 1;        ///< numbers a sample
  unsigned shift = 0;         ///< bits below the number; those below and above it are nobody's

  std::size_t bytes() const noexcept { return storage_bits / 8 * std::size_t{repeat}; }
  /// raw_number() reads it: one number of 1 to 32 bits, all of them within 8, 16 or 32.
  bool is_one_number() const noexcept;
  friend bool operator==(const SampleFormat&, const SampleFormat&) = default;
};

/// From the attribute `type` of an element: "be:s24/32>>8", "le:u16/16X2>>0". Empty: it has another form.
std::optional<SampleFormat> sample_format(std::string_view type) noexcept;

/// The number that a sample holds, for a format that is_one_number(), from its format.bytes().
std::int64_t raw_number(const SampleFormat& format, const std::byte* stored) noexcept;

/// The most that raw_number() can be.
std::int64_t highest_number(const SampleFormat& format) noexcept;

struct ScanElement {
  unsigned index = 0;     ///< its place in the order of the scan
  std::size_t bytes = 1;  ///< a power of two
};

/// [bytes]
struct ScanLayout {
  std::vector<std::size_t> offsets;  ///< of the elements, in the order in which they were given
  std::size_t size = 0;
};

/// As iio_compute_scan_bytes() of drivers/iio/industrialio-buffer.c places them: by index, each at a multiple of its own size; a
/// scan is a multiple of its largest element's.
ScanLayout scan_layout(std::span<const ScanElement> elements);

}  // namespace plenum::board::drivers
