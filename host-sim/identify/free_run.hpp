// Free-run prediction: the model fed with the measured command and volume, its own pressure carried on from
// tick to tick.
//
// A prediction for row k is what the sensor would read there: the mean of (7) over the averaging time before
// t_k. It starts from the measured sample of the start row alone, taken back to p(t) through the tick before
// it (end_from_mean).
//
// Source: Modeling and Identification of Pneumatic Actuators, section V.D, Fig. 12 and 13.
#pragma once

#include <cstddef>
#include <vector>

#include "host-sim/identify/tassa9.hpp"
#include "host-sim/identify/ticks.hpp"
#include "host-sim/trace/log.hpp"

namespace plenum::host::identify {

/// Predicted pressures of the rows start_row + 1 .. start_row + rows [Pa]. `log` has more than start_row +
/// rows rows.
std::vector<double> predict_free_run(const Tassa9& model, const trace::Log& log, std::size_t start_row,
                                     std::size_t rows);

/// As above on rows laid out before (all one log), in kPa: for many predictions of one log.
std::vector<double> predict_free_run_kPa(const Tassa9& model, const Ticks& ticks, std::size_t start_row,
                                         std::size_t rows);

/// One re-initialised run.
struct FreeRun {
  std::size_t start_row;
  std::vector<double> pressure_Pa;  ///< of rows start_row + 1 onward
};

/// The log predicted in runs of `every_s`, each started from the measurement (Fig. 12).
std::vector<FreeRun> reinitialised_runs(const Tassa9& model, const trace::Log& log, double every_s = 2.0);

/// RMS of predicted minus measured over all re-initialised runs [kPa].
double free_run_rms_kPa(const Tassa9& model, const trace::Log& log, double every_s = 2.0);

/// The same for a prediction that knows nothing and holds the measured start of each run [kPa]: what a model
/// must beat.
double held_start_rms_kPa(const trace::Log& log, double every_s = 2.0);

/// Errors of free runs against the time since their start, over all starts (Fig. 13), in percent of P_c -
/// P_r.
struct Drift {
  std::vector<double> time_s;
  std::vector<double> std_percent;   ///< standard deviation about the mean, n - 1
  std::vector<double> mean_percent;  ///< what the standard deviation does not show
  double worst_std_percent = 0.0;    ///< largest of std_percent
};

/// `starts` runs of `horizon_s`, their starts spread evenly from the first row to the last from which a
/// horizon fits. Throws CannotIdentify when the log is shorter than the horizon or starts < 2.
Drift drift(const trace::Log& log, const Tassa9& model, std::size_t starts = 48, double horizon_s = 2.0);

}  // namespace plenum::host::identify
