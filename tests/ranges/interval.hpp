// Intervals as a scalar of the core: one run of it tells the range of every number between, for all inputs of a box at once.
// Included before everything else where the core is compiled for it.
//
// Bounds are doubles, moved outwards by more than they are rounded. Where a comparison is open both ways are gone in turn
// (Ways), and the number that was compared, if it is one that can change, is narrowed to what the way says of it.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <vector>

#define PLENUM_SCALAR_TYPE Interval

namespace plenum::numeric {

/// The ways through what runs: a depth-first walk over its open comparisons.
class Ways {
 public:
  /// The next comparison that is open goes so.
  bool choose() {
    if (at_ == chosen_.size()) chosen_.push_back(false);
    if (chosen_.size() > kMost) throw std::runtime_error("too many open comparisons on one way");
    return chosen_[at_++];
  }
  /// Begins the next way; false: all have been gone.
  bool next() {
    at_ = 0;
    while (!chosen_.empty() && chosen_.back()) chosen_.pop_back();
    if (chosen_.empty()) return false;
    chosen_.back() = true;
    return true;
  }

 private:
  static constexpr std::size_t kMost = 24;
  std::vector<bool> chosen_;
  std::size_t at_ = 0;
};

class Interval {
 public:
  constexpr Interval() = default;
  template <class Number>
  requires std::is_arithmetic_v<Number>
  constexpr Interval(Number x) : low_(static_cast<double>(x)), high_(low_) {}
  constexpr Interval(double low, double high) : low_(low), high_(high) {}

  constexpr double low() const { return low_; }
  constexpr double high() const { return high_; }

  friend constexpr Interval operator-(Interval a) { return {-a.high_, -a.low_}; }
  friend constexpr Interval operator+(Interval a, Interval b) {
    return made(a.low_ + b.low_, a.high_ + b.high_);
  }
  friend constexpr Interval operator-(Interval a, Interval b) { return a + (-b); }
  /// Of a number by itself: its square, which is not negative.
  friend constexpr Interval operator*(const Interval& a, const Interval& b) {
    if (&a == &b) {
      const double near = a.low_ > 0 ? a.low_ : a.high_ < 0 ? -a.high_ : 0;
      const double far = std::max(-a.low_, a.high_);
      return made(near * near, far * far);
    }
    const double ll = a.low_ * b.low_, lh = a.low_ * b.high_, hl = a.high_ * b.low_, hh = a.high_ * b.high_;
    return made(std::min(std::min(ll, lh), std::min(hl, hh)), std::max(std::max(ll, lh), std::max(hl, hh)));
  }
  friend constexpr Interval operator/(Interval a, Interval b) {
    if (b.low_ <= 0 && b.high_ >= 0) return made(-kInfinity, kInfinity);
    const double ll = a.low_ / b.low_, lh = a.low_ / b.high_, hl = a.high_ / b.low_, hh = a.high_ / b.high_;
    return made(std::min(std::min(ll, lh), std::min(hl, hh)), std::max(std::max(ll, lh), std::max(hl, hh)));
  }
  constexpr Interval& operator+=(Interval x) { return *this = *this + x; }
  constexpr Interval& operator*=(Interval x) { return *this = *this * x; }

  friend bool operator<(const Interval& a, const Interval& b) {
    if (a.high_ < b.low_) return true;
    if (a.low_ >= b.high_) return false;
    return ways.choose();
  }
  friend bool operator>(const Interval& a, const Interval& b) { return b < a; }
  friend bool operator<=(const Interval& a, const Interval& b) { return !(b < a); }
  friend bool operator>=(const Interval& a, const Interval& b) { return !(a < b); }
  /// As the last one, and `x` is narrowed.
  friend bool operator>=(Interval& x, const Interval& b) {
    const bool is = static_cast<const Interval&>(x) >= b;
    if (is) x.low_ = std::max(x.low_, b.low_);
    if (!is) x.high_ = std::min(x.high_, b.high_);
    return is;
  }
  /// An open one is false: the core asks for it to mark nodes of a table that coincide, and no number depends on that.
  friend bool operator==(const Interval& a, const Interval& b) {
    return a.low_ == a.high_ && b.low_ == b.high_ && a.low_ == b.low_;
  }

  /// Of all results since it was set to zero, the largest magnitude.
  static inline double largest = 0;
  static inline Ways ways;

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  /// A result: its bounds are within an ulp of what they should be.
  static constexpr Interval made(double low, double high) {
    constexpr double kOut = 4 * std::numeric_limits<double>::epsilon();
    const Interval wide(low - kOut * (low < 0 ? -low : low), high + kOut * (high < 0 ? -high : high));
    if (!std::is_constant_evaluated()) largest = std::max({largest, -wide.low_, wide.high_});
    return wide;
  }
  double low_ = 0, high_ = 0;
};

constexpr Interval min(Interval a, Interval b) {
  return {std::min(a.low(), b.low()), std::min(a.high(), b.high())};
}
constexpr Interval max(Interval a, Interval b) {
  return {std::max(a.low(), b.low()), std::max(a.high(), b.high())};
}
constexpr Interval clamp(Interval x, Interval low, Interval high) {
  return min(max(x, low), high);
}
constexpr Interval abs(Interval x) {
  return max(max(x, -x), Interval(0));
}
/// Of what can be below zero by rounding alone.
inline Interval sqrt(Interval x) {
  return Interval(std::sqrt(std::max(x.low(), 0.0)), std::sqrt(x.high())) * Interval(1);
}
/// Of x > 0.
inline Interval inverse_sqrt(Interval x) {
  return Interval(1) / sqrt(x);
}
inline bool is_finite(Interval x) {
  return std::isfinite(x.low()) && std::isfinite(x.high());
}
inline Interval decay(Interval x) {
  const auto of = [](double t) { return -std::expm1(-std::clamp(t, 0.0, 24.0)); };
  return min(Interval(of(x.low()), of(x.high())) * Interval(1), Interval(1));
}

}  // namespace plenum::numeric
