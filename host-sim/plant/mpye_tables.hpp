// The measured parameters of a FESTO MPYE-5-3/8-010-B valve at 7 bar absolute supply, as printed.
// Source: "Parameter Identification and Evaluation of a Proportional Directional Flow Control Valve Model",
// Tables 1 to 5. Rows are at 0, 0.2 .. 10 V. A row with area 0 was not measured; its other figures are
// placeholders.
#pragma once

#include <array>
#include <cstddef>

namespace plenum::host::plant {

struct MpyeRow {
  double area_m2;         ///< A, effective orifice area
  double critical_ratio;  ///< b
  double cracking_ratio;  ///< a
  double subsonic_index;  ///< beta
};

inline constexpr std::size_t kMpyeRows = 51;
inline constexpr double kMpyeStep_V = 0.2;
using MpyeTable = std::array<MpyeRow, kMpyeRows>;

inline constexpr double kMpyeDischargeCoefficient = 0.575;  ///< C_d, Table 1
inline constexpr double kMpyeChargeExponent = 1.4;          ///< alpha_in, Table 1
inline constexpr double kMpyeDischargeExponent = 1.0;       ///< alpha_ex, Table 1

extern const MpyeTable kMpyeChannelAInlet;    ///< Table 2
extern const MpyeTable kMpyeChannelAExhaust;  ///< Table 3
extern const MpyeTable kMpyeChannelBInlet;    ///< Table 4
extern const MpyeTable kMpyeChannelBExhaust;  ///< Table 5

}  // namespace plenum::host::plant
