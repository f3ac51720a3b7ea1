#include "host-sim/trace/log_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "host-sim/trace/csv.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::trace {
namespace {

struct Column {
  std::string_view name;
  std::vector<double> Log::*values;
  bool required;
};

constexpr std::array<Column, 8> kColumns{{
    {"time_s", &Log::time_s, true},
    {"command_V", &Log::command_V, true},
    {"pressure_Pa", &Log::pressure_Pa, true},
    {"volume_m3", &Log::volume_m3, true},
    {"supply_Pa", &Log::supply_Pa, false},
    {"position_m", &Log::position_m, false},
    {"temperature_K", &Log::temperature_K, false},
    {"reference_Pa", &Log::reference_Pa, false},
}};

bool known(std::string_view name) {
  return std::any_of(kColumns.begin(), kColumns.end(),
                     [&](const Column& column) { return column.name == name; });
}

}  // namespace

Log parse_log(std::string_view text, std::string_view file, std::vector<std::string>* notices) {
  NumberTable table = parse_numbers(text, file, known, notices);
  Log log;
  for (const Column& column : kColumns) {
    if (column.required ||
        std::find(table.names.begin(), table.names.end(), column.name) != table.names.end()) {
      log.*column.values = std::move(table.columns[column_of(table, column.name, file)]);
    }
  }
  log.period_s = uniform_period_s(log.time_s, file);
  log.pressure_average_s = log.period_s;
  return log;
}

Log read_log(const std::filesystem::path& path, std::vector<std::string>* notices) {
  return parse_log(read_whole_file(path), path.string(), notices);
}

void require_rate(const Log& log, const RigDescription& rig, std::string_view file) {
  const double rate_Hz = 1.0 / log.period_s;
  const double expected_Hz = rig.sampling.rate_Hz;
  const auto is_it = [&](double one_Hz) { return std::abs(one_Hz - expected_Hz) <= kSameRate * expected_Hz; };
  if (is_it(rate_Hz)) return;
  constexpr double kMillisecondsPerSecond = 1e3;
  if (is_it(kMillisecondsPerSecond * rate_Hz)) {
    throw InputError(fmt::format(
        "{}: column time_s: {:.6g} Hz, looks like milliseconds, expected the rig's sampling.rate_Hz = {:.6g}",
        file, rate_Hz, expected_Hz));
  }
  throw InputError(
      fmt::format("{}: column time_s: {:.6g} Hz, expected the rig's sampling.rate_Hz = {:.6g} within {:g} %: "
                  "where the log is right, correct the rig",
                  file, rate_Hz, expected_Hz, 100.0 * kSameRate));
}

Log read_log(const std::filesystem::path& path, const RigDescription& rig,
             std::vector<std::string>* notices) {
  Log log = read_log(path, notices);
  require_rate(log, rig, path.string());
  log.pressure_average_s = std::min(rig.sampling.pressure_average_s, log.period_s);  // a clock may be fast
  return log;
}

std::string format_log(const Log& log) {
  std::vector<const Column*> present;
  for (const Column& column : kColumns) {
    const auto& values = log.*column.values;
    if (values.empty() && !column.required) continue;
    if (values.size() != log.size()) {
      throw InputError(fmt::format("log to write: column {}: {} rows, expected {} as in time_s", column.name,
                                   values.size(), log.size()));
    }
    present.push_back(&column);
  }
  std::string text;
  text.reserve(log.size() * present.size() * 20 + 200);
  for (const Column* column : present) {
    if (!text.empty()) text += ',';
    text += column->name;
  }
  text += '\n';
  std::array<char, 32> digits{};
  for (std::size_t row = 0; row < log.size(); ++row) {
    for (std::size_t i = 0; i < present.size(); ++i) {
      const double value = (log.*present[i]->values)[row];
      if (!std::isfinite(value)) {
        throw InputError(fmt::format("log to write: row {}, column {}: {}, expected a finite number", row + 1,
                                     present[i]->name, value));
      }
      const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
      if (i != 0) text += ',';
      text.append(digits.data(), end);
    }
    text += '\n';
  }
  return text;
}

void write_log(const std::filesystem::path& path, const Log& log) {
  write_whole_file(path, format_log(log));
}

}  // namespace plenum::host::trace
