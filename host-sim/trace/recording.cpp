#include "host-sim/trace/recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "host-sim/trace/csv.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::trace {
namespace {

bool among(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

const std::vector<double>& Recording::operator[](std::string_view column) const {
  const auto found = columns.find(column);
  if (found == columns.end())
    throw std::out_of_range(fmt::format("{}: column '{}' was not read", name, column));
  return found->second;
}

Recording read_recording(const std::filesystem::path& path, const std::vector<std::string>& required,
                         const std::vector<std::string>& optional, std::vector<std::string>& notices) {
  const auto wanted = [&](std::string_view name) { return among(required, name) || among(optional, name); };
  const std::string file = path.string();
  NumberTable table = parse_numbers(read_whole_file(path), file, wanted, &notices);
  for (const std::string& name : required) static_cast<void>(column_of(table, name, file));
  Recording recording{.name = path.filename().string(), .rows = table.rows, .columns = {}};
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    if (wanted(table.names[i])) recording.columns.emplace(table.names[i], std::move(table.columns[i]));
  }
  return recording;
}

bool has_columns(const std::filesystem::path& path, const std::vector<std::string>& columns) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;  // what is read from a pipe is gone
  const std::vector<std::string> names = column_names(read_whole_file(path), path.string());
  return std::all_of(columns.begin(), columns.end(),
                     [&](const std::string& name) { return among(names, name); });
}

double period_s(const Recording& recording) {
  return uniform_period_s(recording["time_s"], recording.name);
}

}  // namespace plenum::host::trace
