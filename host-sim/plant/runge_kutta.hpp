// The classical fourth-order Runge-Kutta method, for where a second, plainer route than a room's own steps is wanted.
#pragma once

#include <cstddef>

namespace plenum::host::plant {

/// y + h k; State is a number, a vector of Eigen or an array of numbers.
template <class State>
State along(const State& y, double h, const State& k) {
  if constexpr (requires { State(y + h * k); }) {
    return State(y + h * k);
  } else {
    State sum = y;
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += h * k[i];
    return sum;
  }
}

/// y at t + h, of dy/dt = rate(t, y).
template <class State, class Rate>
State runge_kutta_step(double t, const State& y, double h, const Rate& rate) {
  const State k1 = rate(t, y);
  const State k2 = rate(t + 0.5 * h, along(y, 0.5 * h, k1));
  const State k3 = rate(t + 0.5 * h, along(y, 0.5 * h, k2));
  const State k4 = rate(t + h, along(y, h, k3));
  return along(along(along(along(y, h / 6.0, k1), h / 3.0, k2), h / 3.0, k3), h / 6.0, k4);
}

}  // namespace plenum::host::plant
