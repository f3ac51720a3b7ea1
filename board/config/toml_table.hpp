// One table of a TOML document, asked key by key. What is wrong is told with file, line, key and what was expected; a key
// that nobody asked for is wrong, too.
#pragma once

#include <toml++/toml.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace plenum::board::config {

/// "FILE: line N: TABLE.KEY ...: found, expected ...", a line each where there are several.
struct ConfigError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The document in `text`. Throws ConfigError. `file` names it in errors, here and in the tables of it.
toml::table parse_toml(std::string_view text, const std::string& file);

/// Refers to the document, which must outlive it. All members throw ConfigError.
class TomlTable {
 public:
  /// The document itself.
  TomlTable(const toml::table& document, std::string file) : TomlTable(document, std::move(file), "", 0) {}

  // Each is empty when the key is not there.
  std::optional<std::string> text(std::string_view key);
  std::optional<bool> flag(std::string_view key);
  std::optional<std::int64_t> whole(std::string_view key, std::int64_t low, std::int64_t high);
  std::optional<double> number(std::string_view key, double low, double high);
  std::optional<TomlTable> table(std::string_view key);
  /// The tables [[key]], in order; none when the key is not there.
  std::vector<TomlTable> tables(std::string_view key, std::size_t most);
  /// Which of `names` the text is.
  std::optional<std::size_t> choice(std::string_view key, const std::vector<std::string_view>& names);

  /// The value, or a refusal because the key is missing.
  template <typename Value>
  Value need(std::string_view key, std::optional<Value> value, std::string_view expected) const {
    if (!value) refuse(key, "is missing", expected);
    return *std::move(value);
  }

  /// Refuses every key that was not asked for.
  void end() const;

  /// Throws: at the line of the key, or of the table where the key is not there.
  [[noreturn]] void refuse(std::string_view key, std::string_view found, std::string_view expected) const;

 private:
  TomlTable(const toml::table& table, std::string file, std::string name, std::size_t line)
      : table_(&table), file_(std::move(file)), name_(std::move(name)), line_(line) {}

  const toml::node* find(std::string_view key);
  std::string name_of(std::string_view key) const;

  const toml::table* table_;
  std::string file_;
  std::string name_;  ///< "chamber[2].pressure"; empty: the document
  std::size_t line_;  ///< where the table begins; 0: the document
  std::vector<std::string> asked_;
};

}  // namespace plenum::board::config
