// A pressure sensor that answers late, and what its readings say of the pressure all the same.
//
//   tau y' = p - y
//
// p pressure, y what the sensor shows [kPa]; tau [ticks]. For a pressure that goes from p_0 to p_1 over a tick on a parabola of
// the predicted mean,
//   y_1 = p_1 - l + (y_0 - p_0 + l) E + 6 (I (1 - 2 tau) + E) (mean of p - (p_0 + p_1)/2)         (S1)
//   E = e^(-1/tau),  l = tau (p_1 - p_0),  I = tau (1 - E) - E
//   mean of y over the tick = mean of p - tau (y_1 - y_0)                                         (S2)
// (S2) is exact for any p. A reading that lags says little of the pressure's last move and something of those before: a
// Kalman filter of two states, p and y, weighs it. In a tick p is moved by a model error, evenly, of the given deviation; the
// reading, the mean of y, has kReadingNoise_kPa. The gain is constant, found by kIterations of the Riccati equation when it
// is configured.
//
// Without a lag a reading says what its difference to the predicted mean is, and no more is done with it here.
//
// Source: first-order transducer; Anderson and Moore, Optimal Filtering (1979), 5.4 (one-step predictor with correlated
// noise).
#pragma once

#include <cstdint>

#include "firmware/config/seal.hpp"
#include "firmware/control/pressure_model.hpp"

namespace plenum::control {

class SensorLag {
 public:
  /// `lag_ticks`: tau, 0 or more; `model_noise_kPa`: deviation of the error of a tick's end, above 0.
  void configure(Scalar lag_ticks, Scalar model_noise_kPa) noexcept;

  /// Chamber and sensor stand at this pressure.
  void reset(Scalar pressure_kPa) noexcept { shown_kPa_ = pressure_kPa; }

  bool lags() const noexcept { return lag_ticks_ > Scalar(0); }

  /// A tick passes; the pressure goes from `from_kPa` to what is predicted. Returns the mean that the sensor shows.
  Scalar pass(Scalar from_kPa, const Prediction& predicted) noexcept;

  struct Reading {
    Scalar missed_kPa;  ///< by how much it lies above the predicted one
    Scalar
        above_kPa;  ///< of a sensor that lags, by how much the pressure at the tick's end does; of a prompt one, the same as missed
  };
  /// As pass(), and the tick's reading comes.
  Reading observe(Scalar from_kPa, const Prediction& predicted, Scalar reading_kPa) noexcept;

  /// Of what configure() alone writes: config/seal.hpp.
  std::uint64_t sum_of_constants() const noexcept {
    return config::sum_of_object(lag_ticks_) + config::sum_of_object(left_) +
           config::sum_of_object(by_bend_) + config::sum_of_object(pressure_gain_) +
           config::sum_of_object(shown_gain_);
  }
  std::uint64_t sum_of_estimate() const noexcept { return config::sum_of_object(shown_kPa_); }

  static constexpr int kIterations = 40;
  static constexpr Scalar kReadingNoise_kPa = Scalar(0.3);

 private:
  /// Of y: at the tick's end, and in the mean.
  Prediction shown(Scalar from_kPa, const Prediction& predicted) const noexcept;

  Scalar lag_ticks_ = 0;
  Scalar left_ = 0;     ///< E
  Scalar by_bend_ = 0;  ///< of y_1, by how far the mean of p is off the middle
  Scalar pressure_gain_ = 0, shown_gain_ = 0;
  Scalar shown_kPa_ = 0;  ///< y at the start of the tick
};

}  // namespace plenum::control
