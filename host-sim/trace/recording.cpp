#include "host-sim/trace/recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "host-sim/trace/csv.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::trace {

const std::vector<double>& Recording::operator[](std::string_view column) const {
  const auto found = columns.find(column);
  if (found == columns.end())
    throw std::out_of_range(fmt::format("{}: column '{}' was not read", name, column));
  return found->second;
}

Recording read_recording(const std::filesystem::path& path, const std::vector<std::string>& required,
                         const std::vector<std::string>& optional, std::vector<std::string>& notices) {
  const auto among = [](const std::vector<std::string>& names, std::string_view name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
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

double period_s(const Recording& recording) {
  return uniform_period_s(recording["time_s"], recording.name);
}

}  // namespace plenum::host::trace
