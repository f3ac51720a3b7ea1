// An admissible model with one parameter changed by name, and what is asked of the image of every kind of model.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string_view>

#include "firmware/config/model_image.hpp"

namespace plenum::config::testing {

/// Where a parameter stands in its kind's schema.
inline std::size_t place_of(ModelKind kind, std::string_view name) {
  const auto schema = parameter_schema(kind);
  for (std::size_t i = 0; i < schema.size(); ++i)
    if (schema[i].name == name) return i;
  ADD_FAILURE() << "no parameter " << name;
  return 0;
}

inline ImageVerdict verdict_with(ModelParameters model, std::string_view name, float value) {
  model.value[place_of(model.kind, name)] = value;
  return validate(model);
}

inline void expect_comes_back(const ModelParameters& model) {
  std::array<std::uint8_t, kMaxImageBytes> bytes{};
  const std::size_t size = encode(model, bytes);
  ASSERT_EQ(size, 32U + 4U * model.count + 4U);
  ModelParameters read;
  ASSERT_TRUE(decode(std::span(bytes).first(size), read));
  EXPECT_EQ(read.kind, model.kind);
  EXPECT_EQ(read.value, model.value);
}

/// That the next floats beyond the range of each parameter are refused by name.
inline void expect_held_to_ranges(const ModelParameters& model) {
  for (const ParameterSpec& spec : parameter_schema(model.kind)) {
    for (const float beyond : {std::nextafter(spec.low, -1e9F), std::nextafter(spec.high, 1e9F)}) {
      const ImageVerdict verdict = verdict_with(model, spec.name, beyond);
      EXPECT_EQ(verdict.error, ImageError::out_of_range) << spec.name;
      EXPECT_EQ(verdict.parameter, place_of(model.kind, spec.name));
      EXPECT_EQ(verdict.value, beyond);
    }
  }
}

inline void expect_supply_above_ambient(const ModelParameters& model) {
  const float ambient_kPa = model.value[place_of(model.kind, "ambient_kPa")];
  const ImageVerdict verdict = verdict_with(model, "supply_kPa", ambient_kPa);
  EXPECT_EQ(verdict.error, ImageError::not_admissible);
  EXPECT_EQ(verdict.parameter, place_of(model.kind, "supply_kPa"));
  EXPECT_EQ(verdict.low, ambient_kPa);
}

}  // namespace plenum::config::testing
