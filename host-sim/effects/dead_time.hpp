// dead_time: the command acts only after a transport delay.
//
//   x(t) = u(t - d)
//
// u command, x effective command [V]; d delay [s]. Assumptions: constant delay. Range: up to 31 ticks.
// Vanishes at d = 0. Numerical treatment: the command is held over a tick, so a step of the model sees one held value
// and then at most one other, for any real d. Both enter with their share of the step, as openings: at their mean
// a valve that jumps from venting to filling would be shut. Before the log it is the first command. Source: bus,
// driver and solenoid electronics; gap notes of any sampled actuator.
#pragma once

#include <array>
#include <cstddef>

#include "host-sim/effects/effect.hpp"
#include "host-sim/effects/lanes.hpp"

namespace plenum::host::effects {

inline constexpr std::array<Parameter, 1> kDeadTimeParameters{{
    {"delay_s", "from command to motion of the valve", 0.0, 0.08, 0.0, 0.002},
}};
inline constexpr Effect kDeadTime{
    "dead_time",       Equation::command, "the command reaches the valve after a constant delay",
    "x(t) = u(t - d)", "transport delay", kDeadTimeParameters};

template <class N>
class DeadTime {
 public:
  void prepare(const N* x, double tick_s, double command_V) {
    delay_ticks_ = smaller(x[0] * (1.0 / tick_s), N(static_cast<double>(kPast - 1)));
    for (double& past : past_) past = command_V;
  }

  /// A new tick begins, with this command.
  void hold(double command_V) {
    newest_ = (newest_ + 1) % kPast;
    past_[newest_] = command_V;
  }

  /// The delayed command from `from` to `to`, as shares of this tick: `first` for `share` of it, then `second`.
  struct Held {
    N first, second, share;
    N mean() const { return second + share * (first - second); }
  };
  Held during(double from, double to) const {
    Held held{};
    for (int i = 0; i < kLanesOf<N>; ++i) {
      const double late = from - lane(delay_ticks_, i) + static_cast<double>(kPast);  // from the oldest tick
      const double begin = std::floor(late);
      const double share = std::min((begin + 1.0 - late) / (to - from), 1.0);
      const auto back = static_cast<std::size_t>(static_cast<double>(kPast) - begin);
      const double first = past_[(newest_ + kPast - back) % kPast];
      const bool one = back == 0 || share == 1.0;
      set_lane(held.first, i, first);
      set_lane(held.second, i, one ? first : past_[(newest_ + kPast + 1 - back) % kPast]);
      set_lane(held.share, i, share);
    }
    return held;
  }

 private:
  static constexpr std::size_t kPast = 32;  // ticks remembered: the greatest delay at up to 380 Hz
  N delay_ticks_{};
  std::array<double, kPast> past_{};
  std::size_t newest_ = 0;
};

}  // namespace plenum::host::effects
