// Valve flow as a polynomial of second order in the command and in the pressure.
//
//   mdot = a + b P + c P^2 + d u P + f u P^2 + g u^2 + h u^2 P + i u^2 P^2                    (5), as printed
//   mdot = the same with e u, the ninth term of u^0..2 times P^0..2                                 whole
//
// mdot mass flow [kg/s]; u command [V]; P chamber pressure, absolute [Pa]. The paper lists a coefficient e
// that its equation does not have: the term that is missing is the one in u alone.
// Assumptions: constant supply and ambient. Range: that of the samples; a polynomial is worth nothing
// outside. Method: linear least squares by QR, u and P scaled to -1..1 of their ranges before the products
// are formed, so that the columns are of one size. Source: "Mathematical and Intelligent Modeling of
// Electropneumatic Servo Actuator Systems" (5).
#pragma once

#include <array>
#include <span>

#include "host-sim/identify/servo/flow_samples.hpp"

namespace plenum::host::identify::servo {

enum class Terms { kAsPrinted, kWhole };

/// c[m][n] of u^m P^n, in kg/s, V and Pa.
struct Bipolynomial {
  std::array<std::array<double, 3>, 3> c{};
  double flow_kg_s(double command_V, double pressure_Pa) const;
};

struct BipolynomialFit : FlowError {
  Bipolynomial polynomial;
};

/// Throws std::invalid_argument when a sample is not finite, CannotIdentify when the samples do not determine
/// the coefficients (fewer than three commands or pressures).
BipolynomialFit fit_bipolynomial(std::span<const FlowSample> samples, Terms terms);

}  // namespace plenum::host::identify::servo
