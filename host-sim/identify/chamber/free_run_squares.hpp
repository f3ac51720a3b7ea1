// The sum of squares of free runs as a function of a fit's scaled variables: the figures, then each log's own (the gas at its first
// row, the way of its null). Of fit.cpp alone.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "host-sim/effects/free_run.hpp"
#include "host-sim/identify/box_solver.hpp"
#include "host-sim/identify/chamber/fit.hpp"
#include "host-sim/identify/chamber/rising_areas.hpp"

namespace plenum::host::identify::chamber {

using effects::EffectSet;
using effects::Figures;
using effects::kLanes;
using effects::Start;
inline constexpr int kDynamic = Eigen::Dynamic;
using Vector = identify::BoxVector<kDynamic>;
using Gram = identify::BoxGram<kDynamic>;

inline constexpr double kStartScale_Pa = 10000.0;
/// Of a start pressure: wide, since it also stands in for what the valve did before the first row, as a command that is late.
inline constexpr double kStartRoom_Pa = 250000.0;
inline constexpr double kLeastStart_Pa = 5000.0;
inline constexpr double kDifference =
    1e-4;  // of a scaled variable: its error and that of rounding are both below 1e-4

/// What acts in a record when `on` is looked for.
inline EffectSet acting(const Scene& scene, const Record& record, EffectSet on) {
  return record.before ? scene.known : on | scene.known;
}
/// And with which figures: before the change those of the effects are as configured.
inline Figures acting(const Scene& scene, const Record& record, Figures figures) {
  if (record.before) {
    std::copy(scene.nominal.begin() + effects::kValveFigures, scene.nominal.begin() + effects::kStampedEarly,
              figures.begin() + effects::kValveFigures);
  }
  return figures;
}

/// The readings of `runs` side by side, kLanes a row, over the fitted rows only.
inline std::vector<double> run_lanes(const Scene& scene, const Record& record, EffectSet on,
                                     std::span<const effects::Run> runs) {
  std::vector<double> readings(record.fitted_rows * static_cast<std::size_t>(kLanes));
  effects::free_run(scene.around, record.drive, acting(scene, record, on), runs, readings);
  return readings;
}

/// The sum of squares of the errors of one of them.
inline double lane_squares(const std::vector<double>& readings, const Record& record, std::size_t lane) {
  double sum = 0.0;
  for (std::size_t row = record.settled_rows; row < record.fitted_rows; ++row) {
    if (!record.counts(row)) continue;
    const double e = readings[row * kLanes + lane] - record.measured_Pa[row];
    sum += e * e;
  }
  return sum;
}

/// Whether the gas of a record has a temperature of its own when `on` is looked for.
inline bool has_warmth(const Scene& scene, const Record& record, EffectSet on) {
  return (acting(scene, record, on) >> effects::kIdHeatTransfer & 1U) != 0;
}

/// Warmth of gas at `pressure_Pa` that came there without heat: compressed from ambient pressure at most, or let out by (4)
/// from the supply's.
struct WarmthRange {
  double least_Pa, greatest_Pa;
};
inline WarmthRange warmth_without_heat(const effects::Surroundings& around, double pressure_Pa) {
  const double share = 1.0 - 1.0 / around.gas.kappa;
  const double from_ambient = 1.0 - std::pow(around.ambient_Pa / pressure_Pa, share);
  return {std::min(share * (pressure_Pa - around.supply_Pa), 0.0), std::max(pressure_Pa * from_ambient, 0.0)};
}

inline constexpr double kWanderScale_V = 0.1;
inline constexpr double kMostWander_V = effects::kNullDriftParameters[2].high;

/// Whether the null has a way of its own in a record, the r-th, those from `first` on having one.
inline bool wanders(const Record& record, std::size_t r, std::size_t first) {
  return r >= first && !record.before;
}

/// The sum of squares over the fitted rows as a function of the scaled variables.
class FreeRunSquares {
 public:
  /// The logs from `first_wandering` on have a way of the null of their own.
  FreeRunSquares(const Scene& scene, const std::vector<Record>& records, EffectSet on, const Figures& base,
                 std::vector<Start> start, std::vector<Variable> variables, std::size_t first_wandering,
                 bool rising_areas = false)
      : scene_(scene),
        records_(records),
        on_(on),
        base_(base),
        start_(std::move(start)),
        variables_(std::move(variables)),
        rising_areas_(rising_areas && (on >> effects::kIdAreaShape & 1U) != 0) {
    first_start_.push_back(figures());
    for (std::size_t r = 0; r < records.size(); ++r) {
      gas_.push_back(conducts(scene, records[r], on, variables_) ? 2 : 1);
      first_start_.push_back(first_start_.back() + gas_.back() +
                             (wanders(records[r], r, first_wandering) ? kOfNull : 0));
    }
  }

  Eigen::Index figures() const { return static_cast<Eigen::Index>(variables_.size()); }
  Eigen::Index size() const { return first_start_.back(); }

  Figures figures_at(const Vector& z) const {
    Figures at = base_;
    for (Eigen::Index i = 0; i < figures(); ++i) {
      const Variable& v = variables_[static_cast<std::size_t>(i)];
      at[v.figure] = std::clamp(base_[v.figure] + v.scale * z[i], v.low, v.high);
    }
    return at;
  }
  Start start_at(const Vector& z, std::size_t record) const {
    Start start = start_[record];
    const Eigen::Index first = first_start_[record];
    for (Eigen::Index k = 0; k < start_variables(record); ++k) {
      of_start(start, record, k) += start_scale(record, k) * z[first + k];
    }
    return start;
  }

  Vector low() const {
    Vector z = bounds(&Variable::low, -kStartRoom_Pa, -kMostWander_V);
    for (std::size_t r = 0; r < start_.size(); ++r) {
      double& at = z[first_start_[r]];
      at = std::max(at, std::min(kLeastStart_Pa - start_[r].pressure_Pa, 0.0) / kStartScale_Pa);
      if (gas_[r] > 1) z[first_start_[r] + 1] = warmth_room(r, &WarmthRange::least_Pa);
    }
    return z;
  }
  Vector high() const {
    Vector z = bounds(&Variable::high, kStartRoom_Pa, kMostWander_V);
    for (std::size_t r = 0; r < start_.size(); ++r) {
      if (gas_[r] > 1) z[first_start_[r] + 1] = warmth_room(r, &WarmthRange::greatest_Pa);
    }
    return z;
  }

  double squares(const Vector& z) {
    double sum = 0.0;
    for (std::size_t r = 0; r < records_.size(); ++r)
      sum += lane_squares(first_readings(z, r), records_[r], 0);
    if (rising_areas_) sum += falling_areas_Pa(figures_at(z)).squaredNorm();
    return sum;
  }

  Gram gram(const Vector& z) {
    const Eigen::Index n = size();
    Gram sum = Gram::Zero(n + 1, n + 1);
    for (std::size_t r = 0; r < records_.size(); ++r) {
      const Record& record = records_[r];
      const auto settled = static_cast<Eigen::Index>(record.settled_rows);
      const auto rows = static_cast<Eigen::Index>(record.fitted_rows) - settled;
      Eigen::MatrixXd table(rows, n + 1);
      table.setZero();
      std::vector<double> later;
      for (Eigen::Index first = 0; first < own_variables(r); first += kLanes - 1) {
        const Neighbours beside = neighbours(z, r, first);
        if (first > 0) later = run_lanes(scene_, record, on_, beside.runs);
        const std::vector<double>& readings = first == 0 ? first_readings(z, r) : later;
        for (Eigen::Index row = 0; row < rows; ++row) {
          if (!record.counts(static_cast<std::size_t>(row + settled))) continue;
          const double* at = readings.data() + (row + settled) * kLanes;
          if (first == 0) table(row, n) = at[0] - record.measured_Pa[static_cast<std::size_t>(row + settled)];
          for (std::size_t k = 0; k < beside.columns.size(); ++k) {
            table(row, beside.columns[k]) = (at[k + 1] - at[0]) / beside.steps[k];
          }
        }
      }
      sum.selfadjointView<Eigen::Upper>().rankUpdate(table.transpose());
    }
    if (rising_areas_) add_falling_areas(figures_at(z), sum);
    return sum.selfadjointView<Eigen::Upper>();
  }

 private:
  /// The run at a point, and beside it up to seven that differ from it in one variable each.
  struct Neighbours {
    std::vector<effects::Run> runs;     ///< first that at the point
    std::vector<double> steps;          ///< of the scaled variable, for each of the others
    std::vector<Eigen::Index> columns;  ///< which it is
  };

  /// Those of the variables of record `r` from `first` on: the figures, then its own start.
  Neighbours neighbours(const Vector& z, std::size_t r, Eigen::Index first) const {
    const Figures base = figures_at(z);
    const Start start = start_at(z, r);
    Neighbours beside;
    beside.runs.push_back({acting(scene_, records_[r], base), start});
    const Eigen::Index end = std::min(first + kLanes - 1, own_variables(r));
    for (Eigen::Index k = first; k < end; ++k) {
      effects::Run changed{base, start};
      double step = kDifference;
      Eigen::Index column = k;
      if (k < figures()) {
        const Variable& v = variables_[static_cast<std::size_t>(k)];
        if (base[v.figure] + kDifference * v.scale > v.high)
          step = -kDifference;  // away from the nearer bound
        changed.figures[v.figure] += step * v.scale;
      } else {
        of_start(changed.start, r, k - figures()) += step * start_scale(r, k - figures());
        column = first_start_[r] + k - figures();
      }
      changed.figures = acting(scene_, records_[r], changed.figures);
      beside.runs.push_back(changed);
      beside.steps.push_back(step);
      beside.columns.push_back(column);
    }
    return beside;
  }

  /// The readings of the first neighbours of record `r`, run once a point: eight lanes take the time of one, and a step that
  /// is accepted is followed by its Gram matrix.
  const std::vector<double>& first_readings(const Vector& z, std::size_t r) {
    if (first_at_.size() != z.size() || first_at_ != z) {
      first_at_ = z;
      first_readings_.assign(records_.size(), {});
    }
    std::vector<double>& readings = first_readings_[r];
    if (readings.empty()) readings = run_lanes(scene_, records_[r], on_, neighbours(z, r, 0).runs);
    return readings;
  }

  Eigen::Index start_variables(std::size_t record) const {
    return first_start_[record + 1] - first_start_[record];
  }
  Eigen::Index own_variables(std::size_t record) const { return figures() + start_variables(record); }
  /// Of a log's own variables the k-th: pressure, warmth where it has one, then the null's way.
  double& of_start(Start& start, std::size_t record, Eigen::Index k) const {
    if (k >= gas_[record]) return start.null_V[static_cast<std::size_t>(k - gas_[record])];
    return k == 0 ? start.pressure_Pa : start.warmth_Pa;
  }
  double start_scale(std::size_t record, Eigen::Index k) const {
    return k < gas_[record] ? kStartScale_Pa : kWanderScale_V;
  }
  double warmth_room(std::size_t record, double WarmthRange::*side) const {
    const Start& start = start_[record];
    return (warmth_without_heat(scene_.around, start.pressure_Pa).*side - start.warmth_Pa) / kStartScale_Pa;
  }

  void add_falling_areas(const Figures& base, Gram& sum) const {
    const Eigen::VectorXd errors = falling_areas_Pa(base);
    Eigen::MatrixXd table = Eigen::MatrixXd::Zero(errors.size(), size() + 1);
    table.col(size()) = errors;
    for (Eigen::Index k = 0; k < figures(); ++k) {
      const Variable& v = variables_[static_cast<std::size_t>(k)];
      Figures changed = base;
      changed[v.figure] += kDifference * v.scale;
      table.col(k) = (falling_areas_Pa(changed) - errors) / kDifference;
    }
    sum.selfadjointView<Eigen::Upper>().rankUpdate(table.transpose());
  }

  Vector bounds(double Variable::*side, double pressure_Pa, double null_V) const {
    Vector z(size());
    for (Eigen::Index i = 0; i < figures(); ++i) {
      const Variable& v = variables_[static_cast<std::size_t>(i)];
      z[i] = (v.*side - base_[v.figure]) / v.scale;
    }
    for (std::size_t r = 0; r < start_.size(); ++r) {
      Start start = start_[r];
      for (Eigen::Index k = 0; k < start_variables(r); ++k) {
        z[first_start_[r] + k] =
            k < gas_[r] ? pressure_Pa / kStartScale_Pa : (null_V - of_start(start, r, k)) / kWanderScale_V;
      }
    }
    return z;
  }

  static constexpr auto kOfNull = static_cast<Eigen::Index>(effects::kOwnNull);

  const Scene& scene_;
  const std::vector<Record>& records_;
  EffectSet on_;
  Figures base_;
  std::vector<Start> start_;
  std::vector<Variable> variables_;
  std::vector<Eigen::Index> first_start_;  ///< a record; the last: the number of variables
  std::vector<Eigen::Index> gas_;          ///< a record: pressure, and warmth where it has one
  bool rising_areas_;
  Vector first_at_;
  std::vector<std::vector<double>> first_readings_;  ///< a record, at `first_at_`; empty: not yet run
};

}  // namespace plenum::host::identify::chamber
