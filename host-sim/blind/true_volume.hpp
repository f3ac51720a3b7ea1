// The volume that the chamber has, where departures part it from the motion that its log tells.
//
//   v = m + O + 0.1 O sin(3 (m/M - 1)),   m = motion(t + T) + A sin(2 pi f t + phase)
//
// O offset of the volume_error, M mean of the motion, A amplitude of the volume_tremor [m3]; T time by which the column is late
// [s]. The form is this room's own.
#pragma once

#include <cmath>
#include <numbers>

#include "host-sim/blind/truth.hpp"

namespace plenum::host::blind {

class TrueVolume {
 public:
  struct Moment {
    double value_m3;
    double rate_m3_s;
  };

  explicit TrueVolume(const Machine& machine) : motion_(machine.motion), departures_(machine.departures) {}

  bool rigid() const { return !motion_.moves() && !departures_.volume_tremor; }
  Moment at(double time_s) const {
    const double told_s = time_s + (departures_.volume_lag ? departures_.volume_lag->time_s : 0.0);
    double v = motion_.at(told_s), rate = motion_.rate(told_s);
    if (const auto& tremor = departures_.volume_tremor) {
      const double omega = 2.0 * std::numbers::pi * tremor->frequency_Hz;
      const double angle = omega * time_s + tremor->phase;
      v += tremor->amplitude_m3 * std::sin(angle);
      rate += tremor->amplitude_m3 * omega * std::cos(angle);
    }
    if (!departures_.volume_error) return {v, rate};
    const double offset = departures_.volume_error->offset_m3;
    const double bend = 0.1 * offset;
    const double turn = v / motion_.mean_m3 - 1.0;
    return {v + offset + bend * std::sin(3.0 * turn),
            rate * (1.0 + 3.0 * bend / motion_.mean_m3 * std::cos(3.0 * turn))};
  }

 private:
  const Motion& motion_;
  const Departures& departures_;
};

}  // namespace plenum::host::blind
