// dead_time: the command acts only after a transport delay.
//
//   x(t) = u(t - d);   with a: the least (a > 0) or greatest (a < 0) u of the time from t - d (1 + |a|) to t - d (1 - |a|)
//
// u command, x effective command [V]; d delay [s]; a by how much of it a rise is later (+) than a fall (-): a solenoid that is
// let go otherwise than it pulls. A rise acts after d (1 + a), a fall after d (1 - a), and what is taken back before it has acted is
// not seen. Assumptions: constant delays. Range: up to 31 ticks. Vanishes at d = 0. Numerical treatment: the command is held over a
// tick, so a step of the model sees one held value and then at most one other, for any real d. Both enter with their share
// of the step, as openings: at their mean a valve that jumps from venting to filling would be shut. With a, where a step
// may see three, it is given the first and the last, in shares that keep the mean where any do. Before the log it is the first command.
// Source: bus, driver and solenoid electronics; gap notes of any sampled actuator.
#pragma once

#include <array>
#include <cstddef>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 2> kDeadTimeParameters{{
    {"delay_s", "from command to motion of the valve", 0.0, 0.08, 0.0, 0.002},
    {"delay_rise", "a: share by which a rise is later than a fall", -0.9, 0.9, 0.0, 0.2, Coordinate::linear,
     true},
}};
inline constexpr Effect kDeadTime{"dead_time",
                                  Equation::command,
                                  "the command reaches the valve after a constant delay",
                                  "x(t) = u(t - d (1 +- a))",
                                  "transport delay",
                                  kDeadTimeParameters};

template <class N>
class DeadTime {
 public:
  /// `x`: d [s], a
  void prepare(const N* x, double tick_s, double command_V) {
    const N longest(static_cast<double>(kPast - 1));
    late_ticks_ = smaller(x[0] * (1.0 / tick_s), longest / (1.0 + magnitude(x[1])));
    uneven_ticks_ = late_ticks_ * x[1];
    for (double& past : past_) past = command_V;
  }

  /// A new tick begins, with this command.
  void hold(double command_V) {
    newest_ = (newest_ + 1) % kPast;
    past_[newest_] = command_V;
  }

  /// The delayed command over a part of a tick: `first` for `share` of it, then `second`.
  template <class M>
  struct Halves {
    M first, second, share;
    M mean() const { return second + share * (first - second); }
  };
  using Held = Halves<N>;
  /// From `from` to `to`, as shares of this tick.
  Held during(double from, double to) const {
    Held held{};
    for (int i = 0; i < kLanesOf<N>; ++i) {
      const double late = lane(late_ticks_, i);
      const double uneven = lane(uneven_ticks_, i);
      const auto one =
          uneven == 0.0 ? shifted(from - late, to - late) : unevenly(from - late, to - late, uneven);
      set_lane(held.first, i, one.first);
      set_lane(held.second, i, one.second);
      set_lane(held.share, i, one.share);
    }
    return held;
  }

 private:
  // Times in ticks after the newest tick's begin: it lasts from 0 to 1.

  Halves<double> shifted(double from, double to) const {
    const double begin = std::floor(from);
    const double share = std::min((begin + 1.0 - from) / (to - from), 1.0);
    const double first = of_tick(begin);
    return {first, share == 1.0 ? first : of_tick(begin + 1.0), share};
  }
  Halves<double> unevenly(double from, double to, double uneven) const {
    const double width = std::abs(uneven);
    const double loses = std::floor(from - width) + 1.0 + width;  // the oldest tick of those looked at
    const double gains = std::floor(from + width) + 1.0 - width;  // a newer one
    const double change = std::min(std::min(loses, gains), to);
    const double last_change = std::min(std::max(loses, gains), to);
    const double first = extreme(from, change, uneven);
    const double middle = change < last_change ? extreme(change, last_change, uneven) : first;
    const double second = last_change < to ? extreme(last_change, to, uneven) : middle;
    const double apart =
        (change - from) * (first - second) + (last_change - change) * (middle - second);  // of the mean
    const double share =
        first == second ? 1.0 : std::clamp(apart / ((to - from) * (first - second)), 0.0, 1.0);
    return {first, second, share};
  }
  /// Within a part in which the ticks looked at stay the same.
  double extreme(double from, double to, double uneven) const {
    const double middle = 0.5 * (from + to);
    const double last = std::floor(middle + std::abs(uneven));
    double found = of_tick(last);
    for (double begin = std::floor(middle - std::abs(uneven)); begin < last; ++begin) {
      found = uneven > 0.0 ? std::min(found, of_tick(begin)) : std::max(found, of_tick(begin));
    }
    return found;
  }
  double of_tick(double begin) const {
    const double back = std::clamp(-begin, 0.0, static_cast<double>(kPast - 1));
    return past_[(newest_ + kPast - static_cast<std::size_t>(back)) % kPast];
  }

  static constexpr std::size_t kPast = 32;  // ticks remembered: the greatest delay at up to 380 Hz
  N late_ticks_{}, uneven_ticks_{};         ///< d, and d a
  std::array<double, kPast> past_{};
  std::size_t newest_ = 0;
};

}  // namespace plenum::host::effects
