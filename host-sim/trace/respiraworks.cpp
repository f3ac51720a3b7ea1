#include "host-sim/trace/respiraworks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <string>

#include "host-sim/trace/csv.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::trace {
namespace {

constexpr double kCmH2O_Pa = 98.0665;
constexpr double kFullCommand_V = 10.0;

unsigned test_of(const std::filesystem::path& path, const RespiraworksOptions& options) {
  unsigned test = options.test;
  const std::string stem = path.stem().string();
  if (test == 0 && stem.size() >= 2 && stem[stem.size() - 2] == '_' &&
      std::isdigit(static_cast<unsigned char>(stem.back())) != 0) {
    test = static_cast<unsigned>(stem.back() - '0');
  }
  if (test < 1 || test > kTestLungs.size()) {
    throw InputError(fmt::format("{}: test {}, expected 1 to {} (or a name that ends in _1 to _{})",
                                 path.string(), test, kTestLungs.size(), kTestLungs.size()));
  }
  return test;
}

/// The inlet command of a run, by the valve that moves: the solenoid valve of oxygen, or the pinch valve of air.
struct Inlet {
  std::string column;
  const std::vector<double>& command;  ///< 0 to 1
};

Inlet inlet_of(const NumberTable& table, const std::string& file) {
  std::vector<Inlet> moving;
  for (const char* column : {"cmd_psol", "cmd_inh_valve"}) {
    const auto& command = table.columns[column_of(table, column, file)];
    for (std::size_t i = 0; i < command.size(); ++i) {
      if (!(command[i] >= 0.0 && command[i] <= 1.0)) {
        throw InputError(
            fmt::format("{}: row {}, column {}: {}, expected 0 to 1", file, i + 1, column, command[i]));
      }
    }
    if (*std::max_element(command.begin(), command.end()) > 0.0) moving.push_back({column, command});
  }
  if (moving.size() != 1) {
    throw InputError(fmt::format("{}: columns cmd_psol and cmd_inh_valve: {} above 0, expected one of them",
                                 file, moving.empty() ? "neither is" : "both are"));
  }
  return moving.front();
}

/// Refuses a run in which the exhaust valve is not a function of the inlet command.
void check_one_command(const Inlet& inlet, const std::vector<double>& exhaust, double allowed,
                       const std::string& file) {
  struct Span {
    double low;
    double high;
  };
  std::map<double, Span> seen;
  for (std::size_t i = 0; i < inlet.command.size(); ++i) {
    auto& span = seen.try_emplace(inlet.command[i], Span{exhaust[i], exhaust[i]}).first->second;
    span.low = std::min(span.low, exhaust[i]);
    span.high = std::max(span.high, exhaust[i]);
    if (span.high - span.low > allowed) {
      throw InputError(fmt::format(
          "{}: row {}, column cmd_exh_valve: {} to {} at {} = {}, expected a spread of {} at most", file,
          i + 1, span.low, span.high, inlet.column, inlet.command[i], allowed));
    }
  }
}

}  // namespace

Log import_respiraworks(const std::filesystem::path& path, const RespiraworksOptions& options) {
  const std::string file = path.string();
  const TestLung lung = kTestLungs[test_of(path, options) - 1];
  const NumberTable table = parse_numbers(read_whole_file(path), file, [](std::string_view name) {
    return name == "time(sec)" || name == "pressure" || name == "cmd_psol" || name == "cmd_inh_valve" ||
           name == "cmd_exh_valve";
  });
  const auto& time_s = table.columns[column_of(table, "time(sec)", file)];
  const auto& gauge_kPa = table.columns[column_of(table, "pressure", file)];
  const auto& exhaust = table.columns[column_of(table, "cmd_exh_valve", file)];
  const Inlet inlet = inlet_of(table, file);
  check_one_command(inlet, exhaust, options.exhaust_spread, file);

  Log log;
  log.period_s = uniform_period_s(time_s, file);
  log.pressure_average_s = 0.0;
  log.time_s = time_s;
  const double compliance_m3_per_Pa = lung.compliance_mL_per_cmH2O * 1e-6 / kCmH2O_Pa;
  const double equivalent_m3 = options.gas_volume_m3 + compliance_m3_per_Pa * options.ambient_Pa;
  for (std::size_t i = 0; i < gauge_kPa.size(); ++i) {
    log.command_V.push_back(kFullCommand_V * inlet.command[i]);
    log.pressure_Pa.push_back(options.ambient_Pa + 1000.0 * gauge_kPa[i]);
    log.volume_m3.push_back(equivalent_m3);
  }
  return log;
}

}  // namespace plenum::host::trace
