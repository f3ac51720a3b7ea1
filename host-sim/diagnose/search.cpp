#include "host-sim/diagnose/search.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "host-sim/diagnose/verdict.hpp"
#include "host-sim/identify/chamber/noise.hpp"
#include "host-sim/identify/in_parallel.hpp"

namespace plenum::host::diagnose {
namespace {

using effects::EffectSet;
using effects::Figures;
using effects::kEffects;
using identify::chamber::correlation_rows;
using identify::chamber::figures_without;
using identify::chamber::FitOptions;
using identify::chamber::kStretch_s;
using identify::chamber::Score;

constexpr std::size_t kBeam = 2;      ///< sets of a size that are enlarged
constexpr std::size_t kFinished = 6;  ///< of the effects looked at beside a set, those whose fit is finished
constexpr std::size_t kFinishedInPlace = 3;  ///< of those put in another's place beside the rest
/// An effect enters a set for this much evidence beyond its parameters' price, and for this share of the squares: less
/// can be clutter (jitter, ripple) that one of fourteen effects happens to fit. An effect as large as the noise, the
/// least that is called detectable, takes away half.
constexpr double kWorthEntering = 6.0;
constexpr double kLeastShare = 0.15;
constexpr int kMostSwaps = 1;  ///< of one effect of a set for another that does better
/// Of the noise: while more than this is left, sets are enlarged although the last effect did not pay; three can explain
/// what no two of them do. That they do is known by their leaving no more than this: of a machine far beyond the catalogue
/// three explain a little, too.
constexpr double kMuchLeft = 3.0;
/// Each of several effects must close this share of the squares that the set without it leaves above the noise, and this
/// share of the noise: less is the form of the others, which no catalogue holds exactly.
constexpr double kFurtherOfRest = 0.6;
constexpr double kFurtherOfNoise = 0.25;
/// Of the squares that the first candidate leaves: what leaves less than this tells how its own error is correlated.
constexpr double kFarLess = 0.25;
/// Independent pieces of information in a log. Not more: no model is exact, and what all leave out would decide between
/// rivals whose errors differ by a hundredth.
constexpr double kLeastPieces = 20.0;
constexpr double kMostPieces = 200.0;
/// Short fits are run this long, in so few steps a tick.
constexpr double kLook_s = 40.0;
constexpr int kLookSteps = 2;
constexpr double kWander_s = 65.0;  ///< the null's spline ends before
/// Of what the plain drift leaves above the noise: a way of the null that follows whatever it is given closes less of another cause.
constexpr double kWanderCloses = 0.9;
constexpr double kBetween_s = 1.0;  ///< of the rows held out: so many are followed, so many judge
/// Of the squares: an effect that changes them by less shows nothing at that size.
constexpr double kShown = 1e-4;
/// Of the squares of the best look: an effect that looks worse by this is fitted briefly, and not refined. If its end were no
/// better its odds would be 20^-10 at most.
constexpr double kBehind = 20.0;

EffectSet bit(std::size_t effect) {
  return EffectSet{1} << effect;
}

bool worth_entering(const Trial& with, const Trial& base, double correlated_rows) {
  return with.valid() && with.evidence(correlated_rows) - base.evidence(correlated_rows) > kWorthEntering &&
         with.joint_squares < (1.0 - kLeastShare) * base.joint_squares &&
         std::pow(with.heldout_Pa(), 2) < (1.0 - kLeastShare) * std::pow(base.heldout_Pa(), 2);
}

/// By evidence, but after all others those that do not lower the held-out error.
void best_first(std::vector<Trial>& trials, const Trial& recalibrated, double correlated_rows) {
  const auto rank = [&](const Trial& t) {
    return std::pair(worth_entering(t, recalibrated, correlated_rows), t.evidence(correlated_rows));
  };
  std::sort(trials.begin(), trials.end(), [&](const Trial& a, const Trial& b) { return rank(a) > rank(b); });
}

/// Of several trials of one set, which stand best first, only the best.
void once_each(std::vector<Trial>& trials) {
  std::vector<EffectSet> seen;
  std::erase_if(trials, [&](const Trial& t) {
    const bool again = std::find(seen.begin(), seen.end(), t.on) != seen.end();
    seen.push_back(t.on);
    return again;
  });
}

/// Whether an effect closes enough, beyond being significant, to be named beside others.
bool closes_enough(const Trial& with, const Trial& base, double noise_Pa) {
  return base.heldout_Pa() - with.heldout_Pa() > kFurtherOfNoise * noise_Pa &&
         share_of_rest(with.heldout_Pa(), base.heldout_Pa(), noise_Pa) > kFurtherOfRest;
}

/// The first seconds of the same logs, in fewer steps a tick.
Scene coarse(const Scene& scene, double seconds) {
  Scene coarse = scene;
  for (Record& record : coarse.records) {
    const effects::Drive fine = record.drive;
    const auto rows = std::min(record.fitted_rows, static_cast<std::size_t>(seconds / fine.timing.tick_s));
    std::vector<double> volume_m3(rows);
    for (std::size_t row = 0; row < rows; ++row) {
      volume_m3[row] = fine.volume_m3[row * static_cast<std::size_t>(fine.timing.steps)];
    }
    effects::Timing timing = fine.timing;
    timing.steps = kLookSteps;
    record.drive = effects::make_drive(std::span(fine.command_V).first(rows), volume_m3, timing);
    record.measured_Pa.resize(rows);
    record.fitted_rows = rows;
  }
  return coarse;
}

/// Held-out records as a fit sees them.
std::vector<Record> as_fitted(const std::vector<HeldOut>& heldout) {
  std::vector<Record> records;
  for (const HeldOut& held : heldout) {
    records.push_back(held.record);
    records.back().settled_rows = std::max(held.first, held.record.settled_rows);
    records.back().fitted_rows = held.record.rows();
  }
  return records;
}

/// Which rows are fitted, and which judge.
struct Split {
  Scene fitted;
  std::vector<HeldOut> heldout;
  std::vector<Record> heldout_as_fitted;
};

/// Of the rows from `first` on, every other second, or those between.
Record::Half half_of(const Record& record, std::size_t first, bool second) {
  return {first, static_cast<std::size_t>(std::ceil(kBetween_s / record.drive.timing.tick_s)), second};
}

/// Of the rows held out every other second shows the way of the null, and those between judge.
Split followed(Split split) {
  for (HeldOut& held : split.heldout) {
    held.record.half = half_of(held.record, held.first, true);
    if (held.continues < 0) continue;
    Record& record = split.fitted.records[static_cast<std::size_t>(held.continues)];
    record.fitted_rows = record.rows();
    record.half = half_of(record, held.first, false);
  }
  split.heldout_as_fitted = as_fitted(split.heldout);
  return split;
}

/// Whether the null has a way that each log shows for itself.
bool wanders(const Fit& fit) {
  return (fit.on & fit.refined & bit(effects::kIdNullDrift)) != 0;
}

Trial tried(const Split& rows, Fit fit) {
  const Scene& scene = rows.fitted;
  Trial trial;
  trial.on = fit.on;
  std::vector<effects::Start> start;
  for (const HeldOut& held : rows.heldout) {
    start.push_back(heldout_start(scene, held, fit));
    const Score s =
        score(run(scene, held.record, fit.on, fit.figures, start.back()), held.record, held.first);
    trial.heldout_squares += s.squares;
    trial.heldout_rows += s.rows;
  }
  trial.joint_squares =
      joint_squares(scene, fit, rows.heldout_as_fitted, start, rows.heldout.front().continues >= 0);
  trial.variables = fit.variables.size() + fit.warmths + fit.nulls * effects::kOwnNull;
  for (const HeldOut& held : rows.heldout) {
    if (held.continues >= 0) continue;
    if (conducts(scene, held.record, fit.on, fit.variables)) ++trial.variables;
    if (wanders(fit)) trial.variables += effects::kOwnNull;
  }
  trial.fit = std::move(fit);
  return trial;
}

class Searcher {
 public:
  Searcher(const Scene& scene, const std::vector<HeldOut>& heldout, const SearchOptions& options)
      : scene_(scene),
        coarse_(coarse(scene, kLook_s)),
        before_({scene, heldout, as_fitted(heldout)}),
        followed_(followed(before_)),
        options_(options) {}

  /// To its end. A null that wanders is known only where it is seen: with its spline it is followed into the rows held out.
  Fit fitted(EffectSet on, const Figures& figures, const std::vector<effects::Start>& start,
             const FitOptions& options) const {
    return fit(split(options.refined).fitted, on, figures, start, options);
  }
  Trial tried(Fit fit) const {
    const Split& rows = split(fit.refined);
    return diagnose::tried(rows, std::move(fit));
  }

  /// Short fits of one set.
  struct Look {
    Fit best;
    /// Where the effect changes nothing in the best, the best in which it does: a silencer changes nothing until it is so
    /// narrow that the port before it no longer chokes.
    std::optional<Fit> shown;
    /// A refinement that did not begin in the best and found more.
    std::optional<Fit> finer;
    /// Of the best or of its refinement, whose further variables have their price: a null that wanders shows nothing before.
    double squares = std::numeric_limits<double>::infinity();

    /// `found` where it is better.
    void take(Fit found) {
      if (!(found.squares < squares)) return;
      squares = found.squares;
      best = std::move(found);
    }
  };

  /// The set of `base`, of which a short fit leaves `base_squares`, with `effect` besides: the best of several sizes of it.
  Look look(const Fit& base, double base_squares, std::size_t effect) const {
    const EffectSet on = base.on | bit(effect);
    Look seen;
    seen.best.on = on;
    std::vector<Figures> starts;
    if (base.on == 0) {
      starts = sizes_of(effect, base.figures, {0.3, 3.0, 30.0, -1.0});
    } else {
      // that which errs least beside the others as they stand, and a typical one: heat has two minima
      const std::vector<Figures> sizes =
          sizes_of(effect, base.figures, {0.1, 0.3, 3.0, 10.0, 30.0, -0.3, -1.0, -5.0});
      starts = sizes_of(effect, base.figures, {1.0});
      if (!sizes.empty()) starts.push_back(sizes[least_error(coarse_, on, sizes, base.start)]);
    }
    FitOptions options = brief(base.refined);
    const auto shows = [&](const Fit& found) {
      return std::abs(found.squares - base_squares) > kShown * base_squares;
    };
    for (const Figures& start : starts) {
      Fit found = fit(coarse_, on, start, base.start, options);
      if (shows(found) && (!seen.shown || found.squares < seen.shown->squares)) seen.shown = found;
      seen.take(std::move(found));
    }
    if (!std::isfinite(seen.squares)) return seen;
    if (shows(seen.best)) seen.shown.reset();  // it is the best itself
    if (base.on == 0) {
      // the valve's figures come from a fit without the effect, and may be far from those with it
      Figures fresh = seen.best.figures;
      std::copy_n(scene_.nominal.begin(), effects::kValveFigures, fresh.begin());
      seen.take(fit(coarse_, on, fresh, base.start, finish(options.refined)));
    }
    if (refinable(effect)) {
      options.refined |= bit(effect);
      Fit finer = fit(coarse_, on, seen.best.figures, seen.best.start, options);
      if (const std::optional<Figures> elsewhere = finer_start(effect, seen.best.figures, base)) {
        // alone the valve's figures come from far away
        Fit other =
            fit(coarse_, on, *elsewhere, seen.best.start, base.on == 0 ? finish(options.refined) : options);
        if (other.squares < finer.squares) {
          finer.squares = other.squares;
          seen.finer = std::move(other);
        }
      }
      if (base.on == 0 && effect == effects::kIdNullDrift) {
        Fit other = grown(effect, options);
        if (other.rms_Pa() < finer.rms_Pa()) {  // over other rows
          finer.squares *= std::pow(other.rms_Pa() / finer.rms_Pa(), 2);
          seen.finer = std::move(other);
        }
      }
      const auto more = static_cast<double>(finer.variables.size() - seen.best.variables.size());
      seen.squares =
          std::min(seen.squares, finer.squares * std::exp(more * std::log(kMostPieces) / kMostPieces));
    }
    return seen;
  }

  /// Where a refined effect is looked for besides its plain best: what no small steps lead to from there.
  std::optional<Figures> finer_start(std::size_t effect, const Figures& best, const Fit& base) const {
    Figures start = best;
    double* const x = start.data() + effects::kFirstFigure[effect];
    if (effect == effects::kIdSpoolLag) {
      // as late by its coil alone, the spool without mass
      x[3] += x[0] * x[1] / std::numbers::pi;
      x[0] = 0.0;
      return start;
    }
    if (effect == effects::kIdChamberLeak) {
      // straight in the gauge pressure: beside a gap's, of which there is little, the valve's own leaks took it
      if (base.on == 0) std::copy_n(scene_.nominal.begin(), effects::kValveFigures, start.begin());
      x[1] = 0.0;
      const std::vector<Figures> sizes = sizes_of(effect, start, {1.0, 3.0, 10.0, 30.0, 100.0});
      return sizes[least_error(coarse_, base.on | bit(effect), sizes, base.start)];
    }
    return {};
  }

  /// Refined over the first seconds, then over more and more: what acts in time is found one stretch after another, where
  /// a free run over all of it would be far off before the first is known.
  Fit grown(std::size_t effect, const FitOptions& options) const {
    double longest_s = 0.0;
    for (const Record& record : followed_.fitted.records) {
      longest_s = std::max(longest_s, static_cast<double>(record.fitted_rows) * record.drive.timing.tick_s);
    }
    Fit found;
    found.figures = scene_.nominal;
    for (double seconds = kStretch_s; seconds < std::min(longest_s, kWander_s) + kStretch_s;
         seconds += kStretch_s) {
      found = fit(coarse(followed_.fitted, seconds), bit(effect), found.figures, found.start, options);
    }
    return found;
  }

  /// `set` with `member` taken out and each of `which` put in its place while the others stand as they are, where their own
  /// minimum without it may be far away; those that look best, fitted to their end.
  std::vector<Trial> in_place_of(const Trial& set, std::size_t member,
                                 const std::vector<std::size_t>& which) const {
    Fit rest;
    rest.on = set.on & ~bit(member);
    rest.refined = set.fit.refined & ~bit(member);
    rest.figures = figures_without(scene_, set.fit.figures, member);
    rest.start = set.fit.start;
    return finished_best(rest, which, kFinishedInPlace);
  }

  /// A look at `effect` fitted to its end, refined where that pays; briefly where it is behind the best look.
  Trial finished(const Look& looked, std::size_t effect, double best_squares) const {
    if (!std::isfinite(looked.squares)) return Trial{};
    if (looked.squares > kBehind * best_squares) {
      const Fit& found = looked.best;
      return tried(fitted(found.on, found.figures, found.start, brief(found.refined)));
    }
    const auto to_its_end = [&](const Fit& found) {
      return fitted(found.on, found.figures, found.start, finish(found.refined));
    };
    Fit found = to_its_end(looked.best);
    if (looked.shown) {
      Fit other = to_its_end(*looked.shown);
      if (other.squares < found.squares) found = std::move(other);
    }
    Trial plain = tried(std::move(found));
    return plain.valid() ? refined(std::move(plain), effect, looked.finer) : plain;
  }

  /// `set` with this effect of it refined, where that pays, from there or also from `other`.
  Trial refined(Trial set, std::size_t effect, const std::optional<Fit>& other = {}) const {
    if (!refinable(effect) || (set.fit.refined & bit(effect)) != 0) return set;
    const FitOptions options = finish(set.fit.refined | bit(effect));
    Fit found = fitted(set.on, set.fit.figures, set.fit.start, options);
    if (other) {
      Fit elsewhere = fitted(set.on, other->figures, other->start, options);
      if (elsewhere.squares < found.squares) found = std::move(elsewhere);
    }
    Trial finer = tried(std::move(found));
    if (!finer.valid()) return set;
    // the correlation that is left: that of the plain trial's error is what a refinement explains
    const double correlated = correlation(finer);
    const bool pays = finer.heldout_Pa() < set.heldout_Pa() &&
                      finer.evidence(correlated) > set.evidence(correlated) + kWorthEntering &&
                      (effect != effects::kIdNullDrift || share_of_rest(finer.heldout_Pa(), set.heldout_Pa(),
                                                                        options_.noise_Pa) > kWanderCloses);
    if (pays) return finer;
    return set;
  }

  /// `set` with its effects refined where that pays beside each other: it may not have paid alone.
  Trial refined(Trial set) const {
    for (const std::size_t member : members(set.on)) set = refined(std::move(set), member);
    return set;
  }

  /// `base` with this effect taken out.
  Trial without(const Trial& base, std::size_t effect) const {
    return tried(fitted(base.on & ~bit(effect), figures_without(scene_, base.fit.figures, effect),
                        base.fit.start, finish(base.fit.refined & ~bit(effect))));
  }

  /// `set` without the effects that are not worth their place beside the others, the least first.
  Trial pruned(Trial set, const Trial& recalibrated) const {
    while (set.on != 0) {
      const double correlated = correlation(set);
      Trial least;
      for (const std::size_t member : members(set.on)) {
        Trial rest = std::popcount(set.on) == 1 ? recalibrated : without(set, member);
        const bool stays = worth_entering(set, rest, correlated) &&
                           (rest.on == 0 || closes_enough(set, rest, options_.noise_Pa));
        if (!stays && (!least.valid() || rest.heldout_Pa() < least.heldout_Pa())) least = std::move(rest);
      }
      if (!least.valid()) break;
      set = std::move(least);
    }
    return set;
  }

  /// Rows for one piece of information in a trial's error on fitted rows.
  double correlation(const Trial& trial) const {
    double worst = 1.0;
    for (std::size_t i = 0; i < scene_.records.size(); ++i) {
      const Record& record = scene_.records[i];
      const std::vector<double> reading =
          run(scene_, record, trial.on, trial.fit.figures, trial.fit.start[i]);
      std::vector<double> error;
      for (std::size_t row = record.settled_rows; row < record.fitted_rows; ++row) {
        error.push_back(reading[row] - record.measured_Pa[row]);
      }
      worst = std::max(worst, correlation_rows(error));
    }
    return worst;
  }

  /// `base` with each of `which` besides; only the `most` that look best are fitted to their end and returned.
  const std::vector<Trial>& all_with(const Trial& base, const std::vector<std::size_t>& which,
                                     std::size_t most = kEffects) {
    const std::pair key(base.on, base.fit.refined);
    const auto known = beside_.find(key);
    if (known != beside_.end()) return known->second;
    return beside_.emplace(key, finished_best(base.fit, which, most)).first->second;
  }

 private:
  /// Of the looks at `base` with each of `which` besides, the `most` that fit best, fitted to their end.
  std::vector<Trial> finished_best(const Fit& base, const std::vector<std::size_t>& which,
                                   std::size_t most) const {
    const double base_squares = fit(coarse_, base.on, base.figures, base.start, brief(base.refined)).squares;
    std::vector<Look> looks(which.size());
    identify::in_parallel(which.size(), options_.threads,
                          [&](std::size_t i) { looks[i] = look(base, base_squares, which[i]); });
    std::vector<std::size_t> order(which.size());
    std::iota(order.begin(), order.end(), 0U);
    if (which.size() > most) {
      std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(most), order.end(),
                        [&](std::size_t a, std::size_t b) { return looks[a].squares < looks[b].squares; });
      order.resize(most);
    }
    double best = std::numeric_limits<double>::infinity();
    for (const Look& looked : looks) best = std::min(best, looked.squares);
    std::vector<Trial> trials(order.size());
    identify::in_parallel(order.size(), options_.threads, [&](std::size_t i) {
      trials[i] = finished(looks[order[i]], which[order[i]], best);
    });
    return trials;
  }

  /// `figures` with the first parameter of `effect` so many of its typical changes away from what the rig says, as far as
  /// it is allowed; a decrease that would leave its range is three tenths of one.
  std::vector<Figures> sizes_of(std::size_t effect, const Figures& figures,
                                std::initializer_list<double> sizes) const {
    const std::size_t at = effects::kFirstFigure[effect];
    const effects::Parameter first = effects::kCatalogue[effect]->parameters.front().of(size_of(scene_));
    const double from = scene_.nominal[at];
    std::vector<Figures> all;
    for (const double size : sizes) {
      Figures start = figures;
      start[at] = from + size * first.typical_change;
      if (start[at] < first.least() && size < 0.0 && from > first.least()) {
        start[at] = from - 0.3 * first.typical_change;
      }
      if (start[at] >= first.least() && start[at] <= first.greatest()) all.push_back(start);
    }
    return all;
  }

  static FitOptions brief(EffectSet refined) {
    return {.most_iterations = 5, .tolerance = 1e-3, .refined = refined};
  }
  static FitOptions finish(EffectSet refined) {
    return {.most_iterations = 30, .tolerance = 1e-4, .refined = refined};
  }
  const Split& split(EffectSet refined) const {
    return (refined & bit(effects::kIdNullDrift)) != 0 ? followed_ : before_;
  }
  static bool refinable(std::size_t effect) {
    const auto parameters = effects::kCatalogue[effect]->parameters;
    return std::any_of(parameters.begin(), parameters.end(),
                       [](const effects::Parameter& p) { return p.refines; });
  }

  const Scene& scene_;
  Scene coarse_;  ///< for looks
  Split before_;  ///< the rows held out begin where those fitted end
  Split followed_;
  const SearchOptions& options_;
  /// By the set that was enlarged, and what of it was refined.
  std::map<std::pair<EffectSet, EffectSet>, std::vector<Trial>> beside_;
};

}  // namespace

std::vector<std::size_t> members(EffectSet on) {
  std::vector<std::size_t> in;
  for (std::size_t i = 0; i < kEffects; ++i) {
    if ((on >> i & 1U) != 0) in.push_back(i);
  }
  return in;
}

double Trial::heldout_Pa() const {
  return std::sqrt(heldout_squares / static_cast<double>(heldout_rows));
}
bool Trial::valid() const {
  return fit.rows > 0 && std::isfinite(fit.squares + heldout_squares + joint_squares);
}
double Trial::evidence(double correlated_rows) const {
  if (!valid()) return -std::numeric_limits<double>::infinity();
  const auto rows = static_cast<double>(fit.rows + heldout_rows);
  const double pieces = std::clamp(rows / correlated_rows, kLeastPieces, kMostPieces);
  return -0.5 * pieces * std::log(joint_squares / rows) -
         0.5 * static_cast<double>(variables) * std::log(pieces);
}

double share_of_rest(double with_Pa, double without_Pa, double noise_Pa) {
  const double rest = without_Pa * without_Pa - noise_Pa * noise_Pa;
  return rest > 0.0 ? std::clamp((without_Pa * without_Pa - with_Pa * with_Pa) / rest, 0.0, 1.0) : 0.0;
}

effects::Start heldout_start(const Scene& scene, const HeldOut& held, const Fit& fit) {
  if (held.continues >= 0) return fit.start[static_cast<std::size_t>(held.continues)];
  const effects::Start start = estimate_start(scene, held.record, fit.on, fit.figures);
  if (!wanders(fit)) return start;
  Record shown = held.record;
  shown.half = half_of(shown, held.first, false);
  return wandering_start(scene, shown, fit, start);
}

std::vector<double> heldout_reading(const Scene& scene, const HeldOut& held, const Fit& fit) {
  return run(scene, held.record, fit.on, fit.figures, heldout_start(scene, held, fit));
}

Trial recalibrated(const Scene& scene, const std::vector<HeldOut>& heldout) {
  return tried({scene, heldout, as_fitted(heldout)},
               fit(scene, 0, scene.nominal, {}, {.most_iterations = 100}));
}

Search search(const Scene& scene, const std::vector<HeldOut>& heldout, Trial recalibrated,
              const SearchOptions& options) {
  Searcher searcher(scene, heldout, options);
  const auto tell = [&](double share) {
    if (options.progress) options.progress(share);
  };
  Search result;
  result.recalibrated = std::move(recalibrated);
  tell(0.1);

  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < kEffects; ++i) {
    if ((options.struck & bit(i)) == 0) all.push_back(i);
  }
  const auto but = [&](EffectSet on) {
    std::vector<std::size_t> others = all;
    std::erase_if(others, [&](std::size_t i) { return (on & bit(i)) != 0; });
    return others;
  };
  result.alone.resize(kEffects);
  std::vector<Trial> trials = searcher.all_with(result.recalibrated, all);
  for (const Trial& trial : trials) {
    if (trial.valid()) result.alone[members(trial.on).front()] = trial;
  }
  tell(0.4);

  // forward: the best sets of each size are enlarged, also by an effect that pays only beside another
  result.best = result.recalibrated;
  bool second_paid = true;
  for (std::size_t size = 1; size <= kMostEffects; ++size) {
    std::erase_if(trials, [](const Trial& t) { return !t.valid(); });
    if (trials.empty()) break;
    // the correlation is that of the best candidate's error: that of the error before it is what it explains
    best_first(trials, result.recalibrated, searcher.correlation(result.best));
    const auto least = std::min_element(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) {
      return a.joint_squares < b.joint_squares;
    });
    const bool far_less = least->joint_squares < kFarLess * trials.front().joint_squares;
    const double correlated = searcher.correlation(far_less ? *least : trials.front());
    best_first(trials, result.recalibrated, correlated);
    once_each(trials);
    const bool better = worth_entering(trials.front(), result.best, correlated);
    if (better && size > 1) trials.front() = searcher.refined(std::move(trials.front()));
    if (better && (second_paid || trials.front().heldout_Pa() < kMuchLeft * options.noise_Pa)) {
      result.best = trials.front();
    }
    if (size == 2) second_paid = better;
    const double left = result.best.heldout_Pa() / options.noise_Pa;
    if (size == kMostEffects || left < kAtFloor || (size > 1 && !better && left < kMuchLeft)) break;
    std::vector<Trial> larger;
    for (std::size_t i = 0; i < std::min(kBeam, trials.size()); ++i) {
      const std::vector<Trial>& beside = searcher.all_with(trials[i], but(trials[i].on), kFinished);
      larger.insert(larger.end(), beside.begin(), beside.end());
    }
    trials = std::move(larger);
    tell(0.4 + 0.2 * static_cast<double>(size));
  }

  // back: what closes too little to be told from the form of the others leaves
  result.best = searcher.pruned(std::move(result.best), result.recalibrated);

  // swap: each effect of the set leaves, and every other tries its place; once more where one does better
  for (int pass = 0;; ++pass) {
    result.rivals.clear();
    result.correlated_rows = searcher.correlation(result.best);
    Trial better = result.best;
    for (const std::size_t member : members(result.best.on)) {
      std::vector<Trial> rivals;
      if (std::popcount(result.best.on) == 1) {
        for (const std::size_t i : but(result.best.on)) rivals.push_back(result.alone[i]);
        rivals.push_back(result.recalibrated);
      } else {
        const Trial rest = searcher.without(result.best, member);
        rivals = searcher.in_place_of(result.best, member, but(result.best.on));
        for (const Trial& fresh : searcher.all_with(rest, but(rest.on), kFinished)) {
          const auto same =
              std::find_if(rivals.begin(), rivals.end(), [&](const Trial& t) { return t.on == fresh.on; });
          if (same == rivals.end()) {
            rivals.push_back(fresh);
          } else if (fresh.evidence(result.correlated_rows) > same->evidence(result.correlated_rows)) {
            *same = fresh;
          }
        }
        rivals.push_back(rest);
      }
      std::erase_if(rivals, [&](const Trial& t) { return !t.valid() || t.on == result.best.on; });
      for (const Trial& rival : rivals) {
        if (rival.evidence(result.correlated_rows) > better.evidence(result.correlated_rows)) better = rival;
      }
      result.rivals.push_back(std::move(rivals));
    }
    if (better.on == result.best.on || pass == kMostSwaps) break;
    better = searcher.pruned(std::move(better), result.recalibrated);
    if (better.on == result.best.on ||
        better.evidence(result.correlated_rows) <= result.best.evidence(result.correlated_rows)) {
      break;
    }
    result.best = std::move(better);
  }
  tell(1.0);
  return result;
}

}  // namespace plenum::host::diagnose
