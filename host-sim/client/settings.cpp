#include "host-sim/client/settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include "firmware/canopen/kept_values.hpp"
#include "host-sim/client/shortest_decimal.hpp"

namespace plenum::host::client {
namespace {

using canopen::Abort;
using canopen::DataType;
namespace cob = canopen::cob;
namespace object = canopen::object;

constexpr std::array<std::pair<DataType, const char*>, 7> kTypes{{{DataType::integer8, "INTEGER8"},
                                                                  {DataType::integer16, "INTEGER16"},
                                                                  {DataType::integer32, "INTEGER32"},
                                                                  {DataType::unsigned8, "UNSIGNED8"},
                                                                  {DataType::unsigned16, "UNSIGNED16"},
                                                                  {DataType::unsigned32, "UNSIGNED32"},
                                                                  {DataType::real32, "REAL32"}}};

bool is_signed(DataType type) {
  return type == DataType::integer8 || type == DataType::integer16 || type == DataType::integer32;
}

std::uint32_t read_value(Session& session, const Setting& setting) {
  const std::vector<std::uint8_t> bytes = session.sdo_read(setting.id.index, setting.id.sub);
  if (bytes.size() != canopen::size_of(setting.type)) {
    throw ProtocolError(fmt::format("node {}: reading {:04X}h:{} gave {} bytes, expected {}",
                                    session.node_id(), setting.id.index, setting.id.sub, bytes.size(),
                                    canopen::size_of(setting.type)));
  }
  return canopen::load_le(bytes);
}

void write_value(Session& session, const Setting& setting, std::uint32_t bits) {
  std::array<std::uint8_t, 4> bytes{};
  canopen::store_le(bits, bytes);
  session.sdo_write(setting.id.index, setting.id.sub,
                    std::span<const std::uint8_t>(bytes).first(canopen::size_of(setting.type)));
}

/// What of the value the board minded, behind its abort: the range of the field alone, or what the others leave of it.
std::string reason_of(Session& session, const Setting& setting, const SdoAbort& refusal) {
  constexpr std::uint32_t kValueAborts =
      0x0609'0030;  // invalid, and 31h, 32h, 36h: too high, too low, ends crossed
  if ((refusal.code & ~std::uint32_t{0xF}) != kValueAborts) return refusal.what();
  const canopen::Entry* const row = canopen::find(setting.id.index, setting.id.sub).entry;
  if (row != nullptr && row->range.limited &&
      canopen::judge_value(*row, setting.bits) != canopen::Abort::none) {
    return fmt::format("{}: is {}, expected {:g} to {:g}", refusal.what(), text_of(number_of(setting)),
                       row->range.low, row->range.high);
  }
  if (!canopen::is_setting(setting.id.index)) return refusal.what();
  const std::size_t owner = canopen::owner_of_setting(setting.id.index);
  const std::string told = last_refusal(session, owner == kChambers ? 0U : static_cast<unsigned>(owner) + 1U);
  return told.empty() ? refusal.what() : fmt::format("{}: {}", refusal.what(), told);
}

constexpr std::uint16_t kHeartbeatConsumer = 0x1016;

bool is_pdo_communication(std::uint16_t index) {
  return (index >= 0x1400 && index < 0x1600) || (index >= 0x1800 && index < 0x1A00);
}
bool is_pdo_mapping(std::uint16_t index) {
  return (index >= 0x1600 && index < 0x1800) || (index >= 0x1A00 && index < 0x1C00);
}
bool is_identifier(const SettingId& id) {
  return (is_pdo_communication(id.index) && id.sub == 1) ||
         (id.index == object::kEmergencyCobId && id.sub == 0);
}

/// Writing one board's settings, and what came of each.
class Writer {
 public:
  Writer(Session& session, std::span<const Setting> settings) : session_(session), settings_(settings) {}

  std::vector<SettingTrouble> run() {
    each([](const Setting& s) { return is_identifier(s.id); },
         [](const Setting& s) { return s.bits | cob::kInvalid; });
    const auto is_emptied = [](const Setting& s) {
      return (is_pdo_mapping(s.id.index) && s.id.sub == 0) || s.id.index == kHeartbeatConsumer;
    };
    each(is_emptied,
         [](const Setting&) { return std::uint32_t{0}; });  // no node may be heard by two consumers
    const auto value = [](const Setting& s) { return s.bits; };
    each(
        [](const Setting& s) {
          return !is_identifier(s.id) && !(is_pdo_mapping(s.id.index) && s.id.sub == 0);
        },
        value);
    each([](const Setting& s) { return is_pdo_mapping(s.id.index) && s.id.sub == 0; }, value);
    each([](const Setting& s) { return is_identifier(s.id); }, value);
    // Some settings are judged together, as a low limit and a high one: what was refused may fit once others are there.
    for (std::size_t before = trouble_.size() + 1; !trouble_.empty() && trouble_.size() < before;) {
      before = trouble_.size();
      each([this](const Setting& s) { return trouble_.contains(s.id); }, value);
    }
    for (const Setting& setting : settings_) compare(setting);
    std::vector<SettingTrouble> troubles;
    for (const Setting& setting : settings_) {
      if (const auto found = trouble_.find(setting.id); found != trouble_.end()) {
        troubles.push_back({setting, found->second});
      }
    }
    return troubles;
  }

 private:
  template <class Chosen, class Value>
  void each(const Chosen& chosen, const Value& value) {
    for (const Setting& setting : settings_) {
      if (!chosen(setting)) continue;
      try {
        write_value(session_, setting, value(setting));
        trouble_.erase(setting.id);
      } catch (const SdoAbort& refusal) {
        trouble_.insert_or_assign(setting.id, reason_of(session_, setting, refusal));
      }
    }
  }
  void compare(const Setting& setting) {
    try {
      const std::uint32_t found = read_value(session_, setting);
      if (found == setting.bits) {
        trouble_.erase(setting.id);  // refused or not, the board has it
      } else {
        trouble_.emplace(setting.id, fmt::format("reads back as {:X}h, expected {:X}h", found, setting.bits));
      }
    } catch (const SdoAbort& refusal) {
      trouble_.emplace(setting.id, refusal.what());
    }
  }

  Session& session_;
  std::span<const Setting> settings_;
  std::map<SettingId, std::string> trouble_;
};

}  // namespace

SettingNumber number_of(const Setting& setting) {
  switch (setting.type) {
    case DataType::real32:
      return shortest_decimal(std::bit_cast<float>(setting.bits));
    case DataType::integer8:
      return std::int64_t{static_cast<std::int8_t>(setting.bits)};
    case DataType::integer16:
      return std::int64_t{static_cast<std::int16_t>(setting.bits)};
    case DataType::integer32:
      return std::int64_t{static_cast<std::int32_t>(setting.bits)};
    default:
      return std::int64_t{setting.bits};
  }
}

std::uint32_t bits_of(DataType type, const SettingNumber& number) {
  if (type == DataType::real32) {
    const double value = std::holds_alternative<double>(number)
                             ? std::get<double>(number)
                             : static_cast<double>(std::get<std::int64_t>(number));
    if (!(std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max()))) {
      throw std::invalid_argument(fmt::format("{} is no REAL32", value));
    }
    return std::bit_cast<std::uint32_t>(static_cast<float>(value));
  }
  const unsigned bits = static_cast<unsigned>(8 * canopen::size_of(type));
  const std::int64_t low = is_signed(type) ? -(std::int64_t{1} << (bits - 1)) : 0;
  const std::int64_t high = (std::int64_t{1} << (is_signed(type) ? bits - 1 : bits)) - 1;
  const std::int64_t* value = std::get_if<std::int64_t>(&number);
  if (value == nullptr || *value < low || *value > high) {
    throw std::invalid_argument(fmt::format("{} is no {}, expected a whole number in {}..{}", text_of(number),
                                            type_name(type), low, high));
  }
  return static_cast<std::uint32_t>(*value) &
         (bits == 32 ? ~std::uint32_t{0} : (std::uint32_t{1} << bits) - 1);
}

std::string text_of(const SettingNumber& number) {
  return std::visit([](auto one) { return fmt::format("{}", one); }, number);
}

const char* type_name(DataType type) {
  const auto* found =
      std::find_if(kTypes.begin(), kTypes.end(), [type](const auto& one) { return one.first == type; });
  if (found == kTypes.end()) throw std::invalid_argument("a type without a fixed size, expected a number's");
  return found->second;
}

DataType type_of(const std::string& name) {
  const auto* found =
      std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& one) { return name == one.second; });
  if (found == kTypes.end()) {
    throw std::invalid_argument(
        fmt::format("'{}' is no type of a setting, expected UNSIGNED8 .. REAL32", name));
  }
  return found->first;
}

std::vector<Setting> known_settings() {
  std::vector<Setting> settings;
  for (const canopen::Entry& row : canopen::object_dictionary()) {
    if (row.kept == canopen::Kept::no) continue;
    for (unsigned instance = 0; instance < row.instances; ++instance) {
      for (unsigned sub = row.sub; sub <= row.last_sub; ++sub) {
        settings.push_back(
            {{static_cast<std::uint16_t>(row.index + instance * row.stride), static_cast<std::uint8_t>(sub)},
             row.type,
             row.name});
      }
    }
  }
  std::sort(settings.begin(), settings.end(), [](const Setting& a, const Setting& b) { return a.id < b.id; });
  return settings;
}

std::vector<Setting> read_settings(Session& session, const std::function<bool(const SettingId&)>& wanted) {
  std::vector<Setting> settings = known_settings();
  std::erase_if(settings, [&](const Setting& setting) { return !wanted(setting.id); });
  return read_values(session, std::move(settings));
}

void move_settings(std::span<Setting> settings, std::uint8_t from, std::uint8_t to) {
  for (Setting& setting : settings) {
    const canopen::Found found = canopen::find(setting.id.index, setting.id.sub);
    if (found.entry != nullptr && found.entry->of_node) setting.bits = canopen::moved(setting.bits, from, to);
  }
}

std::vector<Setting> read_values(Session& session, std::vector<Setting> objects) {
  std::vector<Setting> settings;
  for (Setting& setting : objects) {
    try {
      setting.bits = read_value(session, setting);
    } catch (const SdoAbort& abort) {
      const auto code = static_cast<Abort>(abort.code);
      if (code == Abort::no_object || code == Abort::no_subindex || code == Abort::no_data) continue;
      throw;
    }
    settings.push_back(std::move(setting));
  }
  return settings;
}

std::vector<SettingTrouble> write_settings(Session& session, std::span<const Setting> settings) {
  return Writer(session, settings).run();
}

std::string last_refusal(Session& session, unsigned chamber) try {
  const auto of = session.read<std::uint8_t>(object::kSettingRefusal, 1);
  if (of != chamber || session.read<std::uint8_t>(object::kSettingRefusal, 2) == 0) return {};
  const std::vector<std::uint8_t> field = session.sdo_read(object::kSettingRefusal, 3);
  return fmt::format("{} = {:g}, expected {:g} to {:g} with the other settings as they are",
                     std::string(field.begin(), field.end()), session.read<float>(object::kSettingRefusal, 4),
                     session.read<float>(object::kSettingRefusal, 5),
                     session.read<float>(object::kSettingRefusal, 6));
} catch (const SdoAbort&) {
  return {};  // an older firmware, that has no such object
}

bool store_settings(Session& session) {
  constexpr double kPatience_s = 10.0;  // the answer comes when the memory has it
  SdoClient patient(session.link(), session.node_id(), {.timeout_s = kPatience_s},
                    [&session](const CanFrame& frame) { session.hear(frame); });
  std::array<std::uint8_t, 4> key{};
  canopen::store_le(canopen::kSaveSignature, key);
  try {
    patient.write(canopen::object::kStore, 1, key);
  } catch (const SdoAbort& abort) {
    if (abort.code == static_cast<std::uint32_t>(Abort::no_object)) return false;
    throw;
  }
  return true;
}

}  // namespace plenum::host::client
