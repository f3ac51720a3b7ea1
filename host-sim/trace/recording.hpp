// A recording of a component on a test bench: columns of numbers that its reader knows by name.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace plenum::host::trace {

struct Recording {
  std::string name;  ///< of its file, without the folder
  std::size_t rows = 0;
  std::map<std::string, std::vector<double>, std::less<>> columns;  ///< each of `rows` finite numbers

  /// Throws std::out_of_range for a column that was not read.
  const std::vector<double>& operator[](std::string_view column) const;
};

/// Reads the columns `required`, and of those in `optional` what the file has; `notices` tells of others, which are
/// ignored, and of a last row that is left out. Throws InputError naming file, row and column as parse_numbers().
Recording read_recording(const std::filesystem::path& path, const std::vector<std::string>& required,
                         const std::vector<std::string>& optional, std::vector<std::string>& notices);

/// Whether `path` is a regular file whose header names these columns. Throws InputError as column_names().
bool has_columns(const std::filesystem::path& path, const std::vector<std::string>& columns);

/// The period of its column time_s [s]. Throws InputError as uniform_period_s().
double period_s(const Recording& recording);

}  // namespace plenum::host::trace
