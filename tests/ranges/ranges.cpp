// Compiled with the core's sources that it runs, in intervals (CMakeLists.txt).
#include "tests/ranges/ranges.hpp"

#include <algorithm>
#include <stdexcept>

#include "firmware/control/tassa9.hpp"

namespace ranges {
namespace {

using plenum::control::Tassa9;
using plenum::numeric::Interval;

Interval interval(const Bounds& of) {
  return {of.first, of.second};
}
void widen(Bounds& bounds, const Interval& by) {
  bounds = {std::min(bounds.first, by.low()), std::max(bounds.second, by.high())};
}

}  // namespace

Found tick(std::span<const Bounds> parameters, const States& states) {
  std::array<Interval, Tassa9::kParameters> of;
  if (parameters.size() != of.size()) throw std::invalid_argument("another number of parameters");
  std::transform(parameters.begin(), parameters.end(), of.begin(), interval);
  Tassa9 model;
  Interval::largest = 0;
  model.configure(of, Interval(0), Interval(10));
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Found found{.largest = 0, .end_kPa = {kNone, -kNone}, .mean_kPa = {kNone, -kNone}};
  do {
    const auto made =
        model.step(interval(states.pressure_kPa), interval(states.command_V),
                   {.volume_mL = interval(states.volume_mL), .volume_rate_mL_s = interval(states.speed_mL_s)},
                   Interval(1));
    widen(found.end_kPa, made.end_kPa);
    widen(found.mean_kPa, made.mean_kPa);
  } while (Interval::ways.next());
  found.largest = Interval::largest;
  return found;
}

}  // namespace ranges
