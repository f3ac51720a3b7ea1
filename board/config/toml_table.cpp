#include "board/config/toml_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace plenum::board::config {
namespace {

std::string_view kind_of(const toml::node& node) {
  if (node.is_string()) return "a string";
  if (node.is_boolean()) return "a boolean";
  if (node.is_integer()) return "a whole number";
  if (node.is_floating_point()) return "a number";
  if (node.is_array()) return "an array";
  if (node.is_table()) return "a table";
  return "a date or a time";
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
/// point that is never reached, where it looks for white space. No key and no device of ours holds one; a comment may, except in
/// files with strings of several lines, which may hold what looks like one.
void expect_readable(std::string_view text, const std::string& file) {
  const bool comments_may =
      text.find("\"\"\"") == std::string_view::npos && text.find("'''") == std::string_view::npos;
  for (std::size_t line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const auto [size, parts] = code_of(text.substr(0, end), comments_may);
    const std::string_view code = text.substr(0, size);
    if (std::any_of(code.begin(), code.end(), [](char c) { return static_cast<unsigned char>(c) > 0x7FU; })) {
      throw ConfigError(fmt::format(
          "{}: line {}: a character beyond ASCII, expected {}", file, line,
          comments_may ? "those in comments only" : "none in a file with strings of several lines"));
    }
    if (parts > kMostKeyParts) {
      throw ConfigError(fmt::format("{}: line {}: a key of {} parts, expected {} at most", file, line, parts,
                                    kMostKeyParts));
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

}  // namespace

toml::table parse_toml(std::string_view text, const std::string& file) {
  expect_readable(text, file);
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    throw ConfigError(
        fmt::format("{}: line {}: {}, expected TOML", file, error.source().begin.line, error.description()));
  }
}

const toml::node* TomlTable::find(std::string_view key) {
  asked_.emplace_back(key);
  return table_->get(key);
}

std::string TomlTable::name_of(std::string_view key) const {
  return name_.empty() ? std::string(key) : fmt::format("{}.{}", name_, key);
}

void TomlTable::refuse(std::string_view key, std::string_view found, std::string_view expected) const {
  const toml::node* node = table_->get(key);
  const std::size_t line = node != nullptr ? node->source().begin.line : line_;
  const std::string place = line == 0 ? file_ : fmt::format("{}: line {}", file_, line);
  throw ConfigError(fmt::format("{}: {} {}, expected {}", place, name_of(key), found, expected));
}

std::optional<std::string> TomlTable::text(std::string_view key) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  const auto* value = node->as_string();
  if (value == nullptr) refuse(key, fmt::format("is {}", kind_of(*node)), "a string");
  if (value->get().empty()) refuse(key, "is empty", "a string of at least one character");
  return value->get();
}

std::optional<bool> TomlTable::flag(std::string_view key) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  const auto* value = node->as_boolean();
  if (value == nullptr) refuse(key, fmt::format("is {}", kind_of(*node)), "true or false");
  return value->get();
}

std::optional<std::int64_t> TomlTable::whole(std::string_view key, std::int64_t low, std::int64_t high) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  const std::string expected = fmt::format("a whole number from {} to {}", low, high);
  const auto* value = node->as_integer();
  if (value == nullptr) refuse(key, fmt::format("is {}", kind_of(*node)), expected);
  if (value->get() < low || value->get() > high) refuse(key, fmt::format("= {}", value->get()), expected);
  return value->get();
}

std::optional<double> TomlTable::number(std::string_view key, double low, double high) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  const std::string expected = fmt::format("a number from {} to {}", low, high);
  const std::optional<double> value = node->is_number() ? node->value<double>() : std::nullopt;
  if (!value) refuse(key, fmt::format("is {}", kind_of(*node)), expected);
  if (!(*value >= low && *value <= high)) refuse(key, fmt::format("= {}", *value), expected);
  return value;
}

std::optional<TomlTable> TomlTable::table(std::string_view key) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::nullopt;
  const auto* value = node->as_table();
  if (value == nullptr) refuse(key, fmt::format("is {}", kind_of(*node)), "a table");
  return TomlTable(*value, file_, name_of(key), value->source().begin.line);
}

std::vector<TomlTable> TomlTable::tables(std::string_view key, std::size_t most) {
  const toml::node* node = find(key);
  if (node == nullptr) return {};
  const std::string expected = fmt::format("up to {} tables [[{}]]", most, name_of(key));
  const auto* array = node->as_array();
  if (array == nullptr) refuse(key, fmt::format("is {}", kind_of(*node)), expected);
  if (array->size() > most) refuse(key, fmt::format("has {}", array->size()), expected);
  std::vector<TomlTable> all;
  for (const toml::node& one : *array) {
    const auto* value = one.as_table();
    if (value == nullptr) refuse(key, fmt::format("holds {}", kind_of(one)), expected);
    all.push_back(TomlTable(*value, file_, fmt::format("{}[{}]", name_of(key), all.size() + 1),
                            value->source().begin.line));
  }
  return all;
}

std::optional<std::size_t> TomlTable::choice(std::string_view key,
                                             const std::vector<std::string_view>& names) {
  const std::optional<std::string> word = text(key);
  if (!word) return std::nullopt;
  const auto found = std::find(names.begin(), names.end(), *word);
  if (found == names.end())
    refuse(key, fmt::format("= '{}'", *word), fmt::format("{}", fmt::join(names, ", ")));
  return static_cast<std::size_t>(found - names.begin());
}

void TomlTable::end() const {
  std::string unknown;
  for (const auto& [key, node] : *table_) {
    if (std::find(asked_.begin(), asked_.end(), key.str()) != asked_.end()) continue;
    if (!unknown.empty()) unknown += '\n';
    unknown += fmt::format("{}: line {}: {} is no key of this file, expected {}", file_,
                           key.source().begin.line, name_of(key.str()), fmt::join(asked_, ", "));
  }
  if (!unknown.empty()) throw ConfigError(unknown);
}

}  // namespace plenum::board::config
