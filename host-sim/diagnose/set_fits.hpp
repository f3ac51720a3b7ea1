// The fits of a set of effects: enlarged by another, with one in another's place, without one, refined.
//
// Each begins with looks: short fits over the first seconds, in few steps a tick, from several sizes of the effect. Those that look
// best are fitted to their end, and refined where that pays.
#pragma once

#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "host-sim/diagnose/trial.hpp"

namespace plenum::host::diagnose {

/// Of what is left above the noise without it, by the plain drift or by all else: a way of the null that follows whatever it is given
/// closes less of another cause.
inline constexpr double kWanderCloses = 0.9;

class SetFits {
 public:
  /// `scene` must outlive it. `noise_Pa`: of the sensor.
  SetFits(const Scene& scene, const std::vector<HeldOut>& heldout, double noise_Pa, unsigned threads);

  /// `base` with each of `which` besides; only the `most` that look best are fitted to their end and returned.
  const std::vector<Trial>& all_with(const Trial& base, const std::vector<std::size_t>& which,
                                     std::size_t most = effects::kEffects);
  /// `set` with `member` taken out and each of `which` put in its place while the others stand as they are, where their own
  /// minimum without it may be far away; those that look best, fitted to their end.
  std::vector<Trial> in_place_of(const Trial& set, std::size_t member,
                                 const std::vector<std::size_t>& which) const;
  /// `set` with its effects refined where that pays beside each other: it may not have paid alone.
  Trial refined(Trial set) const;
  /// `set` whose null, which wanders, drifts plainly again.
  Trial drifting(const Trial& set) const;
  /// `set` with a null that wanders besides.
  Trial wandering(const Trial& set) const;
  /// `base` with this effect taken out, or the best fit known of that set.
  Trial without(const Trial& base, std::size_t effect) const;

 private:
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

  /// To its end. A null that wanders is known only where it is seen: with its spline it is followed into the rows held out.
  Fit fitted(effects::EffectSet on, const effects::Figures& figures, const std::vector<effects::Start>& start,
             effects::EffectSet refined) const;
  Trial tried(Fit fit) const;
  /// The set of `base`, of which a short fit leaves `base_squares`, with `effect` besides: the best of several sizes of it.
  Look look(const Fit& base, double base_squares, std::size_t effect) const;
  /// Where a refined effect is looked for besides its plain best: what no small steps lead to from there.
  std::optional<effects::Figures> finer_start(std::size_t effect, const effects::Figures& best,
                                              const Fit& base) const;
  /// `base`, of which figures and starts are begun from, with `effect` besides, refined over the first seconds, then over more and
  /// more: what acts in time is found one stretch after another, where a free run over all of it would be far off before the first is
  /// known.
  Fit grown(const Fit& base, std::size_t effect, const identify::chamber::FitOptions& options) const;
  /// A look at `effect` fitted to its end, refined where that pays; briefly where it is behind the best look.
  Trial finished(const Look& looked, std::size_t effect, double best_squares) const;
  /// `set` with this effect of it refined, where that pays, from there or also from `other`.
  Trial refined(Trial set, std::size_t effect, const std::optional<Fit>& other = {}) const;
  /// Of the looks at `base` with each of `which` besides, the `most` that fit best, fitted to their end.
  std::vector<Trial> finished_best(const Fit& base, const std::vector<std::size_t>& which,
                                   std::size_t most) const;
  /// `figures` with the first parameter of `effect` so many of its typical changes away from what the rig says, as far as
  /// it is allowed; a decrease that would leave its range is three tenths of one.
  std::vector<effects::Figures> sizes_of(std::size_t effect, const effects::Figures& figures,
                                         std::initializer_list<double> sizes) const;
  /// Which of these errs least at a look, as it stands; none of none.
  std::optional<effects::Figures> least_erring(effects::EffectSet on,
                                               const std::vector<effects::Figures>& figures,
                                               const std::vector<effects::Start>& start) const;
  /// The null, where no other effect is, as far as that has been tried.
  bool wanders_alone() const;
  const Split& split(effects::EffectSet refined) const;

  const Scene& scene_;
  Scene coarse_;  ///< for looks
  Split before_;  ///< the rows held out begin where those fitted end
  Split followed_;
  double noise_Pa_;
  unsigned threads_;
  /// By the set that was enlarged, and what of it was refined.
  std::map<std::pair<effects::EffectSet, effects::EffectSet>, std::vector<Trial>> beside_;
};

}  // namespace plenum::host::diagnose
