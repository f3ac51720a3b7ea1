// The bus speaks Pa and m3, as SI has them; the core computes in kPa and mL, whose numbers suit a float and fit a fixed-point one.
#pragma once

#include "firmware/numeric/scalar.hpp"

namespace plenum::config {

inline constexpr float kPascal_per_kPa = 1000.0F;  ///< [Pa/kPa]
inline constexpr float kM3_per_mL = 1e-6F;         ///< [m3/mL]
inline constexpr float kVolt_per_V = 1.0F;         ///< the bus, too, speaks volts

/// What the core says, kept in its unit; it reads in SI, as the bus shows it. Who reads converts: in most ticks nobody does, and a
/// board without floating point would spend a call on each product.
template <const float& kSi_per_unit>
class InSi {
 public:
  constexpr InSi(float si = 0.0F) noexcept : in_core_(numeric::Scalar(si / kSi_per_unit)) {}
  static constexpr InSi of_core(numeric::Scalar in_core) noexcept {
    InSi value;
    value.in_core_ = in_core;
    return value;
  }

  constexpr numeric::Scalar in_core() const noexcept { return in_core_; }
  constexpr operator float() const noexcept { return static_cast<float>(in_core_) * kSi_per_unit; }

 private:
  numeric::Scalar in_core_;
};
using Pascals = InSi<kPascal_per_kPa>;
using CubicMetres = InSi<kM3_per_mL>;
using Volts = InSi<kVolt_per_V>;

}  // namespace plenum::config
