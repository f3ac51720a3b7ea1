// The core's numbers in a test that holds for every scalar: a test writes its sets in float and compares in double.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <ostream>

#include "firmware/numeric/scalar.hpp"

namespace plenum {

inline double real(numeric::Scalar x) {
  return static_cast<double>(x);
}

/// As what a model's configure() takes.
template <std::size_t N>
constexpr std::array<numeric::Scalar, N> scalars(const std::array<float, N>& values) {
  std::array<numeric::Scalar, N> made{};
  std::copy(values.begin(), values.end(), made.begin());
  return made;
}

namespace numeric {

inline std::ostream& operator<<(std::ostream& out, Fixed x) {
  return out << static_cast<double>(x);
}

}  // namespace numeric
}  // namespace plenum
