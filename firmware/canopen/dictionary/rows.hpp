// How a row of the object dictionary is written, and the accessors that rows of all areas share.
//
// Only object_dictionary.cpp includes this folder. Each area is one file: its rows, and what reads and writes them.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <iterator>
#include <span>
#include <type_traits>

#include "firmware/canopen/object_dictionary.hpp"
#include "firmware/numeric/nearest.hpp"

namespace plenum::canopen::dictionary {

inline constexpr std::int32_t kPascal_per_mbar = 100;
inline constexpr std::int32_t kInvalid_mbar =
    -32768;  ///< what a NaN pressure reads as: no pressure can be that low

inline bool is_finite(std::uint32_t real32_bits) {
  return (real32_bits & 0x7F80'0000U) != 0x7F80'0000U;
}

inline std::uint32_t bits_of(float value) {
  return std::bit_cast<std::uint32_t>(value);
}

inline std::uint32_t bits_of(std::int32_t value) {
  return static_cast<std::uint32_t>(value);
}

template <numeric::Number Real>
std::uint32_t mbar_bits(Real pressure_mbar) {
  return bits_of(numeric::nearest_within(pressure_mbar, -32767, 32767, kInvalid_mbar));
}

/// The value of a small integer type, sign extended.
inline std::int32_t integer_value(DataType type, std::uint32_t bits) {
  switch (type) {
    case DataType::integer8:
      return static_cast<std::int8_t>(bits);
    case DataType::integer16:
      return static_cast<std::int16_t>(bits);
    case DataType::unsigned8:
      return static_cast<std::uint8_t>(bits);
    case DataType::unsigned16:
      return static_cast<std::uint16_t>(bits);
    default:
      return static_cast<std::int32_t>(bits);
  }
}

/// A VISIBLE_STRING, at most kMaxDomainBytes of it.
inline std::span<const std::uint8_t> text_bytes(const char* text) noexcept {
  std::size_t length = 0;
  while (length < kMaxDomainBytes && text[length] != '\0') ++length;
  return {reinterpret_cast<const std::uint8_t*>(text), length};
}

// ---- accessors: constants and plain members ----

template <std::uint32_t value>
Abort fixed(const Device&, Place, std::uint32_t& bits) noexcept {
  bits = value;
  return Abort::none;
}

template <auto member>
Abort read_image(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = static_cast<std::uint32_t>(device.image.*member);
  return Abort::none;
}

template <auto member>
Abort read_communication(const Device& device, Place, std::uint32_t& bits) noexcept {
  bits = static_cast<std::uint32_t>(device.communication.*member);
  return Abort::none;
}

template <auto member>
Abort write_communication(Device& device, Place, std::uint32_t bits) noexcept {
  using Member = std::remove_reference_t<decltype(device.communication.*member)>;
  device.communication.*member = static_cast<Member>(bits);
  return Abort::none;
}

template <const char* Identity::*member>
std::span<const std::uint8_t> read_string(const Device& device, Place) noexcept {
  return text_bytes(device.config.identity.*member);
}

struct Many {
  std::uint8_t instances;
  std::uint16_t stride;
};
inline constexpr Many kOnce{1, 1};
inline constexpr Many kChambersNext{config::kChambers, 1};
inline constexpr Many kChambersApart{config::kChambers, object::kChamberStride};
inline constexpr Many kEachRpdo{kRpdos, 1};
inline constexpr Many kEachTpdo{kTpdos, 1};

struct Subs {
  std::uint8_t first;
  std::uint8_t last;
  constexpr Subs(int only) : first(static_cast<std::uint8_t>(only)), last(first) {}
  constexpr Subs(int first_sub, int last_sub)
      : first(static_cast<std::uint8_t>(first_sub)), last(static_cast<std::uint8_t>(last_sub)) {}
};

inline constexpr Range kAny{};
inline constexpr Range kSetpointRange{kSetpointLow_Pa, kSetpointHigh_Pa, true};
inline constexpr Range kSetpointRange_mbar{0.0F, 32767.0F, true};
inline constexpr Range kPressureRange{0.0F, kSetpointHigh_Pa, true};
inline constexpr Range kCommandRange_V{0.0F, 10.0F, true};

constexpr Entry value(std::uint16_t index, Subs subs, Many many, const char* name, DataType type,
                      Access access, Mappable mappable, Range range, ReadValue read,
                      WriteValue write = nullptr) {
  return {index,  subs.first, subs.last, many.instances, many.stride, name,    type,
          access, mappable,   range,     read,           write,       nullptr, nullptr};
}

constexpr Entry bytes(std::uint16_t index, Many many, const char* name, DataType type, Access access,
                      ReadBytes read, WriteBytes write = nullptr) {
  return {index,        0,    0,       many.instances, many.stride, name, type, access,
          Mappable::no, kAny, nullptr, nullptr,        read,        write};
}

/// A DOMAIN that is written, at most `most_bytes` long.
constexpr Entry domain_taken(std::uint16_t index, Many many, const char* name, std::size_t most_bytes,
                             WriteBytes write) {
  Entry entry = bytes(index, many, name, DataType::domain, Access::write_only, nullptr, write);
  entry.most_bytes = static_cast<std::uint16_t>(most_bytes);
  return entry;
}

/// A row whose writes may have to wait.
constexpr Entry waiting_for(Outcome outcome, Entry row) {
  row.outcome = outcome;
  return row;
}

/// The same row at another sub-index.
constexpr Entry at_sub(std::uint8_t sub, Entry row) {
  row.sub = row.last_sub = sub;
  return row;
}

/// The name of the record or array whose sub-index 0 the row is.
constexpr Entry named(const char* name, Entry sub_index_0) {
  sub_index_0.object_name = name;
  return sub_index_0;
}

/// A long value, read only. `readable` may be null: it can always be read.
constexpr Entry stream(std::uint16_t index, const char* name, DataType type, ReadStream read, StreamSize size,
                       ReadValue readable = nullptr) {
  Entry entry = bytes(index, kOnce, name, type, Access::read_only, nullptr);
  entry.read_value = readable;
  entry.read_stream = read;
  entry.stream_size = size;
  return entry;
}

template <std::uint32_t count>
constexpr Entry highest(std::uint16_t index, Many many, const char* name) {
  return named(name, value(index, 0, many, "Highest sub-index supported", DataType::unsigned8,
                           Access::constant, Mappable::no, kAny, fixed<count>));
}

/// An identifier that is a base plus the node id.
constexpr Entry of_node(Entry row) {
  row.of_node = true;
  return row;
}

/// A write that changes nothing, of a value whose range allows but one.
inline Abort accept(Device&, Place, std::uint32_t) noexcept {
  return Abort::none;
}

/// Rows and arrays of rows, one after the other.
template <typename... Areas>
constexpr auto joined(const Areas&... areas) {
  std::array<Entry, (sizeof(Areas) + ...) / sizeof(Entry)> rows{};
  Entry* end = rows.data();
  const auto append = [&end](const auto& area) {
    if constexpr (std::is_same_v<decltype(area), const Entry&>) {
      *end++ = area;
    } else {
      end = std::copy(std::begin(area), std::end(area), end);
    }
  };
  (append(areas), ...);
  return rows;
}

/// 1010h stores this row and 1011h restores it.
constexpr Entry kept(Entry row) {
  row.kept = row.index < 0x2000 ? Kept::communication : Kept::application;
  return row;
}

using enum DataType;
using enum Access;
using enum Mappable;

}  // namespace plenum::canopen::dictionary
