// From the raw samples of a cyclic test to a record that can be differentiated.
//
//   cyclic average   y_k = 1/N sum_n y_(k + n P)                    P rows a period, N periods
//   moving average   y_k = 1/w (y_k + .. + y_(k+w-1)), stamped with the mean of the same rows' times
//   rate             ydot_k = (y_(k+1) - y_(k-1)) / (t_(k+1) - t_(k-1))
//
// A moving average of w rows nulls periodic noise of w rows (10 rows at 1 kHz: 100 Hz and its multiples). It
// only takes whole windows, so that the step of the command before a record never leaks into it.
// Source: "Parameter Identification and Evaluation of a Proportional Directional Flow Control Valve Model",
// Parameter Identification: 10 periods, a window of 10.
#pragma once

#include <cstddef>
#include <vector>

#include "host-sim/identify/orifice/vessel.hpp"

namespace plenum::host::identify::orifice {

/// The mean of `periods` equal periods, as long as one of them. Throws std::invalid_argument unless the
/// samples are `periods` whole periods.
std::vector<double> cyclic_average(const std::vector<double>& samples, std::size_t periods);

/// The record under a moving average of `window` rows, window - 1 rows shorter. Throws std::invalid_argument
/// for a window of 0 or longer than the record.
VesselRecord moving_average(const VesselRecord& record, std::size_t window);

/// Means of blocks of `rows` rows; a rest shorter than a block is left out. For slow records of many samples.
/// Throws std::invalid_argument for a block of 0 or longer than the record.
VesselRecord block_means(const VesselRecord& record, std::size_t rows);

/// Rows `first` to before `last`. Throws std::invalid_argument unless first <= last, no more than the record has.
VesselRecord rows_of(const VesselRecord& record, std::size_t first, std::size_t last);

/// The record with its far pressure replaced by the mean: for a supply that is steady but for the sensor's
/// noise. A free run takes the far pressure as exact, and at the cracking ratio, where the flow has a corner,
/// a noisy one pumps the vessel up to its crests.
VesselRecord steady_far_side(VesselRecord record);

/// The standard deviation of white noise on a smooth signal [unit of the signal], by its second differences, whose median is
/// deaf to the few rows of a step. Throws std::invalid_argument for fewer than three values.
double noise_deviation(const std::vector<double>& signal);

/// A record with the rate of change of the vessel's pressure; the first and the last row are lost.
struct RateRecord {
  VesselRecord at;
  std::vector<double> rate_Pa_s;
};

/// Throws std::invalid_argument for fewer than three rows.
RateRecord differentiated(const VesselRecord& record);

}  // namespace plenum::host::identify::orifice
