// How far a port of a valve is open at a command, as the parameters of a grey-box model describe it.
//
//   C(o) = L + w smax((B o m(o) - L)/w),   smax(x) = (x + sqrt(x^2 + 1))/2
//   m(o) = 1 + q g + c g^2 + e g^3 for o > 0, else 1,   g = o/(o + 2 V)
//
// o opening [V]: u - U_c of the inlet, U_r - u of the exhaust; C, L, w [mL/s]; B [mL/(s V)]; q, c, e [1]. m is held above
// 0.05. Source: (3) of "Modeling and Identification of Pneumatic Actuators" with a gain a port, bent as the measured tables of
// "Proportional directional flow control valve" are.
#pragma once

#include <span>

#include "firmware/config/greybox_parameters.hpp"
#include "firmware/numeric/scalar.hpp"

namespace plenum::config {

struct ValveCurve {
  numeric::Scalar gain_mL_s_V = 0;
  numeric::Scalar leak_mL_s = 0;
  numeric::Scalar transition_mL_s = 1;
  numeric::Scalar slope = 0, curve = 0, bend = 0;  ///< q, c, e

  /// o m(o) [V]
  numeric::Scalar bent_V(numeric::Scalar opening_V) const noexcept {
    using numeric::Scalar;
    if (opening_V <= Scalar(0)) return opening_V;
    const Scalar g = opening_V / (opening_V + Scalar(2));
    return opening_V * numeric::max(Scalar(1) + g * (slope + g * (curve + g * bend)), Scalar(0.05));
  }

  /// C [mL/s]
  numeric::Scalar conductance_mL_s(numeric::Scalar opening_V) const noexcept {
    using numeric::Scalar;
    const Scalar beyond_mL_s = gain_mL_s_V * bent_V(opening_V) - leak_mL_s;
    // far from the transition smax(x) is max(x, 0) + 1/(4 |x|) but for 2^-4 |x|^-3, and x^2 would not fit a fixed-point number
    constexpr Scalar kFar = 1024;
    const Scalar far_mL_s = numeric::abs(beyond_mL_s);
    if (far_mL_s > kFar * transition_mL_s) {
      const Scalar rest_mL_s = transition_mL_s * (transition_mL_s / (Scalar(4) * far_mL_s));
      return leak_mL_s + numeric::max(beyond_mL_s, Scalar(0)) + rest_mL_s;
    }
    const Scalar x = beyond_mL_s / transition_mL_s;
    // for x < 0 without the difference of two numbers that are almost alike
    const Scalar root = numeric::sqrt(x * x + Scalar(1));
    const Scalar smax = Scalar(0.5) * (x >= Scalar(0) ? x + root : Scalar(1) / (root - x));
    return leak_mL_s + transition_mL_s * smax;
  }
};

/// `first_of_shape`: q in a grey-box model's parameters, whose c and e follow.
inline ValveCurve curve_of(std::span<const numeric::Scalar> parameters, GreyboxParameter gain,
                           GreyboxParameter leak, GreyboxParameter first_of_shape) noexcept {
  return {.gain_mL_s_V = parameters[gain],
          .leak_mL_s = parameters[leak],
          .transition_mL_s = parameters[kTransition],
          .slope = parameters[first_of_shape],
          .curve = parameters[first_of_shape + 1U],
          .bend = parameters[first_of_shape + 2U]};
}

/// Of a grey-box model, from its parameters in image order.
inline ValveCurve inlet_of(std::span<const numeric::Scalar> parameters) noexcept {
  return curve_of(parameters, kInletConductance, kInletLeak, kInletSlope);
}
inline ValveCurve exhaust_of(std::span<const numeric::Scalar> parameters) noexcept {
  return curve_of(parameters, kExhaustConductance, kExhaustLeak, kExhaustSlope);
}

}  // namespace plenum::config
