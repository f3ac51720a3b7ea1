// A number of the core with all that fixed point can make of it: where it lies for all inputs of a box, and how far at most the
// board's Q31.32 is from it. One run of the core's own code on such numbers bounds what rounding does to its result.
// Included before everything else where the core is compiled for it (CMakeLists.txt).
//
//   x in [low, high] for every input of the box;   |x computed by the board - x| <= error
//
// An operation hands on its operands' errors by its derivatives, and adds its own: those of the table of firmware/numeric/fixed.hpp
// and of decay() there. Bounds are doubles, moved outwards by more than they are rounded. Against what the formula would give in
// exact numbers, with the same clamps and the same float parameters.
//
// Source: the running error analysis of Higham, Accuracy and Stability of Numerical Algorithms, section 3.3, over intervals.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <type_traits>

#include "firmware/numeric/order.hpp"

#define PLENUM_SCALAR_TYPE Rounded

namespace plenum::numeric {

class Rounded {
 public:
  static constexpr double kUlp = 0x1p-32;
  static constexpr double kHalfUlp = 0x1p-33;

  constexpr Rounded() = default;
  /// What the board rounds when it takes it over.
  template <class Number>
  requires std::is_arithmetic_v<Number>
  constexpr Rounded(Number x)
      : low_(static_cast<double>(x)), high_(low_), error_(is_whole_ulps(low_) ? 0 : kHalfUlp) {}
  constexpr Rounded(double low, double high, double error) : low_(low), high_(high), error_(error) {}

  constexpr double low() const { return low_; }
  constexpr double high() const { return high_; }
  constexpr double error() const { return error_; }
  /// The largest magnitude.
  constexpr double most() const { return std::max(-low_, high_); }

  friend constexpr Rounded operator-(const Rounded& a) { return {-a.high_, -a.low_, a.error_}; }
  friend constexpr Rounded operator+(const Rounded& a, const Rounded& b) {
    return made(a.low_ + b.low_, a.high_ + b.high_, a.error_ + b.error_);
  }
  friend constexpr Rounded operator-(const Rounded& a, const Rounded& b) { return a + (-b); }
  /// Of a number by itself: its square, which is not negative.
  friend constexpr Rounded operator*(const Rounded& a, const Rounded& b) {
    const double error = a.most() * b.error_ + b.most() * a.error_ + a.error_ * b.error_ + kHalfUlp;
    if (&a == &b) {
      const double near = a.low_ > 0 ? a.low_ : a.high_ < 0 ? -a.high_ : 0;
      return made(near * near, a.most() * a.most(), error);
    }
    const double ll = a.low_ * b.low_, lh = a.low_ * b.high_, hl = a.high_ * b.low_, hh = a.high_ * b.high_;
    return made(std::min({ll, lh, hl, hh}), std::max({ll, lh, hl, hh}), error);
  }
  friend constexpr Rounded operator/(const Rounded& a, const Rounded& b) {
    const double nearest = b.low_ > 0 ? b.low_ - b.error_ : -b.high_ - b.error_;  // to 0, as computed
    if (nearest <= 0) return made(-kInfinity, kInfinity, kInfinity);
    const double ll = a.low_ / b.low_, lh = a.low_ / b.high_, hl = a.high_ / b.low_, hh = a.high_ / b.high_;
    const double low = std::min({ll, lh, hl, hh}), high = std::max({ll, lh, hl, hh});
    return made(low, high, (a.error_ + std::max(-low, high) * b.error_) / nearest + kHalfUlp);
  }
  constexpr Rounded& operator+=(const Rounded& x) { return *this = *this + x; }
  constexpr Rounded& operator*=(const Rounded& x) { return *this = *this * x; }

  /// A step compares nothing that is not bounded as a whole (below), so that no way through it is chosen here: a comparison that rounding
  /// could turn is a mistake of whoever adds one, and ends the program.
  friend constexpr bool operator<(const Rounded& a, const Rounded& b) {
    const double apart = a.error_ + b.error_;
    if (a.high_ + apart < b.low_) return true;
    if (a.low_ >= b.high_ + apart) return false;
    throw std::logic_error("a comparison that rounding may turn");
  }
  friend constexpr bool operator>(const Rounded& a, const Rounded& b) { return b < a; }
  friend constexpr bool operator<=(const Rounded& a, const Rounded& b) { return !(b < a); }
  friend constexpr bool operator>=(const Rounded& a, const Rounded& b) { return !(a < b); }
  /// The core asks for it to mark nodes of a table that coincide, and no number of a step depends on that.
  friend constexpr bool operator==(const Rounded& a, const Rounded& b) {
    return a.low_ == a.high_ && b.low_ == b.high_ && a.low_ == b.low_;
  }

  /// A result, its bounds moved outwards.
  static constexpr Rounded made(double low, double high, double error) {
    constexpr double kOut = 4 * std::numeric_limits<double>::epsilon();
    const Rounded wide(low - kOut * (low < 0 ? -low : low), high + kOut * (high < 0 ? -high : high),
                       error * (1 + kOut));
    if (!std::is_constant_evaluated()) largest = std::max({largest, -wide.low_, wide.high_});
    return wide;
  }

  /// Of all results since it was set to zero, the largest magnitude.
  static inline double largest = 0;

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  static constexpr bool is_whole_ulps(double x) {
    constexpr double kMost = 0x1p31;
    return x > -kMost && x < kMost && static_cast<double>(static_cast<long long>(x * 0x1p32)) == x * 0x1p32;
  }

  double low_ = 0, high_ = 0, error_ = 0;
};

constexpr Rounded min(const Rounded& a, const Rounded& b) {
  return {std::min(a.low(), b.low()), std::min(a.high(), b.high()), std::max(a.error(), b.error())};
}
constexpr Rounded max(const Rounded& a, const Rounded& b) {
  return {std::max(a.low(), b.low()), std::max(a.high(), b.high()), std::max(a.error(), b.error())};
}
constexpr Rounded clamp(const Rounded& x, const Rounded& low, const Rounded& high) {
  return min(max(x, low), high);
}
constexpr Rounded abs(const Rounded& x) {
  return max(max(x, -x), Rounded(0));
}
inline bool is_finite(const Rounded& x) {
  return std::isfinite(x.low()) && std::isfinite(x.high());
}

/// Of what can be below zero by rounding alone.
inline Rounded sqrt(const Rounded& x) {
  constexpr double kHalfUlpBelow = 0x1p24, kFarUlps = 16;
  const double low = std::sqrt(std::max(x.low(), 0.0)), high = std::sqrt(x.high());
  const double own = x.high() + x.error() < kHalfUlpBelow ? Rounded::kHalfUlp : kFarUlps * Rounded::kUlp;
  // sqrt(x + e) - sqrt(x) = e/(sqrt(x + e) + sqrt(x)), and never above sqrt(e)
  const double handed_on = std::min(std::sqrt(x.error()), low > 0 ? x.error() / low : x.error() * 0x1p1023);
  return Rounded::made(low, high, handed_on + own);
}
/// Of x > 0.
inline Rounded inverse_sqrt(const Rounded& x) {
  constexpr double kRelative = 0x1p-28;
  const double nearest = x.low() - x.error();
  if (nearest <= 0)
    return Rounded::made(0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity());
  const double most = 1 / std::sqrt(nearest);
  return Rounded::made(1 / std::sqrt(x.high()), 1 / std::sqrt(x.low()),
                       0.5 * x.error() * most * most * most + kRelative * most + Rounded::kUlp);
}

/// Of b > 0.
inline Rounded near_ratio(const Rounded& a, const Rounded& b) {
  constexpr double kRelative = 0x1p-25;
  const Rounded exact = a / b;
  return {exact.low(), exact.high(),
          exact.error() * (1 + kRelative) + exact.most() * kRelative + Rounded::kHalfUlp};
}

/// The largest error of decay() and decay_part() of Q31.32 themselves.
inline constexpr double kDecayError = 3.5 * Rounded::kUlp;
/// e^-x where they end.
inline constexpr double kDecayLeft = 3.8e-11;

inline Rounded decay(const Rounded& x) {
  const auto of = [](double t) { return -std::expm1(-std::max(t, 0.0)); };
  const double steepest = std::exp(-std::max(x.low() - x.error(), 0.0));
  return Rounded::made(
      of(x.low()), of(x.high()),
      steepest * x.error() + kDecayError + (x.high() + x.error() > kDecayHigh ? kDecayLeft : 0.0));
}

/// phi_1 and phi_2 of scalar.hpp and what the core computes for them: exact values, and bounds of their slopes and roundings.
namespace phi {

/// (1 - e^-x)/x
inline double first(double x) {
  return std::fabs(x) < 1e-8 ? 1 - 0.5 * x : -std::expm1(-x) / x;
}
/// (1 - first(x))/x
inline double second(double x) {
  constexpr double kSeries = 1e-2;  // of six terms: the next is below 1e-14 of the first
  if (std::fabs(x) >= kSeries) return (1 - first(x)) / x;
  return 1.0 / 2 - x * (1.0 / 6 - x * (1.0 / 24 - x * (1.0 / 120 - x * (1.0 / 720 - x / 5040))));
}
// Both fall, and are convex: as integrals of e^-xy times what is not negative. So the slope is steepest at the low end, and
// nearer to 0 than a secant from one to the left of it, a tenth here.
inline double slope(double (&of)(double), double low) {
  constexpr double kBack = 0.1;
  return (of(low - kBack) - of(low)) / kBack;
}

/// Of mean_decay() itself, for an x of at least 0 as the board has it.
inline double mean_decay_rounding(double low, double high) {
  constexpr double kSeriesBelow = 0x1p-7;
  const double quotient =
      (kDecayError + (high > kDecayHigh ? kDecayLeft : 0.0)) / std::max(low, kSeriesBelow) +
      Rounded::kHalfUlp;
  // remainder of the series, its three products and two constants
  const double series = std::pow(std::min(high, kSeriesBelow), 3) / 24 + 4 * Rounded::kHalfUlp;
  return low >= kSeriesBelow ? quotient : high < kSeriesBelow ? series : std::max(quotient, series);
}
inline double first_rounding(double low, double high) {
  double worst = high >= 0 ? mean_decay_rounding(std::max(low, 0.0), high) : 0;
  if (low < 0) {  // the mean of a decay over what a decay leaves
    const double steepest = std::min(-low, double{kGrowthHigh});
    const double left = std::exp(-steepest) - kDecayError;
    worst = std::max(
        worst, (mean_decay_rounding(std::max(-high, 0.0), steepest) + first(-steepest) * kDecayError) / left +
                   Rounded::kHalfUlp);
  }
  return worst;
}
inline double second_rounding(double low, double high) {
  constexpr double kSeriesWithin = 0.0625;
  const double nearest = std::max({low, -high, kSeriesWithin});
  const double quotient = first_rounding(low, high) / nearest + Rounded::kHalfUlp;
  const double series = 4 * Rounded::kUlp + std::pow(kSeriesWithin, 4) / 720 * 1.1;
  if (low >= kSeriesWithin || high <= -kSeriesWithin) return quotient;
  return low > -kSeriesWithin && high < kSeriesWithin ? series : std::max(quotient, series);
}

inline Rounded of(double (&exact)(double), double (&rounding)(double, double), double kLowest,
                  const Rounded& x) {
  const double low = std::max(x.low(), kLowest), high = std::max(x.high(), kLowest);
  const double from = std::max(low - x.error(), kLowest), to = high + x.error();  // as the board has it
  constexpr double kComputed = 1e-12;  // of it, by the difference in second()
  return Rounded::made(exact(high) * (1 - kComputed), exact(low) * (1 + kComputed),
                       slope(exact, from) * x.error() + rounding(from, to));
}

}  // namespace phi

inline Rounded mean_decay(const Rounded& x, const Rounded& /*done*/) {
  return phi::of(phi::first, phi::mean_decay_rounding, 0.0, x);
}
inline Rounded phi_1(const Rounded& x) {
  return phi::of(phi::first, phi::first_rounding, -kGrowthHigh, x);
}
inline Rounded phi_2(const Rounded& x, const Rounded& /*phi_1*/) {
  return phi::of(phi::second, phi::second_rounding, -kGrowthHigh, x);
}

}  // namespace plenum::numeric
