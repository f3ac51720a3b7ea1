#include "host-sim/tools/arguments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/tools/command_line.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::tools {
namespace {

namespace fs = std::filesystem;

bool is_folder(const Option& option) {
  return option.type() == "DIR";
}

/// Whether the option, by the type that its help shows, is a file.
bool is_file(const Option& option) {
  constexpr std::array<std::string_view, 5> kTypes{"FILE", ".csv", ".json", ".toml", ".log"};
  const std::string type = option.type();
  return std::any_of(kTypes.begin(), kTypes.end(),
                     [&](std::string_view part) { return type.find(part) != std::string::npos; });
}

bool is_written(const Option& option) {
  const std::vector<std::string> names = option.long_names();
  return std::any_of(names.begin(), names.end(), [](const std::string& name) {
    return name == "json" || name == "out" || name == "report" || name.starts_with("save-");
  });
}

/// Whether what is read there says something only where no fit has seen it.
bool is_apart(const Option& option) {
  const std::vector<std::string> names = option.long_names();
  return std::find(names.begin(), names.end(), "heldout") != names.end();
}

struct Named {
  std::string option;
  fs::path path;
  bool written;
  bool apart;
};

std::vector<Named> files_of(const std::vector<Option>& options) {
  std::vector<Named> files;
  for (const Option& option : options) {
    if (!is_file(option)) continue;
    for (const std::string& value : option.values()) {
      if (value == "-" || value.empty()) continue;
      files.push_back({option.name(), value, is_written(option), is_apart(option)});
    }
  }
  return files;
}

fs::path whole(const fs::path& path) {
  std::error_code error;
  const fs::path found = fs::weakly_canonical(fs::absolute(path, error), error);
  return error ? path : found;
}

bool same_file(const fs::path& one, const fs::path& other) {
  std::error_code error;
  const fs::file_status there = fs::status(one, error);
  if (fs::exists(there) && !fs::is_regular_file(there)) return false;
  return fs::equivalent(one, other, error) || whole(one) == whole(other);
}

/// Whether the command makes the folder of `file` itself.
bool in_folder_to_make(const fs::path& file, const std::vector<Option>& options) {
  return std::any_of(options.begin(), options.end(), [&](const Option& option) {
    if (!is_folder(option) || !is_written(option)) return false;
    const std::vector<std::string> folders = option.values();
    return std::any_of(folders.begin(), folders.end(), [&](const std::string& folder) {
      return whole(folder + "/.") == whole(file.parent_path() / ".");
    });
  });
}

}  // namespace

void require_finite_numbers(const Arguments& command) {
  for (const Option& option : command.options()) {
    if (!option.given() || !option.type().starts_with("FLOAT")) continue;
    if (!std::isfinite(option.number())) {
      throw std::invalid_argument(
          fmt::format("{}: {}, expected a finite number", option.name(), option.values().front()));
    }
  }
}

void require_order(const char* low_option, double low, const char* high_option, double high,
                   const char* unit) {
  if (low < high) return;
  throw std::invalid_argument(fmt::format("{} {} {}, {} {} {}: expected low below high", low_option, low,
                                          unit, high_option, high, unit));
}

void require_files_apart(const Arguments& command) {
  const std::vector<Option> options = command.options();
  const std::vector<Named> files = files_of(options);
  for (auto file = files.begin(); file != files.end(); ++file) {
    if (!file->written && !file->apart) continue;
    const auto same = std::find_if(files.begin(), files.end(), [&](const Named& other) {
      return &other != &*file && same_file(file->path, other.path);
    });
    if (same != files.end()) {
      throw trace::InputError(fmt::format("{} {}: the same file as {}, expected another one{}", file->option,
                                          file->path.string(), same->option,
                                          file->written ? " to write" : ""));
    }
    if (file->written && !in_folder_to_make(file->path, options)) require_writable(file->path);
  }
}

}  // namespace plenum::host::tools
