// Random numbers that are the same on every machine and with every compiler: splitmix64 (Steele, Lea, Flood
// 2014) and transformations of our own; the distributions of <random> are not specified to the bit.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace plenum::host::blind {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  /// An independent stream: the same seed and number give the same stream.
  Random(std::uint64_t seed, std::uint64_t stream) : state_(seed) {
    state_ = bits() ^ (stream * 0xD1342543DE82EF95ULL);
    state_ = bits();
  }

  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }
  /// In [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  double log_uniform(double low, double high) { return low * std::exp(uniform() * std::log(high / low)); }
  /// 0 to count - 1.
  unsigned below(unsigned count) { return static_cast<unsigned>(uniform() * static_cast<double>(count)); }
  bool chance(double probability) { return uniform() < probability; }
  /// Of either sign. Two draws in one expression may come in either order: here each has a statement.
  double signed_log_uniform(double low, double high) {
    const double sign = chance(0.5) ? 1.0 : -1.0;
    return sign * log_uniform(low, high);
  }
  double angle() { return uniform(0.0, 2.0 * std::numbers::pi); }
  /// Standard normal (Box and Muller).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(angle());
  }

 private:
  std::uint64_t state_;
};

}  // namespace plenum::host::blind
