// greybox.speed_vs_classical: time to simulate a relief valve by the classical two-stage model over that by
// the grey-box model identified on it.
//
// Both simulate the seven changes of flow of Table V of "Grey-Box Multi-Port Models of Fluid Power Valves"
// for the times printed, 1.71 s in all: the classical model as the supply's flow into its upstream volume,
// the grey-box model as the flow through the valve. Each runs at the coarsest setting of a ladder at which
// the pressure at the ends of its steps is within 5 % of that change's swing from its own exact solution. On
// the classical side that is the stiff method of the plant (RODAS, exact Jacobian, 2 x 2 a stage).
//
// The target of 500 is missed, and that is no fault of the grey-box model: the source's factor holds against
// a classical model advanced in fixed steps of 1e-6 s. With a stiff method the sixth-order model takes some
// 10 to 30 steps a change; 500 times less would be a grey-box run in the time of one division. As the source
// ran them (classical: Runge-Kutta in steps of 1e-6 s; grey box: steps of 0.01 s), the factor is the second
// row.
// Tried for the classical side and slower: BDF of CVODE 6.4 with dense exact Jacobian, 220 us for the first
// change at 3 % of its swing (RODAS: 3 us).
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <vector>

#include "host-sim/plant/relief_valve/grey_box.hpp"
#include "host-sim/plant/relief_valve/inch_units.hpp"
#include "host-sim/plant/relief_valve/two_stage_run.hpp"
#include "host-sim/plant/relief_valve/two_stage_static.hpp"
#include "host-sim/reproduce/relief_valve/recorded.hpp"
#include "tests/bench/row.hpp"

namespace {

using namespace plenum::host::plant::relief_valve;
namespace paper = plenum::host::reproduce::relief_valve;

constexpr double kShareOfSwing = 0.05;
constexpr double kTransientError = 0.15;
constexpr double kSourceStep_s = 1e-6;
constexpr double kSourceGreyStep_s = 0.01;

struct Change {
  double from_m3_s, to_m3_s, ramp_s, duration_s;

  double flow(double t) const { return from_m3_s + (to_m3_s - from_m3_s) * std::min(t / ramp_s, 1.0); }
  double rest_s() const { return duration_s - ramp_s; }
};

std::vector<Change> changes() {
  std::vector<Change> all;
  for (const paper::FlowChange& row : paper::table_v())
    all.push_back({row.from_l_min * kLitrePerMinute_m3_s, row.to_l_min * kLitrePerMinute_m3_s,
                   std::abs(row.to_l_min - row.from_l_min) / row.rate_l_min_s, row.duration_s});
  return all;
}

/// A pressure at a time.
struct Point {
  double time_s, pressure_Pa;
};
using Run = std::vector<Point>;

double swing_Pa(const Run& run) {
  const auto [least, most] = std::minmax_element(
      run.begin(), run.end(), [](const Point& a, const Point& b) { return a.pressure_Pa < b.pressure_Pa; });
  return most->pressure_Pa - least->pressure_Pa;
}

double pressure_at(const Run& exact, double time_s) {
  const auto after = std::lower_bound(exact.begin() + 1, exact.end() - 1, time_s,
                                      [](const Point& point, double t) { return point.time_s < t; });
  const auto before = after - 1;
  const double share = (time_s - before->time_s) / (after->time_s - before->time_s);
  return before->pressure_Pa + share * (after->pressure_Pa - before->pressure_Pa);
}

bool close_enough(const Run& run, const Run& exact) {
  const double allowed_Pa = kShareOfSwing * swing_Pa(exact);
  return std::all_of(run.begin(), run.end(), [&](const Point& point) {
    return std::abs(point.pressure_Pa - pressure_at(exact, point.time_s)) <= allowed_Pa;
  });
}

/// Keeps the compiler from leaving a run out.
volatile double sink = 0.0;

/// Least time of a call over several rounds [s].
template <typename Function>
double seconds(const Function& run, int calls) {
  double least_s = std::numeric_limits<double>::max();
  for (int round = 0; round < 7; ++round) {
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < calls; ++i) run();
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    least_s = std::min(least_s, took.count() / calls);
  }
  return least_s;
}

// ---- the classical model

double classical(const TwoStageValve& at_rest, const Change& change, Run* keep) {
  TwoStageValve valve = at_rest;
  TwoStageValve::Watch watch;
  if (keep != nullptr) watch = [keep](double t, const TwoStageState& s) { keep->push_back({t, s[kP1]}); };
  valve.advance(change.from_m3_s, change.to_m3_s, change.ramp_s, watch);
  valve.advance(change.to_m3_s, change.to_m3_s, change.rest_s(), watch);
  return valve.state()[kP1];
}

/// As the source: equal steps, constraints put on the states after each.
double classical_fixed_step(const TwoStagePhysics& physics, const TwoStageState& start,
                            const Change& change) {
  const auto along = [](const TwoStageState& s, const TwoStageState& rate, double h) {
    TwoStageState moved = s;
    for (std::size_t n = 0; n < s.size(); ++n) moved[n] += h * rate[n];
    return moved;
  };
  const auto hold = [](double& z, double& velocity, double travel) {
    if (z < 0.0 || z > travel) {
      z = std::clamp(z, 0.0, travel);
      velocity = 0.0;
    }
  };
  TwoStageState s = start;
  const int steps = static_cast<int>(std::lround(change.duration_s / kSourceStep_s));
  for (int i = 0; i < steps; ++i) {
    const double t = kSourceStep_s * i;
    const double middle = change.flow(t + 0.5 * kSourceStep_s);
    const TwoStageState k1 = physics.rate(s, change.flow(t));
    const TwoStageState k2 = physics.rate(along(s, k1, 0.5 * kSourceStep_s), middle);
    const TwoStageState k3 = physics.rate(along(s, k2, 0.5 * kSourceStep_s), middle);
    const TwoStageState k4 = physics.rate(along(s, k3, kSourceStep_s), change.flow(t + kSourceStep_s));
    for (std::size_t n = 0; n < s.size(); ++n)
      s[n] += kSourceStep_s / 6.0 * (k1[n] + 2.0 * (k2[n] + k3[n]) + k4[n]);
    hold(s[kX], s[kV], physics.config().main.travel_m);
    hold(s[kY], s[kU], physics.config().pilot.travel_m);
    s[kP1] = std::max(s[kP1], 0.0);
    s[kP2] = std::max(s[kP2], 0.0);
  }
  return s[kP1];
}

// ---- the grey-box model

/// Equal steps on the ramp and after it.
struct Steps {
  int ramp, rest;
};

double grey(const GreyBoxValve& at_rest, const Change& change, const Steps& steps, Run* keep) {
  GreyBoxValve valve = at_rest;
  const auto segment = [&](double from_m3_s, double to_m3_s, double duration_s, int count, double start_s) {
    const double h = duration_s / count;
    double flow = from_m3_s;
    for (int i = 1; i <= count; ++i) {
      const double next = from_m3_s + (to_m3_s - from_m3_s) * i / count;
      valve.drive_flow(flow, next, h);
      flow = next;
      if (keep != nullptr) keep->push_back({start_s + h * i, valve.pressure_Pa(flow)});
    }
  };
  segment(change.from_m3_s, change.to_m3_s, change.ramp_s, steps.ramp, 0.0);
  segment(change.to_m3_s, change.to_m3_s, change.rest_s(), steps.rest, change.ramp_s);
  return valve.pressure_Pa(change.to_m3_s);
}

/// The fewest steps, doubled from one each until the run is close enough to the model's own exact solution;
/// it must then be within the source's 15 % of the classical valve too.
Steps fewest(const GreyBoxValve& at_rest, const Change& change, const Run& valve) {
  Run exact;
  grey(at_rest, change, {4096, 4096}, &exact);
  for (Steps steps{1, 1}; steps.ramp <= 1024;) {
    Run run;
    grey(at_rest, change, steps, &run);
    if (close_enough(run, exact)) {
      for (const Point& point : run) {
        const double true_Pa = pressure_at(valve, point.time_s);
        if (std::abs(point.pressure_Pa - true_Pa) > kTransientError * true_Pa)
          throw std::runtime_error("greybox: the model is not within 15 % of the valve");
      }
      return steps;
    }
    // The longer steps are halved first.
    (change.ramp_s / steps.ramp >= change.rest_s() / steps.rest ? steps.ramp : steps.rest) *= 2;
  }
  throw std::runtime_error("greybox: no setting of the ladder is accurate enough");
}

double coarsest(const TwoStagePhysics& physics, const TwoStageState& start, const Change& change,
                const Run& exact) {
  for (const double tolerance : {0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 5e-4, 2e-4, 1e-4, 1e-5}) {
    Run run;
    classical(TwoStageValve(physics.config(), start, tolerance), change, &run);
    if (close_enough(run, exact)) return tolerance;
  }
  throw std::runtime_error("greybox: no tolerance of the ladder is accurate enough");
}

}  // namespace

int main() {
  const TwoStagePhysics physics(appendix_a_settling());
  const std::vector<Change> all = changes();
  const GreyBoxConfig valve =
      paper::identified_in_two_stages(physics, paper::static_points(physics, 10.0, 110.0, 21));
  const StaticGreyBox line{valve.k1_m2_Pa, 0.0, valve.k3_m2, valve.density_kg_m3};
  double classical_s = 0.0;
  double grey_s = 0.0;
  double fixed_s = 0.0;
  double grey_fixed_s = 0.0;
  for (const Change& change : all) {
    const TwoStageState start = two_stage_at_rest(physics, change.from_m3_s);
    Run exact;
    classical(TwoStageValve(physics.config(), start, 1e-11), change, &exact);
    const double tolerance = coarsest(physics, start, change, exact);
    const TwoStageValve at_rest(physics.config(), start, tolerance);
    const GreyBoxValve grey_at_rest(valve, pressure_Pa(line, change.from_m3_s));
    const Steps steps = fewest(grey_at_rest, change, exact);
    const Steps source_steps{std::max(1, static_cast<int>(std::lround(change.ramp_s / kSourceGreyStep_s))),
                             static_cast<int>(std::lround(change.rest_s() / kSourceGreyStep_s))};
    const double c = seconds([&] { sink = classical(at_rest, change, nullptr); }, 300);
    const double g = seconds([&] { sink = grey(grey_at_rest, change, steps, nullptr); }, 3000);
    classical_s += c;
    grey_s += g;
    fixed_s += seconds([&] { sink = classical_fixed_step(physics, start, change); }, 1);
    grey_fixed_s += seconds([&] { sink = grey(grey_at_rest, change, source_steps, nullptr); }, 300);
    TwoStageValve counted = at_rest;
    counted.advance(change.from_m3_s, change.to_m3_s, change.ramp_s);
    counted.advance(change.to_m3_s, change.to_m3_s, change.rest_s());
    std::fprintf(stderr,
                 "%5.1f to %5.1f l/min: classical %5.2f us (tolerance %g, %ld steps), grey box %.3f us (%d + "
                 "%d steps)\n",
                 change.from_m3_s / kLitrePerMinute_m3_s, change.to_m3_s / kLitrePerMinute_m3_s, 1e6 * c,
                 tolerance, counted.effort().steps, 1e6 * g, steps.ramp, steps.rest);
  }
  plenum::bench::print({"greybox.speed_vs_classical", classical_s / grey_s, "x", "higher", 500.0,
                        "classical model by RODAS at its coarsest, us for the seven changes",
                        1e6 * classical_s});
  plenum::bench::print({"greybox.speed_vs_classical_fixed_step",
                        fixed_s / grey_fixed_s,
                        "x",
                        "higher",
                        {},
                        "classical model by Runge-Kutta in steps of 1e-6 s, us for the seven changes",
                        1e6 * fixed_s});
  return 0;
}
