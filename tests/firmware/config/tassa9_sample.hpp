// A tassa9 set like those fitted to an MPYE valve, for the tests of this folder.
#pragma once

#include <cstdint>
#include <vector>

#include "firmware/config/model_image.hpp"

namespace plenum::config {

// Indices of the parameters in the image, stated here a second time on purpose: the order is a contract.
inline constexpr std::size_t kC1 = 0, kC2 = 1, kC3 = 2, kC7 = 6, kC8 = 7, kC9 = 8, kCGamma = 9, kSupply = 10,
                             kAmbient = 11;

inline ModelParameters tassa9_sample() {
  ModelParameters p;
  p.kind = ModelKind::tassa9;
  p.fit_date_s = 1700000000;
  p.fit_error_kPa = 1.25F;
  p.valve_serial = 4711;
  p.sensor_serial = 815;
  p.fixed_error_kPa = 0.0015F;
  p.count = 12;
  p.value = {5.02F, 2.5F, 4.0F, -0.05F, 0.003F, 0.02F, 40.0F, 0.1F, 0.08F, 0.1F, 620.0F, 101.325F};
  return p;
}

inline std::vector<std::uint8_t> image_of(const ModelParameters& parameters) {
  std::vector<std::uint8_t> bytes(kMaxImageBytes);
  bytes.resize(encode(parameters, bytes));
  return bytes;
}

}  // namespace plenum::config
