#include "host-sim/identify/chamber/fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "host-sim/effects/chamber_effects.hpp"
#include "host-sim/identify/box_solver.hpp"
#include "host-sim/identify/chamber/noise.hpp"
#include "host-sim/identify/chamber/rising_areas.hpp"
#include "host-sim/identify/chamber/valve_figures.hpp"

namespace plenum::host::identify::chamber {
namespace {

using effects::EffectSet;
using effects::Figures;
using effects::kLanes;
using effects::Start;
constexpr int kDynamic = Eigen::Dynamic;
using Vector = identify::BoxVector<kDynamic>;
using Gram = identify::BoxGram<kDynamic>;

constexpr double kStartScale_Pa = 10000.0;
/// Of a start pressure: wide, since it also stands in for what the valve did before the first row, as a command that is late.
constexpr double kStartRoom_Pa = 250000.0;
constexpr double kLeastStart_Pa = 5000.0;
constexpr double kDifference =
    1e-4;  // of a scaled variable: its error and that of rounding are both below 1e-4
constexpr double kForgetting_s = 0.3;
constexpr double kSettling_s = 0.5;       // after that, the rows from which a start is estimated
constexpr double kStartSpread_Pa = 5000;  // of a first reading about the pressure: a tick at 0.5 MPa/s
/// Warmth fades with the gas's time constant, seconds, and shows in the pressure as it fades.
constexpr double kCooling_s = 3.0;
constexpr double kStretch_s = 5.0;            // by which a way of the null is followed further
constexpr double kWarmthSpread_Pa = 20000.0;  // of gas that is a tenth warmer than the wall, at 0.2 MPa

/// What acts in a record when `on` is looked for.
EffectSet acting(const Scene& scene, const Record& record, EffectSet on) {
  return record.before ? scene.known : on | scene.known;
}
/// And with which figures: before the change those of the effects are as configured.
Figures acting(const Scene& scene, const Record& record, Figures figures) {
  if (record.before) {
    std::copy(scene.nominal.begin() + effects::kValveFigures, scene.nominal.end(),
              figures.begin() + effects::kValveFigures);
  }
  return figures;
}

/// The readings of `runs` side by side, kLanes a row, over the fitted rows only.
std::vector<double> run_lanes(const Scene& scene, const Record& record, EffectSet on,
                              std::span<const effects::Run> runs) {
  std::vector<double> readings(record.fitted_rows * static_cast<std::size_t>(kLanes));
  effects::free_run(scene.around, record.drive, acting(scene, record, on), runs, readings);
  return readings;
}

/// The sum of squares of the errors of one of them.
double lane_squares(const std::vector<double>& readings, const Record& record, std::size_t lane) {
  double sum = 0.0;
  for (std::size_t row = record.settled_rows; row < record.fitted_rows; ++row) {
    if (!record.counts(row)) continue;
    const double e = readings[row * kLanes + lane] - record.measured_Pa[row];
    sum += e * e;
  }
  return sum;
}

/// Whether the gas of a record has a temperature of its own when `on` is looked for.
bool has_warmth(const Scene& scene, const Record& record, EffectSet on) {
  return (acting(scene, record, on) >> effects::kIdHeatTransfer & 1U) != 0;
}

/// Warmth of gas at `pressure_Pa` that came there without heat: compressed from ambient pressure at most, or let out by (4)
/// from the supply's.
struct WarmthRange {
  double least_Pa, greatest_Pa;
};
WarmthRange warmth_without_heat(const effects::Surroundings& around, double pressure_Pa) {
  const double share = 1.0 - 1.0 / around.gas.kappa;
  const double from_ambient = 1.0 - std::pow(around.ambient_Pa / pressure_Pa, share);
  return {std::min(share * (pressure_Pa - around.supply_Pa), 0.0), std::max(pressure_Pa * from_ambient, 0.0)};
}

constexpr double kWanderScale_V = 0.1;
constexpr double kMostWander_V = effects::kNullDriftParameters[2].high;

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
      const bool wanders = r >= first_wandering && !records[r].before;
      first_start_.push_back(first_start_.back() + gas_.back() + (wanders ? kOfNull : 0));
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

/// A measured volume without its noise, which compression would turn into pressure noise row by row: least squares of a
/// cubic over 9 rows (Savitzky and Golay 1964), where the noise is above a ten-thousandth. It halves the noise; a swing of
/// 1.5 Hz loses 1e-4 of its amplitude at 100 Hz.
std::vector<double> calmed(const std::vector<double>& volume_m3) {
  constexpr std::ptrdiff_t kHalf = 4;
  constexpr std::array<double, kHalf + 1> kWeights{59.0, 54.0, 39.0, 14.0, -21.0};
  constexpr double kSum = 231.0;
  constexpr double kWorthIt = 1e-4;
  if (white_noise(volume_m3) < kWorthIt * volume_m3.front()) return volume_m3;
  std::vector<double> calm = volume_m3;
  const auto rows = static_cast<std::ptrdiff_t>(volume_m3.size());
  const auto at = [&](std::ptrdiff_t i) {  // beyond an end: mirrored in the end's value
    const auto row = [&](std::ptrdiff_t k) { return volume_m3[static_cast<std::size_t>(k)]; };
    if (i < 0) return 2.0 * row(0) - row(-i);
    if (i >= rows) return 2.0 * row(rows - 1) - row(2 * (rows - 1) - i);
    return row(i);
  };
  for (std::ptrdiff_t i = 0; i < rows; ++i) {
    double sum = kWeights[0] * at(i);
    for (std::ptrdiff_t k = 1; k <= kHalf; ++k) {
      sum += kWeights[static_cast<std::size_t>(k)] * (at(i - k) + at(i + k));
    }
    calm[static_cast<std::size_t>(i)] = sum / kSum;
  }
  return calm;
}

}  // namespace

Record make_record(const std::string& name, const trace::Log& log, double fitted_share) {
  const auto rows = static_cast<double>(log.size());
  return {
      name,
      effects::make_drive(log.command_V, calmed(log.volume_m3),
                          {.tick_s = log.period_s, .average_s = log.pressure_average_s, .steps = 4}),
      log.pressure_Pa,
      std::max<std::size_t>(1, static_cast<std::size_t>(std::min(kForgetting_s / log.period_s, 0.1 * rows))),
      static_cast<std::size_t>(std::lround(rows * fitted_share))};
}

Scene make_scene(const trace::RigDescription& rig) {
  Scene scene;
  scene.around.gas.temperature_K = rig.gas.temperature_K;
  scene.around.supply_Pa = rig.supply.pressure_Pa;
  scene.around.ambient_Pa = rig.ambient.pressure_Pa;
  scene.around.discharge_coefficient = rig.valve.discharge_coefficient;
  const effects::ChamberEffects known = effects::chamber_effects(rig.effects);
  scene.known = known.on;
  scene.nominal = known.figures;
  for (std::size_t i = 0; i < kValveFigures.size(); ++i) {
    scene.nominal[i] = rig.valve.*kValveFigures[i].member;
  }
  const effects::Size size = size_of(scene);
  for (std::size_t i = 0; i < effects::kEffects; ++i) {
    if ((scene.known >> i & 1U) != 0) continue;
    std::size_t at = effects::kFirstFigure[i];
    for (const effects::Parameter& p : effects::kCatalogue[i]->parameters) {
      scene.nominal[at++] = p.of(size).neutral();
    }
  }
  scene.noise_Pa = rig.sensor.pressure_noise_Pa;
  return scene;
}

effects::Size size_of(const Scene& scene) {
  effects::Size size;
  size.valve = 0.5 * (scene.nominal[effects::kInletGain] + scene.nominal[effects::kExhaustGain]) /
               effects::kSizedForGain_m2_V;
  if (!scene.records.empty()) {
    const std::vector<double>& volume_m3 = scene.records.front().drive.volume_m3;
    size.volume = std::accumulate(volume_m3.begin(), volume_m3.end(), 0.0) /
                  static_cast<double>(volume_m3.size()) / effects::kSizedForVolume_m3;
  }
  return size;
}

Figures figures_without(const Scene& scene, Figures figures, std::size_t effect) {
  const std::size_t first = effects::kFirstFigure[effect];
  if (effect == effects::kIdVolumeError) {
    const double logged_mL = size_of(scene).volume * effects::kSizedForVolume_m3 * 1e6;
    const double share = (logged_mL + scene.nominal[first]) / (logged_mL + figures[first]);
    for (const std::size_t area : {effects::kInletGain, effects::kExhaustGain, effects::kInletLeak,
                                   effects::kExhaustLeak, effects::kTransition}) {
      figures[area] *= share;
    }
  }
  for (std::size_t k = first; k < effects::kFirstFigure[effect + 1]; ++k) figures[k] = scene.nominal[k];
  return figures;
}

std::vector<Variable> variables_of(const Scene& scene, EffectSet on, EffectSet refined, Gas gas) {
  const Figures& nominal = scene.nominal;
  const double gain = 0.5 * (nominal[effects::kInletGain] + nominal[effects::kExhaustGain]);
  std::vector<Variable> variables{
      {effects::kOpenAbove, nominal[effects::kOpenAbove] - 1.5, nominal[effects::kOpenAbove] + 1.5, 0.05},
      {effects::kExhaustBelow, nominal[effects::kExhaustBelow] - 1.5, nominal[effects::kExhaustBelow] + 1.5,
       0.05},
      {effects::kInletGain, 0.1 * gain, 10.0 * gain, 0.1 * gain},
      {effects::kExhaustGain, 0.1 * gain, 10.0 * gain, 0.1 * gain},
      {effects::kInletLeak, 0.0, 3.0 * gain, 0.02 * gain},
      {effects::kExhaustLeak, 0.0, 3.0 * gain, 0.02 * gain},
      {effects::kTransition, 1e-4 * gain, 3.0 * gain, 0.05 * gain}};
  const effects::Size size = size_of(scene);
  for (std::size_t i = 0; i < effects::kEffects; ++i) {
    if ((on >> i & 1U) == 0) continue;
    std::size_t at = effects::kFirstFigure[i];
    const bool exponent_alone = i == effects::kIdHeatTransfer && gas == Gas::polytropic;
    for (const effects::Parameter& p : effects::kCatalogue[i]->parameters) {
      if (exponent_alone ? at == kExponent : !p.refines || (refined >> i & 1U) != 0) {
        const effects::Parameter sized = p.of(size);
        variables.push_back({at, sized.least(), sized.greatest(), sized.typical_change});
      }
      ++at;
    }
  }
  return variables;
}

double Fit::rms_Pa() const {
  return std::sqrt(squares / static_cast<double>(rows));
}
double Score::rms_Pa() const {
  return rows == 0 ? 0.0 : std::sqrt(squares / static_cast<double>(rows));
}

bool conducts(const Scene& scene, const Record& record, EffectSet on,
              const std::vector<Variable>& variables) {
  constexpr std::size_t kConductance = effects::kFirstFigure[effects::kIdHeatTransfer];
  return has_warmth(scene, record, on) &&
         (scene.nominal[kConductance] > 0.0 ||
          std::any_of(variables.begin(), variables.end(),
                      [](const Variable& v) { return v.figure == kConductance; }));
}

namespace {
/// The way of the null in the first log is that of the figures; every other has its own, if so many can be fitted.
std::size_t first_wandering(const Scene& scene, EffectSet on, EffectSet refined, std::size_t figures) {
  if ((on & refined & EffectSet{1} << effects::kIdNullDrift) == 0) return kNoneWanders;
  constexpr std::size_t kOfGas = 2;
  const std::size_t most = figures + (kOfGas + effects::kOwnNull) * scene.records.size();
  return most <= identify::kMostVariables ? 1 : kNoneWanders;
}
}  // namespace

Fit fit(const Scene& scene, EffectSet on, const Figures& figures, const std::vector<Start>& start,
        const FitOptions& options) {
  Fit result;
  result.on = on;
  std::vector<Start> begin = start;
  if (begin.empty()) {
    for (const Record& record : scene.records) begin.push_back(estimate_start(scene, record, on, figures));
  }
  for (Start& one : begin) {
    const WarmthRange range = warmth_without_heat(scene.around, one.pressure_Pa);
    one.warmth_Pa = std::clamp(one.warmth_Pa, range.least_Pa, range.greatest_Pa);
  }
  result.refined = options.refined;
  result.variables = variables_of(scene, on, options.refined, options.gas);
  Figures base = figures;
  for (const Variable& v : result.variables) base[v.figure] = std::clamp(base[v.figure], v.low, v.high);
  result.first_wandering = first_wandering(scene, on, options.refined, result.variables.size());
  FreeRunSquares squares(scene, scene.records, on, base, begin, result.variables, result.first_wandering,
                         options.rising_areas);
  identify::BoxProblem<kDynamic> problem;
  problem.squares = [&](const Vector& z) { return squares.squares(z); };
  problem.gram = [&](const Vector& z) { return squares.gram(z); };
  problem.low = squares.low();
  problem.high = squares.high();
  auto solution = identify::minimise_in_box<kDynamic>(problem, Vector::Zero(squares.size()),
                                                      options.most_iterations, options.tolerance);
  result.figures = squares.figures_at(solution.z);
  for (std::size_t r = 0; r < begin.size(); ++r) result.start.push_back(squares.start_at(solution.z, r));
  result.squares = solution.squares;
  for (const Record& record : scene.records) {
    for (std::size_t row = record.settled_rows; row < record.fitted_rows; ++row)
      result.rows += record.counts(row);
    if (conducts(scene, record, on, result.variables)) ++result.warmths;
  }
  result.gram = std::move(solution.gram);
  result.iterations = solution.iterations;
  result.converged = solution.converged;
  result.stop = std::move(solution.stop);
  return result;
}

Eigen::VectorXd standard_errors(const Fit& fit, double correlated_rows) {
  const Eigen::Index n = fit.gram.rows() - 1;
  Eigen::MatrixXd H = fit.gram.topLeftCorner(n, n);
  const double variance = fit.squares / static_cast<double>(fit.rows) * correlated_rows;
  H.diagonal().array() += 1e-9 * H.diagonal().maxCoeff() + 1e-12;
  const Eigen::VectorXd inverse = H.ldlt().solve(Eigen::MatrixXd::Identity(n, n)).diagonal();
  return (inverse.cwiseAbs() * variance).cwiseSqrt();
}

double joint_squares(const Scene& scene, const Fit& fit, const std::vector<Record>& heldout,
                     const std::vector<Start>& held_start, bool same_start) {
  FreeRunSquares held(scene, heldout, fit.on, fit.figures, held_start, fit.variables,
                      same_start ? fit.first_wandering : kNoneWanders);
  const Eigen::Index figures = held.figures();
  const Eigen::Index fitted_starts = fit.gram.rows() - 1 - figures;
  const Eigen::Index held_starts = held.size() - figures;
  const Eigen::Index n = figures + fitted_starts + (same_start ? 0 : held_starts);
  const Eigen::Index first_held_start = same_start ? figures : figures + fitted_starts;
  Eigen::MatrixXd both = Eigen::MatrixXd::Zero(n + 1, n + 1);
  const auto add = [&](const Eigen::MatrixXd& gram, Eigen::Index first_start) {
    std::vector<Eigen::Index> place(static_cast<std::size_t>(gram.rows()), n);
    for (Eigen::Index i = 0; i + 1 < gram.rows(); ++i) {
      place[static_cast<std::size_t>(i)] = i < figures ? i : first_start + i - figures;
    }
    both(place, place) += gram;
  };
  add(fit.gram, figures);
  add(held.gram(Vector::Zero(held.size())), first_held_start);

  Vector low(n), high(n);
  low.setConstant(-1.0);
  high.setConstant(1.0);
  low.head(figures) = low.head(figures).cwiseMax(held.low().head(figures));
  high.head(figures) = high.head(figures).cwiseMin(held.high().head(figures));
  identify::BoxMatrix<kDynamic> H = both.topLeftCorner(n, n);
  H.diagonal().array() += 1e-9 * H.diagonal().maxCoeff() + 1e-12;
  const Vector g = both.topRightCorner(n, 1);
  const Vector d = identify::quadratic_in_box<kDynamic>(H, g, low, high);
  return both(n, n) + 2.0 * g.dot(d) + d.dot(H * d);
}

std::size_t least_error(const Scene& scene, EffectSet on, std::span<const Figures> figures,
                        const std::vector<Start>& start) {
  std::vector<double> squares(figures.size(), 0.0);
  for (std::size_t r = 0; r < scene.records.size(); ++r) {
    const Record& record = scene.records[r];
    std::vector<effects::Run> runs;
    for (const Figures& one : figures) runs.push_back({acting(scene, record, one), start[r]});
    const std::vector<double> readings = run_lanes(scene, record, on, runs);
    for (std::size_t i = 0; i < figures.size(); ++i) squares[i] += lane_squares(readings, record, i);
  }
  for (double& s : squares) {
    if (!std::isfinite(s)) s = std::numeric_limits<double>::infinity();
  }
  return static_cast<std::size_t>(std::min_element(squares.begin(), squares.end()) - squares.begin());
}

std::vector<double> run(const Scene& scene, const Record& record, EffectSet on, const Figures& figures,
                        const Start& start) {
  std::vector<double> lanes(record.rows() * static_cast<std::size_t>(kLanes));
  const effects::Run one{acting(scene, record, figures), start};
  effects::free_run(scene.around, record.drive, acting(scene, record, on), {&one, 1}, lanes);
  std::vector<double> readings(record.rows());
  for (std::size_t row = 0; row < readings.size(); ++row) readings[row] = lanes[row * kLanes];
  return readings;
}

Start estimate_start(const Scene& scene, const Record& record, EffectSet on, const Figures& figures) {
  const bool warm = has_warmth(scene, record, on);
  const double window_s = warm ? kCooling_s : kSettling_s;
  const auto rows =
      std::min(record.rows(),
               record.settled_rows + static_cast<std::size_t>(window_s / record.drive.timing.tick_s) + 2);
  std::vector<double> lanes(rows * static_cast<std::size_t>(kLanes));
  const double first_Pa = record.measured_Pa.front();
  const Figures here = acting(scene, record, figures);
  constexpr double kStep_Pa = 100.0;
  const auto weight = [&](double spread_Pa) { return std::pow(scene.noise_Pa / spread_Pa, 2); };
  const Eigen::Vector2d known(weight(kStartSpread_Pa), weight(kWarmthSpread_Pa));
  Start start{first_Pa};
  for (int pass = 0; pass < 3; ++pass) {
    const std::array<effects::Run, 3> runs{{{here, start},
                                            {here, {start.pressure_Pa + kStep_Pa, start.warmth_Pa}},
                                            {here, {start.pressure_Pa, start.warmth_Pa + kStep_Pa}}}};
    effects::free_run(scene.around, record.drive, acting(scene, record, on), runs, lanes);
    Eigen::Matrix2d H = known.asDiagonal();
    Eigen::Vector2d g = known.cwiseProduct(Eigen::Vector2d(start.pressure_Pa - first_Pa, start.warmth_Pa));
    for (std::size_t row = record.settled_rows; row < rows; ++row) {
      const double* at = lanes.data() + row * kLanes;
      const Eigen::Vector2d slope = Eigen::Vector2d(at[1] - at[0], at[2] - at[0]) / kStep_Pa;
      H += slope * slope.transpose();
      g += slope * (at[0] - record.measured_Pa[row]);
    }
    const Eigen::Vector2d change = H.ldlt().solve(g);
    start.pressure_Pa = std::clamp(start.pressure_Pa - change[0], first_Pa - 0.9 * kStartRoom_Pa,
                                   first_Pa + 0.9 * kStartRoom_Pa);
    start.pressure_Pa = std::max(start.pressure_Pa, kLeastStart_Pa);
    const WarmthRange range = warmth_without_heat(scene.around, start.pressure_Pa);
    start.warmth_Pa = std::clamp(start.warmth_Pa - change[1], range.least_Pa, range.greatest_Pa);
  }
  return start;
}

Start wandering_start(const Scene& scene, const Record& record, const Fit& fit, const Start& start) {
  std::vector<Start> found{start};
  std::vector<Record> one{record};
  const std::size_t rows = record.fitted_rows;
  const auto stretch = static_cast<std::size_t>(kStretch_s / record.drive.timing.tick_s);
  for (std::size_t end = std::min(rows, record.settled_rows + stretch);;
       end = std::min(rows, end + stretch)) {
    one.front().fitted_rows = end;
    FreeRunSquares squares(scene, one, fit.on, fit.figures, found, {}, 0);
    identify::BoxProblem<kDynamic> problem;
    problem.squares = [&](const Vector& z) { return squares.squares(z); };
    problem.gram = [&](const Vector& z) { return squares.gram(z); };
    problem.low = squares.low();
    problem.high = squares.high();
    constexpr int kBrief = 5, kToItsEnd = 30;
    const auto solution = identify::minimise_in_box<kDynamic>(problem, Vector::Zero(squares.size()),
                                                              end < rows ? kBrief : kToItsEnd, 1e-4);
    found = {squares.start_at(solution.z, 0)};
    if (end == rows) return found.front();
  }
}

Score score(const std::vector<double>& reading_Pa, const Record& record, std::size_t first) {
  Score s;
  for (std::size_t row = std::max(first, record.settled_rows); row < record.rows(); ++row) {
    if (!record.counts(row)) continue;
    const double e = reading_Pa[row] - record.measured_Pa[row];
    s.squares += e * e;
    ++s.rows;
  }
  return s;
}

}  // namespace plenum::host::identify::chamber
