// dead_time: the command acts only after a transport delay.
//
//   x(t) = u(t - d)
//
// u command, x effective command [V]; d delay [s]. Assumptions: constant delay. Range: up to 30 ticks.
// Vanishes at d = 0. Numerical treatment: the command is held over a tick, so its mean over a step of the model,
// which is what enters, is the exact mean of at most two held values for any real d; before the log it is the
// first command. Source: bus, driver and solenoid electronics; gap notes of any sampled actuator.
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
    delay_ticks_ = x[0] * (1.0 / tick_s);
    past_.fill(command_V);
  }

  /// A new tick begins, with this command.
  void hold(double command_V) {
    newest_ = (newest_ + 1) % kPast;
    past_[newest_] = command_V;
  }

  /// Mean of the delayed command from `from` to `to`, as shares of this tick.
  N mean(double from, double to) const {
    N r{};
    for (int i = 0; i < kLanesOf<N>; ++i) {
      const double delay = lane(delay_ticks_, i);
      const double late = from - delay + static_cast<double>(kPast);  // above 0: counted from the oldest tick
      const double begin = std::floor(late);
      const double in_first = std::min(begin + 1.0 - late, to - from) / (to - from);
      const auto back = static_cast<std::size_t>(static_cast<double>(kPast) - begin);
      const double first = past_[(newest_ + kPast - back) % kPast];
      const double second = back == 0 ? first : past_[(newest_ + kPast + 1 - back) % kPast];
      set_lane(r, i, in_first * first + (1.0 - in_first) * second);
    }
    return r;
  }

 private:
  static constexpr std::size_t kPast =
      32;  // ticks remembered: above the greatest delay at 100 Hz and at 300 Hz
  N delay_ticks_{};
  std::array<double, kPast> past_{};
  std::size_t newest_ = 0;
};

}  // namespace plenum::host::effects
