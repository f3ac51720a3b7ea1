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
#include <functional>
#include <limits>
#include <vector>

#include "host-sim/identify/tassa9.hpp"
#include "host-sim/identify/ticks.hpp"
#include "host-sim/trace/log.hpp"

namespace plenum::host::identify {

/// Predicted pressures of the rows start_row + 1 .. start_row + rows [Pa]. `log` has more than start_row +
/// rows rows.
std::vector<double> predict_free_run(const Tassa9& model, const trace::Log& log, std::size_t start_row,
                                     std::size_t rows);

/// As above on rows laid out before (all one log, with the model's dead time), in kPa: for many predictions of one log.
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

/// RMS of predicted minus measured, each row predicted from the one before it [kPa]. `ticks`: laid out with the model's dead time.
/// `from_row`: of each log the first that is predicted from, at least 1; NaN where no row is left.
double next_tick_rms_kPa(const Tassa9& model, const Ticks& ticks, std::size_t from_row = 1);

/// The same as free_run_rms_kPa() for a prediction that knows nothing and holds the measured start of each run [kPa]: what a model
/// must beat.
double held_start_rms_kPa(const trace::Log& log, double every_s = 2.0);

/// The same for one that holds the log's mean over all of it, as a model's free run over the whole log must beat.
double held_mean_rms_kPa(const trace::Log& log);

/// Errors of free runs against the time since their start, over all starts (Fig. 13), in percent of P_c -
/// P_r.
struct Drift {
  std::vector<double> time_s;
  std::vector<double> std_percent;   ///< standard deviation about the mean, n - 1
  std::vector<double> mean_percent;  ///< what the standard deviation does not show
  double worst_std_percent = 0.0;    ///< largest of std_percent
};

/// Which free runs a drift is of: their starts are spread evenly over the rows from `from_row` to the last from which a horizon
/// fits before `to_row`.
struct DriftRuns {
  std::size_t from_row = 0;
  std::size_t to_row = std::numeric_limits<std::size_t>::max();  ///< beyond the log: its end
  std::size_t starts = 48;
  double horizon_s = 2.0;
};

/// What a model reads of one log in the rows start_row + 1 .. start_row + rows [kPa].
using Predictor = std::function<std::vector<double>(std::size_t start_row, std::size_t rows)>;

/// Of any model, over one log. Throws CannotIdentify when the rows are fewer than horizon and starts, or starts < 2.
Drift drift(const Ticks& ticks, double span_kPa, const Predictor& predict, const DriftRuns& runs);

/// Of a nine-parameter model over a whole log, likewise.
Drift drift(const trace::Log& log, const Tassa9& model, std::size_t starts = 48, double horizon_s = 2.0);

}  // namespace plenum::host::identify
