// What a grey-box model makes of its parameters before any tick: its tables, as the board has them in Q31.32 and as double has
// them. The core's own sources compiled once for each (CMakeLists.txt), so that nothing of a table has to be bounded.
#pragma once

#include <span>
#include <vector>

namespace rounding {

struct GreyboxTables {
  /// phi(P, p) of one P.
  struct Curve {
    std::vector<double> corner_kPa;  ///< rising
    std::vector<double> flow_kPa;    ///< there
    std::vector<double> slope;       ///< from a corner to the next
  };
  /// Conductances [L/s], or their slopes [L/(s V)].
  struct Ports {
    double inlet = 0, exhaust = 0;
  };

  Curve inlet, exhaust;
  double leak_L_s_kPa = 0;     ///< C_l/(2 P_r)
  double gap_kPa = 0;          ///< beyond it that flow goes on straight
  std::vector<double> node_V;  ///< rising
  std::vector<Ports> node;
  std::vector<Ports> slope;  ///< from a node to the next
  double tick_s_mL_L =
      0;  ///< h times 1000 mL/L: divided by a volume [mL], what the end gains by a flow [s/L]
  double least_volume_mL = 0;  ///< a smaller one counts as that
  double dead_volume_mL = 0, volume_exponent = 1, supply_kPa = 0, ambient_kPa = 0;
};

/// Of the parameters in image order, over commands of 0 to 10 V.
GreyboxTables greybox_in_fixed(std::span<const float> parameters);
GreyboxTables greybox_in_double(std::span<const float> parameters);

}  // namespace rounding
