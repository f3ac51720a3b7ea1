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
#include "host-sim/identify/chamber/free_run_squares.hpp"
#include "host-sim/identify/chamber/noise.hpp"
#include "host-sim/identify/chamber/valve_figures.hpp"

namespace plenum::host::identify::chamber {
namespace {

constexpr double kForgetting_s = 0.3;
constexpr double kEarlyScale_s = 1e-4;
/// Beside the first it cannot be told how early a pressure is stamped, beside the others by what compresses it alone.
constexpr EffectSet kReadLate = EffectSet{1} << effects::kIdSensorLag;
constexpr EffectSet kActsLate = EffectSet{1} << effects::kIdDeadTime | EffectSet{1} << effects::kIdSpoolLag;
constexpr double kCompresses = 0.25;      ///< swing of a volume
constexpr double kSettling_s = 0.5;       // after that, the rows from which a start is estimated
constexpr double kStartSpread_Pa = 5000;  // of a first reading about the pressure: a tick at 0.5 MPa/s
/// Warmth fades with the gas's time constant, seconds, and shows in the pressure as it fades.
constexpr double kCooling_s = 3.0;
constexpr double kWarmthSpread_Pa = 20000.0;  // of gas that is a tenth warmer than the wall, at 0.2 MPa

/// A measured volume, or supply, without its noise, which compression would turn into pressure noise row by row: least squares of a
/// cubic over 0.08 s (Savitzky and Golay 1964), where the noise is above a ten-thousandth. At 100 Hz, over 9 rows, it halves the noise;
/// a swing of 1.5 Hz loses 1e-4 of its amplitude. Over the three rows of 25 Hz a cubic is what was logged.
std::vector<double> calmed(const std::vector<double>& logged, double tick_s) {
  constexpr double kHalf_s = 0.04;
  constexpr double kWorthIt = 1e-4;
  const auto rows = static_cast<std::ptrdiff_t>(logged.size());
  const auto half = std::min<std::ptrdiff_t>(std::lround(kHalf_s / tick_s), rows / 4);
  if (half < 2 || white_noise(logged) < kWorthIt * logged.front()) return logged;
  const auto m = static_cast<double>(half);
  const double sum_of_weights = (2.0 * m - 1.0) * (2.0 * m + 1.0) * (2.0 * m + 3.0) / 3.0;
  std::vector<double> weights;
  for (std::ptrdiff_t k = 0; k <= half; ++k) {
    weights.push_back((3.0 * m * (m + 1.0) - 1.0 - 5.0 * static_cast<double>(k * k)) / sum_of_weights);
  }
  std::vector<double> calm = logged;
  const auto at = [&](std::ptrdiff_t i) {  // beyond an end: mirrored in the end's value
    const auto row = [&](std::ptrdiff_t k) { return logged[static_cast<std::size_t>(k)]; };
    if (i < 0) return 2.0 * row(0) - row(-i);
    if (i >= rows) return 2.0 * row(rows - 1) - row(2 * (rows - 1) - i);
    return row(i);
  };
  for (std::ptrdiff_t i = 0; i < rows; ++i) {
    double sum = weights[0] * at(i);
    for (std::ptrdiff_t k = 1; k <= half; ++k) {
      sum += weights[static_cast<std::size_t>(k)] * (at(i - k) + at(i + k));
    }
    calm[static_cast<std::size_t>(i)] = sum;
  }
  return calm;
}

/// Pairs of steps of 2.5 ms at most, of which a look takes every other: whatever the rate of a log, the model's own error is that at
/// 100 Hz or less.
int steps_of(double tick_s) {
  constexpr double kPair_s = 5e-3;
  constexpr double kRounding = 1e-6;
  return 2 * std::max(1, static_cast<int>(std::ceil(tick_s / kPair_s - kRounding)));
}

/// Whether the logs tell how early their pressures are stamped when `on` is looked for. Those of the machine as it was tell it whatever
/// that is.
bool tells_stamp(const Scene& scene, EffectSet on) {
  if (scene.most_early_s <= 0.0) return false;
  const bool compresses = std::ranges::any_of(
      scene.records, [](const Record& record) { return volume_swing(record) > kCompresses; });
  const auto told_beside = [&](EffectSet acting) {
    return (acting & kReadLate) == 0 && (compresses || (acting & kActsLate) == 0);
  };
  return told_beside(on | scene.known) ||
         (told_beside(scene.known) &&
          std::ranges::any_of(scene.records, [](const Record& record) { return record.before; }));
}

/// `figures` of logs that are looked at with these effects: stamped early only where they tell it, or it is given.
Figures as_stamped(const Scene& scene, EffectSet on, Figures figures) {
  if (scene.most_early_s > 0.0 && !tells_stamp(scene, on)) figures[effects::kStampedEarly] = 0.0;
  return figures;
}

}  // namespace

Record make_record(const std::string& name, const trace::Log& log, double fitted_share) {
  const auto rows = static_cast<double>(log.size());
  return {
      name,
      effects::make_drive(
          log.command_V, calmed(log.volume_m3, log.period_s),
          {.tick_s = log.period_s, .average_s = log.pressure_average_s, .steps = steps_of(log.period_s)},
          log.supply_Pa.empty() ? log.supply_Pa : calmed(log.supply_Pa, log.period_s)),
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

double volume_swing(const Record& record) {
  const auto [least, most] = std::ranges::minmax(record.drive.volume_m3);
  return (most - least) / least;
}

effects::Size size_of(const Scene& scene) {
  effects::Size size;
  size.valve = 0.5 * (scene.nominal[effects::kInletGain] + scene.nominal[effects::kExhaustGain]) /
               effects::kSizedForGain_m2_V;
  size.volume = scene.around.volume_m3 / effects::kSizedForVolume_m3;
  return size;
}

void add_record(Scene& scene, Record record) {
  if (scene.records.empty()) {
    const std::vector<double>& volume_m3 = record.drive.volume_m3;
    scene.around.volume_m3 =
        std::accumulate(volume_m3.begin(), volume_m3.end(), 0.0) / static_cast<double>(volume_m3.size());
  }
  reach_end_of(scene, record);
  scene.records.push_back(std::move(record));
}

void reach_end_of(Scene& scene, const Record& record) {
  if ((scene.known >> effects::kIdNullDrift & 1U) != 0) return;
  const double length_s = static_cast<double>(record.rows()) * record.drive.timing.tick_s;
  scene.nominal[kKnot] = std::clamp(length_s / effects::kNullKnots, scene.nominal[kKnot],
                                    effects::kNullDriftParameters.back().high);
}

double stretch_s(const Scene& scene) {
  return kStretch_s * scene.nominal[kKnot] / effects::kLeastKnot_s;
}

Figures figures_without(const Scene& scene, Figures figures, std::size_t effect) {
  const std::size_t first = effects::kFirstFigure[effect];
  if (effect == effects::kIdVolumeError) {
    const double logged_mL = 1e6 * scene.around.volume_m3;
    const double share = (logged_mL + scene.nominal[first]) / (logged_mL + figures[first]);
    for (const std::size_t area : {effects::kInletGain, effects::kExhaustGain, effects::kInletLeak,
                                   effects::kExhaustLeak, effects::kTransition}) {
      figures[area] *= share;
    }
  }
  for (std::size_t k = first; k < effects::kFirstFigure[effect + 1]; ++k) figures[k] = scene.nominal[k];
  return figures;
}

bool logs_supply(const Scene& scene) {
  constexpr double kApart = 1e-3;
  const double supply_Pa = scene.around.supply_Pa;
  return std::any_of(scene.records.begin(), scene.records.end(), [&](const Record& record) {
    return std::any_of(record.drive.supply_Pa.begin(), record.drive.supply_Pa.end(), [&](double logged_Pa) {
      return std::abs(logged_Pa - supply_Pa) > kApart * supply_Pa;
    });
  });
}

std::vector<Variable> valve_variables(const Scene& scene) {
  const Figures& nominal = scene.nominal;
  const double gain = 0.5 * (nominal[effects::kInletGain] + nominal[effects::kExhaustGain]);
  return {{effects::kOpenAbove, nominal[effects::kOpenAbove] - 1.5, nominal[effects::kOpenAbove] + 1.5, 0.05},
          {effects::kExhaustBelow, nominal[effects::kExhaustBelow] - 1.5,
           nominal[effects::kExhaustBelow] + 1.5, 0.05},
          {effects::kInletGain, 0.1 * gain, 10.0 * gain, 0.1 * gain},
          {effects::kExhaustGain, 0.1 * gain, 10.0 * gain, 0.1 * gain},
          {effects::kInletLeak, 0.0, 3.0 * gain, 0.02 * gain},
          {effects::kExhaustLeak, 0.0, 3.0 * gain, 0.02 * gain},
          {effects::kTransition, 1e-4 * gain, 3.0 * gain, 0.05 * gain}};
}

std::vector<Variable> variables_of(const Scene& scene, EffectSet on, EffectSet refined, Whose whose) {
  std::vector<Variable> variables = valve_variables(scene);
  const effects::Size size = size_of(scene);
  const bool supply_logged = logs_supply(scene);
  for (std::size_t i = 0; i < effects::kEffects; ++i) {
    if ((on >> i & 1U) == 0) continue;
    std::size_t at = effects::kFirstFigure[i];
    const bool of_board = whose == Whose::board;
    const auto sought = [&](std::size_t figure, bool refines) {
      if (of_board && i == effects::kIdHeatTransfer) return figure == kExponent;
      return !refines || (refined >> i & 1U) != 0 || (of_board && figure == kFollowedSupply);
    };
    for (const effects::Parameter& p : effects::kCatalogue[i]->parameters) {
      const bool can_be_told = at != kKnot && (at != kFollowedSupply || supply_logged);
      if (can_be_told && sought(at, p.refines)) {
        const effects::Parameter sized = p.of(size);
        variables.push_back({at, sized.least(), sized.greatest(), sized.typical_change});
      }
      ++at;
    }
  }
  if (tells_stamp(scene, on))
    variables.push_back({effects::kStampedEarly, 0.0, scene.most_early_s, kEarlyScale_s});
  return variables;
}

double Fit::rms_Pa() const {
  return std::sqrt(squares / static_cast<double>(rows));
}
std::size_t Fit::chosen_variables() const {
  return static_cast<std::size_t>(std::count_if(variables.begin(), variables.end(), [](const Variable& v) {
    return v.figure != effects::kStampedEarly;
  }));
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
constexpr std::size_t kNoneWanders = std::numeric_limits<std::size_t>::max();

/// The way of the null in the first log is that of the figures; every other has its own, if so many can be fitted.
std::size_t first_wandering(const Scene& scene, EffectSet on, EffectSet refined, std::size_t figures) {
  if ((on & refined & EffectSet{1} << effects::kIdNullDrift) == 0) return kNoneWanders;
  constexpr std::size_t kOfGas = 2;
  const std::size_t most = figures + (kOfGas + effects::kOwnNull) * scene.records.size();
  return most <= identify::kMostVariables ? 1 : kNoneWanders;
}

identify::BoxSolution<kDynamic> minimised(FreeRunSquares& squares, int most_iterations, double tolerance) {
  identify::BoxProblem<kDynamic> problem;
  problem.squares = [&](const Vector& z) { return squares.squares(z); };
  problem.gram = [&](const Vector& z) { return squares.gram(z); };
  problem.low = squares.low();
  problem.high = squares.high();
  return identify::minimise_in_box<kDynamic>(problem, Vector::Zero(squares.size()), most_iterations,
                                             tolerance);
}
}  // namespace

Fit fit(const Scene& scene, EffectSet on, const Figures& figures, const std::vector<Start>& start,
        const FitOptions& options) {
  Fit result;
  result.on = on;
  Figures base = as_stamped(scene, on, figures);
  std::vector<Start> begin = start;
  if (begin.empty()) {
    for (const Record& record : scene.records) begin.push_back(estimate_start(scene, record, on, base));
  }
  for (Start& one : begin) {
    const WarmthRange range = warmth_without_heat(scene.around, one.pressure_Pa);
    one.warmth_Pa = std::clamp(one.warmth_Pa, range.least_Pa, range.greatest_Pa);
  }
  result.refined = options.refined;
  result.variables = variables_of(scene, on, options.refined, options.whose);
  for (const Variable& v : result.variables) base[v.figure] = std::clamp(base[v.figure], v.low, v.high);
  const std::size_t wandering = first_wandering(scene, on, options.refined, result.variables.size());
  FreeRunSquares squares(scene, scene.records, on, base, begin, result.variables, wandering,
                         options.rising_areas);
  auto solution = minimised(squares, options.most_iterations, options.tolerance);
  result.figures = squares.figures_at(solution.z);
  for (std::size_t r = 0; r < begin.size(); ++r) result.start.push_back(squares.start_at(solution.z, r));
  result.squares = solution.squares;
  for (std::size_t r = 0; r < scene.records.size(); ++r) {
    const Record& record = scene.records[r];
    for (std::size_t row = record.settled_rows; row < record.fitted_rows; ++row)
      result.rows += record.counts(row);
    if (conducts(scene, record, on, result.variables)) ++result.warmths;
    if (wanders(record, r, wandering)) ++result.nulls;
  }
  result.gram = solution.gram;
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

JointSquares joint_squares(const Scene& scene, const Fit& fit, const std::vector<Record>& heldout,
                           const std::vector<Start>& held_start, bool same_start) {
  FreeRunSquares held(scene, heldout, fit.on, fit.figures, held_start, fit.variables,
                      same_start && fit.nulls > 0 ? 1 : kNoneWanders);
  const Eigen::Index figures = held.figures();
  const Eigen::Index fitted_starts = fit.gram.rows() - 1 - figures;
  const Eigen::Index held_starts = held.size() - figures;
  const Eigen::Index n = figures + fitted_starts + (same_start ? 0 : held_starts);
  const Eigen::Index first_held_start = same_start ? figures : figures + fitted_starts;
  if (n > identify::kMostVariables) {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    return {kNone, kNone};
  }
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
  const auto least = [&](const Eigen::MatrixXd& gram) {
    const Eigen::Index size = gram.rows() - 1;
    identify::BoxMatrix<kDynamic> H = gram.topLeftCorner(size, size);
    H.diagonal().array() += 1e-9 * H.diagonal().maxCoeff() + 1e-12;
    const Vector g = gram.topRightCorner(size, 1);
    const Vector d = identify::quadratic_in_box<kDynamic>(H, g, low.head(size), high.head(size));
    return gram(size, size) + 2.0 * g.dot(d) + d.dot(H * d);
  };
  return {.both = least(both), .fitted = least(fit.gram)};
}

std::size_t least_error(const Scene& scene, EffectSet on, std::span<const Figures> figures,
                        const std::vector<Start>& start) {
  std::vector<double> squares(figures.size(), 0.0);
  for (std::size_t r = 0; r < scene.records.size(); ++r) {
    const Record& record = scene.records[r];
    std::vector<effects::Run> runs;
    for (const Figures& one : figures)
      runs.push_back({acting(scene, record, as_stamped(scene, on, one)), start[r]});
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
  const auto stretch = static_cast<std::size_t>(stretch_s(scene) / record.drive.timing.tick_s);
  for (std::size_t end = std::min(rows, record.settled_rows + stretch);;
       end = std::min(rows, end + stretch)) {
    one.front().fitted_rows = end;
    FreeRunSquares squares(scene, one, fit.on, fit.figures, found, {}, 0);
    constexpr int kBrief = 5, kToItsEnd = 30;
    const auto solution = minimised(squares, end < rows ? kBrief : kToItsEnd, 1e-4);
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

std::vector<double> errors_Pa(const std::vector<double>& reading_Pa, const Record& record, std::size_t first,
                              std::size_t last) {
  std::vector<double> errors;
  for (std::size_t row = std::max(first, record.settled_rows); row < last; ++row) {
    errors.push_back(reading_Pa[row] - record.measured_Pa[row]);
  }
  return errors;
}

std::vector<double> fitted_errors_Pa(const Scene& scene, const Fit& fit) {
  std::vector<double> all;
  for (std::size_t r = 0; r < scene.records.size(); ++r) {
    const Record& record = scene.records[r];
    const std::vector<double> errors =
        errors_Pa(run(scene, record, fit.on, fit.figures, fit.start[r]), record, 0, record.fitted_rows);
    all.insert(all.end(), errors.begin(), errors.end());
  }
  return all;
}

}  // namespace plenum::host::identify::chamber
