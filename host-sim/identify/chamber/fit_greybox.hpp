// From logs of a chamber to the board's grey-box model: README.md of this room says how, and what it was measured to do.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host-sim/identify/estimate.hpp"
#include "host-sim/trace/log.hpp"
#include "host-sim/trace/model_json.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::identify::chamber {

/// A figure of the valve, or of an effect ("area_shape.inlet_slope"), in the unit of its name.
struct FigureFit : Estimate {  ///< its standard error is for errors as correlated as those of the fit
  std::string name;
  bool identifiable =
      false;  ///< not at a bound, and its standard error is small against its scale (README.md)
};

/// A set of effects that was tried: what it errs by on the held-out rows, in free run.
struct TriedEffects {
  std::vector<std::string> effects;  ///< ids; "area_shape, refined" with both bends
  double heldout_kPa = 0.0;
};

/// A figure of an effect that was looked for and not kept, the one that stands for it, as it stays: "dead_time.delay_s" 0.
struct NotTold {
  std::string name;
  double value = 0.0;
};

struct GreyboxFit {
  trace::RigDescription rig;          ///< the given one with the valve as fitted and the effects kept
  std::vector<FigureFit> parameters;  ///< of the last fit, on all rows
  std::vector<NotTold> not_told;
  std::vector<TriedEffects> tried;  ///< in order; the first without any
  std::vector<std::string> kept;    ///< ids of effects
  double noise_kPa = 0.0;           ///< white part of the errors of the last fit
  double rms_next_tick_kPa = 0.0;   ///< next_tick.hpp
  double rms_free_run_kPa = 0.0;    ///< whole logs, each from an estimated start
  double rms_heldout_kPa = 0.0;     ///< of the effects kept, over rows they were not fitted to
  std::size_t rows = 0;
  int iterations = 0;  ///< of the last fit
  bool converged = false;
  std::string stop;  ///< why it stopped, in one line
};

/// Fits the valve's figures to all logs together, and of area_shape, flow_function, volume_error, spool_lag, dead_time, tube_dynamics,
/// chamber_leak, valve_hysteresis, sensor_lag, supply_droop and the exponent of heat_transfer those that the held-out rows demand. What `rig` has as
/// effects stays as configured; its [valve] is one of two starts and need not be near. Throws
/// CannotIdentify, in one line: no log, logs that differ in rate, too few rows, no excitation (excitation.hpp). `progress` is told how
/// far the work is, 0 to 1; how many sets of effects will be tried is not known before, so that it slows down.
GreyboxFit fit_greybox(const std::vector<trace::Log>& logs, const trace::RigDescription& rig,
                       const std::function<void(double done)>& progress = {});

/// A free run over a whole log, from an estimated start.
struct WholeRun {
  std::vector<double> pressure_Pa;
  std::size_t settled_rows =
      0;  ///< rows before this one count in no error: they still show what the start was
};
/// Of a rig that was found.
WholeRun free_run_over(const trace::RigDescription& rig, const trace::Log& log);

/// The file that the tools write: greybox_of(fit.rig), and the fit in numbers. Throws trace::InputError when a figure is beyond what
/// a board takes.
trace::ModelFile to_model_file(const GreyboxFit& fit, std::optional<unsigned> chamber);

}  // namespace plenum::host::identify::chamber
