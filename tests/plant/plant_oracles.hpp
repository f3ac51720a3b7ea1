// What the tests hold the plant to: the papers' formulas written again, in the plainest way, and a fine
// fixed-step RK4.
#pragma once

#include <cmath>

namespace plenum::host::plant::oracle {

inline double thin_plate_z(double pu, double pd, double alpha, double beta, double theta, double kappa) {
  if (pu / pd > theta) return beta * pu;
  const double x = pd / pu;
  return alpha * pu * std::sqrt(std::pow(x, 2.0 / kappa) - std::pow(x, (kappa + 1.0) / kappa));
}

/// Classical Runge-Kutta over [0, duration] in `steps` equal steps; returns the end, and the integral by the
/// same rule.
struct End {
  double value;
  double integral;
};
template <class F>
End rk4(double y, double duration, int steps, F f) {
  const double h = duration / steps;
  double integral = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double t = i * h;
    const double k1 = f(t, y);
    const double k2 = f(t + 0.5 * h, y + 0.5 * h * k1);
    const double k3 = f(t + 0.5 * h, y + 0.5 * h * k2);
    const double k4 = f(t + h, y + h * k3);
    integral += h * (y + h / 6.0 * (k1 + k2 + k3));
    y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return {y, integral};
}

}  // namespace plenum::host::plant::oracle
