// One step of the classical fourth-order Runge-Kutta method.
#pragma once

namespace plenum::host::reproduce::proportional_valve {

/// y after `h`, of dy/dt = rate(y).
template <class Rate>
double runge_kutta_step(double y, double h, const Rate& rate) {
  const double k1 = rate(y);
  const double k2 = rate(y + 0.5 * h * k1);
  const double k3 = rate(y + 0.5 * h * k2);
  const double k4 = rate(y + h * k3);
  return y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

}  // namespace plenum::host::reproduce::proportional_valve
