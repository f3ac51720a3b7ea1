#include "host-sim/plant/converter.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant {
namespace {

struct Moments {
  double mean = 0.0;
  double variance = 0.0;
};

double normal_below(double x) {
  return 0.5 * std::erfc(-x * std::numbers::sqrt2 / 2.0);
}

// Of one rounded sample, in steps: x the input, sigma < 1/2 the noise.
Moments rounded_sample(double x, double sigma) {
  const double nearest = std::round(x);
  if (sigma == 0.0) return {nearest, 0.0};
  Moments moments;
  double square = 0.0;
  for (int k = -5; k <= 5; ++k) {  // codes farther than 4.5 steps are beyond 9 sigma
    const double code = nearest + k;
    const double probability =
        normal_below((code + 0.5 - x) / sigma) - normal_below((code - 0.5 - x) / sigma);
    moments.mean += k * probability;
    square += k * k * probability;
  }
  moments.variance = std::max(square - moments.mean * moments.mean, 0.0);
  moments.mean += nearest;
  return moments;
}

}  // namespace

AveragingAdc::AveragingAdc(const AdcConfig& config, const Random& random)
    : config_(config), random_(random), step_V_(0.0) {
  require_finite("adc low_V", config.low_V);
  require_above("adc high_V", config.high_V, config.low_V);
  require_within("adc bits", config.bits, 4, 32);
  require_within("adc sample_noise_V", config.sample_noise_V, 0.0, config.high_V - config.low_V);
  require_within("adc samples_per_tick", config.samples_per_tick, 1, 1e6);
  step_V_ = (config.high_V - config.low_V) / std::exp2(config.bits);
}

double AveragingAdc::read_V(double mean_V) {
  const double x = (mean_V - config_.low_V) / step_V_;
  const double sigma = config_.sample_noise_V / step_V_;
  const double N = config_.samples_per_tick;
  const Moments sample = sigma >= 0.5 ? Moments{x, sigma * sigma + 1.0 / 12.0} : rounded_sample(x, sigma);
  double block = sample.mean;
  if (sample.variance > 0.0) block += std::sqrt(sample.variance / N) * random_.gaussian();
  return config_.low_V + step_V_ * std::clamp(block, 0.0, std::exp2(config_.bits) - 1.0);
}

Dac::Dac(int bits, double span_V) : span_V_(span_V), step_V_(0.0) {
  require_within("dac bits", bits, 4, 32);
  require_above("dac span_V", span_V, 0.0);
  step_V_ = span_V / (std::exp2(bits) - 1.0);
}

double Dac::write_V(double command_V) {
  if (std::isfinite(command_V))
    output_V_ = step_V_ * std::round(std::clamp(command_V, 0.0, span_V_) / step_V_);
  return output_V_;
}

}  // namespace plenum::host::plant
