// A valve with one moving element, two outlets and the volume upstream of it: a grey-box model without a
// force balance.
//
//   dPs/dt V/beta = Q_in - Q_pr - Q_sec - alpha1 dx/dt                              (3.18)
//   Q_pr  = alpha2 x sqrt(Ps - P1),  Q_sec = alpha3 sqrt(Ps - P2)                   (3.19), (3.20)
//   dx/dt = (2 Q_pr' (Ps - P1) - Q_pr (Ps' - P1')) / (2 alpha2 (Ps - P1)^(3/2))     (3.21)
//   Ps'   = (Q_in - Q_pr - Q_sec - alpha5 (2 Q_pr' (Ps - P1) + P1' Q_pr) / (Ps - P1)^(3/2))
//           / (alpha4 - alpha5 Q_pr / (Ps - P1)^(3/2))                              (3.24)
//   alpha4 = V / beta, alpha5 = alpha1 / (2 alpha2)
//
// Ps upstream, P1 primary, P2 secondary port pressure [Pa]; Q flows [m3/s]; x displacement [m]; V upstream
// volume [m3]; beta bulk modulus [Pa]; alpha1 [m2]; alpha2 [m2/(s sqrt(Pa))]; alpha3 [m3/(s sqrt(Pa))].
// Assumptions: the metering area is in proportion to x, the clearance to the second outlet is constant, flow
// leaves.
// Vanishes as alpha1 -> 0: the fluid's capacitance alone. Range: Ps > P1, Ps > P2, and a denominator above 0:
//   Q_pr < alpha4 (Ps - P1)^(3/2) / alpha5.
// Beyond it a higher Ps at the same Q_pr shuts the element by more fluid than the volume's compression takes
// up, and (3.24) has no solution that pressure follows. Numerical treatment: none, a rate in closed form.
// Source: "Grey-Box Multi-Port Models of Fluid Power Valves", (3.18)-(3.24). Where the text calls for the
// derivatives "of the first two quantities" of its list (Q_in, P1), the equation holds those of Q_pr and P1.
#pragma once

namespace plenum::host::plant::relief_valve {

struct MultiInputConfig {
  double alpha1_m2 = 0.0;           ///< volume swept for each metre of displacement, >= 0
  double alpha2_m2_s_sqrtPa = 0.0;  ///< > 0
  double alpha3_m3_s_sqrtPa = 0.0;  ///< >= 0
  double upstream_volume_m3 = 0.0;  ///< > 0
  double bulk_modulus_Pa = 1.4e9;   ///< > 0
};

/// What acts on the valve, and the primary flow with its rate.
struct MultiInputPorts {
  double inflow_m3_s = 0.0;
  double upstream_Pa = 0.0;
  double primary_Pa = 0.0;
  double secondary_Pa = 0.0;
  double primary_flow_m3_s = 0.0;
  double primary_flow_rate_m3_s2 = 0.0;
  double primary_rate_Pa_s = 0.0;
};

/// Throws std::invalid_argument naming the field.
void validate(const MultiInputConfig& config);
/// (3.19) solved for x [m].
double displacement_m(const MultiInputConfig& config, const MultiInputPorts& ports);
/// (3.20) [m3/s].
double secondary_flow_m3_s(const MultiInputConfig& config, const MultiInputPorts& ports);
/// (3.24) [Pa/s]. Throws std::invalid_argument out of the range stated above.
double upstream_rate_Pa_s(const MultiInputConfig& config, const MultiInputPorts& ports);

}  // namespace plenum::host::plant::relief_valve
