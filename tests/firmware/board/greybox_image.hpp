// The image of a grey-box model.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "firmware/config/greybox_parameters.hpp"
#include "firmware/config/model_image.hpp"

namespace plenum {

using Edits = std::vector<std::pair<config::GreyboxParameter, float>>;

/// Of a valve of 60 mL/s a volt, with these figures in place of its own.
inline std::vector<std::uint8_t> greybox_with(const Edits& edits) {
  config::ModelParameters model;
  model.kind = config::ModelKind::greybox;
  model.count = config::kGreyboxParameters;
  model.value = {5.08F, 4.92F, 60.0F, 64.0F, 0.1F, 0.1F, 1.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F,   0.0F,  0.53F,
                 0.5F,  1.0F,  0.0F,  0.0F,  1.4F, 0.0F, 0.0F, 0.0F, 0.8F, 0.0F, 0.0F, 700.0F, 101.3F};
  for (const auto& [which, value] : edits) model.value[which] = value;
  std::vector<std::uint8_t> bytes(config::kMaxImageBytes);
  bytes.resize(config::encode(model, bytes));
  return bytes;
}

}  // namespace plenum
