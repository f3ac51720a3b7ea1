#include "firmware/control/volume_observer.hpp"

namespace plenum::control {
namespace {

using Vector3 = Eigen::Matrix<Scalar, 3, 1>;
using Matrix3 = Eigen::Matrix<Scalar, 3, 3>;

// The slowest mode of interest settles in a few hundred ticks.
constexpr int kRiccatiSteps = 400;
// Of lambda.
constexpr Scalar kLeastIndex = Scalar(1e-4), kMostIndex = Scalar(64);

Vector3 predict(const Vector3& x) noexcept {
  return {x[0] + x[1] + numeric::shifted_down<1>(x[2]), x[1] + x[2], x[2]};
}

}  // namespace

void VolumeObserver::configure(const Config& config) noexcept {
  const Scalar lambda = numeric::clamp(config.tracking_index, kLeastIndex, kMostIndex);
  Scalar s(1);
  while (s * s * s > lambda) s *= Scalar(0.5);
  while (Scalar(8) * s * s * s <= lambda) s *= Scalar(2);
  Matrix3 transition;
  transition << Scalar(1), s, Scalar(0.5) * s * s, Scalar(0), Scalar(1), s, Scalar(0), Scalar(0), Scalar(1);
  // A jerk held over a tick, independent from tick to tick.
  const Vector3 push(lambda / Scalar(6), Scalar(0.5) * lambda / s, lambda / (s * s));
  Matrix3 covariance = Matrix3::Identity();
  for (int i = 0; i < kRiccatiSteps; ++i) {
    covariance = Matrix3(transition * covariance * transition.transpose() + push * push.transpose());
    gain_ = covariance.col(0) / (covariance(0, 0) + Scalar(1));
    covariance -= Matrix3(gain_ * covariance.row(0));
    covariance = Matrix3((covariance + covariance.transpose()) * Scalar(0.5));
  }
  gain_ = State(gain_[0], gain_[1] * s, gain_[2] * s * s);
}

void VolumeObserver::reset(Scalar volume_mL) noexcept {
  state_ = Vector3(volume_mL, Scalar(0), Scalar(0));
}

ChamberMotion VolumeObserver::step(Scalar measured_mL) noexcept {
  state_ = predict(state_);
  state_ += gain_ * (measured_mL - state_[0]);
  return motion(predict(state_));
}

ChamberMotion VolumeObserver::coast() noexcept {
  state_ = predict(state_);
  return motion(predict(state_));
}

ChamberMotion VolumeObserver::motion(const State& state) noexcept {
  constexpr Scalar kPerSecond = Scalar(1) / kTick_s;
  return {.volume_mL = state[0], .volume_rate_mL_s = state[1] * kPerSecond};
}

}  // namespace plenum::control
