#include "firmware/canopen/object_dictionary.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "firmware/canopen/dictionary/capture.hpp"
#include "firmware/canopen/dictionary/communication.hpp"
#include "firmware/canopen/dictionary/device_control.hpp"
#include "firmware/canopen/dictionary/faults.hpp"
#include "firmware/canopen/dictionary/models.hpp"
#include "firmware/canopen/dictionary/pdo.hpp"
#include "firmware/canopen/dictionary/pressure_control.hpp"
#include "firmware/canopen/dictionary/process.hpp"
#include "firmware/canopen/dictionary/settings.hpp"
#include "firmware/canopen/dictionary/store.hpp"
#include "firmware/config/parameter_record.hpp"

namespace plenum::canopen {

using namespace dictionary;

namespace {

constexpr auto kTable = joined(
    dictionary::kCommunicationRows, dictionary::kPdoRows, dictionary::kModelRows, dictionary::kStoreRows,
    dictionary::kModelParameterRows, dictionary::kProcessRows, dictionary::kCaptureRows,
    dictionary::kChamberFloatRows.row, dictionary::kChamberTickRows.row, dictionary::kChamberChoiceRows,
    dictionary::kBoardFloatRows.row, dictionary::kBoardTickRows.row, dictionary::kRefusalRows,
    dictionary::kFaultRows, dictionary::kDeviceControlRows, dictionary::kPressureControlRows);

constexpr bool before(const Entry& a, const Entry& b) {
  return a.index < b.index || (a.index == b.index && a.sub < b.sub);
}
static_assert(std::is_sorted(kTable.begin(), kTable.end(), before), "find() halves the table");

/// FNV-1a over what a data sheet says of the rows.
constexpr std::uint32_t kRevision = [] {
  std::uint32_t digest = 0x811C'9DC5U;
  const auto take = [&digest](std::uint32_t byte) { digest = (digest ^ (byte & 0xFFU)) * 0x0100'0193U; };
  const auto take_text = [&take](const char* text) {
    for (; text != nullptr && *text != '\0'; ++text) take(static_cast<unsigned char>(*text));
  };
  const auto take_number = [&take](std::uint32_t bits) {
    for (int shift = 0; shift < 32; shift += 8) take(bits >> shift);
  };
  for (const Entry& row : kTable) {
    take_number(std::uint32_t{row.index} << 16U | std::uint32_t{row.sub} << 8U | row.last_sub);
    take_number(std::uint32_t{row.instances} << 16U | row.stride);
    for (const std::uint32_t choice :
         {static_cast<std::uint32_t>(row.type), static_cast<std::uint32_t>(row.access),
          static_cast<std::uint32_t>(row.mappable), static_cast<std::uint32_t>(row.kept)})
      take(choice);
    take_number(std::bit_cast<std::uint32_t>(row.range.low));
    take_number(std::bit_cast<std::uint32_t>(row.range.high));
    take_text(row.name);
    take_text(row.object_name);
  }
  return digest;
}();
static_assert(kRevision != 0, "0 asks for it");

/// Of each row: how many rows from it on are of the same object.
constexpr auto kRowsLeft = [] {
  std::array<std::uint8_t, kTable.size()> rows{};
  for (std::size_t row = kTable.size(); row-- > 0;) {
    const bool goes_on = row + 1 < kTable.size() && kTable[row + 1].index == kTable[row].index;
    rows[row] = static_cast<std::uint8_t>(goes_on ? rows[row + 1] + 1 : 1);
  }
  return rows;
}();

/// What the kept values take of a stored set.
constexpr std::size_t kept_bytes() {
  std::size_t bytes = 0;
  for (const Entry& row : kTable) {
    const std::size_t values = std::size_t{row.instances} * (row.last_sub - row.sub + 1U);
    if (row.kept != Kept::no) bytes += values * (config::kRowHeaderBytes + size_of(row.type));
  }
  return bytes;
}
constexpr std::size_t kModelBytes = config::kChambers * (config::kRowHeaderBytes + config::kMaxImageBytes);
constexpr std::size_t kLssBytes = 32;
static_assert(kept_bytes() + kModelBytes + kLssBytes <= config::kMaxBodyBytes,
              "all that is kept fits a slot");

constexpr ObjectGroup group_of(const Entry& row) {
  if (row.index == 0x1000 || row.index == 0x1001 || row.index == 0x1018) return ObjectGroup::mandatory;
  return row.index >= 0x2000 && row.index < 0x6000 ? ObjectGroup::manufacturer : ObjectGroup::optional;
}

constexpr bool begins_object(std::size_t row, ObjectGroup group) {
  return (row == 0 || kTable[row - 1].index != kTable[row].index) && group_of(kTable[row]) == group;
}

constexpr std::size_t count_first_rows(ObjectGroup group) {
  std::size_t count = 0;
  for (std::size_t row = 0; row < kTable.size(); ++row) count += begins_object(row, group) ? 1U : 0U;
  return count;
}

template <ObjectGroup group>
constexpr auto first_rows() {
  std::array<std::uint16_t, count_first_rows(group)> rows{};
  std::size_t count = 0;
  for (std::size_t row = 0; row < kTable.size(); ++row) {
    if (begins_object(row, group)) rows[count++] = static_cast<std::uint16_t>(row);
  }
  return rows;
}

template <ObjectGroup group>
constexpr auto kFirstRows = first_rows<group>();

template <ObjectGroup group>
constexpr ObjectList list() {
  std::uint16_t objects = 0;
  for (const std::uint16_t row : kFirstRows<group>)
    objects = static_cast<std::uint16_t>(objects + kTable[row].instances);
  return {kFirstRows<group>, objects};
}

template <ObjectGroup group>
constexpr ObjectList kList = list<group>();

}  // namespace

std::span<const Entry> object_dictionary() noexcept {
  return kTable;
}

std::uint32_t dictionary_revision() noexcept {
  return kRevision;
}

std::span<const Entry> rows_of_object(std::size_t first) noexcept {
  return object_dictionary().subspan(first, kRowsLeft[first]);
}

ObjectList objects_of(ObjectGroup group) noexcept {
  switch (group) {
    case ObjectGroup::mandatory:
      return kList<ObjectGroup::mandatory>;
    case ObjectGroup::optional:
      return kList<ObjectGroup::optional>;
    case ObjectGroup::manufacturer:
      return kList<ObjectGroup::manufacturer>;
  }
  return {};
}

Found find(std::uint16_t index, std::uint8_t sub) noexcept {
  // the objects of chambers 1..7 stand at multiples of 800h beyond those of chamber 0
  constexpr unsigned kModules = 0x6000;
  const bool of_module = index >= kModules && index < kModules + config::kChambers * object::kChamberStride;
  const unsigned module = of_module ? (index - kModules) / object::kChamberStride : 0;
  const unsigned first = index - module * object::kChamberStride;

  const auto beyond = std::upper_bound(kTable.begin(), kTable.end(), first,
                                       [](unsigned wanted, const Entry& row) { return wanted < row.index; });
  if (beyond == kTable.begin()) return {.abort = Abort::no_object};
  const Entry& last_row = *(beyond - 1);
  const unsigned offset = first - last_row.index;
  const bool each_module = last_row.stride == object::kChamberStride;
  if (each_module ? offset != 0 : module != 0 || offset >= last_row.instances)
    return {.abort = Abort::no_object};

  // the rows of one object follow each other
  const auto instance = static_cast<std::uint8_t>(each_module ? module : offset);
  for (auto row = beyond; row != kTable.begin() && (--row)->index == last_row.index;) {
    if (sub >= row->sub && sub <= row->last_sub) return {.entry = &*row, .place = {instance, sub}};
  }
  return {.abort = Abort::no_subindex};
}

Found find(std::uint16_t index, std::uint8_t sub, const Entry* near) noexcept {
  for (int i = 0; i < 2 && near != nullptr && near != kTable.data() + kTable.size(); ++i, ++near) {
    if (index < near->index || sub < near->sub || sub > near->last_sub) continue;
    const unsigned offset = index - std::uint32_t{near->index};
    const bool apart = near->stride == object::kChamberStride;
    const unsigned instance = apart ? offset / object::kChamberStride : offset;
    if (instance >= near->instances || (apart && offset % object::kChamberStride != 0)) continue;
    return {.entry = near, .place = {static_cast<std::uint8_t>(instance), sub}};
  }
  return find(index, sub);
}

Abort judge_value(const Entry& entry, std::uint32_t bits) noexcept {
  const bool is_real = entry.type == DataType::real32;
  if (is_real && !is_finite(bits)) return Abort::value_range;
  if (!entry.range.limited) return Abort::none;
  const std::int32_t place = numeric::place_of(is_real ? std::bit_cast<float>(bits)
                                                       : static_cast<float>(integer_value(entry.type, bits)));
  if (place > numeric::place_of(entry.range.high)) return Abort::value_too_high;
  return place < numeric::place_of(entry.range.low) ? Abort::value_too_low : Abort::none;
}

Abort write_object(Device& device, const Found& found, std::span<const std::uint8_t> bytes) noexcept {
  const Entry& entry = *found.entry;
  if (entry.access == Access::read_only || entry.access == Access::constant) return Abort::read_only;
  if (entry.write_bytes != nullptr) return entry.write_bytes(device, found.place, bytes);
  const std::size_t size = size_of(entry.type);
  if (bytes.size() > size) return Abort::length_too_high;
  if (bytes.size() < size) return Abort::length_too_low;
  const std::uint32_t bits = load_le(bytes);
  const Abort abort = judge_value(entry, bits);
  if (abort != Abort::none) return abort;
  return entry.write_value(device, found.place, bits);
}

Abort activate_mapping(Mapping& mapping, std::uint8_t count, bool receive) noexcept {
  if (count > kMappable) return Abort::pdo_length_exceeded;
  Mapping active = mapping;
  active.bytes = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Abort abort = resolve(active.packed[i], receive, active.object[i]);
    if (abort != Abort::none) return abort;
    active.bytes = static_cast<std::uint8_t>(active.bytes + active.object[i].bytes);
    if (active.bytes > 8) return Abort::pdo_length_exceeded;
  }
  active.count = count;
  mapping = active;
  return Abort::none;
}

bool carries_setpoint(const Mapping& mapping) noexcept {
  for (std::size_t i = 0; i < mapping.count; ++i) {
    const MappedObject& object = mapping.object[i];
    const std::uint16_t index = object.entry->index;
    if ((index == object::kSetpoint || index == object::kPascals) && object.sub == 1) return true;
  }
  return false;
}

}  // namespace plenum::canopen
