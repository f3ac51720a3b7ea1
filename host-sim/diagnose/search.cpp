#include "host-sim/diagnose/search.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "host-sim/diagnose/set_fits.hpp"
#include "host-sim/diagnose/verdict.hpp"

namespace plenum::host::diagnose {
namespace {

using effects::EffectSet;
using effects::kEffects;

constexpr std::size_t kBeam = 2;      ///< sets of a size that are enlarged
constexpr std::size_t kFinished = 6;  ///< of the effects looked at beside a set, those whose fit is finished
constexpr int kMostSwaps = 4;         ///< of one effect of a set for another that does better
/// Of the noise: while more than this is left, sets are enlarged although the last effect did not pay; three can explain
/// what no two of them do. That they do is known by their leaving no more than this: of a machine far beyond the catalogue
/// three explain a little, too.
constexpr double kMuchLeft = 3.0;
/// Each of several effects must close most of the squares that the set without it leaves above the noise, and this share of the noise.
constexpr double kFurtherOfNoise = 0.25;
/// Of the effects alone, those beside which a null that wanders is followed, where all else leaves much.
constexpr std::size_t kWandersBeside = 3;
/// A command that moves by less from row to row rests, and of the rows so many may lie more than a second into a rest.
constexpr double kStill_V = 0.005;
constexpr double kMostRest = 0.3;
/// Of the squares that the first candidate leaves: what leaves less than this tells how its own error is correlated.
constexpr double kFarLess = 0.25;

/// By evidence, but after all others those that do not lower the held-out error.
void best_first(std::vector<Trial>& trials, const Trial& recalibrated, double correlated_rows,
                double noise_Pa) {
  const auto rank = [&](const Trial& t) {
    return std::pair(worth_entering(t, recalibrated, correlated_rows, noise_Pa), t.evidence(correlated_rows));
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
  const auto by = [&](double with_Pa, double base_Pa) {
    return base_Pa - with_Pa > kFurtherOfNoise * noise_Pa &&
           share_of_rest(with_Pa, base_Pa, noise_Pa) > kMostOfRest;
  };
  return by(with.heldout_Pa(), base.heldout_Pa()) || by(with.judged_Pa(), base.judged_Pa());
}

/// `set` without the effects that are not worth their place beside the others, the least first.
Trial pruned(const SetFits& fits, const Scene& scene, Trial set, const Trial& recalibrated, double noise_Pa) {
  while (set.on != 0) {
    const double correlated = correlation(scene, set);
    Trial least;
    for (const std::size_t member : members(set.on)) {
      Trial rest = std::popcount(set.on) == 1 ? recalibrated : fits.without(set, member);
      const bool stays = worth_entering(set, rest, correlated, noise_Pa) &&
                         (rest.on == 0 || closes_enough(set, rest, noise_Pa));
      if (!stays && (!least.valid() || rest.heldout_Pa() < least.heldout_Pa())) least = std::move(rest);
    }
    if (!least.valid()) break;
    set = std::move(least);
  }
  return set;
}

/// Whether the command moves often enough to tell a null that wanders from a valve that errs otherwise at each command: its way is
/// followed every other second, and while the command rests from one second to the next that foretells any constant error.
bool shows_wandering(const Scene& scene) {
  std::size_t rows = 0, resting = 0;
  for (const Record& record : scene.records) {
    const auto& command_V = record.drive.command_V;
    const auto second = static_cast<std::size_t>(1.0 / record.drive.timing.tick_s);
    std::size_t still = 0;
    for (std::size_t row = 1; row < command_V.size(); ++row) {
      still = std::abs(command_V[row] - command_V[row - 1]) < kStill_V ? still + 1 : 0;
      resting += still > second ? 1U : 0U;
    }
    rows += command_V.size();
  }
  return static_cast<double>(resting) < kMostRest * static_cast<double>(rows);
}

/// Those of `all` that are not in the set.
std::vector<std::size_t> outside(EffectSet on, std::vector<std::size_t> all) {
  std::erase_if(all, [&](std::size_t i) { return (on & bit(i)) != 0; });
  return all;
}

/// The set with a null that wanders that is found by following the null beside the best set, and beside each of the effects that do
/// best alone, stretch by stretch; enlarged while much is left. Sooner in the search it takes the place of others: it follows much.
Trial wandering_beside(SetFits& fits, const Scene& scene, const Search& so_far,
                       const std::vector<std::size_t>& all, double noise_Pa) {
  const EffectSet null = bit(effects::kIdNullDrift);
  const double correlated = correlation(scene, so_far.best);
  std::vector<Trial> bases;
  for (const Trial& trial : so_far.alone) {
    if (trial.valid() && trial.on != null && trial.on != so_far.best.on) bases.push_back(trial);
  }
  best_first(bases, so_far.recalibrated, correlated, noise_Pa);
  bases.resize(std::min(bases.size(), kWandersBeside));
  bases.push_back(so_far.best);
  Trial best;
  const auto take = [&](Trial trial) {
    if (trial.valid() && (!best.valid() || trial.evidence(correlated) > best.evidence(correlated)))
      best = std::move(trial);
  };
  for (const Trial& base : bases) {
    if (std::popcount(base.on | null) <= static_cast<int>(kMostEffects)) take(fits.wandering(base));
  }
  while (best.valid() && std::popcount(best.on) < static_cast<int>(kMostEffects) &&
         best.heldout_Pa() > kMuchLeft * noise_Pa) {
    const EffectSet before = best.on;
    for (const Trial& larger : fits.all_with(best, outside(before, all), kFinished)) take(larger);
    if (best.on == before) break;
    best = fits.refined(std::move(best));
  }
  return best;
}

}  // namespace

Search search(const Scene& scene, const std::vector<HeldOut>& heldout, Trial recalibrated,
              const SearchOptions& options) {
  SetFits fits(scene, heldout, options.noise_Pa, options.threads);
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
  result.alone.resize(kEffects);
  std::vector<Trial> trials = fits.all_with(result.recalibrated, all);
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
    best_first(trials, result.recalibrated, correlation(scene, result.best), options.noise_Pa);
    const auto least = std::min_element(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) {
      return a.joint_squares < b.joint_squares;
    });
    const bool far_less = least->joint_squares < kFarLess * trials.front().joint_squares;
    const double correlated = correlation(scene, far_less ? *least : trials.front());
    best_first(trials, result.recalibrated, correlated, options.noise_Pa);
    once_each(trials);
    const bool better = worth_entering(trials.front(), result.best, correlated, options.noise_Pa);
    if (better && size > 1) trials.front() = fits.refined(std::move(trials.front()));
    if (better && (second_paid || trials.front().heldout_Pa() < kMuchLeft * options.noise_Pa)) {
      result.best = trials.front();
    }
    if (size == 2) second_paid = better;
    const double left = result.best.heldout_Pa() / options.noise_Pa;
    if (size == kMostEffects || left < kAtFloor || (size > 1 && !better && left < kMuchLeft)) break;
    std::vector<Trial> larger;
    const auto enlarge = [&](const Trial& base) {
      const std::vector<Trial>& beside = fits.all_with(base, outside(base.on, all), kFinished);
      larger.insert(larger.end(), beside.begin(), beside.end());
    };
    for (std::size_t i = 0; i < std::min(kBeam, trials.size()); ++i) {
      enlarge(trials[i]);
      // a null that may wander follows the error of another effect, too, and hides it
      if (wanders(trials[i].fit)) enlarge(fits.drifting(trials[i]));
    }
    trials = std::move(larger);
    tell(0.4 + 0.2 * static_cast<double>(size));
  }

  // back: what closes too little to be told from the form of the others leaves
  result.best = pruned(fits, scene, std::move(result.best), result.recalibrated, options.noise_Pa);

  // last: of what is left by much a null that wanders may be the rest
  if ((options.struck & bit(effects::kIdNullDrift)) == 0 && !wanders(result.best.fit) &&
      result.best.heldout_Pa() > kMuchLeft * options.noise_Pa && shows_wandering(scene)) {
    Trial wandering = wandering_beside(fits, scene, result, all, options.noise_Pa);
    wandering = pruned(fits, scene, std::move(wandering), result.recalibrated, options.noise_Pa);
    if (wanders(wandering.fit) &&
        share_of_rest(wandering.heldout_Pa(), result.best.heldout_Pa(), options.noise_Pa) > kWanderCloses) {
      result.best = std::move(wandering);
    }
  }

  // swap: each effect of the set leaves, and every other tries its place; once more where one does better
  for (int pass = 0;; ++pass) {
    result.rivals.clear();
    result.correlated_rows = correlation(scene, result.best);
    Trial better = result.best;
    for (const std::size_t member : members(result.best.on)) {
      std::vector<Trial> rivals;
      if (std::popcount(result.best.on) == 1) {
        for (const std::size_t i : outside(result.best.on, all)) rivals.push_back(result.alone[i]);
        rivals.push_back(result.recalibrated);
      } else {
        const Trial rest = fits.without(result.best, member);
        rivals = fits.in_place_of(result.best, member, outside(result.best.on, all));
        for (const Trial& fresh : fits.all_with(rest, outside(rest.on, all), kFinished)) {
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
    better = pruned(fits, scene, std::move(better), result.recalibrated, options.noise_Pa);
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
