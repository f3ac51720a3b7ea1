// The units that the source prints its numbers in, in SI.
#pragma once

namespace plenum::host::plant::relief_valve {

inline constexpr double kInch_m = 0.0254;
inline constexpr double kInch2_m2 = kInch_m * kInch_m;
inline constexpr double kInch3_m3 = kInch_m * kInch_m * kInch_m;
inline constexpr double kPound_kg = 0.45359237;
inline constexpr double kPoundForce_N = kPound_kg * 9.80665;
inline constexpr double kPsi_Pa = kPoundForce_N / kInch2_m2;
inline constexpr double kPoundPerFoot3_kg_m3 = kPound_kg / (1728.0 * kInch3_m3);
inline constexpr double kLitrePerMinute_m3_s = 1e-3 / 60.0;

}  // namespace plenum::host::plant::relief_valve
