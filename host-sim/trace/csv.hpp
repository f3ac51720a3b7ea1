// A table of numbers: one header row, comma-separated, every row as long as the header. What log and importer
// share.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace plenum::host::trace {

struct NumberTable {
  std::vector<std::string> names;            ///< of all columns of the file, in its order
  std::vector<std::vector<double>> columns;  ///< as names; empty for a column that was not wanted
  std::size_t rows = 0;
};

/// Position of `name` in the header; throws InputError naming the column when it is missing.
std::size_t column_of(const NumberTable& table, std::string_view name, std::string_view file);

/// The names in the header of `text`, in its order. Throws InputError as parse_numbers() does of a header.
std::vector<std::string> column_names(std::string_view text, std::string_view file);

/// Parses `text`. `wanted(name)` says which columns are numbers to be kept; the others need not be numbers.
///
/// A byte-order mark, CRLF line ends, spaces round a cell, a cell in double quotes (RFC 4180, of one line) and empty lines at
/// the end are tolerated. `notices`, when given, gets a line for each column that was not wanted, and one where the last line
/// has no line end: that row is left out, because a number that was cut short cannot be told from a whole one. Throws
/// InputError naming `file`, the row (1: the first row after the header) and the column for: a cell that is missing, not a
/// number or not finite; a row longer than the header; a file that ends within a row, or without `notices` without a line
/// end; a wanted column that appears twice; no header, a comment for one, or one of semicolons or tabs; no rows; UTF-16.
NumberTable parse_numbers(std::string_view text, std::string_view file,
                          const std::function<bool(std::string_view name)>& wanted,
                          std::vector<std::string>* notices = nullptr);

/// A tick may differ from the usual one by this share before time counts as non-uniform: stamps of 300 Hz that are rounded to
/// milliseconds do by 0.3, a lost row by 1.
inline constexpr double kUniformTolerance = 0.35;

/// The period of a time column [s]. A rate within a billionth of a whole number of hertz is that number, so
/// that rounding of the printed times does not make a 100 Hz log a 99.99999999 Hz log. Throws InputError
/// naming the row where time does not advance as it does in most, with what to do where rows are lost or stamps jitter, and for fewer
/// than two rows.
double uniform_period_s(const std::vector<double>& time_s, std::string_view file);

}  // namespace plenum::host::trace
