// Eight numbers that are calculated side by side: the same chamber under eight sets of parameters.
//
// The equations of this room are templates on their number `N`, which is a double or Lanes: the simulator runs
// one chamber, identification a chamber and its seven neighbours in parameter space. A branch on a quantity is
// written with select(), so that every lane takes its own. `kInstructionSet` keeps apart what is compiled for
// different processors: the linker must never mix their functions.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace plenum::host::effects {

inline constexpr int kLanes = 8;

/// What one instruction holds: of SSE2 or NEON, AVX2, AVX-512. Vectors wider than that are not cut well by compilers:
/// their comparisons and choices fall apart into single numbers.
template <int kInstructionSet>
struct Vector {
  static constexpr int kWidth = 2;
  typedef double Values __attribute__((vector_size(16)));
  typedef std::int64_t Mask __attribute__((vector_size(16)));
};
template <>
struct Vector<1> {
  static constexpr int kWidth = 4;
  typedef double Values __attribute__((vector_size(32)));
  typedef std::int64_t Mask __attribute__((vector_size(32)));
};
template <>
struct Vector<2> {
  static constexpr int kWidth = 8;
  typedef double Values __attribute__((vector_size(64)));
  typedef std::int64_t Mask __attribute__((vector_size(64)));
};

template <int kInstructionSet>
struct Lanes {
  static constexpr int kWidth = Vector<kInstructionSet>::kWidth;
  static constexpr std::size_t kParts = static_cast<std::size_t>(kLanes / kWidth);
  using Part = typename Vector<kInstructionSet>::Values;
  using PartMask = typename Vector<kInstructionSet>::Mask;
  struct Mask {
    PartMask part[kParts];
  };
  Part part[kParts];

  Lanes() : part{} {}
  Lanes(double x)  // NOLINT(google-explicit-constructor): 2.0 * lanes reads as it should
      : Lanes(of([x](std::size_t) { return x - Part{}; })) {}
  /// Made of the parts f(0), f(1), ..; a loop would keep them in memory.
  template <class Function>
  static Lanes of(Function&& f) {
    return Lanes(f, Parts{});
  }
  template <class Function>
  static Mask mask_of(Function&& f) {
    return mask_of(f, Parts{});
  }

  Lanes& operator+=(const Lanes& b) { return *this = *this + b; }
  Lanes& operator-=(const Lanes& b) { return *this = *this - b; }
  Lanes& operator*=(const Lanes& b) { return *this = *this * b; }
  friend Lanes operator+(const Lanes& a, const Lanes& b) {
    return of([&](std::size_t i) { return a.part[i] + b.part[i]; });
  }
  friend Lanes operator-(const Lanes& a, const Lanes& b) {
    return of([&](std::size_t i) { return a.part[i] - b.part[i]; });
  }
  friend Lanes operator*(const Lanes& a, const Lanes& b) {
    return of([&](std::size_t i) { return a.part[i] * b.part[i]; });
  }
  friend Lanes operator/(const Lanes& a, const Lanes& b) {
    return of([&](std::size_t i) { return a.part[i] / b.part[i]; });
  }
  friend Lanes operator-(const Lanes& a) {
    return of([&](std::size_t i) { return -a.part[i]; });
  }
  friend Mask operator<(const Lanes& a, const Lanes& b) {
    return mask_of([&](std::size_t i) { return a.part[i] < b.part[i]; });
  }
  friend Mask operator>(const Lanes& a, const Lanes& b) {
    return mask_of([&](std::size_t i) { return a.part[i] > b.part[i]; });
  }

  friend bool any(const Mask& mask) {
    PartMask either = mask.part[0];
    for (std::size_t i = 1; i < kParts; ++i) either |= mask.part[i];
    std::int64_t some = 0;
    for (int k = 0; k < kWidth; ++k) some |= either[k];
    return some != 0;
  }
  friend Lanes select(const Mask& where, const Lanes& yes, const Lanes& no) {
    return of([&](std::size_t i) { return where.part[i] ? yes.part[i] : no.part[i]; });
  }
  friend Lanes smaller(const Lanes& a, const Lanes& b) {
    return of([&](std::size_t i) { return a.part[i] < b.part[i] ? a.part[i] : b.part[i]; });
  }
  friend Lanes larger(const Lanes& a, const Lanes& b) {
    return of([&](std::size_t i) { return a.part[i] > b.part[i] ? a.part[i] : b.part[i]; });
  }
  friend Lanes magnitude(const Lanes& a) {
    return of([&](std::size_t i) { return a.part[i] < 0.0 ? -a.part[i] : a.part[i]; });
  }
  friend Lanes root(const Lanes& a) {
    return of([&](std::size_t i) {
      Part r{};
      for (int k = 0; k < kWidth; ++k) r[k] = __builtin_sqrt(a.part[i][k]);
      return r;
    });
  }

 private:
  using Parts = std::make_index_sequence<kParts>;
  template <class Function, std::size_t... kPart>
  Lanes(const Function& f, std::index_sequence<kPart...>) : part{f(kPart)...} {}
  template <class Function, std::size_t... kPart>
  static Mask mask_of(const Function& f, std::index_sequence<kPart...>) {
    return {{f(kPart)...}};
  }
};

inline bool any(bool mask) {
  return mask;
}
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
  return x.part[i / Lanes<kSet>::kWidth][i % Lanes<kSet>::kWidth];
}
template <int kSet>
void set_lane(Lanes<kSet>& x, int i, double value) {
  x.part[i / Lanes<kSet>::kWidth][i % Lanes<kSet>::kWidth] = value;
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

/// Relative error below 1e-10 for z <= 2. phi_2 by six terms of its series at z/32, then five doublings,
///   e(2y) = e^2,  phi_1(2y) = (e + 1) phi_1 / 2,  phi_2(2y) = (phi_1^2 + 2 phi_2)/4:
/// no branch, no cancellation at z = 0. Below z = -24, where e^z < 4e-11, the limits.
template <class N>
Exponential<N> exponential(const N& z) {
  const N y = larger(z, N(-24.0)) * (1.0 / 32.0);
  N phi_2 = y * (1.0 / 5040.0) + 1.0 / 720.0;
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
  const auto beyond = z < N(-24.0);
  if (!any(beyond)) return {e, phi_1, phi_2};
  const N far = -1.0 / smaller(z, N(-24.0));
  return {e, select(beyond, far, phi_1), select(beyond, (1.0 - far) * far, phi_2)};
}

/// The integral over a step's last `share`, in steps: all of it where that is 1 or more, nothing where 0 or less, and between of
/// the parabola that has this beginning, mean and end.
template <class N>
N last_share(double share, const N& begin, const N& mean, const N& end) {
  if (share >= 1.0) return mean;
  if (share <= 0.0) return N(0.0);
  const N bend = 3.0 * (begin + end - 2.0 * mean);
  return share * (end + share * ((share / 3.0) * bend - 0.5 * (end - begin + bend)));
}

/// artanh(t)/t by six terms of its series: to 1e-9 for |t| <= 1/5, 2e-7 at 1/3.
template <class N>
N artanh_per(const N& t) {
  const N t2 = t * t;
  return 1.0 + t2 * (1.0 / 3.0 + t2 * (1.0 / 5.0 + t2 * (1.0 / 7.0 + t2 * (1.0 / 9.0 + t2 * (1.0 / 11.0)))));
}

/// ln x for x > 0 that is no subnormal number, to 2e-10 of 1 + |ln x|: x = 2^e m with m from 1/sqrt(2) to sqrt(2).
inline double logarithm(double x) {
  return std::log(x);
}
template <int kSet>
Lanes<kSet> logarithm(const Lanes<kSet>& x) {
  using Whole = typename Lanes<kSet>::PartMask;
  using Part = typename Lanes<kSet>::Part;
  constexpr double kLn2 = 0.6931471805599453;
  constexpr double kToWhole =
      6755399441055744.0;  // 1.5 * 2^52: a whole number added to it stands in its last bits
  constexpr std::int64_t kToWholeBits = 0x4338000000000000;
  constexpr std::int64_t kRootHalf = 0x3fe6a09e667f3bcd;  // sqrt(1/2)
  constexpr std::int64_t kExponent = -(std::int64_t{1} << 52);
  Lanes<kSet> mantissa, exponent;
  for (std::size_t i = 0; i < Lanes<kSet>::kParts; ++i) {
    const Whole bits = std::bit_cast<Whole>(x.part[i]);
    const Whole up = (bits - kRootHalf) & kExponent;
    mantissa.part[i] = std::bit_cast<Part>(bits - up);
    exponent.part[i] = std::bit_cast<Part>((up >> 52) + kToWholeBits) - kToWhole;
  }
  const Lanes<kSet> t = (mantissa - 1.0) / (mantissa + 1.0);
  return exponent * kLn2 + 2.0 * t * artanh_per(t);
}

/// x^a for x > 0 and a ln x up to 7, to 2e-7 of itself; 0 below -24.
template <class N>
N power(const N& x, const N& a) {
  return exponential(a * logarithm(x)).e;
}

/// Wright's omega function: y > 0 with y + ln y = x, to 1e-9 of itself (Corless and Jeffrey, LNCS 2385 (2002)). Below -24, where it is
/// less than 4e-11, nothing. Newton's method from below, whose tangents never lead beyond.
template <class N>
N wright_omega(const N& at) {
  const N x = larger(at, N(-24.0));
  const N grown = exponential(smaller(x, N(1.0))).e;
  N y = select(x < N(1.0), grown / (1.0 + grown), x - logarithm(larger(x, N(1.0))));
  for (int i = 0; i < 4; ++i) y = y * (1.0 + x - logarithm(y)) / (1.0 + y);
  return select(at < x, N(0.0), y);
}

}  // namespace plenum::host::effects
