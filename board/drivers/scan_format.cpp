#include "board/drivers/scan_format.hpp"

#include <algorithm>
#include <charconv>
#include <numeric>
#include <system_error>

namespace plenum::board::drivers {
namespace {

std::size_t rounded_up(std::size_t bytes, std::size_t multiple) noexcept {
  return (bytes + multiple - 1) / multiple * multiple;
}

}  // namespace

bool SampleFormat::is_one_number() const noexcept {
  const bool held = storage_bits == 8 || storage_bits == 16 || storage_bits == 32;
  return held && repeat == 1 && bits >= 1 && bits <= storage_bits && shift <= storage_bits - bits;
}

std::optional<SampleFormat> sample_format(std::string_view type) noexcept {
  const auto skip = [&](std::string_view word) {
    const bool there = type.starts_with(word);
    if (there) type.remove_prefix(word.size());
    return there;
  };
  const auto number = [&](unsigned& value) {
    const auto [at, error] = std::from_chars(type.data(), type.data() + type.size(), value);
    type.remove_prefix(static_cast<std::size_t>(at - type.data()));
    return error == std::errc{};
  };
  SampleFormat format;
  format.big_endian = skip("be:");
  bool good = format.big_endian || skip("le:");
  format.is_signed = skip("s");
  good = good && (format.is_signed || skip("u")) && number(format.bits);
  good = good && skip("/") && number(format.storage_bits);
  if (good && skip("X")) good = number(format.repeat);
  if (good && skip(">>")) good = number(format.shift);
  if (!good || !type.empty()) return std::nullopt;
  return format;
}

std::int64_t raw_number(const SampleFormat& format, const std::byte* stored) noexcept {
  const std::size_t last = format.bytes() - 1;
  std::uint32_t word = 0;
  for (std::size_t i = 0; i <= last; ++i)
    word = word << 8U | std::to_integer<std::uint32_t>(stored[format.big_endian ? i : last - i]);
  const std::uint32_t highest = std::uint32_t{1} << (format.bits - 1);
  const std::uint32_t number = word >> format.shift & (highest | (highest - 1));
  const bool negative = format.is_signed && (number & highest) != 0;
  return std::int64_t{number} - (negative ? 2 * std::int64_t{highest} : 0);
}

std::int64_t highest_number(const SampleFormat& format) noexcept {
  return (std::int64_t{1} << (format.is_signed ? format.bits - 1 : format.bits)) - 1;
}

ScanLayout scan_layout(std::span<const ScanElement> elements) {
  std::vector<std::size_t> order(elements.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return elements[a].index < elements[b].index; });
  ScanLayout layout{.offsets = std::vector<std::size_t>(elements.size()), .size = 0};
  std::size_t largest = 1;
  for (const std::size_t which : order) {
    const std::size_t bytes = elements[which].bytes;
    layout.offsets[which] = rounded_up(layout.size, bytes);
    layout.size = layout.offsets[which] + bytes;
    largest = std::max(largest, bytes);
  }
  layout.size = rounded_up(layout.size, largest);
  return layout;
}

}  // namespace plenum::board::drivers
