// Logs laid out for fitting: which command, volume and volume rate act on which pressure sample.
//
//   row k of a log:  command u_k held from t_k to t_(k+1); volume v at t_k; pressure y_k = mean of p over
//   [t_k - a, t_k] tick k (t_k to t_(k+1)):  u_k;  v and v' at its MIDDLE;  it ends in the sample y_(k+1)
//
// A valve that answers d = n + f ticks late (0 <= f < 1) acts over tick k by u_(k-n-1) for the first f of it, by u_(k-n) for the
// rest. Predictions take one after the other; to a fit their mean stands for both. To a prediction a log's first command has been held
// before its first row; a fit leaves out the ticks in which one from there acts.
//
// So y_(k+1) depends on u_k alone if a <= h and p(t_k) is known; and p(t_k) follows from y_k through tick
// k-1, with u_(k-1). Reading y_k as p(t_k), as if a were 0, is a delay of a/2 that a fit would take for a
// slower valve.
//
// v and v' at mid-tick: a polynomial of degree 3 fitted by least squares to the 2n rows around the middle
// (Savitzky and Golay 1964; n before, n after), its value and slope there. Non-causal, symmetric: no delay.
// Value and slope are exact for cubics; noise of one row enters v' with the gain sqrt(sum w_i^2), about
// 0.20/h for n = 4. At the two ends of a log the nearest full window is evaluated off its middle.
#pragma once

#include <cstddef>
#include <vector>

#include "host-sim/trace/log.hpp"

namespace plenum::host::identify {

/// Rows of several logs one behind the other. Arrays are as long as all logs together; the tick of a log's
/// last row is unused.
struct Ticks {
  double period_s = 0.01;  ///< of the first log; the others' are the same within trace::kSameRate
  double average_s = 0.01;
  std::vector<double> command_V;         ///< that acts; in the mean
  std::vector<double> early_V;           ///< that acts in the first `early` of a tick
  std::vector<double> late_V;            ///< and in its rest
  double early = 0.0;                    ///< f
  std::size_t unknown = 0;               ///< first ticks of each log in which a command from before it acts
  std::vector<double> volume_mL;         ///< at mid-tick
  std::vector<double> volume_rate_mL_s;  ///< at mid-tick
  std::vector<double> pressure_kPa;      ///< y_k: the sample of this row, BEFORE this tick
  std::vector<std::size_t> begin;        ///< first row of each log, and the number of all rows at the end

  std::size_t size() const { return command_V.size(); }
};

inline constexpr std::size_t kHalfWindow = 4;

/// Rows a log must have: one window.
inline constexpr std::size_t kFewestRows = 2 * kHalfWindow;

/// `dead_time_s`: d, 0 or more. Throws CannotIdentify when there is no log, a log is shorter than kFewestRows, or the logs differ in rate
/// or averaging time, or average over more than a tick.
Ticks lay_out(const std::vector<trace::Log>& logs, double dead_time_s = 0.0);

}  // namespace plenum::host::identify
