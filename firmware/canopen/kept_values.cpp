#include "firmware/canopen/kept_values.hpp"

#include <array>

namespace plenum::canopen {
namespace {

using config::RecordRow;

/// When a row is written, of all rows of its group.
enum class Pass : std::uint8_t { switch_off, mapped_objects, mapping_count, plain, identifier };
constexpr Pass kPasses[] = {Pass::switch_off, Pass::mapped_objects, Pass::mapping_count, Pass::plain,
                            Pass::identifier};

bool is_mapping(std::uint16_t index) noexcept {
  return (index >= object::kRpdoMapping && index < object::kRpdoMapping + kRpdos) ||
         (index >= object::kTpdoMapping && index < object::kTpdoMapping + kTpdos);
}

/// An identifier that changes only while its object is switched off.
bool is_identifier(std::uint16_t index, std::uint8_t sub) noexcept {
  const bool of_pdo = (index >= object::kRpdoCommunication && index < object::kRpdoCommunication + kRpdos) ||
                      (index >= object::kTpdoCommunication && index < object::kTpdoCommunication + kTpdos);
  return (of_pdo && sub == 1) || index == object::kEmergencyCobId;
}

Pass pass_of(std::uint16_t index, std::uint8_t sub) noexcept {
  if (is_mapping(index)) return sub == 0 ? Pass::mapping_count : Pass::mapped_objects;
  return is_identifier(index, sub) ? Pass::identifier : Pass::plain;
}

/// What is refused here is refused again when the row itself is written, and counted there.
void write_quietly(Device& device, std::uint16_t index, std::uint8_t sub, std::uint32_t bits) noexcept {
  const Found found = find(index, sub);
  if (found.entry == nullptr) return;
  std::array<std::uint8_t, 4> bytes{};
  store_le(bits, bytes);
  static_cast<void>(write_object(device, found, std::span(bytes).first(size_of(found.entry->type))));
}

/// Makes room: a PDO is switched off before its mapping is emptied, so identifiers come first in the stored order. An
/// object that turns out not to be mappable any more then leaves its PDO empty, and never half old and half new.
void switch_off(Device& device, const Found& found, const RecordRow& row) noexcept {
  if (is_identifier(row.index, row.sub)) {
    std::uint32_t bits = 0;
    if (found.entry->read_value(device, found.place, bits) != Abort::none) return;
    write_quietly(device, row.index, row.sub, bits | cob::kInvalid);
  } else if (is_mapping(row.index) && row.sub == 0) {
    write_quietly(device, row.index, 0, 0);
    for (std::uint8_t sub = 1; sub <= kMappable; ++sub) write_quietly(device, row.index, sub, 0);
  }
}

std::uint32_t moved(std::uint32_t cob_id, std::uint8_t saved_id, std::uint8_t now) noexcept {
  constexpr std::uint32_t kNodeIdMask = 0x7F;
  const bool follows = saved_id != 0 && (cob_id & kNodeIdMask) == saved_id;
  return follows ? (cob_id & ~kNodeIdMask) | now : cob_id;
}

bool write_row(Device& device, const Found& found, const RecordRow& row, std::uint8_t saved_id) noexcept {
  if (!is_identifier(row.index, row.sub) || row.value.size() != 4) {
    return write_object(device, found, row.value) == Abort::none;
  }
  std::array<std::uint8_t, 4> bytes{};
  store_le(moved(load_le(row.value), saved_id, device.config.node_id), bytes);
  return write_object(device, found, bytes) == Abort::none;
}

}  // namespace

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

void restore_kept(Device& device, Kept group, std::span<const std::uint8_t> body, std::uint8_t saved_id,
                  Restored& restored) noexcept {
  for (const Pass pass : kPasses) {
    config::RowReader rows(body);
    for (RecordRow row; rows.next(row);) {
      if (group_of_row(row.index) != group) continue;
      const bool now = pass_of(row.index, row.sub) == pass;
      if (!now && pass != Pass::switch_off) continue;
      const Found found = find(row.index, row.sub);
      const bool known = found.entry != nullptr && found.entry->kept == group;
      if (pass == Pass::switch_off) {
        if (known) switch_off(device, found, row);
      } else if (!known || !write_row(device, found, row, saved_id)) {
        restored.skip(row.index, row.sub);
        if (is_setting(row.index)) device.settings.refuse_restored(owner_of_setting(row.index));
      }
    }
  }
}

}  // namespace plenum::canopen
