#include "host-sim/trace/csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/legible.hpp"

namespace plenum::host::trace {
namespace {

std::string_view trimmed(std::string_view cell) {
  while (!cell.empty() && (cell.front() == ' ' || cell.front() == '\t')) cell.remove_prefix(1);
  while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\t')) cell.remove_suffix(1);
  return cell;
}

/// Takes one line off the front of `text`, without its line end. `ended`: whether it had one.
std::string_view take_line(std::string_view& text, bool& ended) {
  const std::size_t end = text.find('\n');
  ended = end != std::string_view::npos;
  std::string_view line = text.substr(0, end);
  text.remove_prefix(ended ? end + 1 : text.size());
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

std::vector<std::string> parse_header(std::string_view line, std::string_view file) {
  std::vector<std::string> names;
  for (;;) {
    const std::size_t comma = line.find(',');
    names.emplace_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) break;
    line.remove_prefix(comma + 1);
  }
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), names[i]) !=
        names.begin() + static_cast<std::ptrdiff_t>(i)) {
      throw InputError(
          fmt::format("{}: header: column '{}' appears twice, expected once", file, legible(names[i])));
    }
  }
  return names;
}

double parse_cell(std::string_view cell, std::string_view file, std::size_t row, const std::string& name) {
  cell = trimmed(cell);
  if (cell.empty()) {
    throw InputError(fmt::format("{}: row {}, column {}: missing, expected a number", file, row, name));
  }
  double value = 0.0;
  const char* first = cell.data() + (cell.front() == '+' ? 1 : 0);
  const char* last = cell.data() + cell.size();
  const auto [end, error] = std::from_chars(first, last, value);
  if (end != last || (error != std::errc{} && error != std::errc::result_out_of_range)) {
    throw InputError(
        fmt::format("{}: row {}, column {}: '{}', expected a number", file, row, name, legible(cell)));
  }
  if (error == std::errc::result_out_of_range || !std::isfinite(value)) {
    throw InputError(
        fmt::format("{}: row {}, column {}: '{}', expected a finite number", file, row, name, legible(cell)));
  }
  return value;
}

}  // namespace

std::size_t column_of(const NumberTable& table, std::string_view name, std::string_view file) {
  const auto found = std::find(table.names.begin(), table.names.end(), name);
  if (found == table.names.end()) {
    throw InputError(fmt::format("{}: header: column '{}' is missing, expected among: {}", file, name,
                                 legible_list(table.names)));
  }
  return static_cast<std::size_t>(found - table.names.begin());
}

NumberTable parse_numbers(std::string_view text, std::string_view file,
                          const std::function<bool(std::string_view name)>& wanted) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  if (text.empty()) throw InputError(fmt::format("{}: empty, expected a header row", file));
  NumberTable table;
  bool ended = false;
  const std::string_view header = take_line(text, ended);
  table.names = parse_header(header, file);
  const std::size_t width = table.names.size();
  table.columns.resize(width);
  std::vector<char> keep(width);
  const auto expected_rows = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  for (std::size_t i = 0; i < width; ++i) {
    keep[i] = wanted(table.names[i]) ? 1 : 0;
    if (keep[i] != 0) table.columns[i].reserve(expected_rows);
  }
  while (!text.empty()) {
    std::string_view line = take_line(text, ended);
    const std::size_t row = table.rows + 1;
    if (!ended) {
      throw InputError(fmt::format(
          "{}: row {}: the file ends within this line, expected a line end (truncated?)", file, row));
    }
    for (std::size_t i = 0; i < width; ++i) {
      const std::size_t comma = line.find(',');
      if (keep[i] != 0)
        table.columns[i].push_back(parse_cell(line.substr(0, comma), file, row, table.names[i]));
      if (comma != std::string_view::npos) {
        line.remove_prefix(comma + 1);
        if (i + 1 == width) {
          throw InputError(fmt::format("{}: row {}: more than {} cells, expected as many as the header has",
                                       file, row, width));
        }
      } else if (i + 1 < width) {
        throw InputError(fmt::format("{}: row {}, column {}: missing, expected a number", file, row,
                                     legible(table.names[i + 1])));
      }
    }
    ++table.rows;
  }
  if (table.rows == 0)
    throw InputError(fmt::format("{}: no rows after the header, expected one a tick", file));
  return table;
}

double uniform_period_s(const std::vector<double>& time_s, std::string_view file) {
  if (time_s.size() < 2) {
    throw InputError(fmt::format("{}: {} row, expected at least 2 to know the rate", file, time_s.size()));
  }
  const double first_s = time_s[1] - time_s[0];
  if (!(first_s > 0.0)) {
    throw InputError(fmt::format("{}: row 2, column time_s: {} after {}, expected time to advance", file,
                                 time_s[1], time_s[0]));
  }
  for (std::size_t i = 2; i < time_s.size(); ++i) {
    const double step_s = time_s[i] - time_s[i - 1];
    if (!(std::abs(step_s - first_s) <= kUniformTolerance * first_s)) {
      throw InputError(
          fmt::format("{}: row {}, column time_s: {} after {}, expected a step of {:.6g} s as before", file,
                      i + 1, time_s[i], time_s[i - 1], first_s));
    }
  }
  const double period_s = (time_s.back() - time_s.front()) / static_cast<double>(time_s.size() - 1);
  const double whole_Hz = std::round(1.0 / period_s);
  return std::abs(whole_Hz * period_s - 1.0) < 1e-9 ? 1.0 / whole_Hz : period_s;
}

}  // namespace plenum::host::trace
