#include "host-sim/plant/relief_valve/two_stage_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant::relief_valve {
namespace {

// RODAS: stage i solves (1/(h gamma) I - J) U_i = f(s + sum a_ij U_j) + sum c_ij U_j / h + h d_i df/dt; the
// last two stages start from the sums that they add to.
constexpr double kGamma = 0.25;
constexpr std::size_t kStages = 6;
constexpr double kA[kStages][kStages] = {
    {},
    {1.544},
    {0.9466785280815826, 0.2557011698983284},
    {3.314825187068521, 2.896124015972201, 0.9986419139977817},
    {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950},
    {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1.0}};
constexpr double kC[kStages][kStages] = {
    {},
    {-5.6688},
    {-2.430093356833875, -0.2063599157091915},
    {-0.1073529058151375, -9.594562251023355, -20.47028614809616},
    {7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160},
    {8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054}};
constexpr double kAlpha[kStages] = {0.0, 0.386, 0.21, 0.63, 1.0, 1.0};
constexpr double kD[kStages] = {0.25, -0.1043, 0.1035, -0.0362, 0.0, 0.0};

constexpr double kCautious = 0.9;
constexpr double kGrowAtMost = 5.0;
constexpr double kShrinkAtMost = 0.2;
constexpr double kShortest_s = 1e-13;
constexpr double kBeyond = 1e-9;   // a margin below -this has been left
constexpr double kReached = 1e-7;  // an event is located when no margin is below -this
constexpr double kNone = std::numeric_limits<double>::max();

// Sizes of quantities, for their error and their margins.
constexpr double kPressure_Pa = 1e5;
constexpr double kPressureRate_Pa_s = 1e8;
constexpr double kSmallTravel = 0.02;
constexpr double kRate_1_s = 500.0;

double force_size_N(const MeteringElement& element) {
  return element.spring_N_m * (element.preload_m + element.travel_m);
}

}  // namespace

TwoStageValve::TwoStageValve(const TwoStageConfig& config, const TwoStageState& start, double tolerance)
    : physics_(config), state_(start), tolerance_(tolerance) {
  require_within("two-stage valve tolerance", tolerance, 1e-12, 0.1);
  require_within("two-stage valve start P1", start[kP1], 0.0, kNone);
  require_within("two-stage valve start P2", start[kP2], 0.0, kNone);
  require_within("two-stage valve start x", start[kX], 0.0, config.main.travel_m);
  require_within("two-stage valve start y", start[kY], 0.0, config.pilot.travel_m);
  const double x = kSmallTravel * config.main.travel_m;
  const double y = kSmallTravel * config.pilot.travel_m;
  floor_ = {kPressure_Pa, kPressure_Pa, x, kRate_1_s * x, y, kRate_1_s * y};
  const auto place = [](double z, double velocity, double travel) {
    if (z <= 0.0 && velocity <= 0.0) return Place::kOnSeat;
    return z >= travel && velocity >= 0.0 ? Place::kAtStop : Place::kMoving;
  };
  main_ = place(start[kX], start[kV], config.main.travel_m);
  pilot_ = place(start[kY], start[kU], config.pilot.travel_m);
  if (main_ != Place::kMoving) state_[kV] = 0.0;
  if (pilot_ != Place::kMoving) state_[kU] = 0.0;
}

bool TwoStageValve::chamber_follows() const {
  return physics_.config().chamber_follows_while_pilot_shut && pilot_ == Place::kOnSeat;
}

TwoStageState TwoStageValve::constrained_rate(const TwoStageState& s, double supply_m3_s) const {
  TwoStageState rate = physics_.rate(s, supply_m3_s);
  if (main_ != Place::kMoving) rate[kX] = rate[kV] = 0.0;
  if (pilot_ != Place::kMoving) rate[kY] = rate[kU] = 0.0;
  if (upstream_empty_) rate[kP1] = 0.0;
  if (chamber_follows()) rate[kP2] = rate[kP1];
  if (chamber_empty_) rate[kP2] = 0.0;
  return rate;
}

TwoStageValve::Trial TwoStageValve::step(const Supply& supply, double h) const {
  const TwoStagePhysics::Slopes j = physics_.slopes(state_);
  const double c = 1.0 / (h * kGamma);
  const double per_c = h * kGamma;
  const bool main_moves = main_ == Place::kMoving;
  const bool pilot_moves = pilot_ == Place::kMoving;
  const bool follows = chamber_follows() && !chamber_empty_;

  // U_v = main_1 U_1 + main_2 U_2 + ..., U_u = pilot_2 U_2 + ...: what an element's rows say once x and y are
  // put in.
  const double per_dv = main_moves ? 1.0 / (c - j.v_v - j.v_x * per_c) : 0.0;
  const double per_du = pilot_moves ? 1.0 / (c - j.u_u - j.u_y * per_c) : 0.0;
  const double main_1 = per_dv * j.v_P1;
  const double main_2 = per_dv * j.v_P2;
  const double pilot_2 = per_du * j.u_P2;
  // The pressure rows: what a velocity adds to each, the displacement that comes with it included.
  const double P1_v = upstream_empty_ ? 0.0 : j.P1_v + j.P1_x * per_c;
  const double P1_P1 = upstream_empty_ ? 0.0 : j.P1_P1;
  const double P1_P2 = upstream_empty_ ? 0.0 : j.P1_P2;
  const double P1_x = upstream_empty_ ? 0.0 : j.P1_x;
  const double P2_v = chamber_empty_ ? 0.0 : (follows ? P1_v : j.P2_v);
  const double P2_u = chamber_empty_ || follows ? 0.0 : j.P2_u + j.P2_y * per_c;
  const double P2_P1 = chamber_empty_ ? 0.0 : (follows ? P1_P1 : j.P2_P1);
  const double P2_P2 = chamber_empty_ ? 0.0 : (follows ? P1_P2 : j.P2_P2);
  const double P2_x = follows ? P1_x : 0.0;
  const double P2_y = chamber_empty_ || follows ? 0.0 : j.P2_y;
  const double a11 = c - P1_P1 - P1_v * main_1;
  const double a12 = -P1_P2 - P1_v * main_2;
  const double a21 = -P2_P1 - P2_v * main_1;
  const double a22 = c - P2_P2 - P2_v * main_2 - P2_u * pilot_2;
  const double per_det = 1.0 / (a11 * a22 - a12 * a21);

  const double by_time = upstream_empty_ ? 0.0 : physics_.upstream_stiffness_Pa_m3() * supply.slope_m3_s2;
  const double chamber_by_time = follows ? by_time : 0.0;

  std::array<TwoStageState, kStages> U{};
  TwoStageState s = state_;
  for (std::size_t i = 0; i < kStages; ++i) {
    if (i > 0) {
      s = state_;
      for (std::size_t k = 0; k < i; ++k) {
        for (std::size_t n = 0; n < 6; ++n) s[n] += kA[i][k] * U[k][n];
      }
    }
    TwoStageState r = constrained_rate(s, supply.flow_m3_s + supply.slope_m3_s2 * kAlpha[i] * h);
    for (std::size_t k = 0; k < i; ++k) {
      const double weight = kC[i][k] / h;
      for (std::size_t n = 0; n < 6; ++n) r[n] += weight * U[k][n];
    }
    r[kP1] += h * kD[i] * by_time;
    r[kP2] += h * kD[i] * chamber_by_time;
    // An element that does not move has no right side: U stays 0 in its rows.
    const double v0 = per_dv * (r[kV] + j.v_x * per_c * r[kX]);
    const double u0 = per_du * (r[kU] + j.u_y * per_c * r[kY]);
    const double b1 = r[kP1] + P1_x * per_c * r[kX] + P1_v * v0;
    const double b2 = r[kP2] + P2_x * per_c * r[kX] + P2_y * per_c * r[kY] + P2_v * v0 + P2_u * u0;
    TwoStageState& x = U[i];
    x[kP1] = per_det * (a22 * b1 - a12 * b2);
    x[kP2] = per_det * (a11 * b2 - a21 * b1);
    x[kV] = v0 + main_1 * x[kP1] + main_2 * x[kP2];
    x[kU] = u0 + pilot_2 * x[kP2];
    x[kX] = main_moves ? per_c * (r[kX] + x[kV]) : 0.0;
    x[kY] = pilot_moves ? per_c * (r[kY] + x[kU]) : 0.0;
  }
  Trial trial{s, 0.0};
  double square = 0.0;
  for (std::size_t n = 0; n < 6; ++n) {
    trial.state[n] += U[kStages - 1][n];
    const double part =
        U[kStages - 1][n] / (std::max(std::abs(state_[n]), std::abs(trial.state[n])) + floor_[n]);
    square += part * part;
  }
  trial.error = std::sqrt(square / 6.0) / tolerance_;
  return trial;
}

// In pairs: toward the seat and toward the stop of spool and pilot; then the two pressures.
TwoStageValve::Margins TwoStageValve::margins(const TwoStageState& s, double supply_m3_s) const {
  Margins m;
  m.fill(kNone);
  const auto element = [](Place place, double z, double travel, double force, double* seat, double* stop) {
    if (place == Place::kMoving) {
      *seat = z / travel;
      *stop = 1.0 - z / travel;
    } else {
      (place == Place::kOnSeat ? *seat : *stop) = place == Place::kOnSeat ? -force : force;
    }
  };
  const TwoStageConfig& config = physics_.config();
  element(main_, s[kX], config.main.travel_m, physics_.main_force_N(s) / force_size_N(config.main), &m[0],
          &m[1]);
  element(pilot_, s[kY], config.pilot.travel_m, physics_.pilot_force_N(s) / force_size_N(config.pilot), &m[2],
          &m[3]);
  const TwoStageState rate = physics_.rate(s, supply_m3_s);
  m[4] = upstream_empty_ ? -rate[kP1] / kPressureRate_Pa_s : s[kP1] / kPressure_Pa;
  m[5] = chamber_empty_ ? -rate[chamber_follows() ? kP1 : kP2] / kPressureRate_Pa_s : s[kP2] / kPressure_Pa;
  return m;
}

void TwoStageValve::change_mode(std::size_t margin) {
  ++effort_.events;
  const auto element = [this, margin](Place& place, std::size_t z, std::size_t velocity, double travel) {
    const bool seat = margin % 2 == 0;
    if (place != Place::kMoving) {
      place = Place::kMoving;
      return;
    }
    place = seat ? Place::kOnSeat : Place::kAtStop;
    state_[z] = seat ? 0.0 : travel;
    state_[velocity] = 0.0;
  };
  if (margin < 2) return element(main_, kX, kV, physics_.config().main.travel_m);
  if (margin < 4) return element(pilot_, kY, kU, physics_.config().pilot.travel_m);
  bool& empty = margin == 4 ? upstream_empty_ : chamber_empty_;
  empty = !empty;
  if (empty) state_[margin == 4 ? kP1 : kP2] = 0.0;
}

void TwoStageValve::settle_modes(double supply_m3_s) {
  // One change may cause another (an element that lands and is pushed off at once), each margin at most
  // twice.
  for (int i = 0; i < 12; ++i) {
    const Margins m = margins(state_, supply_m3_s);
    const auto least = std::min_element(m.begin(), m.end());
    if (*least >= -kBeyond) return;
    change_mode(static_cast<std::size_t>(least - m.begin()));
  }
}

// Shortens h from a step that went `beyond` a margin until it ends within kReached of it.
TwoStageValve::Trial TwoStageValve::locate(const Supply& supply, Trial beyond, double& h) {
  double inside_h = 0.0;
  Margins inside = margins(state_, supply.flow_m3_s);
  double beyond_h = h;
  while (beyond_h - inside_h > kShortest_s) {
    const Margins m = margins(beyond.state, supply.flow_m3_s + supply.slope_m3_s2 * beyond_h);
    // The first of the margins to be left, by the chord of each.
    double share = 1.0;
    double least = 0.0;
    for (std::size_t k = 0; k < m.size(); ++k) {
      if (m[k] >= -kBeyond) continue;
      least = std::min(least, m[k]);
      share = std::min(share, std::max(inside[k], 0.0) / (std::max(inside[k], 0.0) - m[k]));
    }
    if (least >= -kReached) break;
    const double middle_h = inside_h + std::clamp(share, 0.1, 0.9) * (beyond_h - inside_h);
    const Trial middle = step(supply, middle_h);
    ++effort_.located;
    const Margins at = margins(middle.state, supply.flow_m3_s + supply.slope_m3_s2 * middle_h);
    if (*std::min_element(at.begin(), at.end()) < -kBeyond) {
      beyond_h = middle_h;
      beyond = middle;
    } else {
      inside_h = middle_h;
      inside = at;
    }
  }
  h = beyond_h;
  return beyond;
}

void TwoStageValve::advance(double from_m3_s, double to_m3_s, double duration_s, const Watch& watch) {
  require_finite("two-stage valve from_m3_s", from_m3_s);
  require_finite("two-stage valve to_m3_s", to_m3_s);
  require_above("two-stage valve duration_s", duration_s, 0.0);
  const double slope_m3_s2 = (to_m3_s - from_m3_s) / duration_s;
  double done_s = 0.0;
  settle_modes(from_m3_s);
  while (done_s < duration_s) {
    const double left_s = duration_s - done_s;
    // A last step that would be a sliver is taken with the one before it.
    const bool last = next_s_ * 1.01 >= left_s;
    double h = last ? left_s : std::min(next_s_, left_s);
    const Supply supply{from_m3_s + slope_m3_s2 * done_s, slope_m3_s2};
    Trial trial = step(supply, h);
    const double grow = std::clamp(kCautious * std::pow(trial.error, -0.25), kShrinkAtMost, kGrowAtMost);
    if (!(trial.error <= 1.0)) {
      ++effort_.refused;
      next_s_ = h * (std::isfinite(grow) ? std::min(grow, 0.9) : kShrinkAtMost);
      if (next_s_ < kShortest_s)
        throw std::runtime_error("two-stage valve: the step vanishes at " + std::to_string(time_s_) + " s");
      continue;
    }
    const Margins m = margins(trial.state, supply.flow_m3_s + slope_m3_s2 * h);
    const bool event = *std::min_element(m.begin(), m.end()) < -kBeyond;
    if (event) {
      trial = locate(supply, trial, h);
    } else if (!last || grow < 1.0) {
      next_s_ = h * grow;
    } else {
      next_s_ = std::max(next_s_, h * grow);
    }
    state_ = trial.state;
    ++effort_.steps;
    const bool ended = !event && last;
    done_s = ended ? duration_s : done_s + h;
    time_s_ += h;
    if (event) settle_modes(supply.flow_m3_s + slope_m3_s2 * h);
    if (watch) watch(time_s_, state_);
  }
}

}  // namespace plenum::host::plant::relief_valve
