#include "host-sim/tools/arguments.hpp"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/tools/output.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::tools {
namespace {

namespace fs = std::filesystem;

/// The options of `command` and of its subcommands that were named.
std::vector<const CLI::Option*> options_of(const CLI::App& command) {
  std::vector<const CLI::Option*> options = command.get_options();
  for (const CLI::App* of : command.get_subcommands()) {
    const std::vector<const CLI::Option*> more = options_of(*of);
    options.insert(options.end(), more.begin(), more.end());
  }
  return options;
}

std::vector<std::string> values_of(const CLI::Option& option) {
  if (option.count() > 0) return option.results();
  return option.get_default_str().empty() ? std::vector<std::string>{}
                                          : std::vector<std::string>{option.get_default_str()};
}

bool is_folder(const CLI::Option& option) {
  return option.get_type_name() == "DIR";
}

/// Whether the option, by the type that its help shows, is a file.
bool is_file(const CLI::Option& option) {
  constexpr std::array<std::string_view, 5> kTypes{"FILE", ".csv", ".json", ".toml", ".log"};
  const std::string type = option.get_type_name();
  return std::any_of(kTypes.begin(), kTypes.end(),
                     [&](std::string_view part) { return type.find(part) != std::string::npos; });
}

bool is_written(const CLI::Option& option) {
  const auto& names = option.get_lnames();
  return std::any_of(names.begin(), names.end(), [](const std::string& name) {
    return name == "json" || name == "out" || name == "report" || name.starts_with("save-");
  });
}

struct Named {
  std::string option;
  fs::path path;
  bool written;
};

std::vector<Named> files_of(const std::vector<const CLI::Option*>& options) {
  std::vector<Named> files;
  for (const CLI::Option* const option : options) {
    if (!is_file(*option)) continue;
    for (const std::string& value : values_of(*option)) {
      if (value != "-" && !value.empty()) files.push_back({option->get_name(), value, is_written(*option)});
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
bool in_folder_to_make(const fs::path& file, const std::vector<const CLI::Option*>& options) {
  return std::any_of(options.begin(), options.end(), [&](const CLI::Option* option) {
    if (!is_folder(*option) || !is_written(*option)) return false;
    const std::vector<std::string> folders = values_of(*option);
    return std::any_of(folders.begin(), folders.end(), [&](const std::string& folder) {
      return whole(folder + "/.") == whole(file.parent_path() / ".");
    });
  });
}

}  // namespace

void require_finite_numbers(const CLI::App& command) {
  for (const CLI::Option* const option : options_of(command)) {
    if (option->count() == 0 || !option->get_type_name().starts_with("FLOAT")) continue;
    if (!std::isfinite(option->as<double>())) {
      throw std::invalid_argument(
          fmt::format("{}: {}, expected a finite number", option->get_name(), option->results().front()));
    }
  }
}

void require_files_apart(const CLI::App& command) {
  const std::vector<const CLI::Option*> options = options_of(command);
  const std::vector<Named> files = files_of(options);
  for (auto file = files.begin(); file != files.end(); ++file) {
    if (!file->written) continue;
    const auto same = std::find_if(files.begin(), files.end(), [&](const Named& other) {
      return &other != &*file && same_file(file->path, other.path);
    });
    if (same != files.end()) {
      throw trace::InputError(fmt::format("{} {}: the same file as {}, expected another one to write",
                                          file->option, file->path.string(), same->option));
    }
    if (!in_folder_to_make(file->path, options)) require_writable(file->path);
  }
}

}  // namespace plenum::host::tools
