// Bounded nonlinear least squares of c1..c9 on recorded logs: README.md of this room says what is minimised
// and why.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/identify/estimate.hpp"
#include "host-sim/identify/tassa9.hpp"
#include "host-sim/identify/ticks.hpp"
#include "host-sim/trace/log.hpp"
#include "host-sim/trace/model_json.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::identify {

struct FitOptions {
  /// Start here instead of at the built-in start. Values outside of the bounds are moved inside.
  std::optional<Tassa9> start;
  /// Follow a few fixed starts besides the given one on a part of the data, and the best two on all of it.
  /// Chambers whose volume moves much have a second minimum (the null half a volt off, 4 to 30 % higher) into
  /// which many starts fall without this. false: the solver starts where it is told and nowhere else.
  bool explore = true;
  /// After the one-step fit, minimise the free-run error over stretches of `stretch_s`, from the one-step
  /// minimum.
  bool refine_free_run = true;
  double stretch_s = 2.0;
  double c_gamma_V = 0.1;
  double dead_time_s = 0.0;
  Form form = Form::published;
  int most_iterations = 200;  ///< of each of the two fits
};

/// One parameter of a fit. The bounds (V: the mean volume), Table I where it gives one, else practical:
///
///   c1  2 .. 8 V                c4                +-2 c_s/rms(v')
///   c2  1e-3 .. 50 1/V          c5/(1 + c6 V)     +-10/V
///   c3  -c2/192 .. 500 1/V3     c6                0 .. 1000/V
///   c8  -0.99 .. 0.99           c7/(1 + c6 V)     1e-3 .. 200 1/(V s)
///   c9  c_gamma (1 - sqrt(1 - c8^2)) + 1e-4 .. that + 5 V
///
/// Two of these are joint, because Table I is not enough for what the paper asks of the model:
///   - s rises with u on the whole 0..10 V only where c2 + 3 c3 U^2 >= 0; "c3 > -1" does not give that.
///     |U| is 8 V at most for 2 < c1 < 8, hence c3 >= -c2/(3 8^2).
///   - k > 0 for every u only if c9 > c_gamma (1 - sqrt(1 - c8^2)), the depth of the minimum of
///     sqrt(U^2 + c_gamma^2) - c_gamma + c8 U.
/// c6 = 1000/V is a rate inverse to the volume but for 0.1 % of the mean: no log can tell it from the limit.
/// Above c7/(1 + c6 V) = 200 1/(V s) a tick of 10 ms no longer shows the rate.
struct ParameterFit : Estimate {
  bool held =
      false;  ///< not fitted but 0: c4, c5 where the volume does not move, c6 where it is one; c4 of the
              ///< repaired form
  bool identifiable = false;  ///< free, and its standard error is small against its scale (README.md)
};

struct Tassa9Fit {
  Tassa9 model;
  std::array<ParameterFit, kFree> parameters;
  ParameterFit dead_time;  ///< [s]; held where it was given
  /// Of c1..c9; rows and columns of parameters at a bound or held are zero. From the errors of the last fit
  /// done, taken as white: exact for white sensor noise on a chamber that obeys the model, a lower bound
  /// elsewhere.
  Eigen::Matrix<double, kFree, kFree> covariance;
  double condition = 0.0;  ///< of the Jacobian by the free parameters, columns scaled to unit length
  double rms_one_step_kPa = 0.0;
  double rms_free_run_kPa = 0.0;  ///< over stretches of stretch_s, initial pressures estimated
  double cost_kPa2 = 0.0;         ///< half the sum of squares of the last fit done
  int iterations = 0;
  bool converged = false;
  std::string stop;  ///< why it stopped, in one line
  std::size_t rows = 0;
  double rate_not_positive_fraction =
      0.0;  ///< share of ticks at which (10e) gives r <= 0, against the paper's r > 0
};

/// Fits c1..c9, of the repaired form all but c4, to all logs together; P_c and P_r are the rig's. One thread; may be called from several at
/// once. Throws CannotIdentify, in one line: no log, logs that differ in rate, too few rows, no excitation
/// (excitation.hpp), a rank-deficient Jacobian (which parameters), a rate that the logs do not tell: c7/(1 + c6 V) at its lower bound,
/// or its standard error larger than itself; commands on both sides of a null that the rig has above c1's range.
Tassa9Fit fit_tassa9(const std::vector<trace::Log>& logs, const trace::RigDescription& rig,
                     const FitOptions& options = {});

/// Enough to tell c4 and c5, and with them the two forms apart: by a thousandth of the mean volume a second (RMS).
bool volume_moves(const Ticks& ticks);

/// The model of the least error of the next tick at the dead time, width and form of `options`, whatever these logs tell of its
/// parameters: to compare what a fit holds by. `ticks`: the logs laid out with that dead time. Throws CannotIdentify where
/// fit_tassa9() does for the logs' length and null.
Tassa9 least_next_tick_error(const Ticks& ticks, const trace::RigDescription& rig,
                             const FitOptions& options = {});

/// The start that is used when none is given: null command at the middle of the commands, a smooth kink, the
/// rate that the largest pressure changes in the logs ask for.
Tassa9 default_start(const std::vector<trace::Log>& logs, const trace::RigDescription& rig);

/// Draws a start within the bounds from 9 numbers in [0, 1). Bounds of several decades (c2, c3, c6, c7, c9)
/// are drawn in the logarithm. For measuring how often the fit ends in the same minimum.
Tassa9 start_within_bounds(const std::array<double, kFree>& unit, const std::vector<trace::Log>& logs,
                           const trace::RigDescription& rig);

/// The file that the tools write: kind, parameters, and the fit in numbers.
trace::ModelFile to_model_file(const Tassa9Fit& fit, std::optional<unsigned> chamber);

}  // namespace plenum::host::identify
