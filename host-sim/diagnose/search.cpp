#include "host-sim/diagnose/search.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <limits>
#include <thread>

#include "host-sim/diagnose/noise.hpp"

namespace plenum::host::diagnose {
namespace {

using effects::EffectSet;
using effects::Figures;
using effects::kEffects;

constexpr int kMostEffects = 3;
constexpr std::size_t kSecondLook =
    6;  // effects tried beside a set: those that gained most beside the set before
/// An effect enters a set for this much evidence beyond its parameters' price, and for this share of the squares: less
/// can be clutter (jitter, ripple) that one of fourteen effects happens to fit. An effect as large as the noise, the
/// least that is called detectable, takes away half.
constexpr double kWorthEntering = 6.0;
constexpr double kLeastShare = 0.15;
/// A second or third effect must close these shares of the gap that calibration leaves, and of what the set without it
/// leaves, and this share of the noise: less is the form of the first effect, which no catalogue holds exactly.
constexpr double kFurtherOfAll = 0.05;
constexpr double kFurtherOfRest = 0.3;
constexpr double kFurtherOfNoise = 0.25;

EffectSet bit(std::size_t effect) {
  return EffectSet{1} << effect;
}

void in_parallel(std::size_t count, unsigned threads, const std::function<void(std::size_t)>& task) {
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) task(i);
  };
  std::vector<std::jthread> others;
  for (unsigned t = 1; t < threads; ++t) others.emplace_back(work);
  work();
}

class Searcher {
 public:
  Searcher(const Scene& scene, const std::vector<HeldOut>& heldout, const SearchOptions& options)
      : scene_(scene), heldout_(heldout), options_(options) {}

  Trial tried(Fit fit) const {
    Trial trial;
    trial.on = fit.on;
    for (const HeldOut& held : heldout_) {
      const Score s = score(heldout_reading(scene_, held, fit), held.record, held.first);
      trial.heldout_squares += s.squares;
      trial.heldout_rows += s.rows;
    }
    trial.fit = std::move(fit);
    return trial;
  }

  /// The set of `base` with `effect` besides: short fits from several sizes of it, the best to its end.
  Trial with(const Trial& base, std::size_t effect) const {
    const EffectSet on = base.on | bit(effect);
    const std::size_t at = effects::first_figure(effect);
    const effects::Parameter& first = effects::kCatalogue[effect]->parameters.front();
    Fit best;
    best.squares = std::numeric_limits<double>::infinity();
    for (const double size : {0.3, 3.0, -1.0}) {
      Figures start = base.fit.figures;
      start[at] = first.neutral() + size * first.typical_change;
      if (start[at] < first.least() || start[at] > first.greatest()) {
        if (size < 0.0 && first.neutral() > first.least())
          start[at] = first.neutral() - 0.3 * first.typical_change;
        if (start[at] < first.least() || start[at] > first.greatest()) continue;
      }
      Fit look = fit(scene_, on, start, base.fit.start_Pa,
                     {.most_iterations = 5, .tolerance = 1e-3, .refined = base.fit.refined});
      if (look.squares < best.squares) best = std::move(look);
    }
    if (!std::isfinite(best.squares)) return Trial{};
    Trial plain = tried(fit(scene_, on, best.figures, best.start_Pa, finish(base.fit.refined)));
    if (!refinable(effect) || !plain.valid()) return plain;
    const Trial refined =
        tried(fit(scene_, on, plain.fit.figures, plain.fit.start_Pa, finish(base.fit.refined | bit(effect))));
    const double correlated = correlation(plain);
    return refined.valid() && refined.heldout_squares < plain.heldout_squares &&
                   refined.evidence(correlated) > plain.evidence(correlated) + kWorthEntering
               ? refined
               : plain;
  }

  /// `base` with this effect taken out.
  Trial without(const Trial& base, std::size_t effect) const {
    Figures start = base.fit.figures;
    std::size_t at = effects::first_figure(effect);
    for (const effects::Parameter& p : effects::kCatalogue[effect]->parameters) start[at++] = p.neutral();
    return tried(fit(scene_, base.on & ~bit(effect), start, base.fit.start_Pa,
                     finish(base.fit.refined & ~bit(effect))));
  }

  /// Rows for one piece of information in a trial's error on fitted rows.
  double correlation(const Trial& trial) const {
    double worst = 1.0;
    for (std::size_t i = 0; i < scene_.records.size(); ++i) {
      const Record& record = scene_.records[i];
      const std::vector<double> reading =
          run(scene_, record, trial.on, trial.fit.figures, trial.fit.start_Pa[i]);
      std::vector<double> error;
      for (std::size_t row = record.settled_rows; row < record.fitted_rows; ++row) {
        error.push_back(reading[row] - record.measured_Pa[row]);
      }
      worst = std::max(worst, correlation_rows(error));
    }
    return worst;
  }

  std::vector<Trial> all_with(const Trial& base, const std::vector<std::size_t>& which) const {
    std::vector<Trial> trials(which.size());
    in_parallel(which.size(), options_.threads, [&](std::size_t i) { trials[i] = with(base, which[i]); });
    return trials;
  }

 private:
  static FitOptions finish(EffectSet refined) {
    return {.most_iterations = 30, .tolerance = 1e-4, .refined = refined};
  }
  static bool refinable(std::size_t effect) {
    const auto parameters = effects::kCatalogue[effect]->parameters;
    return std::any_of(parameters.begin(), parameters.end(),
                       [](const effects::Parameter& p) { return p.refines; });
  }

  const Scene& scene_;
  const std::vector<HeldOut>& heldout_;
  const SearchOptions& options_;
};

bool worth_entering(const Trial& with, const Trial& base, double correlated_rows) {
  return with.valid() && with.evidence(correlated_rows) - base.evidence(correlated_rows) > kWorthEntering &&
         with.fit.squares < (1.0 - kLeastShare) * base.fit.squares &&
         with.heldout_squares < (1.0 - kLeastShare) * base.heldout_squares;
}

/// Whether a further effect closes enough, beyond being significant.
bool closes_enough(const Trial& with, const Trial& base, const Trial& recalibrated, double noise_Pa) {
  const double closed = base.heldout_Pa() - with.heldout_Pa();
  return closed > kFurtherOfAll * (recalibrated.heldout_Pa() - noise_Pa) &&
         closed > kFurtherOfRest * (base.heldout_Pa() - noise_Pa) && closed > kFurtherOfNoise * noise_Pa;
}

/// Leaves those in `which` that live in the equation of `member`, and those that do best alone.
void keep_likely(std::vector<std::size_t>& which, const std::vector<Trial>& alone, std::size_t member,
                 double correlated_rows) {
  std::sort(which.begin(), which.end(), [&](std::size_t a, std::size_t b) {
    return alone[a].evidence(correlated_rows) > alone[b].evidence(correlated_rows);
  });
  std::size_t place = 0;
  std::erase_if(which, [&](std::size_t i) {
    return place++ >= kSecondLook &&
           effects::kCatalogue[i]->equation != effects::kCatalogue[member]->equation;
  });
}

std::size_t best_of(const std::vector<Trial>& trials, double correlated_rows) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < trials.size(); ++i) {
    if (!trials[i].valid()) continue;
    if (!trials[best].valid() || trials[i].evidence(correlated_rows) > trials[best].evidence(correlated_rows))
      best = i;
  }
  return best;
}

std::vector<std::size_t> members(EffectSet on) {
  std::vector<std::size_t> in;
  for (std::size_t i = 0; i < kEffects; ++i) {
    if ((on & bit(i)) != 0) in.push_back(i);
  }
  return in;
}

}  // namespace

double Trial::heldout_Pa() const {
  return std::sqrt(heldout_squares / static_cast<double>(heldout_rows));
}
bool Trial::valid() const {
  return fit.rows > 0 && std::isfinite(fit.squares + heldout_squares);
}
double Trial::evidence(double correlated_rows) const {
  if (!valid()) return -std::numeric_limits<double>::infinity();
  const auto rows = static_cast<double>(fit.rows);
  const double pieces = std::max(rows / correlated_rows, 20.0);
  return -0.5 * pieces * std::log(fit.squares / rows) -
         0.5 * static_cast<double>(fit.variables.size()) * std::log(pieces);
}

std::vector<double> heldout_reading(const Scene& scene, const HeldOut& held, const Fit& fit) {
  const double start = held.continues >= 0 ? fit.start_Pa[static_cast<std::size_t>(held.continues)]
                                           : estimate_start(scene, held.record, fit.on, fit.figures);
  return run(scene, held.record, fit.on, fit.figures, start);
}

Search search(const Scene& scene, const std::vector<HeldOut>& heldout, const SearchOptions& options) {
  const Searcher searcher(scene, heldout, options);
  const auto tell = [&](double share) {
    if (options.progress) options.progress(share);
  };
  Search result;
  result.recalibrated = searcher.tried(fit(scene, 0, scene.nominal, {}, {.most_iterations = 100}));
  tell(0.1);

  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < kEffects; ++i) {
    if ((options.struck & bit(i)) == 0) all.push_back(i);
  }
  std::vector<Trial> trials = searcher.all_with(result.recalibrated, all);
  result.alone.resize(kEffects);
  for (std::size_t k = 0; k < all.size(); ++k) result.alone[all[k]] = trials[k];
  tell(0.5);

  // forward: the effect that gains most, while it is worth it
  result.best = result.recalibrated;
  std::vector<std::size_t> beside = all;
  for (int size = 1; size <= kMostEffects && !beside.empty(); ++size) {
    if (size > 1) trials = searcher.all_with(result.best, beside);
    // the correlation is that of the best candidate's error: that of the error before it is what it explains
    const std::size_t first = best_of(trials, searcher.correlation(result.best));
    if (!trials[first].valid()) break;
    const double correlated = searcher.correlation(trials[first]);
    const std::size_t chosen = best_of(trials, correlated);
    if (!worth_entering(trials[chosen], result.best, correlated)) break;
    if (size > 1 && !closes_enough(trials[chosen], result.best, result.recalibrated, options.noise_Pa)) break;
    // those that gained most beside the old set are looked at beside the new one
    std::vector<std::size_t> order(beside.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return trials[a].evidence(correlated) > trials[b].evidence(correlated);
    });
    std::vector<std::size_t> next;
    for (const std::size_t i : order) {
      if (i != chosen && (size == 1 || next.size() < kSecondLook)) next.push_back(beside[i]);
    }
    result.best = std::move(trials[chosen]);
    beside = std::move(next);
    if (result.best.heldout_Pa() < 1.02 * options.noise_Pa) break;  // nothing is left to explain
  }
  tell(0.8);

  // swap: each effect of the set leaves, and every other tries its place; once more where one does better
  for (int pass = 0; pass < 2; ++pass) {
    result.rivals.clear();
    result.correlated_rows = searcher.correlation(result.best);
    Trial better = result.best;
    for (const std::size_t member : members(result.best.on)) {
      std::vector<Trial> rivals;
      if (std::popcount(result.best.on) == 1) {
        for (const std::size_t i : all) {
          if (i != member) rivals.push_back(result.alone[i]);
        }
        rivals.push_back(result.recalibrated);
      } else {
        const Trial rest = searcher.without(result.best, member);
        std::vector<std::size_t> others;
        for (const std::size_t i : all) {
          if ((result.best.on & bit(i)) == 0) others.push_back(i);
        }
        keep_likely(others, result.alone, member, result.correlated_rows);
        rivals = searcher.all_with(rest, others);
        rivals.push_back(rest);
      }
      std::erase_if(rivals, [](const Trial& t) { return !t.valid(); });
      for (const Trial& rival : rivals) {
        if (rival.evidence(result.correlated_rows) > better.evidence(result.correlated_rows)) better = rival;
      }
      result.rivals.push_back(std::move(rivals));
    }
    if (better.on == result.best.on) break;
    result.best = std::move(better);
  }
  tell(1.0);
  return result;
}

}  // namespace plenum::host::diagnose
