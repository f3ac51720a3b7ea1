#include "host-sim/diagnose/set_fits.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>

#include "host-sim/diagnose/look.hpp"
#include "host-sim/identify/in_parallel.hpp"

namespace plenum::host::diagnose {
namespace {

using effects::EffectSet;
using effects::Figures;
using identify::chamber::figures_without;
using identify::chamber::FitOptions;

/// Of the effects put in another's place beside the rest, those whose fit is finished.
constexpr std::size_t kFinishedInPlace = 3;
/// Short fits are run this long, in half as many steps a tick.
constexpr double kLook_s = 40.0;
/// Of the squares: an effect that changes them by less shows nothing at that size. A brief fit ends where a step takes off 1e-3.
constexpr double kShown = 3e-3;
/// Of the squares of the best look: an effect that looks worse by this is fitted briefly, and not refined. If its end were no
/// better its odds would be 20^-10 at most.
constexpr double kBehind = 20.0;
/// Of the noise: what comes as near is followed to the end of its valley, which may be long. Farther away, and in looks, a fit ends where a
/// step takes off a thousandth of the squares, a tenth of a nat.
constexpr double kNear = 3.0;

FitOptions brief(EffectSet refined) {
  return {.most_iterations = 5, .tolerance = 1e-3, .refined = refined};
}
FitOptions finish(EffectSet refined) {
  return {.most_iterations = 30, .tolerance = 1e-3, .refined = refined};
}
FitOptions settle(EffectSet refined) {
  return {.most_iterations = 30, .tolerance = 1e-4, .refined = refined};
}
bool refinable(std::size_t effect) {
  const auto parameters = effects::kCatalogue[effect]->parameters;
  return std::any_of(parameters.begin(), parameters.end(),
                     [](const effects::Parameter& p) { return p.refines; });
}

}  // namespace

SetFits::SetFits(const Scene& scene, const std::vector<HeldOut>& heldout, double noise_Pa, unsigned threads)
    : scene_(scene),
      coarse_(coarse(scene, kLook_s)),
      before_(split_of(scene, heldout)),
      followed_(followed(before_)),
      noise_Pa_(noise_Pa),
      threads_(threads) {}

const std::vector<Trial>& SetFits::all_with(const Trial& base, const std::vector<std::size_t>& which,
                                            std::size_t most) {
  const std::pair key(base.on, base.fit.refined);
  const auto known = beside_.find(key);
  if (known != beside_.end()) return known->second;
  return beside_.emplace(key, finished_best(base.fit, which, most)).first->second;
}

bool SetFits::wanders_alone() const {
  const auto alone = beside_.find({0, 0});
  return alone != beside_.end() &&
         std::any_of(alone->second.begin(), alone->second.end(),
                     [](const Trial& t) { return (t.fit.refined & bit(effects::kIdNullDrift)) != 0; });
}

std::vector<Trial> SetFits::in_place_of(const Trial& set, std::size_t member,
                                        const std::vector<std::size_t>& which) const {
  Fit rest;
  rest.on = set.on & ~bit(member);
  rest.refined = set.fit.refined & ~bit(member);
  rest.figures = figures_without(scene_, set.fit.figures, member);
  rest.start = set.fit.start;
  return finished_best(rest, which, kFinishedInPlace);
}

Trial SetFits::refined(Trial set) const {
  for (const std::size_t member : members(set.on)) set = refined(std::move(set), member);
  return set;
}

Trial SetFits::drifting(const Trial& set) const {
  constexpr std::size_t kNull = effects::kIdNullDrift;
  const auto parameters = effects::kCatalogue[kNull]->parameters;
  Figures figures = set.fit.figures;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const std::size_t at = effects::kFirstFigure[kNull] + k;
    if (parameters[k].refines) figures[at] = scene_.nominal[at];
  }
  std::vector<effects::Start> start = set.fit.start;
  for (effects::Start& of : start) of.null_V = {};
  return tried(fitted(set.on, figures, start, set.fit.refined & ~bit(kNull)));
}

Trial SetFits::wandering(const Trial& set) const {
  constexpr std::size_t kNull = effects::kIdNullDrift;
  const EffectSet finer = set.fit.refined | bit(kNull);
  const Fit looked = grown(set.fit, kNull, brief(finer));
  Trial with = tried(fitted(looked.on, looked.figures, looked.start, finer));
  return with.valid() ? refined(std::move(with)) : with;  // the corners of a loop show only now
}

Trial SetFits::without(const Trial& base, std::size_t effect) const {
  Trial rest = tried(fitted(base.on & ~bit(effect), figures_without(scene_, base.fit.figures, effect),
                            base.fit.start, base.fit.refined & ~bit(effect)));
  // the figures beside the effect may lead to another minimum than the one in which the smaller set was found
  for (const auto& [enlarged, trials] : beside_) {
    for (const Trial& known : trials) {
      if (known.on == rest.on && known.valid() &&
          (!rest.valid() || known.joint_mean_square() < rest.joint_mean_square())) {
        rest = known;
      }
    }
  }
  return rest;
}

Fit SetFits::fitted(EffectSet on, const Figures& figures, const std::vector<effects::Start>& start,
                    EffectSet refined) const {
  const Scene& rows = split(refined).fitted;
  Fit found = fit(rows, on, figures, start, finish(refined));
  if (found.rms_Pa() < kNear * noise_Pa_) found = fit(rows, on, found.figures, found.start, settle(refined));
  return found;
}

Trial SetFits::tried(Fit fit) const {
  const Split& rows = split(fit.refined);
  return diagnose::tried(rows, std::move(fit));
}

SetFits::Look SetFits::look(const Fit& base, double base_squares, std::size_t effect) const {
  const EffectSet on = base.on | bit(effect);
  Look seen;
  seen.best.on = on;
  std::vector<Figures> starts;
  if (base.on == 0) {
    starts = sizes_of(effect, base.figures, {0.3, 3.0, 30.0, -1.0});
    if (effect == effects::kIdTubeDynamics) {
      // a hose of 3 m under a chirp is found neither from 0.9 m nor from 9 m
      const std::vector<Figures> between = sizes_of(effect, base.figures, {10.0});
      starts.insert(starts.end(), between.begin(), between.end());
    }
  } else {
    // that which errs least beside the others as they stand, and a typical one: heat has two minima
    const std::optional<Figures> least = least_erring(
        on, sizes_of(effect, base.figures, {0.1, 0.3, 3.0, 10.0, 30.0, -0.3, -1.0, -5.0}), base.start);
    starts = sizes_of(effect, base.figures, {1.0});
    if (least) starts.push_back(*least);
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
      Fit nothing_known;
      nothing_known.figures = scene_.nominal;
      Fit other = grown(nothing_known, effect, options);
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

std::optional<Figures> SetFits::finer_start(std::size_t effect, const Figures& best, const Fit& base) const {
  Figures start = best;
  double* const x = start.data() + effects::kFirstFigure[effect];
  const auto least_of = [&](std::initializer_list<double> sizes) {
    return least_erring(base.on | bit(effect), sizes_of(effect, start, sizes), base.start);
  };
  if (effect == effects::kIdSpoolLag) {
    // as late by its coil alone, the spool without mass
    x[3] += x[0] * x[1] / std::numbers::pi;
    x[0] = 0.0;
    return start;
  }
  if (effect == effects::kIdSupplyDroop && logs_supply(scene_)) {
    // as the log has it, and no resistance: where others draw, none is found to begin from
    x[0] = 0.0;
    start[identify::chamber::kFollowedSupply] = 1.0;
    return start;
  }
  if (effect == effects::kIdChamberLeak) {
    // straight in the gauge pressure: beside a gap's, of which there is little, the valve's own leaks took it; or past a piston, to
    // half way between ambient and supply, to which no small steps lead from where nothing leaks
    if (base.on == 0) std::copy_n(scene_.nominal.begin(), effects::kValveFigures, start.begin());
    x[1] = 0.0;
    std::vector<Figures> starts = sizes_of(effect, start, {1.0, 3.0, 10.0, 30.0});
    x[1] = 1.0;
    x[3] = 0.5e-3 * (scene_.around.supply_Pa - scene_.around.ambient_Pa);
    const std::vector<Figures> past = sizes_of(effect, start, {1.0, 3.0, 10.0, 30.0});
    starts.insert(starts.end(), past.begin(), past.end());
    return least_erring(base.on | bit(effect), starts, base.start);
  }
  if (effect == effects::kIdExhaustBackpressure) {
    // half straight and no manifold, where an orifice's ran away with one
    x[1] = 0.0;
    x[2] = 0.5;
    return least_of({1.0, 3.0, 10.0, 20.0, 40.0, 60.0, 100.0});
  }
  return {};
}

Fit SetFits::grown(const Fit& base, std::size_t effect, const FitOptions& options) const {
  double longest_s = 0.0;
  for (const Record& record : followed_.fitted.records) {
    longest_s = std::max(longest_s, static_cast<double>(record.fitted_rows) * record.drive.timing.tick_s);
  }
  Fit found;
  found.figures = base.figures;
  found.start = base.start;
  const double stretch_s = identify::chamber::stretch_s(scene_);
  for (double seconds = stretch_s; seconds < longest_s + stretch_s; seconds += stretch_s) {
    found =
        fit(coarse(followed_.fitted, seconds), base.on | bit(effect), found.figures, found.start, options);
  }
  return found;
}

Trial SetFits::finished(const Look& looked, std::size_t effect, double best_squares) const {
  if (!std::isfinite(looked.squares)) return Trial{};
  if (looked.squares > kBehind * best_squares) {
    const Fit& found = looked.best;
    return tried(
        fit(split(found.refined).fitted, found.on, found.figures, found.start, brief(found.refined)));
  }
  const auto to_its_end = [&](const Fit& found) {
    return fitted(found.on, found.figures, found.start, found.refined);
  };
  Fit found = to_its_end(looked.best);
  if (looked.shown) {
    Fit other = to_its_end(*looked.shown);
    if (other.squares < found.squares) found = std::move(other);
  }
  Trial plain = tried(std::move(found));
  return plain.valid() ? refined(std::move(plain), effect, looked.finer) : plain;
}

Trial SetFits::refined(Trial set, std::size_t effect, const std::optional<Fit>& other) const {
  if (!refinable(effect) || (set.fit.refined & bit(effect)) != 0) return set;
  // beside an effect whose form is not the machine's twenty figures follow what that leaves
  if (effect == effects::kIdNullDrift && set.on != bit(effect) && !wanders_alone()) return set;
  const EffectSet finer_set = set.fit.refined | bit(effect);
  Fit found = fitted(set.on, set.fit.figures, set.fit.start, finer_set);
  if (other) {
    Fit elsewhere = fitted(set.on, other->figures, other->start, finer_set);
    if (elsewhere.squares < found.squares) found = std::move(elsewhere);
  }
  Trial finer = tried(std::move(found));
  if (!finer.valid()) return set;
  // the correlation that is left: that of the plain trial's error is what a refinement explains
  const double correlated = correlation(scene_, finer);
  const bool pays = finer.heldout_Pa() < set.heldout_Pa() &&
                    finer.evidence(correlated) > set.evidence(correlated) + kWorthEntering &&
                    (effect != effects::kIdNullDrift ||
                     share_of_rest(finer.heldout_Pa(), set.heldout_Pa(), noise_Pa_) > kWanderCloses);
  if (pays) return finer;
  return set;
}

std::vector<Trial> SetFits::finished_best(const Fit& base, const std::vector<std::size_t>& which,
                                          std::size_t most) const {
  const double base_squares = fit(coarse_, base.on, base.figures, base.start, brief(base.refined)).squares;
  std::vector<Look> looks(which.size());
  identify::in_parallel(which.size(), threads_,
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
  identify::in_parallel(order.size(), threads_,
                        [&](std::size_t i) { trials[i] = finished(looks[order[i]], which[order[i]], best); });
  return trials;
}

std::vector<Figures> SetFits::sizes_of(std::size_t effect, const Figures& figures,
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

std::optional<Figures> SetFits::least_erring(EffectSet on, const std::vector<Figures>& figures,
                                             const std::vector<effects::Start>& start) const {
  if (figures.empty()) return {};
  return figures[least_error(coarse_, on, figures, start)];
}

const Split& SetFits::split(EffectSet refined) const {
  return (refined & bit(effects::kIdNullDrift)) != 0 ? followed_ : before_;
}

}  // namespace plenum::host::diagnose
