// The motion of a chamber's volume: a mean and up to three sines, in closed form.
//
//   v(t) = v_0 + sum A_i sin(2 pi f_i t + phi_i),    vdot(t) = sum 2 pi f_i A_i cos(2 pi f_i t + phi_i)
//
// v volume [m3], A amplitude [m3], f frequency [Hz], phi phase [rad], t time [s].
// Assumption: the volume is imposed (a piston moved from outside; the mechanics is not a part of it).
// Range: the amplitudes together stay below the mean, so that v > 0. Vanishes (fixed volume) at zero
// amplitudes. Numerical treatment: the sines are evaluated exactly once at the start of an interval, and
// turned from there by the angle 2 pi f tau with short Taylor series (relative error below 1e-14 up to a
// quarter radian, the library beyond). Source: (4a) of "Modeling and Identification of Pneumatic Actuators"
// takes v and vdot as given.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant {

struct VolumeSine {
  double amplitude_m3 = 0.0;
  double frequency_Hz = 0.0;
  double phase_rad = 0.0;
};

struct VolumeState {
  double volume_m3 = 0.0;
  double rate_m3_s = 0.0;
};

class VolumeMotion {
 public:
  static constexpr std::size_t kSines = 3;

  /// Throws std::invalid_argument when a figure is not finite or the volume would not stay positive.
  explicit VolumeMotion(double mean_m3, const std::array<VolumeSine, kSines>& sines = {})
      : mean_m3_(mean_m3), sines_(sines) {
    double swing_m3 = 0.0;
    for (const VolumeSine& sine : sines_) {
      require_finite("volume amplitude_m3", sine.amplitude_m3);
      require_finite("volume frequency_Hz", sine.frequency_Hz);
      require_finite("volume phase_rad", sine.phase_rad);
      swing_m3 += std::abs(sine.amplitude_m3);
      if (sine.amplitude_m3 != 0.0) moving_ = static_cast<std::size_t>(&sine - sines_.data()) + 1;
    }
    require_above("volume mean_m3 (against the sum of its amplitudes)", mean_m3_, swing_m3);
  }

  VolumeState at(double time_s) const { return Interval(*this, time_s).at(0.0); }

  double mean_m3() const { return mean_m3_; }

  /// The motion as seen from `start_s`.
  class Interval {
   public:
    Interval(const VolumeMotion& motion, double start_s) : mean_m3_(motion.mean_m3_), count_(motion.moving_) {
      for (std::size_t i = 0; i < count_; ++i) {
        const VolumeSine& sine = motion.sines_[i];
        omega_[i] = 2.0 * std::numbers::pi * sine.frequency_Hz;
        const double angle = omega_[i] * start_s + sine.phase_rad;
        sin_[i] = sine.amplitude_m3 * std::sin(angle);
        cos_[i] = sine.amplitude_m3 * std::cos(angle);
      }
    }

    VolumeState at(double after_s) const {
      VolumeState state{mean_m3_, 0.0};
      for (std::size_t i = 0; i < count_; ++i) {
        const double d = omega_[i] * after_s;
        const double d2 = d * d;
        double s = 0.0;
        double c = 0.0;
        if (d2 < 0.0625) {
          s = d * (1.0 - d2 / 6.0 * (1.0 - d2 / 20.0 * (1.0 - d2 / 42.0 * (1.0 - d2 / 72.0))));
          c = 1.0 - d2 / 2.0 * (1.0 - d2 / 12.0 * (1.0 - d2 / 30.0 * (1.0 - d2 / 56.0 * (1.0 - d2 / 90.0))));
        } else {
          s = std::sin(d);
          c = std::cos(d);
        }
        state.volume_m3 += sin_[i] * c + cos_[i] * s;
        state.rate_m3_s += omega_[i] * (cos_[i] * c - sin_[i] * s);
      }
      return state;
    }

   private:
    double mean_m3_;
    std::size_t count_;
    std::array<double, kSines> omega_{};
    std::array<double, kSines> sin_{};
    std::array<double, kSines> cos_{};
  };

 private:
  double mean_m3_;
  std::array<VolumeSine, kSines> sines_;
  std::size_t moving_ = 0;  // sines beyond this index are still
};

}  // namespace plenum::host::plant
