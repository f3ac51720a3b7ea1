#include "host-sim/trace/csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
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

/// Where the cell at the front of `line` ends: at the next comma that stands in no quotes, or npos.
std::size_t end_of_cell(std::string_view line) {
  const std::size_t first = line.find_first_not_of(" \t");
  if (first == std::string_view::npos || line[first] != '"') return line.find(',');
  bool quoted = false;  // a doubled quote within closes and opens again
  for (std::size_t i = first; i < line.size(); ++i) {
    if (line[i] == '"') quoted = !quoted;
    if (line[i] == ',' && !quoted) return i;
  }
  return std::string_view::npos;
}

/// What a cell holds, without the spaces and the quotes round it.
std::string_view content(std::string_view cell) {
  cell = trimmed(cell);
  if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"')
    cell = trimmed(cell.substr(1, cell.size() - 2));
  return cell;
}

std::vector<std::string> parse_header(std::string_view line) {
  std::vector<std::string> names;
  for (;;) {
    const std::size_t comma = end_of_cell(line);
    names.emplace_back(content(line.substr(0, comma)));
    if (comma == std::string_view::npos) return names;
    line.remove_prefix(comma + 1);
  }
}

std::size_t cells_of(std::string_view line) {
  std::size_t cells = 1;
  for (std::size_t comma = end_of_cell(line); comma != std::string_view::npos; comma = end_of_cell(line)) {
    line.remove_prefix(comma + 1);
    ++cells;
  }
  return cells;
}

double parse_cell(std::string_view cell, std::string_view file, std::size_t row, const std::string& name) {
  cell = content(cell);
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

/// "Pressure [kPa]" is of the quantity of "pressure_Pa".
bool same_quantity(std::string_view column, std::string_view name) {
  const std::string_view quantity = name.substr(0, name.rfind('_'));
  return std::equal(quantity.begin(), quantity.end(), column.substr(0, quantity.size()).begin(),
                    column.substr(0, quantity.size()).end(), [](char a, char b) {
                      return std::tolower(static_cast<unsigned char>(a)) ==
                             std::tolower(static_cast<unsigned char>(b));
                    });
}

/// By its byte-order mark, or by the half of its first character that is 0.
bool looks_like_utf16(std::string_view text) {
  return text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF") ||
         text.substr(0, 2).find('\0') != std::string_view::npos;
}

/// Takes the header off the front of `text`.
std::vector<std::string> take_header(std::string_view& text, std::string_view file) {
  if (looks_like_utf16(text)) {
    throw InputError(fmt::format("{}: looks like UTF-16, expected UTF-8", file));
  }
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  if (text.empty()) throw InputError(fmt::format("{}: empty, expected a header row", file));
  bool ended = false;
  const std::string_view header = take_line(text, ended);
  if (header.starts_with('#')) {
    throw InputError(fmt::format("{}: header: '{}' is a comment, expected the names of the columns", file,
                                 legible(header)));
  }
  std::vector<std::string> names = parse_header(header);
  if (const auto at = names.front().find_first_of(";\t"); names.size() == 1 && at != std::string::npos) {
    throw InputError(
        fmt::format("{}: header: columns are separated by {}, expected commas, and decimal points in numbers",
                    file, names.front()[at] == ';' ? "semicolons" : "tabs"));
  }
  return names;
}

/// For steps of time of which so many are off the usual one.
std::string remedy(std::ptrdiff_t off, std::size_t steps, bool longer) {
  constexpr double kFewLost = 0.01;  // of the steps; where more are off, the stamps jitter
  if (off > 1 && static_cast<double>(off) > kFewLost * static_cast<double>(steps)) {
    return fmt::format("; {} of {} steps are off: resample the log at a uniform rate", off, steps);
  }
  return longer ? "; where rows are missing, split the log and give both parts" : "";
}

}  // namespace

std::size_t column_of(const NumberTable& table, std::string_view name, std::string_view file) {
  const auto found = std::find(table.names.begin(), table.names.end(), name);
  if (found == table.names.end()) {
    const auto like = std::find_if(table.names.begin(), table.names.end(),
                                   [&](const std::string& other) { return same_quantity(other, name); });
    if (like != table.names.end()) {
      const std::size_t unit = name.rfind('_');
      throw InputError(
          fmt::format("{}: header: found column '{}', expected '{}'{}", file, legible(*like), name,
                      unit == std::string_view::npos ? "" : fmt::format(", in {}", name.substr(unit + 1))));
    }
    throw InputError(fmt::format("{}: header: column '{}' is missing, expected among: {}", file, name,
                                 legible_list(table.names)));
  }
  return static_cast<std::size_t>(found - table.names.begin());
}

std::vector<std::string> column_names(std::string_view text, std::string_view file) {
  return take_header(text, file);
}

NumberTable parse_numbers(std::string_view text, std::string_view file,
                          const std::function<bool(std::string_view name)>& wanted,
                          std::vector<std::string>* notices) {
  NumberTable table;
  table.names = take_header(text, file);
  const std::size_t width = table.names.size();
  table.columns.resize(width);
  std::vector<char> keep(width);
  const auto expected_rows = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  for (std::size_t i = 0; i < width; ++i) {
    keep[i] = wanted(table.names[i]) ? 1 : 0;
    if (keep[i] == 0) {
      if (notices != nullptr) {
        notices->push_back(
            fmt::format("{}: column '{}' is not asked for and is ignored", file, legible(table.names[i])));
      }
      continue;
    }
    if (std::count(table.names.begin(), table.names.end(), table.names[i]) > 1) {
      throw InputError(
          fmt::format("{}: header: column '{}' appears twice, expected once", file, legible(table.names[i])));
    }
    table.columns[i].reserve(expected_rows);
  }
  // Empty lines at the end are no rows; elsewhere one is a row without cells.
  while (text.find_first_not_of(" \t\r\n") != std::string_view::npos) {
    bool ended = false;
    std::string_view line = take_line(text, ended);
    const std::size_t row = table.rows + 1;
    if (!ended) {
      if (notices == nullptr || cells_of(line) != width) {
        throw InputError(fmt::format(
            "{}: row {}: the file ends within this line, expected a line end (truncated?)", file, row));
      }
      notices->push_back(
          fmt::format("{}: row {}, the last, has no line end (truncated?) and is left out", file, row));
      break;
    }
    if (trimmed(line).empty()) {
      throw InputError(fmt::format("{}: row {}, column {}: missing, the line is empty, expected {} cells",
                                   file, row, legible(table.names.front()), width));
    }
    for (std::size_t i = 0; i < width; ++i) {
      const std::size_t comma = end_of_cell(line);
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
  std::vector<double> steps_s;
  steps_s.reserve(time_s.size());
  for (std::size_t i = 1; i < time_s.size(); ++i) {
    steps_s.push_back(time_s[i] - time_s[i - 1]);
    if (!(steps_s.back() > 0.0)) {
      throw InputError(fmt::format("{}: row {}, column time_s: {} after {}, expected time to advance", file,
                                   i + 1, time_s[i], time_s[i - 1]));
    }
  }
  const auto middle = steps_s.begin() + static_cast<std::ptrdiff_t>((steps_s.size() - 1) / 2);
  std::nth_element(steps_s.begin(), middle, steps_s.end());
  const double usual_s = *middle;
  const auto off = std::count_if(steps_s.begin(), steps_s.end(), [&](double step_s) {
    return !(std::abs(step_s - usual_s) <= kUniformTolerance * usual_s);
  });
  for (std::size_t i = 1; i < time_s.size(); ++i) {
    const double longer_s = time_s[i] - time_s[i - 1] - usual_s;
    if (!(std::abs(longer_s) <= kUniformTolerance * usual_s)) {
      throw InputError(fmt::format(
          "{}: row {}, column time_s: {} after {}, expected a step of {:.6g} s as in most rows{}", file,
          i + 1, time_s[i], time_s[i - 1], usual_s, remedy(off, steps_s.size(), longer_s > 0.0)));
    }
  }
  const double period_s = (time_s.back() - time_s.front()) / static_cast<double>(time_s.size() - 1);
  const double whole_Hz = std::round(1.0 / period_s);
  return std::abs(whole_Hz * period_s - 1.0) < 1e-9 ? 1.0 / whole_Hz : period_s;
}

}  // namespace plenum::host::trace
