// Volume and its rate from the measured volume: a steady-state Kalman filter with constant acceleration.
//
//   x  = (v, v', v'')
//   x+ = F x + noise on v''
//   y  = v + noise
//
// The measured volume is the mean over the tick just past, so y belongs to the middle of that tick, and so
// does x.
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
    Scalar noise_mL = Scalar(0.05);     ///< standard deviation of one tick's measured volume
    Scalar jerk_mL_s3 = Scalar(30000);  ///< how hard the load moves: 100 mL at 1 Hz has up to 12,000
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

 private:
  /// In units of ticks, so that the filter's matrices are of order one and single precision suffices: (v, v' h, v'' h^2).
  using State = Eigen::Matrix<Scalar, 3, 1>;
  static ChamberMotion motion(const State& state) noexcept;

  State gain_ = State::Zero();
  State state_ = State::Zero();
};

}  // namespace plenum::control
