#include "firmware/canopen/kept_values.hpp"

#include <algorithm>
#include <array>

namespace plenum::canopen {
namespace {

using config::RecordRow;

// What the pieces of a restoration cost, in units of Work (callgrind, gcc 12 -O2, the dearest of each).
constexpr int kLook = 2;
constexpr int kWrite = 20;
constexpr int kResolve = 14;  ///< of each object that a mapping names

bool is_mapping(std::uint16_t index) noexcept {
  return (index >= object::kRpdoMapping && index < object::kRpdoMapping + kRpdos) ||
         (index >= object::kTpdoMapping && index < object::kTpdoMapping + kTpdos);
}

/// An identifier that changes only while its object is switched off, or once those that had it are.
bool is_identifier(std::uint16_t index, std::uint8_t sub) noexcept {
  const bool of_pdo = (index >= object::kRpdoCommunication && index < object::kRpdoCommunication + kRpdos) ||
                      (index >= object::kTpdoCommunication && index < object::kTpdoCommunication + kTpdos);
  return (of_pdo && sub == 1) || index == object::kEmergencyCobId || index == object::kSyncCobId;
}

/// That of the PDO whose row is at `index`; while the PDO is on, it stays.
void empty_mapping(Device& device, std::uint16_t index) noexcept {
  const auto empty = [](PdoParameters& parameters) {
    if (!is_valid(parameters)) parameters.mapping = {};
  };
  if (index < object::kTpdoMapping) {
    device.communication.rpdo[index - object::kRpdoMapping].change(empty);
  } else {
    empty(device.communication.tpdo[index - object::kTpdoMapping].parameters);
  }
}

bool write_row(Device& device, const Found& found, const RecordRow& row, std::uint8_t saved_id) noexcept {
  if (!found.entry->of_node || row.value.size() != 4) {
    return write_object(device, found, row.value) == Abort::none;
  }
  std::array<std::uint8_t, 4> bytes{};
  store_le(moved(load_le(row.value), saved_id, device.config.node_id), bytes);
  return write_object(device, found, bytes) == Abort::none;
}

}  // namespace

std::uint32_t moved(std::uint32_t cob_id, std::uint8_t saved_id, std::uint8_t now) noexcept {
  constexpr std::uint32_t kNodeIdMask = 0x7F;
  const bool follows = saved_id != 0 && (cob_id & kNodeIdMask) == saved_id;
  return follows ? (cob_id & ~kNodeIdMask) | now : cob_id;
}

void collect_kept(const Device& device, Kept group, config::RowWriter& rows) noexcept {
  for (const Entry& entry : object_dictionary()) {
    if (entry.kept != group) continue;
    for (std::uint8_t instance = 0; instance < entry.instances; ++instance) {
      for (unsigned sub = entry.sub; sub <= entry.last_sub; ++sub) {
        const Place place{instance, static_cast<std::uint8_t>(sub)};
        std::uint32_t bits = 0;
        if (entry.read_value(device, place, bits) != Abort::none) continue;
        std::array<std::uint8_t, 4> bytes{};
        store_le(bits, bytes);
        const auto index = static_cast<std::uint16_t>(entry.index + instance * entry.stride);
        rows.add({index, place.sub, std::span(bytes).first(size_of(entry.type))});
      }
    }
  }
}

void KeptRestoration::begin(Kept group, std::span<const std::uint8_t> body, std::uint8_t saved_id) noexcept {
  group_ = group;
  rows_ = config::RowReader(body);
  saved_id_ = saved_id;
  near_ = nullptr;
  mapping_counts_ = {};
  identifiers_ = {};
}

bool KeptRestoration::go_on(Device& device, Restored& restored, Work& work) noexcept {
  RecordRow row;
  while (work.is_left()) {
    if (rows_.next(row)) {
      work.take(kLook);
      if (group_of_row(row.index) == group_) take(device, restored, row, work);
    } else if (const RecordRow* count = mapping_counts_.next()) {
      const int cost =
          kWrite + kResolve * static_cast<int>(std::min<std::size_t>(load_le(count->value), kMappable));
      if (!work.has_room_for(cost)) {
        work.end();
        return false;
      }
      work.take(cost);
      write(device, restored, *count);
      ++mapping_counts_.done;
    } else if (const RecordRow* identifier = identifiers_.next()) {
      work.take(kWrite);
      write(device, restored, *identifier);
      ++identifiers_.done;
    } else {
      return true;
    }
  }
  return false;
}

Found KeptRestoration::look_up(const RecordRow& row) noexcept {
  Found found = find(row.index, row.sub, near_);
  near_ = found.entry;
  if (found.entry != nullptr && found.entry->kept != group_) found.entry = nullptr;
  return found;
}

void KeptRestoration::take(Device& device, Restored& restored, const RecordRow& row, Work& work) noexcept {
  const bool maps = is_mapping(row.index);
  const bool waits = is_identifier(row.index, row.sub) || (maps && row.sub == 0);
  work.take(maps && !waits ? kWrite + kResolve : kWrite);
  if (!waits) return write(device, restored, row);
  if (!set_aside(device, row)) restored.skip(row.index, row.sub);
}

void KeptRestoration::write(Device& device, Restored& restored, const RecordRow& row) noexcept {
  const Found found = look_up(row);
  if (found.entry != nullptr && write_row(device, found, row, saved_id_)) return;
  restored.skip(row.index, row.sub);
  if (is_setting(row.index)) device.settings.refuse_restored(owner_of_setting(row.index));
}

/// Makes room: a PDO is switched off, and its mapping emptied. An object that turns out not to be mappable any more then leaves
/// its PDO empty, and never half old and half new.
bool KeptRestoration::set_aside(Device& device, const RecordRow& row) noexcept {
  const Found found = look_up(row);
  if (found.entry == nullptr) return false;
  if (is_mapping(row.index)) {
    empty_mapping(device, row.index);
    return mapping_counts_.add(row);
  }
  std::uint32_t bits = 0;
  // neither is refused: identifiers can be read, and stay what they are but for a bit that they all may have
  static_cast<void>(found.entry->read_value(device, found.place, bits));
  static_cast<void>(found.entry->write_value(device, found.place, bits | cob::kInvalid));
  return identifiers_.add(row);
}

}  // namespace plenum::canopen
