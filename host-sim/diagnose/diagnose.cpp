#include "host-sim/diagnose/diagnose.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>

#include "host-sim/diagnose/aliases.hpp"
#include "host-sim/diagnose/command_check.hpp"
#include "host-sim/diagnose/detectable.hpp"
#include "host-sim/diagnose/estimates.hpp"
#include "host-sim/diagnose/found_rig.hpp"
#include "host-sim/diagnose/gap_beyond_noise.hpp"
#include "host-sim/diagnose/latent.hpp"
#include "host-sim/diagnose/next_experiment.hpp"
#include "host-sim/diagnose/other_reading.hpp"
#include "host-sim/diagnose/reference_check.hpp"
#include "host-sim/diagnose/search.hpp"
#include "host-sim/diagnose/trust.hpp"
#include "host-sim/diagnose/verdict.hpp"
#include "host-sim/diagnose/where.hpp"
#include "host-sim/identify/box_solver.hpp"
#include "host-sim/identify/chamber/noise.hpp"
#include "host-sim/identify/chamber/valve_figures.hpp"

namespace plenum::host::diagnose {
namespace {

using effects::EffectSet;
using effects::kCatalogue;
using effects::kEffects;
using identify::chamber::kValveFigures;
using identify::chamber::make_record;
using identify::chamber::make_scene;
using identify::chamber::white_noise;

/// Each log's start, pressure and warmth, is of a fit's variables.
constexpr std::size_t kMostLogs = 16;
/// Of the largest set of effects.
constexpr std::size_t most_parameters() {
  std::array<std::size_t, kEffects> sizes{};
  for (std::size_t i = 0; i < kEffects; ++i) sizes[i] = kCatalogue[i]->parameters.size();
  std::sort(sizes.begin(), sizes.end(), std::greater<>());
  std::size_t sum = 0;
  for (std::size_t i = 0; i < kMostEffects; ++i) sum += sizes[i];
  return sum;
}
/// Of one effect, those that do not refine it.
constexpr std::size_t most_plain_parameters() {
  std::size_t most = 0;
  for (const effects::Effect* effect : kCatalogue) {
    const auto plain =
        std::ranges::count_if(effect->parameters, [](const effects::Parameter& p) { return !p.refines; });
    most = std::max(most, static_cast<std::size_t>(plain));
  }
  return most;
}
/// The valve, a set, one more beside it, the stamp, and the starts of fitted and held-out logs, or of later ones and the baseline's.
static_assert(effects::kValveFigures + most_parameters() + most_plain_parameters() + 1 + 4 * kMostLogs <=
              identify::kMostVariables);
/// From this share of the gap on, or at the floor, the effects found know their equation better than the latent disturbances do: of 67 blind
/// cases 59 are then right, and 21 of 32 whose effect is no hypothesis; from 0.6 on 59 and 18.
constexpr double kKnowsEquation = 0.8;
/// A cause that has another's place with this share of the odds is its alias.
constexpr double kAlias = 0.02;
/// A set whose first effect is less probable explains nothing.
constexpr double kLeastNamed = 0.02;
/// Of a tick: a mean over the steps of a simulation, or a clock, is off by less.
constexpr double kMostEarly = 0.1;
/// The likeliest alias of a cause that is not named alone is listed among the effects, and every other from here on.
constexpr double kListed = 0.1;

EffectSet struck_of(const std::vector<std::string>& ids) {
  EffectSet struck = 0;
  for (const std::string& id : ids) {
    const auto at = effects::find(id);
    if (!at) {
      std::string known;
      for (const effects::Effect* effect : kCatalogue)
        known += fmt::format("{}{}", known.empty() ? "" : ", ", effect->id);
      throw std::invalid_argument(fmt::format("effect {}: not in the catalogue, expected {}", id, known));
    }
    struck |= EffectSet{1} << *at;
  }
  return struck;
}

std::string id_of(std::size_t effect) {
  return std::string(kCatalogue[effect]->id);
}

std::string equation_of(std::size_t effect) {
  return std::string(effects::name_of(kCatalogue[effect]->equation));
}

/// Probabilities from differences of evidence.
std::vector<double> probabilities(const std::vector<double>& evidence) {
  const double best = *std::max_element(evidence.begin(), evidence.end());
  std::vector<double> p(evidence);
  for (double& one : p) one = std::exp(one - best);
  const double sum = std::accumulate(p.begin(), p.end(), 0.0);
  for (double& one : p) one /= sum;
  return p;
}

/// Of the noise that the pressures alone show: less is left of an error only where they were not smooth.
constexpr double kNoSmoothPressure = 0.7;

class Diagnosis {
 public:
  /// `before`: what was found on the baseline that `rig` describes, or none.
  Diagnosis(const std::vector<NamedLog>& logs, const std::vector<NamedLog>& heldout,
            const trace::RigDescription& rig, const DiagnoseOptions& options, const GapReport* before)
      : scene_(make_scene(rig)), threads_(options.threads) {
    const EffectSet struck = struck_of(options.strike);
    if (before != nullptr) before_Pa_ = before->with_effects_Pa;
    double sum = 0.0;
    for (const NamedLog& of : logs) {
      add_record(scene_, make_record(of.name, of.log, heldout.empty() ? kFittedShare : 1.0));
      logs_from_s_.push_back(of.log.time_s.front());
      sum += white_noise(of.log.pressure_Pa) / static_cast<double>(logs.size());
    }
    set_noise(sum > 0.0 ? sum : scene_.noise_Pa);
    scene_.most_early_s = kMostEarly * scene_.records.front().drive.timing.tick_s;
    if (heldout.empty()) {
      for (std::size_t i = 0; i < scene_.records.size(); ++i) {
        heldout_.push_back({scene_.records[i], scene_.records[i].fitted_rows, static_cast<int>(i)});
      }
    } else {
      for (const NamedLog& of : heldout) {
        heldout_.push_back({make_record(of.name, of.log, 1.0), 1, -1});
        heldout_from_s_.push_back(of.log.time_s.front());
        reach_end_of(scene_, heldout_.back().record);
      }
    }
    if (before != nullptr) {
      for (const NamedLog& of : options.baseline) {
        baseline_.push_back(make_record(of.name, of.log, 1.0));
        baseline_.back().before = true;
      }
    }
    fitted_ = scene_;
    fitted_.records.insert(fitted_.records.end(), baseline_.begin(), baseline_.end());
    Trial base = recalibrated(fitted_, heldout_);
    calibrate_to_all(base);
    lower_noise(base);
    require_as_written(base);
    search_ = search(fitted_, heldout_, std::move(base),
                     {.struck = struck,
                      .threads = options.threads,
                      .noise_Pa = report_.noise_floor_Pa,
                      .progress = options.progress});
    if (search_.best.on != 0) {
      const Fit found = of_the_logs(search_.best.fit);
      require_no_offset_of_ambient(scene_, found);
      require_absolute_pressures(scene_, found, threads_);
    }
    lower_noise(search_.best);
    recalibrated_evidence_ = search_.recalibrated.evidence(search_.correlated_rows);
    if (!baseline_.empty()) valve_changed();
  }

  GapReport report() {
    gaps();
    candidates();
    name_effects();
    decide();
    where();
    calibration();
    report_.alias_classes =
        alias_classes(fitted_, search_.recalibrated.fit.figures, search_.recalibrated.fit.start);
    traces();
    return std::move(report_);
  }

 private:
  /// What the model leaves of the machine as it was, no model of what has changed can be expected to close.
  void set_noise(double noise_Pa) {
    scene_.noise_Pa = fitted_.noise_Pa = noise_Pa;
    report_.noise_floor_Pa = std::max(noise_Pa, before_Pa_);
  }

  /// `fit`, which answers for the baseline, too, where there is one, as it is without it.
  Fit of_the_logs(const Fit& fit) const {
    return baseline_.empty() ? fit : identify::chamber::fit(scene_, fit.on, fit.figures, {});
  }

  /// Refuses logs that are read better otherwise than they are written, and such logs held out: those show by erring far more
  /// than what was fitted.
  void require_as_written(const Trial& base) const {
    const Fit of_logs = of_the_logs(base.fit);
    require_acting_command(scene_, of_logs, threads_);
    require_absolute_pressures(scene_, of_logs, threads_);
    if (heldout_from_s_.empty() || !far_better(base.fit.rms_Pa(), base.heldout_Pa())) return;
    Scene held = scene_;
    held.records.clear();
    for (const HeldOut& of : heldout_) held.records.push_back(of.record);
    const ErrorOf error_of = foretold_by(base.fit);
    require_acting_command(held, base.heldout_Pa(), error_of, threads_);
    require_absolute_pressures(held, base.heldout_Pa(), error_of, threads_);
  }

  /// Under a command that never rests the pressure is not smooth, and what third differences leave of it is no noise: what they
  /// leave of a model's error is less.
  void lower_noise(const Trial& of) {
    double sum = 0.0;
    for (std::size_t i = 0; i < scene_.records.size(); ++i) {
      const Record& record = scene_.records[i];
      const std::vector<double> error =
          errors_Pa(run(scene_, record, of.on, of.fit.figures, of.fit.start[i]), record, 0, record.rows());
      sum += white_noise(error) / static_cast<double>(scene_.records.size());
    }
    if (sum > 0.0 && sum < kNoSmoothPressure * scene_.noise_Pa) set_noise(sum);
  }

  /// What fits all rows is no worse explained by the valve alone than the search is to believe.
  void calibrate_to_all(Trial& base) {
    to_all_ = calibrated_to_all(fitted_, heldout_, base.fit);
    base.joint_squares = std::min(base.joint_squares, to_all_.fit.squares);
  }

  /// The other hypothesis of what has changed since the baseline: the valve's figures, all of them, and no effect. Both
  /// answer for the baseline, too. Where an effect comes to the floor, seven figures that follow the log below it prove nothing.
  void valve_changed() {
    Trial changed = recalibrated(scene_, heldout_);
    Scene then = scene_;
    then.records = baseline_;
    then.nominal[effects::kStampedEarly] = changed.fit.figures[effects::kStampedEarly];
    then.most_early_s = 0.0;  // stamped as the later logs are
    const Fit was = fit(then, 0, then.nominal, {});
    Trial both = changed;  // over the same rows as the trials of the search
    both.joint_squares += was.squares;
    both.fit.rows += was.rows;
    both.rows += was.rows;
    both.variables += was.chosen_variables() + was.warmths;
    const double evidence = both.evidence(search_.correlated_rows);
    const bool closed = search_.best.on != 0 && search_.best.heldout_Pa() < kAtFloor * report_.noise_floor_Pa;
    if (closed || evidence <= search_.best.evidence(search_.correlated_rows)) return;
    recalibrated_evidence_ = evidence;
    fitted_ = scene_;
    calibrate_to_all(changed);
    search_.recalibrated = changed;
    search_.best = std::move(changed);
    search_.rivals.clear();
  }

  void gaps() {
    Fit nominal;
    nominal.figures = scene_.nominal;
    for (const Record& record : scene_.records) {
      nominal.start.push_back(estimate_start(scene_, record, 0, scene_.nominal));
    }
    nominal_ = nominal;
    Score sum;
    for (const HeldOut& held : heldout_) {
      const Score s = score(heldout_reading(scene_, held, nominal), held.record, held.first);
      sum.squares += s.squares;
      sum.rows += s.rows;
    }
    report_.as_configured_Pa = sum.rms_Pa();
    report_.recalibrated_Pa = search_.recalibrated.heldout_Pa();
    report_.with_effects_Pa = search_.best.heldout_Pa();
    report_.gap_p_value = gap_p_value(to_all_, heldout_, scene_, search_.best.fit, report_.noise_floor_Pa);
  }

  void candidates() {
    std::vector<double> evidence;
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < kEffects; ++i) {
      if (!search_.alone[i].valid()) continue;
      which.push_back(i);
      evidence.push_back(search_.alone[i].evidence(search_.correlated_rows));
    }
    which.push_back(kEffects);
    evidence.push_back(recalibrated_evidence_);
    const std::vector<double> p = probabilities(evidence);
    std::map<std::string, double> by_equation;
    double named = 0.0;
    for (std::size_t k = 0; k + 1 < which.size(); ++k) {
      const Trial& trial = search_.alone[which[k]];
      report_.candidates.push_back({id_of(which[k]), trial.heldout_Pa(), p[k],
                                    parameters_of(trial, which[k], search_.correlated_rows)});
      by_equation[equation_of(which[k])] += p[k];
      named += p[k];
    }
    std::stable_sort(report_.candidates.begin(), report_.candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.confidence > b.confidence; });
    if (named <= 0.0) return;
    const auto best = std::max_element(by_equation.begin(), by_equation.end(),
                                       [](const auto& a, const auto& b) { return a.second < b.second; });
    blame_ = {best->first, best->second / named};
  }

  void name_effects() {
    const std::vector<std::size_t> in = members(search_.best.on);
    const double with_Pa = search_.best.heldout_Pa();
    const double floor2 = with_Pa * with_Pa;
    double sum = 0.0;
    std::map<std::string, double> closes;  // of what the others leave
    for (std::size_t k = 0; k < in.size(); ++k) {
      NamedEffect effect;
      effect.id = id_of(in[k]);
      std::vector<double> evidence{search_.best.evidence(search_.correlated_rows)};
      for (const Trial& rival : search_.rivals[k])
        evidence.push_back(rival.evidence(search_.correlated_rows));
      const std::vector<double> p = probabilities(evidence);
      effect.confidence = p[0];
      doubtful_ = doubtful_ || p[0] < kNamedAlone;
      effect.gap_with_Pa = with_Pa;
      const EffectSet rest = search_.best.on & ~(EffectSet{1} << in[k]);
      for (std::size_t r = 0; r < search_.rivals[k].size(); ++r) {
        const Trial& rival = search_.rivals[k][r];
        if (rival.on == rest) {
          effect.gap_without_Pa = rival.heldout_Pa();
          closes[effect.id] = share_of_rest(search_.best, rival, report_.noise_floor_Pa);
        } else if (p[r + 1] > kAlias) {
          effect.aliases.push_back(id_of(members(rival.on & ~rest).front()));
          alias_trials_.push_back({&rival, members(rival.on & ~rest).front(), in[k], p[r + 1]});
        }
      }
      effect.share = std::max(effect.gap_without_Pa * effect.gap_without_Pa - floor2, 1e-9);
      sum += effect.share;
      effect.parameters = parameters_of(search_.best, in[k], search_.correlated_rows);
      report_.effects.push_back(effect);
    }
    for (NamedEffect& effect : report_.effects) effect.share /= sum;
    std::stable_sort(report_.effects.begin(), report_.effects.end(),
                     [](const NamedEffect& a, const NamedEffect& b) { return a.share > b.share; });
    for (NamedEffect& effect : report_.effects) {
      const bool first = &effect == &report_.effects.front();
      const double trust = worth_of_name(with_Pa / report_.noise_floor_Pa,
                                         first ? std::nullopt : std::optional(closes[effect.id])) *
                           (unknown(effect) ? kTrustUnknown : 1.0);
      effect.confidence *= trust;
      for (AliasTrial& alias : alias_trials_) {
        if (id_of(alias.replaced) == effect.id) alias.probability *= trust;
      }
    }
  }

  /// Of a null that wanders no figure is known, as any may stand in for the others, but the way that they make together is.
  bool unknown(const NamedEffect& effect) const {
    const std::size_t at = *effects::find(effect.id);
    if (at == effects::kIdNullDrift && wanders(search_.best.fit)) return false;
    return says_nothing(effect.parameters, at, size_of(scene_));
  }

  void decide() {
    const bool named = !report_.effects.empty() && report_.effects.front().confidence >= kLeastNamed;
    const bool rivals = doubtful_ && !alias_trials_.empty();
    const GapErrors errors{.as_configured_Pa = report_.as_configured_Pa,
                           .recalibrated_Pa = report_.recalibrated_Pa,
                           .recalibrated_fitted_Pa = search_.recalibrated.fit.rms_Pa(),
                           .with_effects_Pa = report_.with_effects_Pa,
                           .noise_floor_Pa = report_.noise_floor_Pa,
                           .gap_p_value = report_.gap_p_value};
    report_.verdict = verdict_of(errors, !named ? Best::no_effect : rivals ? Best::has_rivals : Best::alone);
    switch (report_.verdict) {
      case Verdict::none:
      case Verdict::calibration:
        name_nothing();
        break;
      case Verdict::unexplained:
        name_nothing();
        blame();
        plan({{"recalibrated", search_.recalibrated.on | scene_.known, search_.recalibrated.fit.figures,
               search_.recalibrated.variables}});
        break;
      case Verdict::explained:
      case Verdict::partly_explained:
      case Verdict::ambiguous:
        report_.closed_fraction = closed_fraction(errors);
        if (rivals) list_rivals();
        blame();
        if (rivals) plan(listed_rivals());
    }
  }

  void name_nothing() {
    if (search_.best.on == 0) return;
    report_.effects.clear();
    report_.with_effects_Pa = report_.recalibrated_Pa;
    used_ = &search_.recalibrated;
  }

  /// The equation whose disturbance explains the readings, whatever the catalogue holds; where effects close most of the
  /// gap, theirs.
  void blame() {
    std::vector<const Record*> records;
    records.reserve(scene_.records.size());
    for (const Record& record : scene_.records) records.push_back(&record);
    const std::vector<LatentEquation> found =
        latent(scene_, records, search_.recalibrated.fit.figures, threads_);
    for (const LatentEquation& e : found) {
      report_.disturbances.push_back({std::string(effects::name_of(e.equation)), e.probability, e.size,
                                      e.unit, e.terms.front().on, e.terms.front().share, e.disturbance});
    }
    const bool known = report_.closed_fraction >= kKnowsEquation ||
                       report_.with_effects_Pa < kAtFloor * report_.noise_floor_Pa;
    report_.equation = known || found.empty()
                           ? blame_of_the_named()
                           : Blame{report_.disturbances.front().equation, found.front().probability};
  }

  /// The equation that single effects speak for, if one that is named lives there; else that of the first of them: two that
  /// explain the error together may each alone look like a third.
  Blame blame_of_the_named() const {
    const auto equation = [](const NamedEffect& effect) { return equation_of(*effects::find(effect.id)); };
    const bool among = std::any_of(report_.effects.begin(), report_.effects.end(),
                                   [&](const NamedEffect& e) { return equation(e) == blame_.equation; });
    if (among || report_.effects.empty()) return blame_;
    return {equation(report_.effects.front()), report_.effects.front().confidence};
  }

  /// All causes that fit alike are listed, the likeliest first.
  void list_rivals() {
    std::stable_sort(alias_trials_.begin(), alias_trials_.end(),
                     [](const auto& a, const auto& b) { return a.probability > b.probability; });
    alias_trials_.erase(std::find_if(alias_trials_.begin() + 1, alias_trials_.end(),
                                     [](const AliasTrial& a) { return a.probability < kListed; }),
                        alias_trials_.end());
    for (const AliasTrial& alias : alias_trials_) {
      const std::string id = id_of(alias.effect);
      if (std::any_of(report_.effects.begin(), report_.effects.end(),
                      [&](const NamedEffect& e) { return e.id == id; })) {
        continue;
      }
      NamedEffect effect;
      effect.id = id;
      effect.confidence = alias.probability;
      effect.gap_without_Pa =
          std::find_if(report_.effects.begin(), report_.effects.end(), [&](const NamedEffect& e) {
            return e.id == id_of(alias.replaced);
          })->gap_without_Pa;
      effect.gap_with_Pa = alias.trial->heldout_Pa();
      effect.parameters = parameters_of(*alias.trial, alias.effect, search_.correlated_rows);
      for (const std::size_t other : members(search_.best.on)) {
        if ((alias.trial->on >> other & 1U) == 0) effect.aliases.push_back(id_of(other));
      }
      report_.effects.push_back(effect);
    }
  }

  /// The set that fits best, by its effect that is not sure, and those that are listed with another in its place.
  std::vector<Rival> listed_rivals() const {
    const AliasTrial& most = alias_trials_.front();
    std::vector<Rival> rivals{{id_of(most.replaced), search_.best.on | scene_.known, search_.best.fit.figures,
                               search_.best.variables}};
    for (const AliasTrial& alias : alias_trials_) {
      if (alias.replaced == most.replaced)
        rivals.push_back({id_of(alias.effect), alias.trial->on | scene_.known, alias.trial->fit.figures,
                          alias.trial->variables});
    }
    return rivals;
  }

  void plan(const std::vector<Rival>& rivals) { report_.next = next_experiment(scene_, rivals); }

  void where() {
    std::vector<Scored> scored;
    for (const HeldOut& held : heldout_) {
      scored.push_back({&held.record, std::max(held.first, held.record.settled_rows),
                        heldout_reading(scene_, held, search_.recalibrated.fit),
                        heldout_reading(scene_, held, used_->fit)});
    }
    report_.map = error_map(scene_, scored);
    if (report_.equation) report_.where = regimes(scene_, search_.recalibrated.fit.figures, scored);
  }

  void calibration() {
    const Fit& fit = search_.recalibrated.fit;
    const Eigen::VectorXd errors = standard_errors(fit, search_.correlated_rows);
    for (std::size_t i = 0; i < effects::kValveFigures; ++i) {
      report_.calibration.push_back(
          {kValveFigures[i].name, scene_.nominal[i], estimate_of(fit, i, errors), used_->fit.figures[i]});
    }
    stamped_early();
    std::vector<std::size_t> others;
    for (std::size_t i = 0; i < kEffects; ++i) {
      if (search_.alone[i].valid() && ((used_->on | scene_.known) >> i & 1U) == 0) others.push_back(i);
    }
    report_.detectable = detectable(fitted_, used_->fit, others, search_.correlated_rows, threads_);
  }

  /// As the model that is used has it, where it shows.
  void stamped_early() {
    const Fit& used = used_->fit;
    if (used.variables.back().figure != effects::kStampedEarly) return;
    const double early_s = used.figures[effects::kStampedEarly];
    const auto last = static_cast<Eigen::Index>(used.variables.size()) - 1;
    const double error_s = used.variables.back().scale * standard_errors(used, search_.correlated_rows)[last];
    if (early_s > kShownErrors * error_s) report_.stamped_early_s = early_s;
  }

  void traces() {
    const auto trace_of = [&](const Record& record, double from_s, std::size_t first,
                              const std::vector<double>& configured, const std::vector<double>& recalibrated,
                              const std::vector<double>& with) {
      Trace trace;
      trace.name = record.name;
      trace.heldout_from = first;
      for (std::size_t row = 0; row < record.rows(); ++row) {
        trace.time_s.push_back(from_s + static_cast<double>(row) * record.drive.timing.tick_s);
      }
      trace.command_V = record.drive.command_V;
      trace.measured_Pa = record.measured_Pa;
      trace.as_configured_Pa = configured;
      trace.recalibrated_Pa = recalibrated;
      trace.with_effects_Pa = with;
      trace.disturbance_kg_s = disturbance_kg_s(scene_, record, search_.recalibrated.fit.figures);
      report_.traces.push_back(std::move(trace));
    };
    const auto of = [&](const Record& record, const Fit& fit, std::size_t i) {
      return run(scene_, record, fit.on, fit.figures, fit.start[i]);
    };
    for (std::size_t i = 0; i < scene_.records.size(); ++i) {
      const Record& record = scene_.records[i];
      trace_of(record, logs_from_s_[i], record.fitted_rows, of(record, nominal_, i),
               of(record, search_.recalibrated.fit, i), of(record, used_->fit, i));
    }
    for (std::size_t i = 0; i < heldout_from_s_.size(); ++i) {
      const HeldOut& held = heldout_[i];
      trace_of(held.record, heldout_from_s_[i], 0, heldout_reading(scene_, held, nominal_),
               heldout_reading(scene_, held, search_.recalibrated.fit),
               heldout_reading(scene_, held, used_->fit));
    }
  }

  struct AliasTrial {
    const Trial* trial;
    std::size_t effect;
    std::size_t replaced;  ///< the effect of the best set in whose place it is
    double probability;
  };

  Scene scene_;  ///< the logs to be explained
  unsigned threads_;
  std::vector<HeldOut> heldout_;
  std::vector<double> logs_from_s_,
      heldout_from_s_;            ///< time of the first row; of the logs held out where there are any
  std::vector<Record> baseline_;  ///< of the machine as it was: the search's fits answer for them, too
  Scene fitted_;  ///< the records that search_.recalibrated has starts of: scene_'s, then the baseline's
  double before_Pa_ = 0.0;  ///< left of the baseline with what was found there; 0: there is none
  CalibratedToAll to_all_;
  Search search_;
  double recalibrated_evidence_ = 0.0;
  const Trial* used_ = &search_.best;
  Fit nominal_;
  Blame blame_;
  std::vector<AliasTrial> alias_trials_;
  bool doubtful_ = false;  ///< a cause whose rivals fit nearly as well
  GapReport report_;
};

}  // namespace

GapReport diagnose(const std::vector<NamedLog>& logs, const std::vector<NamedLog>& heldout,
                   const trace::RigDescription& rig, const DiagnoseOptions& options) {
  const auto require_room = [](std::size_t count, const char* what) {
    if (count > kMostLogs) {
      throw std::invalid_argument(fmt::format("{} {}, expected at most {}", count, what, kMostLogs));
    }
  };
  require_room(heldout.size(), "held-out logs");
  require_room(logs.size() + options.baseline.size(),
               options.baseline.empty() ? "logs" : "logs and baselines");
  if (options.baseline.empty()) {
    GapReport report = Diagnosis(logs, heldout, rig, options, nullptr).report();
    report.found = found_rig(rig, report);
    return report;
  }
  const auto half = [&](double from) {
    DiagnoseOptions of = options;
    if (options.progress) of.progress = [&, from](double share) { options.progress(from + 0.5 * share); };
    return of;
  };
  const GapReport before = Diagnosis(options.baseline, {}, rig, half(0.0), nullptr).report();
  const trace::RigDescription was = found_rig(rig, before);
  GapReport now = Diagnosis(logs, heldout, was, half(0.5), &before).report();
  now.found = found_rig(was, now);
  now.baseline =
      Baseline{before.verdict, before.as_configured_Pa, before.with_effects_Pa, effects_in_model(before)};
  return now;
}

}  // namespace plenum::host::diagnose
