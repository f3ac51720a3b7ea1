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

/// Probability that noise of the kind of `noise`, an error in which nothing is left to explain, has means over blocks of 20
/// rows as large as those of `error`: the ratio of their mean squares, against that of stretches of 2 s at 100 Hz, or a tenth of
/// `noise` where it is shorter than 20 s, drawn from it (moving-block bootstrap, Kuensch 1989; 999 draws, always the same). `sigma`:
/// of the white part; noise that stays on one side for a while counts as noise while it raises the RMS to `greatest` at most.
/// `fitted_to_noise`: figures that were fitted to the rows of `noise`, of which few blocks show the less, but no less than white noise.
/// 1 without 20 rows of each, 0.001 at least.
double probability_of_noise(const std::vector<double>& error, const std::vector<double>& noise,
                            std::size_t fitted_to_noise, double sigma, double greatest);

}  // namespace plenum::host::identify::chamber
