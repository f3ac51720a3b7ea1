#include "host-sim/plant/refuse.hpp"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace plenum::host::plant {
namespace {

[[noreturn]] void refuse(std::string_view field, double value, const std::ostringstream& expected) {
  std::ostringstream line;
  line << field << ": " << value << ", expected " << expected.str();
  throw std::invalid_argument(line.str());
}

}  // namespace

void require_finite(std::string_view field, double value) {
  if (std::isfinite(value)) return;
  std::ostringstream expected;
  expected << "a finite number";
  refuse(field, value, expected);
}

void require_above(std::string_view field, double value, double bound) {
  if (std::isfinite(value) && value > bound) return;
  std::ostringstream expected;
  expected << "a finite number above " << bound;
  refuse(field, value, expected);
}

void require_within(std::string_view field, double value, double low, double high) {
  if (value >= low && value <= high) return;
  std::ostringstream expected;
  expected << low << " to " << high;
  refuse(field, value, expected);
}

}  // namespace plenum::host::plant
