// Volume and its rate from the measured volume: a steady-state Kalman filter with constant acceleration.
//
//   x  = (v, v', v'')
//   x+ = F x + noise on v''
//   y  = v + noise
//
// The measured volume is the mean over the tick just past, so y belongs to the middle of that tick, and so
// does x.
//
// Only the ratio of the two noises counts, lambda = jerk h^3/noise (the tracking index: Kalata, 1984). The filter is solved in units
// of the measurement's noise, and of ticks stretched by s, a power of two near the cube root of lambda: v, v' h/s, v'' h^2/s^2 are
// then all of order one, so that single precision and fixed point suffice. lambda is kept within 1e-4, where a step takes half a
// second to be believed, and 64, where the filter is the parabola through the last three measurements.
//
// A bare difference of the measured volume, as the paper takes, multiplies its noise by 1/h = 100 per second;
// this estimate is what the tick at hand needs: volume and rate one tick ahead of the last measurement.
//
// Units: volume [mL], rate [mL/s], acceleration [mL/s^2].
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "firmware/config/seal.hpp"
#include "firmware/control/pressure_model.hpp"

namespace plenum::control {

class VolumeObserver {
 public:
  struct Config {
    Scalar tracking_index = Scalar(0.6);  ///< lambda (config::tracking_index())
  };

  /// Solves the steady-state Riccati equation by iteration (a fixed number of steps, at configuration only).
  void configure(const Config& config) noexcept;

  /// Starts at a volume at rest.
  void reset(Scalar volume_mL) noexcept;

  /// Takes the volume measured over the tick just past, returns volume and rate of the tick to come.
  ChamberMotion step(Scalar measured_mL) noexcept;

  /// In place of step() when the tick just past brought no measurement: it goes on as it moves.
  ChamberMotion coast() noexcept;

  /// Volume and rate of the tick just past, as known after its measurement.
  ChamberMotion past() const noexcept { return motion(state_); }

  /// Of what configure() alone writes: config/seal.hpp.
  std::uint64_t sum_of_constants() const noexcept { return config::sum_of_object(gain_); }
  std::uint64_t sum_of_estimates() const noexcept { return config::sum_of_object(state_); }

 private:
  /// (v, v' h, v'' h^2).
  using State = Eigen::Matrix<Scalar, 3, 1>;
  static ChamberMotion motion(const State& state) noexcept;

  State gain_ = State::Zero();
  State state_ = State::Zero();
};

}  // namespace plenum::control
