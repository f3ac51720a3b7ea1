#include "host-sim/identify/fit.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "host-sim/identify/box_solver.hpp"
#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/excitation.hpp"
#include "host-sim/identify/squares.hpp"
#include "host-sim/identify/ticks.hpp"

namespace plenum::host::identify {
namespace {

constexpr double kLowestNull_V = 2.0, kHighestNull_V = 8.0;
constexpr double kInside_V = 1e-6;        // Table I leaves 2 and 8 V out, and so does a board, in float
constexpr double kFarthest_V = 8.0;       // |u - c1| at most, for 0 <= u <= 10 V and 2 < c1 < 8
constexpr double kLeastOpening_V = 1e-4;  // k at its minimum
constexpr double kMonotone =
    1.0 / (3.0 * kFarthest_V * kFarthest_V);  // c3 >= -c2 kMonotone: s rises everywhere
constexpr double kTolerance = 1e-9;           // of the sum of squares
constexpr double kLookTolerance = 1e-5;       // while only a part of the data is looked at
constexpr double kMostVolumeGain = 1000.0;    // c6 V
constexpr std::size_t kFewestErrors = 50;
constexpr double kRankDeficient = 1e9;
constexpr double kStillVolume = 1e-3;      // std of the volume over its mean
constexpr double kStillRate_per_s = 1e-3;  // RMS of v' over the mean volume [1/s]

using Matrix9 = Eigen::Matrix<double, kFree, kFree>;

/// Depth of the minimum of sqrt(U^2 + c_gamma^2) - c_gamma + c8 U below 0, and its slope by c8.
double tilt_depth_V(double c8, double c_gamma_V) {
  return c_gamma_V * (1.0 - std::sqrt(1.0 - c8 * c8));
}
double tilt_depth_slope(double c8, double c_gamma_V) {
  return c_gamma_V * c8 / std::sqrt(1.0 - c8 * c8);
}

/// asinh(x/unit): x near 0, decades far from it, so that a step means as much at 0.01 as at 100.
double folded(double x, double unit) {
  return std::asinh(x / unit);
}
double unfolded(double z, double unit) {
  return unit * std::sinh(z);
}
double unfolded_slope(double z, double unit) {
  return unit * std::cosh(z);
}

constexpr double kUnit_c2 = 0.3;   // [1/V]
constexpr double kUnit_c3 = 0.3;   // [1/V3]
constexpr double kUnit_c9 = 0.03;  // [V]

/// What the solver sees: nine numbers of order one with plain bounds, in which the joint conditions are
/// bounds too.
///   z = c1, c2~, (c3 + c2/192)~, c4/(c_s/v'), e5 v', d, log e7, c8, (c9 - depth(c8))~
/// where x~ is folded(x), and e5, d, e7 are those of squares.hpp.
struct Coordinates {
  Bench bench;
  double rate_scale_mL_s;  ///< v' [mL/s] of these logs

  double c_s() const { return 0.5 * (bench.supply_kPa - bench.ambient_kPa); }

  Vector9 low() const {
    Vector9 z;
    z << kLowestNull_V + kInside_V, folded(1e-3, kUnit_c2), 0.0, -2.0,
        -10.0 * rate_scale_mL_s / bench.mean_volume_mL, 0.0, std::log(1e-3), -0.99,
        folded(kLeastOpening_V, kUnit_c9);
    return z;
  }
  Vector9 high() const {
    Vector9 z;
    z << kHighestNull_V - kInside_V, folded(50.0, kUnit_c2), folded(500.0, kUnit_c3), 2.0,
        10.0 * rate_scale_mL_s / bench.mean_volume_mL, kMostVolumeGain / (1.0 + kMostVolumeGain),
        std::log(200.0), 0.99, folded(5.0, kUnit_c9);
    return z;
  }
  Shape shape(const Vector9& z) const {
    const double c2 = unfolded(z[1], kUnit_c2);
    Shape q;
    q << z[0], c2, unfolded(z[2], kUnit_c3) - c2 * kMonotone, z[3] * c_s() / rate_scale_mL_s,
        z[4] / rate_scale_mL_s, z[5], std::exp(z[6]), z[7],
        unfolded(z[8], kUnit_c9) + tilt_depth_V(z[7], bench.c_gamma_V);
    return q;
  }
  Matrix9 shape_slope(const Vector9& z) const {
    Matrix9 d = Matrix9::Identity();
    d(1, 1) = unfolded_slope(z[1], kUnit_c2);
    d(2, 1) = -kMonotone * d(1, 1);
    d(2, 2) = unfolded_slope(z[2], kUnit_c3);
    d(3, 3) = c_s() / rate_scale_mL_s;
    d(4, 4) = 1.0 / rate_scale_mL_s;
    d(6, 6) = std::exp(z[6]);
    d(8, 7) = tilt_depth_slope(z[7], bench.c_gamma_V);
    d(8, 8) = unfolded_slope(z[8], kUnit_c9);
    return d;
  }
  Vector9 of(const Tassa9& model) const {
    const Shape q = to_shape(model, bench.mean_volume_mL);
    const double c8 = std::clamp(q[7], -0.99, 0.99);
    Vector9 z;
    z << q[0], folded(q[1], kUnit_c2), folded(q[2] + q[1] * kMonotone, kUnit_c3),
        q[3] * rate_scale_mL_s / c_s(), q[4] * rate_scale_mL_s, q[5], std::log(std::max(q[6], 1e-300)), c8,
        folded(q[8] - tilt_depth_V(c8, bench.c_gamma_V), kUnit_c9);
    return z.cwiseMax(low()).cwiseMin(high());
  }
  /// Gram matrix by z.
  Gram gram_by_z(Error error, const Vector9& z) const {
    Gram slope = Gram::Identity();
    slope.topLeftCorner<kFree, kFree>() = shape_slope(z);
    return slope.transpose() * gram(error, shape(z), bench) * slope;
  }
};

/// Parameters that these logs cannot speak of; they stay at 0.
using Held = std::array<bool, kFree>;

BoxSolution<kFree> minimise(const Coordinates& coordinates, Error error, const Vector9& start,
                            const Held& held, int most_iterations, double tolerance = kTolerance) {
  BoxProblem<kFree> problem;
  problem.squares = [&](const Vector9& z) {
    return sum_of_squares(error, coordinates.shape(z), coordinates.bench);
  };
  problem.gram = [&](const Vector9& z) { return coordinates.gram_by_z(error, z); };
  problem.low = coordinates.low();
  problem.high = coordinates.high();
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(kFree); ++i) {
    if (held[static_cast<std::size_t>(i)]) problem.low[i] = problem.high[i] = start[i];
  }
  return minimise_in_box(problem, start, most_iterations, tolerance);
}

double rms(const std::vector<double>& values) {
  const double square = std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
  return std::sqrt(square / static_cast<double>(values.size()));
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double deviation(const std::vector<double>& values) {
  const double centre = mean(values);
  double square = 0.0;
  for (const double value : values) square += (value - centre) * (value - centre);
  return std::sqrt(square / static_cast<double>(values.size()));
}

/// c4 and c5 need a volume that moves, c6 needs volumes that differ (several logs at rest do); c4 needs a form that has it.
Held held_by(const Ticks& ticks, Form form) {
  const double volume_mL = mean(ticks.volume_mL);
  Held held{};
  held[kC4] = held[4] = !volume_moves(ticks);
  held[5] = deviation(ticks.volume_mL) < kStillVolume * volume_mL;
  if (!has_parameter(form, kC4)) held[kC4] = true;
  return held;
}

Coordinates coordinates_of(const Ticks& ticks, const trace::RigDescription& rig, const FitOptions& options) {
  Coordinates coordinates;
  coordinates.bench.ticks = &ticks;
  coordinates.bench.mean_volume_mL = mean(ticks.volume_mL);
  coordinates.bench.c_gamma_V = options.c_gamma_V;
  coordinates.bench.form = options.form;
  coordinates.bench.supply_kPa = 1e-3 * rig.supply.pressure_Pa;
  coordinates.bench.ambient_kPa = 1e-3 * rig.ambient.pressure_Pa;
  coordinates.bench.stretch =
      static_cast<std::size_t>(std::max(2.0, std::round(options.stretch_s / ticks.period_s)));
  coordinates.rate_scale_mL_s =
      std::max(rms(ticks.volume_rate_mL_s), 1e-9 * coordinates.bench.mean_volume_mL);
  return coordinates;
}

/// Commands on both sides of a valve's null need it in the form. One below 2 V leaves the flank above it, which the form follows.
void require_null_within(const Ticks& ticks, const trace::RigDescription::Valve& valve) {
  const auto [lowest, highest] = std::minmax_element(ticks.command_V.begin(), ticks.command_V.end());
  if (valve.exhaust_below_V <= kHighestNull_V || *lowest >= valve.exhaust_below_V ||
      *highest <= valve.open_above_V) {
    return;
  }
  throw CannotIdentify(fmt::format(
      "the 9-parameter form has its null c1_V within {:g} and {:g} V, the rig's ports open below {:.6g} and "
      "above {:.6g} V: expected the grey-box model for such a valve",
      kLowestNull_V, kHighestNull_V, valve.exhaust_below_V, valve.open_above_V));
}

void require_length(const Bench& bench) {
  const std::size_t rows = count_rows(Error::one_step, bench).rows;
  if (rows < kFewestErrors) {
    throw CannotIdentify(
        fmt::format("too short: {} pressures to predict, expected at least {}", rows, kFewestErrors));
  }
}

/// Null command at the middle of the commands, a smooth kink, a time constant of 0.1 s one volt off, and
/// where the volume moves a rate that is nearly inverse to it.
Tassa9 start_of(const Ticks& ticks, const Coordinates& coordinates, const Held& held) {
  const auto [lowest, highest] = std::minmax_element(ticks.command_V.begin(), ticks.command_V.end());
  const double volume_gain = held[5] ? 0.0 : 10.0;                                           // c6 V
  const double exponent = coordinates.bench.form == Form::repaired && !held[4] ? 1.2 : 0.0;  // c5/c6
  Tassa9 start = to_model(Shape::Zero(), coordinates.bench);
  start.c = {std::clamp(0.5 * (*lowest + *highest), 2.5, 7.5),
             1.0,
             1.0,
             0.0,
             exponent * volume_gain / coordinates.bench.mean_volume_mL,
             volume_gain / coordinates.bench.mean_volume_mL,
             10.0 * (1.0 + volume_gain),
             0.0,
             0.1};
  return start;
}

// Null commands tried, off the middle of the commands, each with every tilt c8: between them lie the minima
// met so far.
constexpr std::array<double, 4> kLooks_V{-1.0, -0.4, 0.4, 1.0};
constexpr std::array<double, 3> kLookTilts{-0.6, 0.0, 0.6};
constexpr std::size_t kLookEvery = 4;
constexpr std::size_t kLeastLook = 1000;  // errors; below, all are looked at
constexpr double kSameMinimum = 1e-3;     // sums of squares nearer than this are one minimum
constexpr int kLookIterations = 60;

/// The least one-step minimum that the given start and the fixed ones lead to: each is followed on a part of
/// the data, the two best on all of it. Two, because two minima may change places between the part and the
/// whole.
BoxSolution<kFree> explore(const Coordinates& coordinates, const Tassa9& given, const Held& held,
                           int most_iterations) {
  const Ticks& ticks = *coordinates.bench.ticks;
  Coordinates part = coordinates;
  part.bench.every =
      count_rows(Error::one_step, coordinates.bench).rows > kLookEvery * kLeastLook ? kLookEvery : 1;
  std::vector<Tassa9> starts{given};
  for (const double off_V : kLooks_V) {
    for (const double tilt : kLookTilts) {
      starts.push_back(start_of(ticks, coordinates, held));
      starts.back().c[0] += off_V;
      starts.back().c[7] = tilt;
      starts.back().c[8] += tilt_depth_V(tilt, coordinates.bench.c_gamma_V);
    }
  }
  std::vector<BoxSolution<kFree>> looks;
  looks.reserve(starts.size());
  for (const Tassa9& start : starts) {
    looks.push_back(
        minimise(part, Error::one_step, coordinates.of(start), held, kLookIterations, kLookTolerance));
  }
  std::sort(looks.begin(), looks.end(),
            [](const BoxSolution<kFree>& a, const BoxSolution<kFree>& b) { return a.squares < b.squares; });
  const BoxSolution<kFree>& first = looks.front();
  const auto other = std::find_if(looks.begin(), looks.end(), [&](const BoxSolution<kFree>& look) {
    return look.squares > first.squares * (1.0 + kSameMinimum);
  });
  BoxSolution<kFree> best = minimise(coordinates, Error::one_step, first.z, held, most_iterations);
  if (other != looks.end()) {
    const BoxSolution<kFree> second = minimise(coordinates, Error::one_step, other->z, held, most_iterations);
    if (second.squares < best.squares) best = second;
  }
  return best;
}

void require_fit_for_the_form(const Ticks& ticks, const trace::RigDescription& rig, const Bench& bench) {
  require_null_within(ticks, rig.valve);
  require_length(bench);
}

BoxSolution<kFree> one_step_minimum(const Coordinates& coordinates, const Held& held,
                                    const FitOptions& options) {
  Tassa9 start = options.start.value_or(start_of(*coordinates.bench.ticks, coordinates, held));
  if (held[kC4]) start.c[kC4] = 0.0;
  if (held[4]) start.c[4] = 0.0;
  if (held[5]) {
    // The rate at the one volume there is stays what it was.
    start.c[6] /= 1.0 + start.c[5] * coordinates.bench.mean_volume_mL;
    start.c[5] = 0.0;
  }
  if (options.explore) return explore(coordinates, start, held, options.most_iterations);
  return minimise(coordinates, Error::one_step, coordinates.of(start), held, options.most_iterations);
}

/// By z: c7/(1 + c6 V) is a logarithm there, so that its error is relative.
void require_rate(const ParameterFit& rate, double variance_of_log) {
  if (rate.at_bound == Bound::low) {
    throw CannotIdentify("these logs show no rate: c7_per_V_s is at its lower bound");
  }
  if (rate.at_bound == Bound::none && !(variance_of_log < 1.0)) {
    throw CannotIdentify(fmt::format(
        "these logs do not tell the rate: the standard error of c7_per_V_s is {:.2g} times its value",
        std::sqrt(variance_of_log)));
  }
}

/// Fills in everything that follows from the minimum: errors, covariance, bounds, condition. Throws CannotIdentify.
void report(const Coordinates& coordinates, Error error, const BoxSolution<kFree>& solution, const Held& held,
            Tassa9Fit& fit) {
  const Bench& bench = coordinates.bench;
  const Shape q = coordinates.shape(solution.z);
  fit.model = to_model(q, bench);
  fit.cost_kPa2 = 0.5 * solution.squares;
  fit.converged = solution.converged;
  fit.stop = solution.stop;
  const Count one_step = count_rows(Error::one_step, bench);
  const Count free_run = count_rows(Error::free_run, bench);
  fit.rows = one_step.rows;
  fit.rms_one_step_kPa =
      std::sqrt(sum_of_squares(Error::one_step, q, bench) / static_cast<double>(one_step.rows));
  fit.rms_free_run_kPa =
      std::sqrt(sum_of_squares(Error::free_run, q, bench) / static_cast<double>(free_run.rows));

  const Vector9 low = coordinates.low();
  const Vector9 high = coordinates.high();
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(kFree); ++i) {
    ParameterFit& parameter = fit.parameters[static_cast<std::size_t>(i)];
    parameter = {};
    parameter.value = fit.model.c[static_cast<std::size_t>(i)];
    parameter.standard_error = std::numeric_limits<double>::quiet_NaN();
    const double near = 1e-6 * (high[i] - low[i]);
    parameter.held = held[static_cast<std::size_t>(i)];
    if (parameter.held) continue;
    if (solution.z[i] <= low[i] + std::min(near, 1e-6)) parameter.at_bound = Bound::low;
    if (solution.z[i] >= high[i] - std::min(near, 1e-6)) parameter.at_bound = Bound::high;
    if (parameter.at_bound == Bound::none) free.push_back(i);
  }

  if (free.empty()) {
    throw CannotIdentify(
        "these logs tell no parameter: every one that is not held is at a bound: expected commands of "
        "several heights that the pressure follows");
  }

  const Gram by_z = coordinates.gram_by_z(error, solution.z);
  const auto n = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd normal(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      normal(i, j) = by_z(free[static_cast<std::size_t>(i)], free[static_cast<std::size_t>(j)]);
    }
  }
  const Eigen::VectorXd scale = normal.diagonal().cwiseSqrt();
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!(scale[i] > 0.0)) {
      throw CannotIdentify(
          fmt::format("rank-deficient: {} has no influence on the pressures of these logs",
                      trace::kTassa9Names[static_cast<std::size_t>(free[static_cast<std::size_t>(i)])]));
    }
  }
  const Eigen::MatrixXd unit = scale.cwiseInverse().asDiagonal() * normal * scale.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(unit);
  const double smallest = std::max(spectrum.eigenvalues()[0], 0.0);
  fit.condition = std::sqrt(spectrum.eigenvalues()[n - 1] / std::max(smallest, 1e-300));
  if (!(smallest * kRankDeficient * 1e3 > spectrum.eigenvalues()[n - 1])) {
    Eigen::Index first = 0, second = 0;
    Eigen::VectorXd weakest = spectrum.eigenvectors().col(0).cwiseAbs();
    weakest.maxCoeff(&first);
    weakest[first] = 0.0;
    weakest.maxCoeff(&second);
    throw CannotIdentify(
        fmt::format("rank-deficient: {} and {} cannot be told apart on these logs",
                    trace::kTassa9Names[static_cast<std::size_t>(free[static_cast<std::size_t>(first)])],
                    trace::kTassa9Names[static_cast<std::size_t>(free[static_cast<std::size_t>(second)])]));
  }

  const Count& count = error == Error::one_step ? one_step : free_run;
  const double freedom =
      static_cast<double>(count.rows) - static_cast<double>(count.eliminated) - static_cast<double>(n);
  const double variance = solution.squares / std::max(freedom, 1.0);
  const Eigen::MatrixXd inverse_unit = unit.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  Matrix9 covariance_z = Matrix9::Zero();
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      covariance_z(free[static_cast<std::size_t>(i)], free[static_cast<std::size_t>(j)]) =
          variance * inverse_unit(i, j) / (scale[i] * scale[j]);
    }
  }
  require_rate(fit.parameters[6], covariance_z(6, 6));
  const Matrix9 slope = model_by_shape(q, bench.mean_volume_mL) * coordinates.shape_slope(solution.z);
  fit.covariance = slope * covariance_z * slope.transpose();
  for (const Eigen::Index i : free) {
    ParameterFit& parameter = fit.parameters[static_cast<std::size_t>(i)];
    parameter.standard_error = std::sqrt(fit.covariance(i, i));
    // In z every number is of order one.
    parameter.identifiable = std::sqrt(covariance_z(i, i)) < 0.25;
  }
}

double share_of_rates_not_positive(const Bench& bench, const Tassa9& model) {
  const Ticks& ticks = *bench.ticks;
  std::size_t count = 0;
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    if (steady_and_rate(model, ticks.command_V[i], ticks.volume_mL[i], ticks.volume_rate_mL_s[i])
            .rate_per_s <= 0.0) {
      ++count;
    }
  }
  return static_cast<double>(count) / static_cast<double>(ticks.size());
}

}  // namespace

bool volume_moves(const Ticks& ticks) {
  return rms(ticks.volume_rate_mL_s) >= kStillRate_per_s * mean(ticks.volume_mL);
}

Tassa9 least_next_tick_error(const Ticks& ticks, const trace::RigDescription& rig,
                             const FitOptions& options) {
  const Coordinates coordinates = coordinates_of(ticks, rig, options);
  require_fit_for_the_form(ticks, rig, coordinates.bench);
  const Held held = held_by(ticks, options.form);
  Tassa9 model =
      to_model(coordinates.shape(one_step_minimum(coordinates, held, options).z), coordinates.bench);
  model.dead_time_s = options.dead_time_s;
  return model;
}

Tassa9Fit fit_tassa9(const std::vector<trace::Log>& logs, const trace::RigDescription& rig,
                     const FitOptions& options) {
  const Ticks ticks = lay_out(logs, options.dead_time_s);
  const Coordinates coordinates = coordinates_of(ticks, rig, options);
  require_fit_for_the_form(ticks, rig, coordinates.bench);
  require_excitation(ticks);
  const Held held = held_by(ticks, options.form);
  BoxSolution<kFree> solution = one_step_minimum(coordinates, held, options);
  Error last = Error::one_step;
  int iterations = solution.iterations;
  if (options.refine_free_run) {
    last = Error::free_run;
    solution = minimise(coordinates, last, solution.z, held, options.most_iterations);
    iterations += solution.iterations;
  }
  Tassa9Fit fit;
  report(coordinates, last, solution, held, fit);
  fit.model.dead_time_s = options.dead_time_s;
  fit.dead_time.value = options.dead_time_s;
  fit.dead_time.standard_error = std::numeric_limits<double>::quiet_NaN();
  fit.dead_time.held = true;
  fit.iterations = iterations;
  fit.rate_not_positive_fraction = share_of_rates_not_positive(coordinates.bench, fit.model);
  return fit;
}

Tassa9 default_start(const std::vector<trace::Log>& logs, const trace::RigDescription& rig) {
  const Ticks ticks = lay_out(logs);
  return start_of(ticks, coordinates_of(ticks, rig, {}), held_by(ticks, Form::published));
}

Tassa9 start_within_bounds(const std::array<double, kFree>& unit, const std::vector<trace::Log>& logs,
                           const trace::RigDescription& rig) {
  const Ticks ticks = lay_out(logs);
  const Coordinates coordinates = coordinates_of(ticks, rig, {});
  const Vector9 low = coordinates.low();
  const Vector9 high = coordinates.high();
  Vector9 z;
  for (Eigen::Index i = 0; i < static_cast<Eigen::Index>(kFree); ++i) {
    const double at = unit[static_cast<std::size_t>(i)];
    z[i] = low[i] + at * (high[i] - low[i]);
  }
  return to_model(coordinates.shape(z), coordinates.bench);
}

trace::ModelFile to_model_file(const Tassa9Fit& fit, std::optional<unsigned> chamber) {
  trace::ModelFile file;
  file.kind = kind_of(fit.model.form);
  file.chamber = chamber;
  const auto image = fit.model.image();
  file.parameters.assign(image.begin(), image.end());
  file.fit["rms_one_step_kPa"] = fit.rms_one_step_kPa;
  file.fit["rms_free_run_kPa"] = fit.rms_free_run_kPa;
  file.fit["rows"] = fit.rows;
  file.fit["iterations"] = fit.iterations;
  file.fit["converged"] = fit.converged;
  file.fit["stop"] = fit.stop;
  file.fit["condition"] = fit.condition;
  file.fit["rate_not_positive_fraction"] = fit.rate_not_positive_fraction;
  const auto add = [&](std::string_view name, const ParameterFit& parameter) {
    nlohmann::ordered_json entry = to_json(parameter);
    entry["held"] = parameter.held;
    entry["identifiable"] = parameter.identifiable;
    file.fit["parameters"][name] = entry;
  };
  for (std::size_t i = 0; i < kFree; ++i) {
    if (has_parameter(fit.model.form, i)) add(trace::kTassa9Names[i], fit.parameters[i]);
  }
  add(trace::kTassa9Names.back(), fit.dead_time);
  return file;
}

}  // namespace plenum::host::identify
