#include "host-sim/trace/rig_toml.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>

#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/legible.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::trace {
namespace {

/// One key: where it stands, what it may be, what it means. Reader, writer and validation read this table
/// alone.
struct Key {
  std::string_view table;
  std::string_view name;
  double& (*of)(RigDescription&);
  double low;   ///< smallest admissible value
  double high;  ///< largest admissible value
  std::string_view meaning;
};

const std::array<Key, 14> kKeys{{
    {"sampling", "rate_Hz", [](RigDescription& r) -> double& { return r.sampling.rate_Hz; }, 1.0, 1e5,
     "rows per second"},
    {"sampling", "pressure_average_s",
     [](RigDescription& r) -> double& { return r.sampling.pressure_average_s; }, 0.0, 1.0,
     "a pressure is the mean over this time before its row; 0: an instant sample"},
    {"gas", "temperature_K", [](RigDescription& r) -> double& { return r.gas.temperature_K; }, 200.0, 400.0,
     ""},
    {"supply", "pressure_Pa", [](RigDescription& r) -> double& { return r.supply.pressure_Pa; }, 1e4, 2e6,
     "absolute"},
    {"ambient", "pressure_Pa", [](RigDescription& r) -> double& { return r.ambient.pressure_Pa; }, 1e3, 2e5,
     "absolute"},
    {"valve", "open_above_V", [](RigDescription& r) -> double& { return r.valve.open_above_V; }, -24.0, 24.0,
     "U_c: the supply port opens above"},
    {"valve", "exhaust_below_V", [](RigDescription& r) -> double& { return r.valve.exhaust_below_V; }, -24.0,
     24.0, "U_r: the exhaust port opens below"},
    {"valve", "inlet_area_per_V_m2", [](RigDescription& r) -> double& { return r.valve.inlet_area_per_V_m2; },
     1e-9, 1e-3, ""},
    {"valve", "exhaust_area_per_V_m2",
     [](RigDescription& r) -> double& { return r.valve.exhaust_area_per_V_m2; }, 1e-9, 1e-3, ""},
    {"valve", "inlet_leak_m2", [](RigDescription& r) -> double& { return r.valve.inlet_leak_m2; }, 0.0, 1e-4,
     "L_c"},
    {"valve", "exhaust_leak_m2", [](RigDescription& r) -> double& { return r.valve.exhaust_leak_m2; }, 0.0,
     1e-4, "L_r"},
    {"valve", "transition_m2", [](RigDescription& r) -> double& { return r.valve.transition_m2; }, 1e-12,
     1e-4, "width w of the smooth transition"},
    {"valve", "discharge_coefficient",
     [](RigDescription& r) -> double& { return r.valve.discharge_coefficient; }, 0.1, 1.0, ""},
    {"sensor", "pressure_noise_Pa", [](RigDescription& r) -> double& { return r.sensor.pressure_noise_Pa; },
     0.0, 1e6, "standard deviation of one row's pressure"},
}};

const Key* find_key(std::string_view table, std::string_view name) {
  const auto found = std::find_if(kKeys.begin(), kKeys.end(),
                                  [&](const Key& key) { return key.table == table && key.name == name; });
  return found == kKeys.end() ? nullptr : &*found;
}

std::string names_of(std::string_view table) {
  std::string names;
  for (const Key& key : kKeys) {
    if (key.table != table) continue;
    names += names.empty() ? "" : ", ";
    names += key.name;
  }
  return names;
}

void check_range(const Key& key, double value, std::string_view where) {
  if (!(value >= key.low && value <= key.high)) {
    throw InputError(fmt::format("{}: {}.{} = {}, expected {} to {}", where, key.table, key.name, value,
                                 key.low, key.high));
  }
}

void check_together(const RigDescription& rig, std::string_view where) {
  // A pressure that averages over more than one tick would need the command before the row before. One tick may be rounded.
  constexpr double kRounding = 1e-3;
  if (rig.sampling.pressure_average_s > (1.0 + kRounding) / rig.sampling.rate_Hz) {
    throw InputError(fmt::format("{}: sampling.pressure_average_s = {}, expected 0 to one tick, {}", where,
                                 rig.sampling.pressure_average_s, 1.0 / rig.sampling.rate_Hz));
  }
  if (!(rig.supply.pressure_Pa > rig.ambient.pressure_Pa)) {
    throw InputError(fmt::format("{}: supply.pressure_Pa = {}, expected above ambient.pressure_Pa = {}",
                                 where, rig.supply.pressure_Pa, rig.ambient.pressure_Pa));
  }
}

double number_of(const toml::node& node, std::string_view where, std::string_view name,
                 std::string_view expected) {
  if (const auto* real = node.as_floating_point()) return real->get();
  if (const auto* whole = node.as_integer()) return static_cast<double>(whole->get());
  std::string_view kind = "something else";
  if (node.is_string()) kind = "a string";
  if (node.is_boolean()) kind = "a boolean";
  if (node.is_array()) kind = "an array";
  if (node.is_table()) kind = "a table";
  throw InputError(fmt::format("{}: {} is {}, expected {}", where, name, kind, expected));
}

constexpr std::string_view kEffects = "effects";

/// A name that TOML takes unquoted, and a C++ identifier could be.
void check_effect_name(std::string_view name, std::string_view where) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto allowed = [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_'; };
  if (name.empty() || !letter(name.front()) || !std::all_of(name.begin(), name.end(), allowed)) {
    throw InputError(
        fmt::format("{}: '{}' in [effects], expected a name of letters, digits and _", where, legible(name)));
  }
}

void check_effect_figure(std::string_view id, std::string_view name, double value, std::string_view where) {
  check_effect_name(id, where);
  check_effect_name(name, where);
  if (!std::isfinite(value)) {
    throw InputError(fmt::format("{}: effects.{}.{} = {}, expected a finite number", where, id, name, value));
  }
}

void parse_effects(const toml::table& effects, std::string_view file, RigDescription& rig) {
  for (const auto& [id_key, id_node] : effects) {
    const std::string_view id = id_key.str();
    const std::string where = fmt::format("{}: line {}", file, id_key.source().begin.line);
    check_effect_name(id, where);
    const auto* figures = id_node.as_table();
    if (figures == nullptr) {
      throw InputError(
          fmt::format("{}: effects.{} is a value, expected a table [effects.{}]", where, id, id));
    }
    auto& read = rig.effects[std::string(id)];
    for (const auto& [name_key, node] : *figures) {
      const std::string_view name = name_key.str();
      const std::string at = fmt::format("{}: line {}", file, name_key.source().begin.line);
      const double value = number_of(node, at, fmt::format("effects.{}.{}", id, name), "a finite number");
      check_effect_figure(id, name, value, at);
      read[std::string(name)] = value;
    }
  }
}

constexpr std::string_view kChamber = "chamber";
constexpr unsigned kMostChambers = 8;
constexpr std::string_view kValveSerial = "valve_serial";
constexpr std::string_view kSensorSerial = "sensor_serial";

std::uint32_t serial_of(const toml::node& node, std::string_view where, std::string_view name) {
  constexpr std::int64_t kMost = std::numeric_limits<std::uint32_t>::max();
  const auto* whole = node.as_integer();
  if (whole == nullptr || whole->get() < 0 || whole->get() > kMost) {
    throw InputError(
        fmt::format("{}: {} is no serial number, expected a whole number from 0 to {}", where, name, kMost));
  }
  return static_cast<std::uint32_t>(whole->get());
}

void parse_chambers(const toml::table& chambers, std::string_view file, RigDescription& rig) {
  for (const auto& [number_key, node] : chambers) {
    const std::string_view number = number_key.str();
    const std::string where = fmt::format("{}: line {}", file, number_key.source().begin.line);
    const auto* entries = node.as_table();
    if (entries == nullptr || number.size() != 1 || number[0] < '1' || number[0] > '0' + int{kMostChambers}) {
      throw InputError(fmt::format("{}: chamber.{}, expected a table [chamber.N], N from 1 to {}", where,
                                   legible(number), kMostChambers));
    }
    RigDescription::Chamber& chamber = rig.chamber[static_cast<unsigned>(number[0] - '0')];
    for (const auto& [name_key, entry] : *entries) {
      const std::string_view name = name_key.str();
      const std::string at = fmt::format("{}: line {}", file, name_key.source().begin.line);
      if (name != kValveSerial && name != kSensorSerial) {
        throw InputError(fmt::format("{}: unknown key '{}' in [chamber.{}], expected {}, {}", at,
                                     legible(name), number, kValveSerial, kSensorSerial));
      }
      (name == kValveSerial ? chamber.valve_serial : chamber.sensor_serial) =
          serial_of(entry, at, fmt::format("chamber.{}.{}", number, name));
    }
  }
}

/// What of a line TOML reads, and the most parts that a key in it has, "a.b" being of two.
struct Code {
  std::size_t size = 0;  ///< without the comment
  std::size_t key_parts = 1;
};

/// With `quotes` neither a dot nor a '#' in a string counts: no string of the file spans lines. Without, all of the line is read.
Code code_of(std::string_view line, bool quotes) {
  Code code{.size = line.size()};
  std::size_t parts = 1;
  char quote = '\0';
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (quote != '\0') {
      if (line[i] == '\\' && quote == '"') {
        ++i;
      } else if (line[i] == quote) {
        quote = '\0';
      }
    } else if (line[i] == '.') {
      code.key_parts = std::max(code.key_parts, ++parts);
    } else if (quotes && line[i] == '#') {
      code.size = i;
      return code;
    } else if (quotes && (line[i] == '"' || line[i] == '\'')) {
      quote = line[i];
    } else if (quotes && std::string_view("=,[]{}").find(line[i]) != std::string_view::npos) {
      parts = 1;
    }
  }
  return code;
}

constexpr std::size_t kMostKeyParts = 8;  ///< those of ours have three

/// What toml++ does not survive. It calls itself once for each part of a key. Up to 3.3 it takes some letters beyond ASCII for a
/// point that is never reached, where it looks for white space. No key of ours holds one; a comment may, except in files with
/// strings of several lines, which may hold what looks like one.
void expect_readable(std::string_view text, std::string_view file) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  const bool comments_may =
      text.find("\"\"\"") == std::string_view::npos && text.find("'''") == std::string_view::npos;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const auto [size, parts] = code_of(text.substr(0, end), comments_may);
    const std::string_view code = text.substr(0, size);
    if (std::any_of(code.begin(), code.end(),
                    [](char c) { return (static_cast<unsigned char>(c) & 0x80U) != 0; })) {
      throw InputError(fmt::format(
          "{}: line {}: a character beyond ASCII, expected {}", file, line,
          comments_may ? "those in comments only" : "none in a file with strings of several lines"));
    }
    if (parts > kMostKeyParts) {
      throw InputError(fmt::format("{}: line {}: a key of {} parts, expected {} at most", file, line, parts,
                                   kMostKeyParts));
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

bool has_default_valve(RigDescription rig) {
  RigDescription standard;
  return std::all_of(kKeys.begin(), kKeys.end(),
                     [&](const Key& key) { return key.table != "valve" || key.of(rig) == key.of(standard); });
}

}  // namespace

RigDescription parse_rig(std::string_view text, std::string_view file, std::vector<std::string>* assumed) {
  expect_readable(text, file);
  toml::table document;
  try {
    document = toml::parse(text, std::string(file));
  } catch (const toml::parse_error& error) {
    throw InputError(
        fmt::format("{}: line {}: {}, expected TOML", file, error.source().begin.line, error.description()));
  }
  RigDescription rig;
  std::set<const Key*> stated;
  for (const auto& [table_key, table_node] : document) {
    const std::string_view table = table_key.str();
    const std::string where = fmt::format("{}: line {}", file, table_key.source().begin.line);
    if (names_of(table).empty() && table != kEffects && table != kChamber) {
      throw InputError(
          fmt::format("{}: unknown table or key '{}', expected [sampling], [gas], [supply], [ambient], "
                      "[valve], [sensor], [effects.ID] or [chamber.N]",
                      where, legible(table)));
    }
    const auto* entries = table_node.as_table();
    if (entries == nullptr)
      throw InputError(fmt::format("{}: '{}' is a value, expected a table", where, legible(table)));
    if (table == kEffects) {
      parse_effects(*entries, file, rig);
      continue;
    }
    if (table == kChamber) {
      parse_chambers(*entries, file, rig);
      continue;
    }
    for (const auto& [entry_key, entry_node] : *entries) {
      const std::string_view name = entry_key.str();
      const std::string at = fmt::format("{}: line {}", file, entry_key.source().begin.line);
      const Key* key = find_key(table, name);
      if (key == nullptr) {
        throw InputError(fmt::format("{}: unknown key '{}' in [{}], expected {}", at, legible(name), table,
                                     names_of(table)));
      }
      const double value = number_of(entry_node, at, fmt::format("{}.{}", table, name),
                                     fmt::format("a number from {} to {}", key->low, key->high));
      check_range(*key, value, at);
      key->of(rig) = value;
      stated.insert(key);
    }
  }
  if (!stated.contains(find_key("sampling", "rate_Hz")))
    throw InputError(fmt::format("{}: sampling.rate_Hz is missing, expected 1 to 100000", file));
  const double tick_s = 1.0 / rig.sampling.rate_Hz;
  if (!stated.contains(find_key("sampling", "pressure_average_s"))) rig.sampling.pressure_average_s = tick_s;
  check_together(rig, file);
  rig.sampling.pressure_average_s = std::min(rig.sampling.pressure_average_s, tick_s);
  if (assumed != nullptr) {
    for (const Key& key : kKeys) {
      if (!stated.contains(&key))
        assumed->push_back(fmt::format("{}.{} = {:g}", key.table, key.name, key.of(rig)));
    }
  }
  return rig;
}

RigDescription read_rig(const std::filesystem::path& path, std::vector<std::string>* assumed) {
  return parse_rig(read_whole_file(path), path.string(), assumed);
}

std::string format_rig(const RigDescription& rig) {
  RigDescription copy = rig;
  std::string text;
  std::string_view table;
  for (const Key& key : kKeys) {
    if (key.table != table) {
      text += fmt::format("{}[{}]{}\n", text.empty() ? "" : "\n", key.table,
                          key.table == "valve" && has_default_valve(copy)
                              ? "  # defaults, of no measured valve and no data sheet"
                              : "");
      table = key.table;
    }
    text += fmt::format("{} = {}", key.name, key.of(copy));
    if (!key.meaning.empty()) text += fmt::format("  # {}", key.meaning);
    text += '\n';
  }
  for (const auto& [id, figures] : rig.effects) {
    text += fmt::format("\n[effects.{}]\n", id);
    for (const auto& [name, value] : figures) text += fmt::format("{} = {}\n", name, value);
  }
  for (const auto& [number, chamber] : rig.chamber) {
    text += fmt::format("\n[chamber.{}]\n{} = {}\n{} = {}\n", number, kValveSerial, chamber.valve_serial,
                        kSensorSerial, chamber.sensor_serial);
  }
  return text;
}

void write_rig(const std::filesystem::path& path, const RigDescription& rig) {
  RigDescription copy = rig;
  for (const Key& key : kKeys) check_range(key, key.of(copy), "rig to write");
  check_together(copy, "rig to write");
  for (const auto& [id, figures] : rig.effects) {
    check_effect_name(id, "rig to write");
    for (const auto& [name, value] : figures) check_effect_figure(id, name, value, "rig to write");
  }
  for (const auto& [number, chamber] : rig.chamber) {
    if (number >= 1 && number <= kMostChambers) continue;
    throw InputError(fmt::format("rig to write: chamber {}, expected 1 to {}", number, kMostChambers));
  }
  write_whole_file(path, format_rig(rig));
}

}  // namespace plenum::host::trace
