// The bus speaks Pa and m3, as SI has them; the core computes in kPa and mL, whose numbers suit a float.
#pragma once

namespace plenum::config {

inline constexpr float kPascal_per_kPa = 1000.0F;  ///< [Pa/kPa]
inline constexpr float kM3_per_mL = 1e-6F;         ///< [m3/mL]
inline constexpr float kMl_per_m3 = 1e6F;          ///< [mL/m3]; not 1/kM3_per_mL, which a float does not hold

}  // namespace plenum::config
