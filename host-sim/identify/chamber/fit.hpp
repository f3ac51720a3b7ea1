// Fits of the chamber with a set of effects to logs, in free run.
//
//   minimise  sum over logs and rows of (reading(figures, start; command, volume) - pressure)^2
//
// Variables: the seven figures of the valve, the parameters of the effects that are on, how early the pressures are stamped, if
// that is asked and can be told, and the gas at each log's first
// row: its pressure, which is estimated, never copied from a noisy averaged sample, and, where heat_transfer is on, its
// warmth, since nobody knows what was done to the gas before. Each is scaled to be of order one.
// The Jacobian is by forward differences, seven columns to a free run in eight lanes.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host-sim/effects/free_run.hpp"
#include "host-sim/trace/log.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::identify::chamber {

/// A log as a fit sees it: rows settled_rows .. fitted_rows - 1 are fitted, the rest is held out. Before that the model
/// forgets what it cannot know: where spool and hose stood before the first row.
struct Record {
  std::string name;
  effects::Drive drive;
  std::vector<double> measured_Pa;
  std::size_t settled_rows = 1;
  std::size_t fitted_rows = 0;
  /// Of the machine as it was before whatever is looked for: only the effects as configured act here.
  bool before = false;
  /// Of the rows from `from` on, every other stretch of so many: the first and third, or where `second` those between.
  struct Half {
    std::size_t from = 0, stretch = 1;
    bool second = false;
  };
  /// Only these count there: what wanders in time is known where it is seen, and judged between.
  std::optional<Half> half = {};

  std::size_t rows() const { return measured_Pa.size(); }
  bool counts(std::size_t row) const {
    return !half || row < half->from || ((row - half->from) / half->stretch % 2 == 1) == half->second;
  }
};

/// The logs of one chamber and what its rig says.
struct Scene {
  effects::Surroundings around;
  effects::Figures nominal{};  ///< [valve] and [effects] as configured, every other effect vanished
  effects::EffectSet known =
      0;  ///< effects as configured: on in every run, with these figures unless a fit changes them
  double noise_Pa = 100.0;
  /// By how much the pressures of all its logs may be stamped early [s]: looked for by each fit that can tell it from what it looks for
  /// besides (a lag of the sensor, or one of the command while the volume rests). 0: they are as nominal says.
  double most_early_s = 0.0;
  std::vector<Record> records;
};

/// `fitted_share` of the rows of `log` are fitted.
Record make_record(const std::string& name, const trace::Log& log, double fitted_share);
Scene make_scene(const trace::RigDescription& rig);

/// How far a log's volume moves, from its least to its most, over its least.
double volume_swing(const Record& record);

/// How large its chamber is: its ports as the rig says, its volume as in the first record.
effects::Size size_of(const Scene& scene);
/// One more log; the mean volume of the first is the chamber's size, and what figures that bend with the volume refer to.
void add_record(Scene& scene, Record record);
/// Has the spline of null_drift reach the end of a log, unless the rig knows that effect.
void reach_end_of(Scene& scene, const Record& record);

/// `figures` with those of `effect` at the values the rig says. Of a volume the valve takes up what it can, which at rest is all: a
/// chamber of twice the volume behind ports of twice the area is the same one.
effects::Figures figures_without(const Scene& scene, effects::Figures figures, std::size_t effect);

/// One variable of a fit: a figure. The starts of the logs are variables besides.
struct Variable {
  std::size_t figure = 0;
  double low = 0.0, high = 0.0;  ///< of the figure's coordinate
  double scale = 1.0;
};

/// The exponent n of heat_transfer, with which the gas is compressed.
inline constexpr std::size_t kExponent = effects::kFirstFigure[effects::kIdHeatTransfer] + 1;
static_assert(effects::kHeatTransferParameters[1].name == "exponent");

/// What share of a logged supply the valve sees: told only by logs of a supply that is not the rig's.
inline constexpr std::size_t kFollowedSupply = effects::kFirstFigure[effects::kIdSupplyDroop] + 4;
static_assert(effects::kSupplyDroopParameters[4].name == "followed_share");
/// How far apart the knots of a wandering null are: given by the logs' lengths.
inline constexpr std::size_t kKnot = effects::kFirstFigure[effects::kIdNullDrift] + effects::kOwnNull;
static_assert(effects::kNullDriftParameters[effects::kOwnNull].name == "knot_s");

/// Whether a log says that the supply is another than the rig's, so that a share of it can be told.
bool logs_supply(const Scene& scene);

/// Whose figures are sought. A board knows of heat_transfer the exponent alone, of a gas that keeps its heat; and which share of a
/// logged supply its valve sees, without the other figures that refine supply_droop.
enum class Whose { rig, board };

/// The figures of the valve alone.
std::vector<Variable> valve_variables(const Scene& scene);

/// The valve's figures, then the parameters of the effects in `on`; those that refine an effect only for `refined`. Last, where it is
/// looked for, how early the pressures are stamped, which is the log's and no trial's.
std::vector<Variable> variables_of(const Scene& scene, effects::EffectSet on, effects::EffectSet refined = 0,
                                   Whose whose = Whose::rig);

struct Fit {
  effects::EffectSet on = 0;
  effects::EffectSet refined = 0;  ///< of these the refining parameters were free, too
  effects::Figures figures{};
  std::vector<effects::Start> start;  ///< a record
  std::vector<Variable> variables;
  std::size_t warmths = 0;  ///< starts whose warmth was free, too
  /// Logs that have, with null_drift refined, a way of the null of their own: their starts hold what it is beyond the figures'.
  std::size_t nulls = 0;
  double squares = 0.0;  ///< [Pa^2]
  std::size_t rows = 0;
  /// Gram matrix of [J e] at the end, by scaled variables (figures, then the start of each record: pressure, warmth
  /// where it is free, the null's way where it has its own).
  Eigen::MatrixXd gram;
  int iterations = 0;
  bool converged = false;
  std::string stop;  ///< why it stopped, in one line

  double rms_Pa() const;
  /// Of the variables those that a trial chose to have: how early the pressures are stamped is of the log.
  std::size_t chosen_variables() const;
};

struct FitOptions {
  int most_iterations = 40;
  double tolerance = 1e-5;  ///< share of the sum of squares below which a step is not worth it
  effects::EffectSet refined = 0;
  bool rising_areas =
      false;  ///< hold area_shape's areas rising over the whole command range (rising_areas.hpp)
  Whose whose = Whose::rig;
};

/// Whether heat flows in a record when `on` is looked for, or may with these variables: then the warmth with which its gas begins is a
/// variable, too. Gas that keeps its heat may be as warm as it likes.
bool conducts(const Scene& scene, const Record& record, effects::EffectSet on,
              const std::vector<Variable>& variables);

/// From `figures`; `start` may be empty, and is then taken from the logs and refined.
Fit fit(const Scene& scene, effects::EffectSet on, const effects::Figures& figures,
        const std::vector<effects::Start>& start, const FitOptions& options = {});

/// Standard errors of a fit's scaled variables, its errors being correlated over so many rows; a variable that the log
/// does not show has a very large one.
Eigen::VectorXd standard_errors(const Fit& fit, double correlated_rows);

/// Sums of squares of the fits that the linearisation at a fit leads to, no variable moving by more than its scale. Infinite where the logs
/// have more starts and ways of the null than kMostVariables has room for.
struct JointSquares {
  double both = 0.0;  ///< over fitted and held-out rows, of the fit to both
  double fitted =
      0.0;  ///< over the fitted rows, of the fit to them alone: where it has converged those of the fit itself
  /// What the held-out rows say against the model, not against figures that the fitted rows left unknown: of a model that is linear
  /// the squares of the error that it foretells them with, e'(1 + J C J')^-1 e, C being the covariance of the fit.
  double judged() const { return both - fitted; }
};

/// `heldout` counts with its settled_rows .. fitted_rows - 1. `held_start`: one each; `same_start`: they are those of the
/// fitted records, in their order.
JointSquares joint_squares(const Scene& scene, const Fit& fit, const std::vector<Record>& heldout,
                           const std::vector<effects::Start>& held_start, bool same_start);

/// Which of `figures` (1 to effects::kLanes) errs least over the fitted rows, each run as it stands.
std::size_t least_error(const Scene& scene, effects::EffectSet on, std::span<const effects::Figures> figures,
                        const std::vector<effects::Start>& start);

/// Readings of a free run over a whole record [Pa].
std::vector<double> run(const Scene& scene, const Record& record, effects::EffectSet on,
                        const effects::Figures& figures, const effects::Start& start);

/// The start that fits the first half second best, or with warmth the first three seconds.
effects::Start estimate_start(const Scene& scene, const Record& record, effects::EffectSet on,
                              const effects::Figures& figures);

/// A way of the null is followed by so much further at a time: over a whole log a free run is far off before its beginning is right.
inline constexpr double kStretch_s = 5.0;
/// The same where the knots of the null's spline are further apart.
double stretch_s(const Scene& scene);

/// `start` with the way of the null that fits the rows of `record` which count, the figures being as `fit` found them.
effects::Start wandering_start(const Scene& scene, const Record& record, const Fit& fit,
                               const effects::Start& start);

/// Sum of squares and number of the rows that are held out, in `record`, from row `first` on, those that count.
struct Score {
  double squares = 0.0;
  std::size_t rows = 0;
  double rms_Pa() const;
};
Score score(const std::vector<double>& reading_Pa, const Record& record, std::size_t first);

/// The error of a reading of `record` on rows `first` to `last` - 1, as far as they have settled [Pa].
std::vector<double> errors_Pa(const std::vector<double>& reading_Pa, const Record& record, std::size_t first,
                              std::size_t last);
/// That of a fit on the fitted rows of its scene's records, one record after the other [Pa].
std::vector<double> fitted_errors_Pa(const Scene& scene, const Fit& fit);

}  // namespace plenum::host::identify::chamber
