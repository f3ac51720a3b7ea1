// A model as the board has it after its upload.
#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "firmware/config/model_image.hpp"
#include "host-sim/client/model_bytes.hpp"

namespace plenum::host::testing {

/// `kind` and `values` as in a model file. Throws std::invalid_argument saying why the board would refuse them.
inline plenum::config::ModelParameters board_parameters(std::string_view kind,
                                                        std::span<const double> values) {
  plenum::config::ModelParameters parameters;
  const plenum::config::ImageVerdict verdict =
      plenum::config::decode(client::encode_model(kind, values, {}), parameters);
  if (!verdict) {
    throw std::invalid_argument("parameter " + std::to_string(verdict.parameter) + " = " +
                                std::to_string(verdict.value) + " of a " + std::string(kind) + " model " +
                                plenum::config::describe(verdict.error));
  }
  return parameters;
}

}  // namespace plenum::host::testing
