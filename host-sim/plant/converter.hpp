// The converters of the front end.
//
// AveragingAdc: the mean over a tick of N samples Q(x + n), n white and Gaussian with deviation sigma, Q
// rounding to the step q = range / 2^bits. For a signal that rests within the tick, mean and variance of the
// block are exact; its distribution is taken as Gaussian (central limit, N = 200), one deviate a tick:
//   sigma >= q/2: mean x (bias below 0.0023 q), variance (sigma^2 + q^2/12) / N
//   sigma <  q/2: E Q = sum_k k q P_k, Var Q = sum_k (k q)^2 P_k - (E Q)^2, P_k by the normal distribution;
//                 at sigma = 0 plain rounding of the mean, an error that repeats
// Assumptions: samples independent; a signal that moves by more than a step within the tick is linearised by
// that, which the second line does not grant it. The grid q / N of a block mean is not reproduced. The mean
// is clipped to the codes, exact farther than 4 sigma from the rails. Vanishes: many bits and no noise give
// the mean itself.
//
// Dac: rounds to the nearest code of 2^bits over 0..span, and holds it until the next write.
// Source: sampling at 20 kHz averaged by 200: "Modeling and Identification of Pneumatic Actuators", V.
#pragma once

#include "host-sim/plant/random.hpp"

namespace plenum::host::plant {

struct AdcConfig {
  double low_V = 0.0;
  double high_V = 10.0;
  int bits = 16;                ///< 4 to 32
  double sample_noise_V = 0.0;  ///< standard deviation of one sample
  int samples_per_tick = 200;
};

class AveragingAdc {
 public:
  /// Throws std::invalid_argument naming the field when a figure is out of range.
  AveragingAdc(const AdcConfig& config, const Random& random);

  /// The block mean that the board reads [V] when the input had `mean_V` over the tick.
  double read_V(double mean_V);

  double step_V() const { return step_V_; }

 private:
  AdcConfig config_;
  Random random_;
  double step_V_;
};

class Dac {
 public:
  /// Throws std::invalid_argument naming the field when a figure is out of range.
  explicit Dac(int bits = 16, double span_V = 10.0);

  /// Takes the nearest code and holds it; a value that is not finite changes nothing. Returns the output [V].
  double write_V(double command_V);

  double output_V() const { return output_V_; }
  double step_V() const { return step_V_; }

 private:
  double span_V_;
  double step_V_;
  double output_V_ = 0.0;
};

}  // namespace plenum::host::plant
