#include "host-sim/identify/chamber/fit_greybox.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <thread>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/chamber/area_table.hpp"
#include "host-sim/identify/chamber/fit.hpp"
#include "host-sim/identify/chamber/next_tick.hpp"
#include "host-sim/identify/chamber/noise.hpp"
#include "host-sim/identify/chamber/valve_figures.hpp"
#include "host-sim/identify/excitation.hpp"
#include "host-sim/identify/greybox.hpp"
#include "host-sim/identify/in_parallel.hpp"
#include "host-sim/identify/ticks.hpp"

namespace plenum::host::identify::chamber {
namespace {

using effects::EffectSet;
using effects::Figures;

constexpr double kFittedShare = 0.6;  // while effects are chosen; then all rows
/// An effect is kept when without it the squares of the held-out rows are larger by this share.
constexpr double kWorthKeeping = 0.1;
/// One that leaves more of them than this may only stand in for two others.
constexpr double kStandIn = 0.5;
/// And, of one figure, when that is so many standard errors from where it vanishes.
constexpr double kTold = 3.0;
constexpr double kNothingLeft = 1.05;  // of the noise
constexpr std::size_t kFewestTicks = 200;
constexpr double kShareOfChoice = 0.8;  // of the progress that is told; the rest is the last fit
constexpr double kUsualTrials = 10.0;
constexpr int kMostIterations = 100;
/// Of a trial; where a choice hangs on one it is fitted to its end.
constexpr double kTrialTolerance = 1e-3;

/// What a board's model has figures for; of heat_transfer that is the exponent. The first kPaired are tried two together as well: of
/// those each can stand in for another, or hide it.
constexpr std::array kCandidates{
    effects::kIdAreaShape,       effects::kIdFlowFunction, effects::kIdVolumeError,  effects::kIdSpoolLag,
    effects::kIdDeadTime,        effects::kIdTubeDynamics, effects::kIdHeatTransfer, effects::kIdChamberLeak,
    effects::kIdValveHysteresis, effects::kIdSensorLag,    effects::kIdSupplyDroop};
constexpr std::size_t kPaired = 6;

EffectSet bit(std::size_t effect) {
  return EffectSet{1} << effect;
}

/// By which an effect is sought: its first figure; of heat_transfer the exponent.
std::size_t sought_figure(std::size_t effect) {
  return effect == effects::kIdHeatTransfer ? kExponent : effects::kFirstFigure[effect];
}
const effects::Parameter& sought_parameter(std::size_t effect) {
  return effects::kCatalogue[effect]->parameters[sought_figure(effect) - effects::kFirstFigure[effect]];
}

/// What may be added to a fit, or taken out: an effect, or the refining parameters of one.
struct Part {
  EffectSet on = 0;
  EffectSet refined = 0;
};

struct Trial {
  Fit fit;
  double heldout_squares = std::numeric_limits<double>::infinity();
  std::size_t heldout_rows = 0;
  bool ended = false;  ///< fitted to its end

  double heldout_Pa() const { return std::sqrt(heldout_squares / static_cast<double>(heldout_rows)); }
  bool has(const Part& part) const {
    return (fit.on & part.on) == part.on && (fit.refined & part.refined) == part.refined;
  }
};

FitOptions options_of(EffectSet refined, int most_iterations) {
  return {
      .most_iterations = most_iterations, .refined = refined, .rising_areas = true, .whose = Whose::board};
}

Scene scene_of(const std::vector<trace::Log>& logs, const trace::RigDescription& rig, double fitted_share) {
  Scene scene = make_scene(rig);
  for (const trace::Log& log : logs) add_record(scene, make_record({}, log, fitted_share));
  return scene;
}

void require_learnable(const std::vector<trace::Log>& logs) {
  const Ticks ticks = lay_out(logs);
  if (ticks.size() < kFewestTicks) {
    throw CannotIdentify(fmt::format("too short: {} rows, expected at least {}", ticks.size(), kFewestTicks));
  }
  require_excitation(ticks);
}

class Chooser {
 public:
  Chooser(Scene scene, const std::function<void(double)>& progress)
      : scene_(std::move(scene)), table_(area_table(scene_)), progress_(progress) {
    scene_.nominal = better_start();
    for (const std::size_t id : kCandidates) {
      if ((scene_.known & bit(id)) == 0) candidates_.push_back(id);
    }
  }

  const std::vector<std::size_t>& candidates() const { return candidates_; }
  const Trial& best() const { return best_; }
  const std::vector<TriedEffects>& tried() const { return tried_; }

  /// What this set errs by on the rows held out, in kPa, fitted from there to its end.
  double heldout_kPa(EffectSet on, EffectSet refined, const Figures& figures) {
    if (best_.fit.on != on || best_.fit.refined != refined) best_ = trial({on, refined}, {figures});
    end(best_);
    return 1e-3 * best_.heldout_Pa();
  }

  void choose() {
    best_ = plain_ = trial({}, {scene_.nominal});
    while (!at_the_noise() && (enlarged() || refined())) {
    }
    while (reduced()) {
    }
  }

 private:
  /// The [valve] of the rig, or the one nearest to the table: what errs less.
  Figures better_start() const {
    const Figures own = nearest_valve(table_, scene_.nominal, 0);
    return squares_at(own) < squares_at(scene_.nominal) ? own : scene_.nominal;
  }
  double squares_at(const Figures& figures) const {
    double squares = 0.0;
    for (const Record& record : scene_.records) {
      const effects::Start start = estimate_start(scene_, record, 0, figures);
      squares += score(run(scene_, record, 0, figures, start), record, 1).squares;
    }
    return squares;
  }

  /// A fit that is to be tried, from each of the starts.
  struct Attempt {
    Part part;
    std::vector<Figures> starts;
  };

  Trial trial(const Part& part, const std::vector<Figures>& starts) {
    return std::move(trials({{part, starts}}).front());
  }

  /// Of each attempt, side by side.
  std::vector<Trial> trials(const std::vector<Attempt>& attempts) {
    std::vector<Trial> made(attempts.size());
    auto count = static_cast<double>(tried_.size());
    in_parallel(
        attempts.size(), std::thread::hardware_concurrency(),
        [&](std::size_t i) { made[i] = trial(attempts[i]); },
        [&](double) {
          count += 1.0;
          if (progress_) progress_(kShareOfChoice * count / (count + kUsualTrials));
        });
    for (const Trial& one : made) note(one);
    return made;
  }

  Trial trial(const Attempt& attempt) const {
    FitOptions options = options_of(attempt.part.refined, kMostIterations);
    options.tolerance = kTrialTolerance;
    Fit least;
    for (const Figures& start : attempt.starts) {
      Fit found = fit(scene_, attempt.part.on, start, {}, options);
      if (least.rows == 0 || found.squares < least.squares) least = std::move(found);
    }
    return held_out(std::move(least));
  }

  /// What stopped early errs in rows that it was not fitted to by as much as a small effect.
  void end(Trial& trial) const {
    if (trial.ended) return;
    trial = held_out(fit(scene_, trial.fit.on, trial.fit.figures, trial.fit.start,
                         options_of(trial.fit.refined, kMostIterations)));
    trial.ended = true;
  }

  Trial held_out(Fit found) const {
    Trial tried{.fit = std::move(found), .heldout_squares = 0.0};
    for (std::size_t r = 0; r < scene_.records.size(); ++r) {
      const Record& record = scene_.records[r];
      const auto reading_Pa = run(scene_, record, tried.fit.on, tried.fit.figures, tried.fit.start[r]);
      const Score held = score(reading_Pa, record, record.fitted_rows);
      tried.heldout_squares += held.squares;
      tried.heldout_rows += held.rows;
    }
    return tried;
  }

  void note(const Trial& trial) {
    TriedEffects one;
    for (const std::size_t id : candidates_) {
      if ((trial.fit.on & bit(id)) == 0) continue;
      const bool refined = (trial.fit.refined & bit(id)) != 0;
      one.effects.push_back(std::string(effects::kCatalogue[id]->id) + (refined ? ", refined" : ""));
    }
    one.heldout_kPa = 1e-3 * trial.heldout_Pa();
    tried_.push_back(std::move(one));
  }

  bool at_the_noise() const {
    const std::vector<double> errors = fitted_errors_Pa(scene_, best_.fit);
    return best_.fit.rms_Pa() < kNothingLeft * white_noise(errors);
  }

  static bool pays(const Trial& with, const Trial& without) {
    return (1.0 + kWorthKeeping) * with.heldout_squares < without.heldout_squares;
  }
  /// Whether it still does when both are fitted to their ends.
  bool pays_at_the_end(Trial& with, Trial& without) const {
    if (!pays(with, without)) return false;
    end(with);
    end(without);
    return pays(with, without);
  }
  /// Takes `with` for the best when it is worth it.
  bool taken(Trial with) {
    if (!pays_at_the_end(with, best_)) return false;
    best_ = std::move(with);
    return true;
  }

  /// By one effect; beside a valve's figures alone, where none takes off enough to be more than a stand-in, by two where they
  /// are better.
  bool enlarged() {
    std::vector<Attempt> singles;
    for (const std::size_t id : candidates_) {
      if ((best_.fit.on & bit(id)) == 0) singles.push_back(with({id, id}));
    }
    Trial most = least_held_out(singles);
    if (best_.fit.on != 0 || most.heldout_squares < kStandIn * best_.heldout_squares)
      return taken(std::move(most));
    std::vector<Attempt> pairs;
    for (std::size_t i = 0; i < kPaired; ++i) {
      for (std::size_t j = i + 1; j < kPaired; ++j) {
        if ((scene_.known & (bit(kCandidates[i]) | bit(kCandidates[j]))) == 0)
          pairs.push_back(with({kCandidates[i], kCandidates[j]}));
      }
    }
    Trial two = least_held_out(pairs);
    return taken(std::move(two.heldout_squares < most.heldout_squares ? two : most));
  }
  Trial least_held_out(const std::vector<Attempt>& attempts) {
    Trial least;
    for (Trial& one : trials(attempts)) {
      if (one.heldout_squares < least.heldout_squares) least = std::move(one);
    }
    return least;
  }
  /// What is best so far, with two more effects, or one given twice.
  Attempt with(const std::array<std::size_t, 2>& ids) const {
    EffectSet added = 0;
    Figures start = best_.fit.figures;
    for (const std::size_t id : ids) {
      added |= bit(id);
      start = begun(start, id);
    }
    Attempt attempt{{best_.fit.on | added, best_.fit.refined}, {start}};
    if ((added & bit(effects::kIdAreaShape)) != 0)
      attempt.starts.push_back(nearest_valve(table_, start, attempt.part.on));
    if ((added & bit(effects::kIdSupplyDroop)) != 0 && logs_supply(scene_)) {
      // as the logs have it: where others draw, no resistance is found to begin from
      attempt.starts.push_back(start);
      attempt.starts.back()[sought_figure(effects::kIdSupplyDroop)] = 0.0;
      attempt.starts.back()[kFollowedSupply] = 1.0;
    }
    return attempt;
  }

  /// An effect that vanishes at a bound begins a step off it.
  Figures begun(Figures figures, std::size_t id) const {
    const effects::Parameter sought = sought_parameter(id).of(size_of(scene_));
    double& at = figures[sought_figure(id)];
    if (at == sought.least()) at = sought.least() + sought.typical_change;
    return figures;
  }

  bool refined() {
    const EffectSet shape = bit(effects::kIdAreaShape);
    if ((best_.fit.on & shape) == 0 || (best_.fit.refined & shape) != 0) return false;
    return taken(trial({best_.fit.on, best_.fit.refined | shape}, {best_.fit.figures}));
  }

  /// Without one effect that the others have made needless, or that no longer pays alone.
  bool reduced() {
    for (const std::size_t id : candidates_) {
      if ((best_.fit.on & bit(id)) == 0) continue;
      Trial rest = best_.fit.on == bit(id) ? plain_
                                           : trial({best_.fit.on & ~bit(id), best_.fit.refined & ~bit(id)},
                                                   {figures_without(scene_, best_.fit.figures, id)});
      if (!pays_at_the_end(best_, rest)) {
        best_ = std::move(rest);
        return true;
      }
    }
    return false;
  }

  Scene scene_;
  AreaTable table_;
  const std::function<void(double)>& progress_;
  std::vector<std::size_t> candidates_;  ///< those that the rig does not state
  Trial plain_;                          ///< without any effect
  Trial best_;
  std::vector<TriedEffects> tried_;
};

/// A quarter of a gain, or the change by which another figure is sought, is much not to know of it.
bool is_known(const Variable& of, double at, double standard_error) {
  const bool gain = of.figure == effects::kInletGain || of.figure == effects::kExhaustGain;
  return standard_error < (gain ? 0.25 * at : of.scale);
}

/// Where a figure has its name, and in a rig its place.
struct Place {
  std::string name;
  double* value = nullptr;
  const effects::Parameter* parameter = nullptr;  ///< of an effect
};
Place place_of(std::size_t figure, trace::RigDescription& rig) {
  if (figure < effects::kValveFigures) {
    return {kValveFigures[figure].name, &(rig.valve.*kValveFigures[figure].member), nullptr};
  }
  std::size_t id = 0;
  while (effects::kFirstFigure[id + 1] <= figure) ++id;
  const effects::Effect& effect = *effects::kCatalogue[id];
  const effects::Parameter& parameter = effect.parameters[figure - effects::kFirstFigure[id]];
  return {fmt::format("{}.{}", effect.id, parameter.name),
          &rig.effects[std::string(effect.id)][std::string(parameter.name)], &parameter};
}

void put_figures(const Fit& fit, double correlated_rows, GreyboxFit& into) {
  const Eigen::VectorXd errors = standard_errors(fit, correlated_rows);
  for (std::size_t i = 0; i < fit.variables.size(); ++i) {
    const Variable& v = fit.variables[i];
    const double at = fit.figures[v.figure];
    const Place place = place_of(v.figure, into.rig);
    const double value = place.parameter != nullptr ? place.parameter->value_of(at) : at;
    const double per_coordinate =
        place.parameter != nullptr && place.parameter->coordinate == effects::Coordinate::reciprocal
            ? value * value
            : 1.0;
    *place.value = value;
    const double error = v.scale * errors[static_cast<Eigen::Index>(i)];
    FigureFit one{{value, per_coordinate * error, bound_of(at, v.low, v.high)}, place.name, false};
    if (one.at_bound != Bound::none) {
      one.standard_error = std::numeric_limits<double>::quiet_NaN();
    } else {
      one.identifiable = is_known(v, at, error);
    }
    into.parameters.push_back(std::move(one));
  }
}

/// An effect of one figure that may be the one with which it vanishes, none of `needed`. Of several, each may be uncertain where all
/// together are not.
std::optional<std::size_t> not_shown(const Scene& scene, const Fit& fit, double correlated_rows,
                                     EffectSet needed) {
  const Eigen::VectorXd errors = standard_errors(fit, correlated_rows);
  for (const std::size_t id : kCandidates) {
    if ((fit.on & ~needed & bit(id)) == 0) continue;
    std::size_t figures = 0;
    bool shown = false;
    for (std::size_t i = 0; i < fit.variables.size(); ++i) {
      const Variable& v = fit.variables[i];
      if (v.figure < effects::kFirstFigure[id] || v.figure >= effects::kFirstFigure[id + 1]) continue;
      const double error = v.scale * errors[static_cast<Eigen::Index>(i)];
      ++figures;
      shown = std::abs(fit.figures[v.figure] - scene.nominal[v.figure]) > kTold * error;
    }
    if (figures == 1 && !shown) return id;
  }
  return std::nullopt;
}

NotTold not_told(const Scene& scene, std::size_t id) {
  const effects::Parameter& parameter = sought_parameter(id);
  return {fmt::format("{}.{}", effects::kCatalogue[id]->id, parameter.name),
          parameter.value_of(scene.nominal[sought_figure(id)])};
}

}  // namespace

GreyboxFit fit_greybox(const std::vector<trace::Log>& logs, const trace::RigDescription& rig,
                       const std::function<void(double done)>& progress) {
  require_learnable(logs);
  Chooser chooser(scene_of(logs, rig, kFittedShare), progress);
  chooser.choose();
  const Trial& chosen = chooser.best();

  Scene scene = scene_of(logs, rig, 1.0);
  std::copy_n(chosen.fit.figures.begin(), effects::kValveFigures, scene.nominal.begin());
  const auto fitted = [&scene](EffectSet on, EffectSet refined, const Figures& figures,
                               const std::vector<effects::Start>& start) {
    return fit(scene, on, figures, start, options_of(refined, 3 * kMostIterations));
  };
  Fit last = fitted(chosen.fit.on, chosen.fit.refined, chosen.fit.figures, chosen.fit.start);
  std::vector<double> errors = fitted_errors_Pa(scene, last);
  // Standard errors are of a parabola: what the squares miss stays, whatever they say.
  EffectSet needed = 0;
  while (const auto id = not_shown(scene, last, correlation_rows(errors), needed)) {
    Fit without = fitted(last.on & ~bit(*id), last.refined & ~bit(*id),
                         figures_without(scene, last.figures, *id), last.start);
    if (without.squares > (1.0 + kWorthKeeping) * last.squares) {
      needed |= bit(*id);
      continue;
    }
    last = std::move(without);
    errors = fitted_errors_Pa(scene, last);
  }

  GreyboxFit result;
  result.rig = rig;
  for (const std::size_t id : chooser.candidates()) {
    if ((last.on & bit(id)) != 0) {
      result.kept.emplace_back(effects::kCatalogue[id]->id);
    } else {
      result.not_told.push_back(not_told(scene, id));
    }
  }
  put_figures(last, correlation_rows(errors), result);
  result.noise_kPa = 1e-3 * white_noise(errors);
  result.rms_next_tick_kPa = 1e-3 * next_tick_rms_Pa(scene, last.on, last.figures, last.start);
  result.rms_free_run_kPa = 1e-3 * last.rms_Pa();
  result.rms_heldout_kPa = chooser.heldout_kPa(last.on, last.refined, last.figures);
  result.tried = chooser.tried();
  result.rows = last.rows;
  result.iterations = last.iterations;
  result.converged = last.converged;
  result.stop = last.stop;
  return result;
}

WholeRun free_run_over(const trace::RigDescription& rig, const trace::Log& log) {
  const Scene scene = scene_of({log}, rig, 1.0);
  const Record& record = scene.records.front();
  return {run(scene, record, 0, scene.nominal, estimate_start(scene, record, 0, scene.nominal)),
          record.settled_rows};
}

trace::ModelFile to_model_file(const GreyboxFit& fit, std::optional<unsigned> chamber) {
  const GreyboxModel made = greybox_of(fit.rig, chamber);
  trace::ModelFile file = made.file;
  file.fit["rms_one_step_kPa"] = fit.rms_next_tick_kPa;
  file.fit["rms_free_run_kPa"] = fit.rms_free_run_kPa;
  file.fit["rms_heldout_kPa"] = fit.rms_heldout_kPa;
  file.fit["noise_kPa"] = fit.noise_kPa;
  file.fit["rows"] = fit.rows;
  file.fit["iterations"] = fit.iterations;
  file.fit["converged"] = fit.converged;
  file.fit["stop"] = fit.stop;
  file.fit["effects"] = fit.kept;
  for (const std::string& name : made.without()) file.fit["left_out"].push_back(name);
  for (const TriedEffects& one : fit.tried) {
    file.fit["tried"].push_back({{"effects", one.effects}, {"rms_heldout_kPa", one.heldout_kPa}});
  }
  for (const NotTold& figure : fit.not_told) file.fit["not_told"].push_back(figure.name);
  for (const FigureFit& figure : fit.parameters) {
    nlohmann::ordered_json& entry = file.fit["parameters"][figure.name];
    entry["value"] = figure.value;
    entry.update(to_json(figure));
    entry["identifiable"] = figure.identifiable;
  }
  return file;
}

}  // namespace plenum::host::identify::chamber
