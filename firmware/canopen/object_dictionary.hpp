// The object dictionary: one constexpr table, sorted, of the areas in dictionary/, and the ways to read it.
//
// A row names an object once; `instances` and `stride` repeat it for chambers and PDOs, `last_sub` for
// arrays. SDO access, PDO mapping and the electronic data sheet all read this table, so that none can
// disagree with another.
#pragma once

#include <cstdint>
#include <span>

#include "firmware/canopen/cia301.hpp"
#include "firmware/canopen/communication.hpp"

namespace plenum::canopen {

enum class Access : std::uint8_t { constant, read_only, read_write, write_only };

/// Which PDOs may carry an object.
enum class Mappable : std::uint8_t { no, transmit, receive_and_transmit };

/// What 1010h stores and 1011h restores: communication 1000h..1FFFh, application 2000h..9FFFh (CiA 301, 7.5.2.13).
enum class Kept : std::uint8_t { no, communication, application };

/// Which one of a row's objects is meant.
struct Place {
  std::uint8_t instance = 0;  ///< chamber or PDO, from 0
  std::uint8_t sub = 0;
};

/// Inclusive limits of the value. Only types that float holds exactly are limited here (up to 16 bits, and
/// REAL32); 32-bit integers check themselves when written.
struct Range {
  float low = 0.0F;
  float high = 0.0F;
  bool limited = false;
};

using ReadValue = Abort (*)(const Device&, Place, std::uint32_t& bits) noexcept;
using WriteValue = Abort (*)(Device&, Place, std::uint32_t bits) noexcept;
using ReadBytes = std::span<const std::uint8_t> (*)(const Device&, Place) noexcept;
/// Of a write that was answered with Abort::pending: how it has ended, or pending while it has not.
using Outcome = Abort (*)(const Device&, Place) noexcept;
using WriteBytes = Abort (*)(Device&, Place, std::span<const std::uint8_t>) noexcept;
/// Bytes of a long value from `offset` on, as many as fit `bytes`; returns their count, 0 at the end. Read forward,
/// but for a block that is repeated: that one begins again at its first byte.
using ReadStream = std::size_t (*)(Device&, Place, std::uint32_t offset,
                                   std::span<std::uint8_t> bytes) noexcept;
/// Its size in bytes; 0 when it is not known before it has been read.
using StreamSize = std::uint32_t (*)(const Device&, Place) noexcept;

struct Entry {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::uint8_t last_sub = 0;  ///< >= sub; rows of one sub-index have them equal
  std::uint8_t instances = 1;
  std::uint16_t stride = 1;  ///< from one instance's index to the next
  const char* name = "";
  DataType type = DataType::unsigned8;
  Access access = Access::read_only;
  Mappable mappable = Mappable::no;
  Range range;
  ReadValue read_value = nullptr;
  WriteValue write_value = nullptr;
  ReadBytes read_bytes = nullptr;
  WriteBytes write_bytes = nullptr;
  /// For values that no buffer holds, in place of read_bytes. `read_value`, where there is one, is asked before the
  /// first byte whether the value can be read now.
  ReadStream read_stream = nullptr;
  StreamSize stream_size = nullptr;
  Outcome outcome = nullptr;  ///< of what may be answered with Abort::pending
  Kept kept = Kept::no;
  std::uint16_t most_bytes = 0;       ///< of a DOMAIN that is written
  bool of_node = false;               ///< an identifier: its base plus the node id
  const char* object_name = nullptr;  ///< of sub-index 0: the name of the whole record or array
};

/// All rows.
std::span<const Entry> object_dictionary() noexcept;
/// A digest of the table: two firmwares whose objects differ have different ones, so that no tool takes a data sheet that it has kept
/// for that of this board. Never 0.
std::uint32_t dictionary_revision() noexcept;
/// The rows of the object that begins with row `first` of all rows.
std::span<const Entry> rows_of_object(std::size_t first) noexcept;

/// The lists of a data sheet (CiA 306).
enum class ObjectGroup : std::uint8_t { mandatory, optional, manufacturer };

struct ObjectList {
  std::span<const std::uint16_t> first_row;  ///< of each object and its instances, in object_dictionary()
  std::uint16_t objects = 0;                 ///< every instance counted
};
ObjectList objects_of(ObjectGroup group) noexcept;

struct Found {
  Abort abort = Abort::none;  ///< no_object or no_subindex when `entry` is null
  const Entry* entry = nullptr;
  Place place{};
};

/// Halves the table: bounded by the logarithm of its length and the rows of one object.
Found find(std::uint16_t index, std::uint8_t sub) noexcept;
/// The same, and at once when it is of the row `near` or of the one after it. `near`: a row of the table, or null.
Found find(std::uint16_t index, std::uint8_t sub, const Entry* near) noexcept;

/// An identifier of node 0 that is not empty is the node id's, plus a base; 1005h is everyone's.
constexpr bool adds_node_id(const Entry& entry, std::uint32_t bits) noexcept {
  return entry.of_node && (bits & cob::kIdMask) != 0;
}

/// Value in range for its type, and finite if REAL32: none, or value_range, value_too_high, value_too_low.
Abort judge_value(const Entry& entry, std::uint32_t bits) noexcept;

/// Checks access, length and range, then writes. Nothing is changed unless the result is Abort::none.
Abort write_object(Device& device, const Found& found, std::span<const std::uint8_t> bytes) noexcept;

/// Checks what a PDO mapping needs to know, and looks its objects up. `receive`: RPDO. Writes `mapping`
/// (count, bytes, objects) only when the result is Abort::none.
Abort activate_mapping(Mapping& mapping, std::uint8_t count, bool receive) noexcept;

/// True when the mapping carries a set point (6380h or 2150h:1): such a PDO feeds the set-point watchdog.
bool carries_setpoint(const Mapping& mapping) noexcept;

}  // namespace plenum::canopen
