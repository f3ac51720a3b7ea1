#include "host-sim/tools/bench_input.hpp"

#include <fmt/format.h>

#include <cmath>

#include "host-sim/trace/input_error.hpp"

namespace plenum::host::tools {

std::size_t rows_before(std::size_t rows, double held_out) {
  return static_cast<std::size_t>(std::lround((1.0 - held_out) * static_cast<double>(rows)));
}

report::Mark held_out_from(double time_s) {
  return {report::Mark::On::kX, time_s, "held out from here"};
}

std::vector<double> times_s(std::size_t rows, double period_s, std::size_t first) {
  std::vector<double> times(rows);
  for (std::size_t k = 0; k < rows; ++k) times[k] = period_s * static_cast<double>(first + k);
  return times;
}

trace::Recording read_bench(const std::string& command, const std::string& file,
                            const std::vector<std::string>& required,
                            const std::vector<std::string>& optional) {
  std::vector<std::string> notices;
  trace::Recording recording = trace::read_recording(file, required, optional, notices);
  for (const std::string& notice : notices) fmt::print(stderr, "plenum {}: {}\n", command, notice);
  return recording;
}

void require_between(const trace::Recording& recording, std::string_view column, double low, double high,
                     const std::string& expected) {
  const std::vector<double>& values = recording[column];
  for (std::size_t row = 0; row < values.size(); ++row) {
    if (values[row] >= low && values[row] <= high) continue;
    throw trace::InputError(fmt::format("{}: row {}, column {}: {:g}, expected {}", recording.name, row + 1,
                                        column, values[row], expected));
  }
}

void require_rising_time(const trace::Recording& recording, std::string_view column) {
  const std::vector<double>& t = recording[column];
  for (std::size_t row = 1; row < t.size(); ++row) {
    if (t[row] > t[row - 1]) continue;
    throw trace::InputError(fmt::format("{}: row {}, column {}: {:g} after {:g}, expected time to rise",
                                        recording.name, row + 1, column, t[row], t[row - 1]));
  }
}

void require_absolute_pressure(const trace::Recording& recording, std::string_view column,
                               double ambient_Pa) {
  constexpr double kLeastAbsolute = 0.5;  // of the ambient pressure
  constexpr double kGreatest_Pa = 1e8;
  require_between(recording, column, kLeastAbsolute * ambient_Pa, kGreatest_Pa,
                  "absolute pressure in Pa, not below the ambient's");
}

}  // namespace plenum::host::tools
