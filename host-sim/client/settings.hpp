// The settings of a board: every object that 1010h stores, by the object dictionary that board and program share.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "firmware/canopen/object_dictionary.hpp"
#include "host-sim/client/session.hpp"

namespace plenum::host::client {

struct SettingId {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  // NOLINTNEXTLINE(modernize-use-nullptr): what the compiler makes of it compares with 0
  friend auto operator<=>(const SettingId&, const SettingId&) = default;
};

struct Setting {
  SettingId id;
  canopen::DataType type = canopen::DataType::unsigned8;
  std::string name;
  std::uint32_t bits = 0;
};

/// A number as its type has it: REAL32 as the shortest decimal that reads back to it.
using SettingNumber = std::variant<std::int64_t, double>;
SettingNumber number_of(const Setting& setting);
std::string text_of(const SettingNumber& number);
/// Throws std::invalid_argument when the type cannot hold it.
std::uint32_t bits_of(canopen::DataType type, const SettingNumber& number);
/// "UNSIGNED16", as an EDS has it; type_of throws std::invalid_argument for another name.
const char* type_name(canopen::DataType type);
canopen::DataType type_of(const std::string& name);

/// All settings that this program knows, without values, in the order of the dictionary.
std::vector<Setting> known_settings();
/// `objects` with their values on the board, of settings or of other objects of the dictionary. Those that the board does not
/// have are left out.
std::vector<Setting> read_values(Session& session, std::vector<Setting> objects);
/// The same of all settings, or of those that are `wanted`.
std::vector<Setting> read_settings(
    Session& session,
    const std::function<bool(const SettingId&)>& wanted = [](const SettingId&) { return true; });

/// Settings of node `from` made those of node `to`: identifiers that hold the node id follow it, as on a board that gets another.
void move_settings(std::span<Setting> settings, std::uint8_t from, std::uint8_t to);

struct SettingTrouble {
  Setting setting;
  std::string reason;
};

/// Writes settings in the order that CiA 301 asks for: PDOs are switched off before they change, their mappings are
/// emptied, filled and activated, identifiers come last. What is refused does not stop the rest. Reads all back; returns
/// those that the board refused or shows differently. Throws Timeout and ProtocolError.
std::vector<SettingTrouble> write_settings(Session& session, std::span<const Setting> settings);

/// The setting that the board has refused last, its value and the range that the others leave it (241Ah), of this chamber from 1 or
/// with 0 of the board: "pressure_low_kPa = 700, expected 0 to 600 with the other settings as they are"; empty where it tells none.
std::string last_refusal(Session& session, unsigned chamber);

/// Makes the board keep its settings (1010h:1). Returns false when the board cannot (no such object). Throws SdoAbort
/// when storing failed.
bool store_settings(Session& session);

}  // namespace plenum::host::client
