#include "host-sim/plant/servo/cylinder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::plant::servo {
namespace {

constexpr double kFirstSlide_s = 1e-5;  // after letting go: the velocity grows from 0
constexpr double kShortest_s = 1e-13;   // taken whatever its error estimate
constexpr double kSpoolStep_rad = 0.6;  // as in chamber.cpp: the areas have corners that an estimate may miss
constexpr double kCautious = 0.9;
constexpr double kGrowAtMost = 5.0;
constexpr double kShrinkAtMost = 0.2;
constexpr int kBisections = 50;

double sign_of(Motion motion) {
  if (motion == Motion::kForward) return 1.0;
  return motion == Motion::kBackward ? -1.0 : 0.0;
}

// Nodes and weights of Dormand and Prince; the last stage is the end of the step.
constexpr std::array<double, 6> kNode{0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0};
constexpr std::array<std::array<double, 6>, 7> kStage{{
    {},
    {1.0 / 5.0},
    {3.0 / 40.0, 9.0 / 40.0},
    {44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0},
    {19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0},
    {9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0},
    {35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0},
}};
constexpr std::array<double, 7> kError{71.0 / 57600.0,      0.0,          -71.0 / 16695.0, 71.0 / 1920.0,
                                       -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0};
constexpr std::array<double, 7> kDense{-12715105075.0 / 11282082432.0,  0.0,
                                       87487479700.0 / 32700410799.0,   -10690763975.0 / 1880347072.0,
                                       701980252875.0 / 199316789632.0, -1453857185.0 / 822651844.0,
                                       69997945.0 / 29380423.0};

}  // namespace

// One step tried: its end, its error estimate in units of the tolerance, its continuous extension.
struct ServoCylinder::Trial {
  CylinderVector start;
  CylinderVector end;
  CylinderVector bend_1, bend_2, bend_3;
  double error = 0.0;

  // 0 at the start, 1 at the end of the step
  CylinderVector at(double theta) const {
    const double rest = 1.0 - theta;
    return start + theta * (end - start + rest * (bend_1 + theta * (bend_2 + rest * bend_3)));
  }
};

ServoCylinder::ServoCylinder(const ValvePair& valves, const ServoCylinderConfig& config)
    : config_(config), valves_(valves) {
  validate(config_);
  y_ = initial_state(config_);
  const double mass = std::max(y_[kMass1], y_[kMass2]);
  scale_ << config_.stroke_m, 1.0, 1e5, mass, 1e5, mass;
  scale_ *= config_.tolerance;
  force_resolution_N_ = 1e-9 * config_.supply_Pa * config_.piston_area_1_m2;
  if (config_.spool) {
    const Commands rest = five_three_commands_V(config_.initial_command_V);
    spools_ = {Spool(*config_.spool, rest[0]), Spool(*config_.spool, rest[1])};
  }
}

void ServoCylinder::set_external_force_N(double force_N) {
  require_finite("cylinder external_force_N", force_N);
  config_.external_force_N = force_N;
}

double ServoCylinder::temperature_K(int chamber) const {
  const Eigen::Index pressure = chamber == 0 ? kPressure1 : kPressure2;
  return temperature_under_K(config_.law, config_.gas, {y_[pressure], y_[pressure + 1]},
                             volume_of(config_, chamber, y_[kPosition], 0.0).volume_m3);
}

double ServoCylinder::friction_N() const {
  if (motion_ != Motion::kStuck) return sliding_friction_N(config_.friction, sign_of(motion_), y_[kVelocity]);
  const double drive = driving_force_N(config_, y_);
  const double most = config_.friction.breakaway_N();
  const bool carried = (drive > most && y_[kPosition] >= 0.5 * config_.stroke_m) ||
                       (drive < -most && y_[kPosition] <= -0.5 * config_.stroke_m);
  return carried ? 0.0 : drive;
}

void ServoCylinder::advance(const Commands& commands_V, double duration_s) {
  require_finite("cylinder command 1_V", commands_V[0]);
  require_finite("cylinder command 2_V", commands_V[1]);
  require_above("cylinder duration_s", duration_s, 0.0);
  std::visit([&](const auto& pair) { integrate(pair, commands_V, duration_s); }, valves_);
  time_s_ += duration_s;
}

bool ServoCylinder::spool_moves(const Commands& commands_V) const {
  return spools_ && !((*spools_)[0].settled_on(commands_V[0]) && (*spools_)[1].settled_on(commands_V[1]));
}

// The direction in which a stuck piston lets go, 0: none.
double ServoCylinder::release_direction(const CylinderVector& y) const {
  const double drive = driving_force_N(config_, y);
  if (std::abs(drive) <= config_.friction.breakaway_N() + force_resolution_N_) return 0.0;
  const double direction = drive > 0.0 ? 1.0 : -1.0;
  const bool barred = direction * y[kPosition] >= 0.5 * config_.stroke_m;
  return barred ? 0.0 : direction;
}

// Whether `y` is no state of `motion` any more.
bool ServoCylinder::has_left(Motion motion, const CylinderVector& y) const {
  if (motion == Motion::kStuck) return release_direction(y) != 0.0;
  if (config_.friction.breakaway_N() > 0.0) {
    const double s = sign_of(motion);
    return s * y[kVelocity] < 0.0 || s * y[kPosition] > 0.5 * config_.stroke_m;
  }
  return std::abs(y[kPosition]) > 0.5 * config_.stroke_m;
}

void ServoCylinder::let_go(double direction) {
  if (motion_ != Motion::kStuck || direction == 0.0) return;
  motion_ = direction > 0.0 ? Motion::kForward : Motion::kBackward;
  next_step_s_ = std::min(next_step_s_, kFirstSlide_s);
  ++slips_;
}

// At the instant at which the velocity passed 0 or a stop was met.
void ServoCylinder::come_to_rest() {
  const double half = 0.5 * config_.stroke_m;
  if (std::abs(y_[kPosition]) > half * (1.0 - 1e-9)) y_[kPosition] = std::copysign(half, y_[kPosition]);
  y_[kVelocity] = 0.0;
  motion_ = Motion::kStuck;
  ++sticks_;
}

template <class AnyValve>
ServoCylinder::Trial ServoCylinder::attempt(const std::array<AnyValve, 2>& valves, const Commands& commands_V,
                                            double step_s) const {
  const bool moving_spool = spool_moves(commands_V);
  const double direction = sign_of(motion_);
  std::array<typename AnyValve::Opening, 2> openings{valves[0].opening(commands_V[0]),
                                                     valves[1].opening(commands_V[1])};
  const auto rates = [&](double after_s, const CylinderVector& y) {
    if (moving_spool) {
      for (std::size_t j = 0; j < 2; ++j) {
        Spool spool = (*spools_)[j];
        if (after_s > 0.0) spool.advance(commands_V[j], after_s);
        openings[j] = valves[j].opening(spool.effective_V());
      }
    }
    CylinderVector dy;
    gas_rates(config_, valves, openings, y, dy);
    dy[kPosition] = 0.0;
    dy[kVelocity] = 0.0;
    if (motion_ != Motion::kStuck) {
      dy[kPosition] = y[kVelocity];
      dy[kVelocity] =
          (driving_force_N(config_, y) - sliding_friction_N(config_.friction, direction, y[kVelocity])) /
          config_.moving_mass_kg;
    }
    return dy;
  };

  Trial trial;
  trial.start = y_;
  std::array<CylinderVector, 7> k;
  k[0] = rates(0.0, y_);
  CylinderVector y;
  for (std::size_t stage = 1; stage < 7; ++stage) {
    y = y_;
    for (std::size_t i = 0; i < stage; ++i) y += step_s * kStage[stage][i] * k[i];
    // outside the range of the equations: refused by the caller
    if (!(y[kPressure1] > 0.0 && y[kPressure2] > 0.0 && y[kMass1] > 0.0 && y[kMass2] > 0.0 &&
          std::abs(y[kPosition]) < config_.stroke_m)) {
      trial.error = std::numeric_limits<double>::infinity();
      return trial;
    }
    k[stage] = rates(kNode[std::min<std::size_t>(stage, 5)] * step_s, y);
  }
  trial.end = y;
  CylinderVector error = CylinderVector::Zero();
  trial.bend_3 = CylinderVector::Zero();
  for (std::size_t i = 0; i < 7; ++i) {
    error += kError[i] * k[i];
    trial.bend_3 += step_s * kDense[i] * k[i];
  }
  trial.error = step_s * error.cwiseQuotient(scale_).lpNorm<Eigen::Infinity>();
  trial.bend_1 = step_s * k[0] - (trial.end - trial.start);
  trial.bend_2 = (trial.end - trial.start) - step_s * k[6] - trial.bend_1;
  return trial;
}

template <class AnyValve>
void ServoCylinder::integrate(const std::array<AnyValve, 2>& valves, const Commands& commands_V,
                              double duration_s) {
  if (spools_ && !spool_moves(commands_V)) {
    for (std::size_t j = 0; j < 2; ++j) (*spools_)[j].settle(commands_V[j]);
  }
  if (motion_ == Motion::kStuck && config_.friction.breakaway_N() == 0.0 &&
      std::abs(y_[kPosition]) < 0.5 * config_.stroke_m) {
    motion_ = Motion::kForward;  // nothing holds it; the direction has no meaning without dry friction
  }
  double t = 0.0;
  while (t < duration_s) {
    let_go(release_direction(y_));
    double wanted = next_step_s_;
    if (spool_moves(commands_V))
      wanted = std::min(wanted, kSpoolStep_rad / (*spools_)[0].natural_frequency_rad_s());
    const double left = duration_s - t;
    const bool last = wanted >= left * (1.0 - 1e-12);
    double h = last ? left : wanted;
    ++steps_tried_;
    Trial trial = attempt(valves, commands_V, h);
    const bool finite = std::isfinite(trial.error);
    const double grow =
        finite ? std::clamp(kCautious * std::pow(trial.error + 1e-30, -0.2), kShrinkAtMost, kGrowAtMost)
               : kShrinkAtMost;
    if (!finite || (trial.error > 1.0 && h > kShortest_s)) {
      next_step_s_ = h * grow;
      continue;
    }

    // the first of four instants at which the motion has been left, then the instant itself
    double before = 0.0;
    double after = 2.0;
    for (const double theta : {0.25, 0.5, 0.75, 1.0}) {
      if (has_left(motion_, theta < 1.0 ? trial.at(theta) : trial.end)) {
        after = theta;
        break;
      }
      before = theta;
    }
    const bool left_motion = after <= 1.0;
    double released = 0.0;
    if (left_motion) {
      for (int i = 0; i < kBisections; ++i) {
        const double middle = 0.5 * (before + after);
        (has_left(motion_, trial.at(middle)) ? after : before) = middle;
      }
      released = release_direction(after < 1.0 ? trial.at(after) : trial.end);
      if (after < 1.0) {
        h = std::max(h * after, kShortest_s);
        ++steps_tried_;
        trial = attempt(valves, commands_V, h);
      }
    }
    y_ = trial.end;
    t = last && !(left_motion && after < 1.0) ? duration_s : t + h;
    if (spool_moves(commands_V)) {
      for (std::size_t j = 0; j < 2; ++j) (*spools_)[j].advance(commands_V[j], h);
    }
    // a last step cut short says little about the size of the next: it may only raise it
    if (!left_motion) next_step_s_ = last ? std::max(next_step_s_, h * grow) : h * grow;
    // the step done again may end a rounding error short of what the extension saw: it decides
    if (left_motion && motion_ == Motion::kStuck)
      let_go(released);
    else if (left_motion)
      come_to_rest();
  }
}

}  // namespace plenum::host::plant::servo
