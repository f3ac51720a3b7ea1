#include "host-sim/diagnose/trial.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "host-sim/identify/chamber/noise.hpp"

namespace plenum::host::diagnose {
namespace {

using effects::EffectSet;
using identify::chamber::Score;

constexpr double kBetween_s = 1.0;  ///< of the rows held out: so many are followed, so many judge

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

/// Of the rows from `first` on, every other second, or those between.
Record::Half half_of(const Record& record, std::size_t first, bool second) {
  return {first, static_cast<std::size_t>(std::ceil(kBetween_s / record.drive.timing.tick_s)), second};
}

}  // namespace

bool wanders(const Fit& fit) {
  return (fit.on & fit.refined & bit(effects::kIdNullDrift)) != 0;
}

Split split_of(const Scene& scene, const std::vector<HeldOut>& heldout) {
  return {scene, heldout, as_fitted(heldout)};
}

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

double Trial::heldout_Pa() const {
  return std::sqrt(heldout_squares / static_cast<double>(heldout_rows));
}
double Trial::judged_Pa() const {
  return std::sqrt(judged_squares / static_cast<double>(heldout_rows));
}
bool Trial::valid() const {
  return fit.rows > 0 && std::isfinite(fit.squares + heldout_squares + joint_squares);
}
double Trial::joint_mean_square() const {
  return joint_squares / static_cast<double>(fit.rows + heldout_rows);
}
double Trial::evidence(double correlated_rows) const {
  if (!valid()) return -std::numeric_limits<double>::infinity();
  const double pieces = std::clamp(static_cast<double>(rows) / correlated_rows, kLeastPieces, kMostPieces);
  return -0.5 * pieces * std::log(joint_mean_square()) -
         0.5 * static_cast<double>(variables) * std::log(pieces);
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
    trial.rows +=
        held.continues >= 0 ? s.rows : held.record.rows() - std::max(held.first, held.record.settled_rows);
  }
  trial.rows += fit.rows;
  const identify::chamber::JointSquares joint =
      joint_squares(scene, fit, rows.heldout_as_fitted, start, rows.heldout.front().continues >= 0);
  trial.joint_squares = joint.both;
  trial.judged_squares = joint.judged();
  trial.variables = fit.chosen_variables() + fit.warmths + fit.nulls * effects::kOwnNull;
  for (const HeldOut& held : rows.heldout) {
    if (held.continues >= 0) continue;
    if (conducts(scene, held.record, fit.on, fit.variables)) ++trial.variables;
    if (wanders(fit)) trial.variables += effects::kOwnNull;
  }
  trial.fit = std::move(fit);
  return trial;
}

Trial recalibrated(const Scene& scene, const std::vector<HeldOut>& heldout) {
  return tried(split_of(scene, heldout), fit(scene, 0, scene.nominal, {}, {.most_iterations = 100}));
}

double correlation(const Scene& scene, const Trial& trial) {
  double worst = 1.0;
  for (std::size_t i = 0; i < scene.records.size(); ++i) {
    const Record& record = scene.records[i];
    const std::vector<double> reading = run(scene, record, trial.on, trial.fit.figures, trial.fit.start[i]);
    worst = std::max(worst,
                     identify::chamber::correlation_rows(errors_Pa(reading, record, 0, record.fitted_rows)));
  }
  return worst;
}

bool worth_entering(const Trial& with, const Trial& base, double correlated_rows, double noise_Pa) {
  return with.valid() && with.evidence(correlated_rows) - base.evidence(correlated_rows) > kWorthEntering &&
         with.joint_squares < (1.0 - kLeastShare) * base.joint_squares &&
         (std::pow(with.heldout_Pa(), 2) < (1.0 - kLeastShare) * std::pow(base.heldout_Pa(), 2) ||
          share_of_rest(with.judged_Pa(), base.judged_Pa(), noise_Pa) > kMostOfRest);
}

double share_of_rest(double with_Pa, double without_Pa, double noise_Pa) {
  const double rest = without_Pa * without_Pa - noise_Pa * noise_Pa;
  return rest > 0.0 ? std::clamp((without_Pa * without_Pa - with_Pa * with_Pa) / rest, 0.0, 1.0) : 0.0;
}

double share_of_rest(const Trial& with, const Trial& without, double noise_Pa) {
  return std::max(share_of_rest(with.heldout_Pa(), without.heldout_Pa(), noise_Pa),
                  share_of_rest(with.judged_Pa(), without.judged_Pa(), noise_Pa));
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

std::vector<std::size_t> members(EffectSet on) {
  std::vector<std::size_t> in;
  for (std::size_t i = 0; i < effects::kEffects; ++i) {
    if ((on >> i & 1U) != 0) in.push_back(i);
  }
  return in;
}

}  // namespace plenum::host::diagnose
