// All chambers of a board at once.
#pragma once

#include <cstddef>
#include <vector>

#include "host-sim/client/session.hpp"
#include "host-sim/identify/fit.hpp"
#include "host-sim/trace/log.hpp"
#include "host-sim/trace/model_json.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::tools {

/// A bound of what a board in fixed point errs in a tick of this model [kPa]; 0 where none is known.
double fixed_error_kPa(const trace::ModelFile& file);

/// A model file as it is handed to a board, and with it what fixed_error_kPa() says of it. `chamber` from 1.
client::ModelUpload upload_of(const trace::ModelFile& file, unsigned chamber, double fixed_error_kPa);

/// The image of chamber `chamber` (from 1) as a model file that uploads to the same bytes.
trace::ModelFile file_of(std::span<const std::uint8_t> image, unsigned chamber);

}  // namespace plenum::host::tools
