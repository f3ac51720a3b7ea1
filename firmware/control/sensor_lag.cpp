#include "firmware/control/sensor_lag.hpp"

#include <Eigen/Core>

namespace plenum::control {

void SensorLag::configure(Scalar lag_ticks, Scalar model_noise_kPa) noexcept {
  lag_ticks_ = lag_ticks > Scalar(1) / numeric::kDecayHigh ? lag_ticks : Scalar(0);
  if (!lags()) return;
  const Scalar done = numeric::decay(Scalar(1) / lag_ticks_);
  left_ = Scalar(1) - done;
  by_bend_ = Scalar(6) * ((lag_ticks_ * done - left_) * (Scalar(1) - Scalar(2) * lag_ticks_) + left_);

  // state (p, y) and (S1), (S2) for a tick in which p moves by the model's error alone
  using Column = Eigen::Matrix<Scalar, 2, 1>;
  using Square = Eigen::Matrix<Scalar, 2, 2>;
  const Scalar moved_y = Scalar(1) - lag_ticks_ * done;
  const Square next{{Scalar(1), Scalar(0)}, {done, left_}};
  const Column moved{Scalar(1), moved_y};
  const Eigen::Matrix<Scalar, 1, 2> read{Scalar(1) - lag_ticks_ * done, lag_ticks_ * done};
  const Scalar read_moved = Scalar(0.5) - lag_ticks_ * moved_y;
  const Scalar variance = model_noise_kPa * model_noise_kPa;
  Square spread = variance * Square::Identity();
  Column gain = Column::Zero();
  for (int i = 0; i < kIterations; ++i) {
    const Column with_reading = next * spread * read.transpose() + moved * (variance * read_moved);
    const Scalar of_reading = read.dot(spread * read.transpose()) + variance * read_moved * read_moved +
                              kReadingNoise_kPa * kReadingNoise_kPa;
    gain = with_reading / of_reading;
    const Square after = next * spread * next.transpose() + variance * moved * moved.transpose() -
                         gain * with_reading.transpose();
    spread = after;
  }
  pressure_gain_ = gain(0);
  shown_gain_ = gain(1);
}

Prediction SensorLag::shown(Scalar from_kPa, const Prediction& predicted) const noexcept {
  const Scalar behind_kPa = lag_ticks_ * (predicted.end_kPa - from_kPa);
  const Scalar bend_kPa = predicted.mean_kPa - Scalar(0.5) * (from_kPa + predicted.end_kPa);
  const Scalar end_kPa =
      predicted.end_kPa - behind_kPa + (shown_kPa_ - from_kPa + behind_kPa) * left_ + by_bend_ * bend_kPa;
  return {.end_kPa = end_kPa, .mean_kPa = predicted.mean_kPa - lag_ticks_ * (end_kPa - shown_kPa_)};
}

Scalar SensorLag::pass(Scalar from_kPa, const Prediction& predicted) noexcept {
  if (!lags()) return predicted.mean_kPa;
  const Prediction reading = shown(from_kPa, predicted);
  shown_kPa_ = reading.end_kPa;
  return reading.mean_kPa;
}

SensorLag::Reading SensorLag::observe(Scalar from_kPa, const Prediction& predicted,
                                      Scalar reading_kPa) noexcept {
  const Scalar missed_kPa = reading_kPa - pass(from_kPa, predicted);
  if (!lags()) return {.missed_kPa = missed_kPa, .above_kPa = missed_kPa};
  shown_kPa_ += shown_gain_ * missed_kPa;
  return {.missed_kPa = missed_kPa, .above_kPa = pressure_gain_ * missed_kPa};
}

}  // namespace plenum::control
