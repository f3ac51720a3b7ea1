// Recordings of a component on a test bench, as the commands that identify one take them.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/report/chart.hpp"
#include "host-sim/trace/recording.hpp"

namespace plenum::host::tools {

/// What of each recording is held out where no other recording is: its end.
inline constexpr double kHeldOut = 0.4;
/// Rows before such an end.
std::size_t rows_before(std::size_t rows, double held_out);
/// That a chart shows where it begins.
report::Mark held_out_from(double time_s);

/// When so many rows are, the first of them `first` periods after the recording's [s].
std::vector<double> times_s(std::size_t rows, double period_s, std::size_t first = 0);

/// Does a fit of what is in `file`, whose CannotIdentify then says so.
template <class Work>
void told_of(const std::string& file, Work&& work) {
  try {
    std::forward<Work>(work)();
  } catch (const identify::CannotIdentify& why) {
    throw identify::CannotIdentify(file + ": " + why.what());
  }
}

/// Reads `file` for `plenum COMMAND`; columns that are ignored are told on standard error. Throws trace::InputError.
trace::Recording read_bench(const std::string& command, const std::string& file,
                            const std::vector<std::string>& required,
                            const std::vector<std::string>& optional = {});

/// Sees that all of a column lies from `low` to `high`. Throws trace::InputError that names the first row that does not,
/// and says that `expected` was expected.
void require_between(const trace::Recording& recording, std::string_view column, double low, double high,
                     const std::string& expected);
/// Sees that the times of a column rise, evenly or not. Throws trace::InputError that names the first row that does not.
void require_rising_time(const trace::Recording& recording, std::string_view column);
/// Sees that the column may be absolute pressure: neither gauge pressure nor of another unit. Throws as above.
void require_absolute_pressure(const trace::Recording& recording, std::string_view column, double ambient_Pa);

}  // namespace plenum::host::tools
