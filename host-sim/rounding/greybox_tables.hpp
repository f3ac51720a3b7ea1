// What a grey-box model makes of its parameters before any tick: its tables, as the board has them in Q31.32 and as double has
// them. The core's own sources compiled once for each (CMakeLists.txt), so that nothing of a table has to be bounded.
#pragma once

#include <span>
#include <vector>

namespace rounding {

struct GreyboxTables {
  /// phi(P_c, p), phi(P_r, p) [kPa] and C_l lambda [kPa L/s]; or the slopes of these, per kPa.
  struct Flows {
    double inlet = 0, exhaust = 0, leak = 0;
  };
  /// Conductances [L/s], or their slopes [L/(s V)].
  struct Ports {
    double inlet = 0, exhaust = 0;
  };

  std::vector<double> corner_kPa;  ///< rising
  std::vector<Flows> corner;
  std::vector<Flows> side;     ///< slopes from a corner to the next
  std::vector<double> node_V;  ///< rising
  std::vector<Ports> node;
  std::vector<Ports> slope;  ///< from a node to the next
  double tick_s_mL_L =
      0;  ///< h times 1000 mL/L: divided by a volume [mL], what the end gains by a flow [s/L]
  double volume_exponent = 1, supply_kPa = 0, ambient_kPa = 0;
};

/// Of the parameters in image order, all that the kind has, over commands of 0 to 10 V.
GreyboxTables greybox_in_fixed(std::span<const float> parameters);
GreyboxTables greybox_in_double(std::span<const float> parameters);

}  // namespace rounding
