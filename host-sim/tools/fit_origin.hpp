// When and on what a model was fitted, as its file tells it: the date, and the serial numbers of valve and sensor.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "host-sim/tools/command_line.hpp"
#include "host-sim/trace/model_json.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::tools {

/// Declares --date.
void add_fit_date(Arguments& arguments, std::string& date);

/// Seconds since 1970 of `date`, "2026-11-24" or a whole number of seconds; where it is empty of the environment's
/// SOURCE_DATE_EPOCH, so that the same input gives the same file; where there is none of this PC's clock. Throws
/// std::invalid_argument for what is none of them, or beyond the 32 bits that an image has for it.
std::uint32_t fit_date_s(const std::string& date);

/// Writes the date, and the serial numbers that the rig states for the model's chamber, into its `fit`.
void state_origin(trace::ModelFile& model, std::uint32_t date_s, const trace::RigDescription& rig);

}  // namespace plenum::host::tools
