// What of a record is noise, and whether an error is more than that.
#pragma once

#include <vector>

namespace plenum::host::identify::chamber {

/// Standard deviation of white noise on a smooth signal [as the signal], from third differences: those of a smooth
/// pressure vanish, those of noise have variance 20 sigma^2. Taken from the calmer windows of a quarter second at 100
/// Hz, so that jumps of the command do not count. Needs 100 rows; 0 for fewer.
double white_noise(const std::vector<double>& signal);

/// Rows for one independent piece of information in `error`: 1 + 2 sum of its autocorrelation, up to where that falls
/// below a twentieth. 1 for white noise.
double correlation_rows(const std::vector<double>& error);

/// Probability that the means of `error` over blocks of 20 rows are as large as they are if it is white noise of
/// `sigma` (chi-squared, Wilson and Hilferty's approximation): an error that stays on one side for a while is no noise.
double probability_of_noise(const std::vector<double>& error, double sigma);

}  // namespace plenum::host::identify::chamber
