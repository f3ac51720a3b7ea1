// References that a board is asked to follow, and how well it did.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "host-sim/client/capture.hpp"
#include "host-sim/client/session.hpp"

namespace plenum::host::client {

enum class ReferenceKind { sine, steps, trapezoid, random };

/// A reference between mean - amplitude and mean + amplitude, sampled at 100 Hz.
///   sine       mean + amplitude sin(2 pi f t)
///   steps      a square wave of frequency f, chamber c a tenth of a period later than chamber c - 1
///   trapezoid  up, hold, down, hold: a quarter of a period each
///   random     12 sines spread evenly over f/10 .. f, their phases drawn; amplitude is 2.7 standard
///   deviations
struct ReferenceShape {
  ReferenceKind kind = ReferenceKind::sine;
  double mean_Pa = 350'000.0;
  double amplitude_Pa = 100'000.0;
  double frequency_Hz = 1.0;
  std::uint32_t seed = 1;  ///< random only
};

/// One reference a chamber. Throws std::invalid_argument for a frequency that is not above 0 and below 50 Hz.
std::vector<std::vector<double>> references(const ReferenceShape& shape, unsigned chambers, double seconds);

/// A board clips a set point to its chamber's limits (63A1h, 63A0h) and follows what is left. Throws std::invalid_argument, which
/// says of which chamber, for references [Pa] that it would not follow as they are; as Session does.
void require_within_limits(Session& session, std::span<const std::vector<double>> references_Pa);

/// How a chamber followed its reference. A recorded pressure is the mean over the tick before its row, so it
/// is held against the mean of the references at the tick's two ends.
struct Tracking {
  double rmse_Pa = 0.0;
  double worst_Pa = 0.0;
  /// Farthest beyond a step's target, and longest time until the pressure stays within 1 % of span of it,
  /// over all steps, which lead from rest to rest over more than 5 % of span; NaN without such a step, the latter also
  /// when one never settled.
  double overshoot_Pa = std::numeric_limits<double>::quiet_NaN();
  double settling_s = std::numeric_limits<double>::quiet_NaN();
};

inline constexpr std::size_t kOnsetRows =
    50;  ///< the first half second, the way onto the reference, is left out

inline constexpr std::size_t kPreviewRows =
    8;  ///< before a step: a board that knows of it begins early, so these are left out of its settling

/// Of the rows of follow(). `sensor_lag_s`: what the sensor lags by, as the chamber's model says; its readings are held against what
/// it would show of the reference, RMS and worst; 0 for a prompt one. Throws std::invalid_argument for fewer than kOnsetRows + 2 rows.
Tracking tracking(std::span<const CapturedRow> rows, std::size_t chamber, double span_Pa,
                  double sensor_lag_s = 0.0);

}  // namespace plenum::host::client
