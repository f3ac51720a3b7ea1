// Recordings of a component on a test bench, as the commands that identify one take them.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/trace/recording.hpp"

namespace plenum::host::tools {

/// What of each recording is held out where no other recording is: its end.
inline constexpr double kHeldOut = 0.4;
/// Rows before such an end.
std::size_t rows_before(std::size_t rows, double held_out);

/// Reads `file` for `plenum COMMAND`; columns that are ignored are told on standard error. Throws trace::InputError.
trace::Recording read_bench(const std::string& command, const std::string& file,
                            const std::vector<std::string>& required,
                            const std::vector<std::string>& optional = {});

/// Sees that all of a column lies from `low` to `high`. Throws trace::InputError that names the first row that does not,
/// and says that `expected` was expected.
void require_between(const trace::Recording& recording, std::string_view column, double low, double high,
                     const std::string& expected);
/// Sees that the column may be absolute pressure: neither gauge pressure nor of another unit. Throws as above.
void require_absolute_pressure(const trace::Recording& recording, std::string_view column, double ambient_Pa);

}  // namespace plenum::host::tools
