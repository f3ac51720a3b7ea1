// Eight numbers that are calculated side by side: the same chamber under eight sets of parameters.
//
// The equations of this room are templates on their number `N`, which is a double or Lanes: the simulator runs
// one chamber, identification a chamber and its seven neighbours in parameter space. A branch on a quantity is
// written with select(), so that every lane takes its own. `kInstructionSet` keeps apart what is compiled for
// different processors: the linker must never mix their functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace plenum::host::effects {

inline constexpr int kLanes = 8;

template <int kInstructionSet>
struct Lanes {
  typedef double Values __attribute__((vector_size(8 * kLanes)));
  typedef std::int64_t Mask __attribute__((vector_size(8 * kLanes)));
  Values v;

  Lanes() : v{} {}
  Lanes(double x) : v(x - Values{}) {}  // NOLINT(google-explicit-constructor): 2.0 * lanes reads as it should
  static Lanes of(Values values) {
    Lanes r;
    r.v = values;
    return r;
  }

  Lanes& operator+=(const Lanes& b) {
    v += b.v;
    return *this;
  }
  Lanes& operator-=(const Lanes& b) {
    v -= b.v;
    return *this;
  }
  Lanes& operator*=(const Lanes& b) {
    v *= b.v;
    return *this;
  }
  friend Lanes operator+(const Lanes& a, const Lanes& b) { return of(a.v + b.v); }
  friend Lanes operator-(const Lanes& a, const Lanes& b) { return of(a.v - b.v); }
  friend Lanes operator*(const Lanes& a, const Lanes& b) { return of(a.v * b.v); }
  friend Lanes operator/(const Lanes& a, const Lanes& b) { return of(a.v / b.v); }
  friend Lanes operator-(const Lanes& a) { return of(-a.v); }
  friend Mask operator<(const Lanes& a, const Lanes& b) { return a.v < b.v; }
  friend Mask operator>(const Lanes& a, const Lanes& b) { return a.v > b.v; }

  friend Lanes select(const Mask& where, const Lanes& yes, const Lanes& no) {
    return of(where ? yes.v : no.v);
  }
  friend Lanes smaller(const Lanes& a, const Lanes& b) { return of(a.v < b.v ? a.v : b.v); }
  friend Lanes larger(const Lanes& a, const Lanes& b) { return of(a.v > b.v ? a.v : b.v); }
  friend Lanes magnitude(const Lanes& a) { return of(a.v < 0.0 ? -a.v : a.v); }
  friend Lanes root(const Lanes& a) {
    Lanes r;
    for (int i = 0; i < kLanes; ++i) r.v[i] = __builtin_sqrt(a.v[i]);
    return r;
  }
};

inline double select(bool where, double yes, double no) {
  return where ? yes : no;
}
inline double smaller(double a, double b) {
  return a < b ? a : b;
}
inline double larger(double a, double b) {
  return a > b ? a : b;
}
inline double magnitude(double a) {
  return std::abs(a);
}
inline double root(double a) {
  return std::sqrt(a);
}

/// How many numbers are in `N`, and each of them: for what happens once a run, and for what has no vector form.
template <class N>
inline constexpr int kLanesOf = kLanes;
template <>
inline constexpr int kLanesOf<double> = 1;
inline double lane(double x, int) {
  return x;
}
inline void set_lane(double& x, int, double value) {
  x = value;
}
template <int kSet>
double lane(const Lanes<kSet>& x, int i) {
  return x.v[i];
}
template <int kSet>
void set_lane(Lanes<kSet>& x, int i, double value) {
  x.v[i] = value;
}
template <class N, class Function>
N each(const N& x, Function&& f) {
  N r{};
  for (int i = 0; i < kLanesOf<N>; ++i) set_lane(r, i, f(lane(x, i)));
  return r;
}

/// e^z and the two functions of exponential integrators: phi_1 = (e^z - 1)/z, phi_2 = (phi_1 - 1)/z.
template <class N>
struct Exponential {
  N e, phi_1, phi_2;
};

/// Relative error below 1e-10 for z <= 2. phi_2 by its series at z/32, then five doublings,
///   e(2y) = e^2,  phi_1(2y) = (e + 1) phi_1 / 2,  phi_2(2y) = (phi_1^2 + 2 phi_2)/4:
/// no branch, no cancellation at z = 0. Below z = -24, where e^z < 4e-11, the limits.
template <class N>
Exponential<N> exponential(const N& z) {
  const N y = larger(z, N(-24.0)) * (1.0 / 32.0);
  N phi_2 = y * (1.0 / 39916800.0) + 1.0 / 3628800.0;
  phi_2 = phi_2 * y + 1.0 / 362880.0;
  phi_2 = phi_2 * y + 1.0 / 40320.0;
  phi_2 = phi_2 * y + 1.0 / 5040.0;
  phi_2 = phi_2 * y + 1.0 / 720.0;
  phi_2 = phi_2 * y + 1.0 / 120.0;
  phi_2 = phi_2 * y + 1.0 / 24.0;
  phi_2 = phi_2 * y + 1.0 / 6.0;
  phi_2 = phi_2 * y + 0.5;
  N phi_1 = phi_2 * y + 1.0;
  N e = phi_1 * y + 1.0;
  for (int i = 0; i < 5; ++i) {
    phi_2 = (phi_1 * phi_1 + 2.0 * phi_2) * 0.25;
    phi_1 = (e + 1.0) * phi_1 * 0.5;
    e = e * e;
  }
  const N far = -1.0 / smaller(z, N(-24.0));
  const auto beyond = z < N(-24.0);
  return {e, select(beyond, far, phi_1), select(beyond, (1.0 - far) * far, phi_2)};
}

}  // namespace plenum::host::effects
