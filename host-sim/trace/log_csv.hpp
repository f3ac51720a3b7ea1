// Logs as comma-separated files: README.md of this room holds the format.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/trace/log.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::trace {

/// Reads a log. The file does not say over which time a pressure was averaged: one whole period is assumed.
/// Unknown columns are ignored, and a last row without line end is left out: each adds a line to `notices` when that is
/// given, without which such a row is refused.
/// Throws InputError naming file, row and column (see parse_numbers), also for fewer than two rows and for
/// time that does not advance uniformly.
Log read_log(const std::filesystem::path& path, std::vector<std::string>* notices = nullptr);

/// Two rates are the same within this share: recorders' clocks differ, stamps and figures are rounded, and a loop that sleeps is late.
/// What is computed from a log runs at its own rate.
inline constexpr double kSameRate = 0.01;

/// Throws InputError naming `file` for a log of another rate than the rig's.
void require_rate(const Log& log, const RigDescription& rig, std::string_view file);

/// Reads a log of this rig: the averaging time is the rig's, and the log's rate must be the rig's (kSameRate).
Log read_log(const std::filesystem::path& path, const RigDescription& rig,
             std::vector<std::string>* notices = nullptr);

/// As read_log, from memory; `file` is the name used in errors.
Log parse_log(std::string_view text, std::string_view file, std::vector<std::string>* notices = nullptr);

/// Writes the columns that are not empty, each number in the shortest form that reads back to the same bits.
/// Throws InputError when a column's length differs from time_s, a number is not finite, or the file cannot
/// be written.
void write_log(const std::filesystem::path& path, const Log& log);

std::string format_log(const Log& log);

}  // namespace plenum::host::trace
