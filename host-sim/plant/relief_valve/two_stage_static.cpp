#include "host-sim/plant/relief_valve/two_stage_static.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "host-sim/plant/refuse.hpp"
#include "host-sim/plant/root_between.hpp"

namespace plenum::host::plant::relief_valve {
namespace {

// P2 that balances the pilot at y: its force, all but the pressure's, is linear in P2.
double chamber_Pa(const TwoStagePhysics& physics, double y) {
  const TwoStageState at_0{0.0, 0.0, 0.0, 0.0, y, 0.0};
  TwoStageState at_1 = at_0;
  at_1[kP2] = 1e6;
  const double force_0 = physics.pilot_force_N(at_0);
  const double area_m2 = (physics.pilot_force_N(at_1) - force_0) / 1e6;
  return -force_0 / area_m2;
}

// The state in which spool and pilot stand at x and y; the main spool's balance is left open.
TwoStageState standing(const TwoStagePhysics& physics, double x, double y) {
  TwoStageState s{0.0, chamber_Pa(physics, y), x, 0.0, y, 0.0};
  s[kP1] = s[kP2] + physics.pilot_flow_m3_s(s[kP2], y) / physics.capillary_flow_m3_s(1.0, 0.0);
  return s;
}

TwoStageState balanced(const TwoStagePhysics& physics, double x) {
  const double travel_m = physics.config().pilot.travel_m;
  // The main force rises with y up to where it first gets above 0: found by doubling, then halved.
  double high_m = 1e-9 * travel_m;
  while (high_m < travel_m && physics.main_force_N(standing(physics, x, high_m)) <= 0.0) high_m *= 2.0;
  high_m = std::min(high_m, travel_m);
  const double y =
      root_between([&](double z) { return physics.main_force_N(standing(physics, x, z)); }, 0.0, high_m);
  return standing(physics, x, y);
}

double flow(const TwoStagePhysics& physics, const TwoStageState& s) {
  return physics.main_flow_m3_s(s[kP1], s[kX]) + physics.capillary_flow_m3_s(s[kP1], s[kP2]);
}

}  // namespace

double pilot_cracking_Pa(const TwoStageConfig& config) {
  return config.pilot.spring_N_m * config.pilot.preload_m / config.pilot_area_m2;
}

double least_main_flow_m3_s(const TwoStagePhysics& physics) {
  return flow(physics, balanced(physics, 0.0));
}

TwoStageState two_stage_at_rest(const TwoStagePhysics& physics, double flow_m3_s) {
  const double travel_m = physics.config().main.travel_m;
  const auto missing = [&](double x) { return flow(physics, balanced(physics, x)) - flow_m3_s; };
  require_within("two-stage valve flow_m3_s at rest", flow_m3_s, least_main_flow_m3_s(physics),
                 flow(physics, balanced(physics, travel_m)));
  return balanced(physics, root_between(missing, 0.0, travel_m));
}

std::vector<Mode> modes(const TwoStagePhysics& physics, const TwoStageState& state) {
  const TwoStagePhysics::Slopes j = physics.slopes(state);
  Eigen::Matrix<double, 6, 6> J = Eigen::Matrix<double, 6, 6>::Zero();
  J.row(kP1) << j.P1_P1, j.P1_P2, j.P1_x, j.P1_v, 0.0, 0.0;
  J.row(kP2) << j.P2_P1, j.P2_P2, 0.0, j.P2_v, j.P2_y, j.P2_u;
  J(kX, kV) = 1.0;
  J.row(kV) << j.v_P1, j.v_P2, j.v_x, j.v_v, 0.0, 0.0;
  J(kY, kU) = 1.0;
  J.row(kU) << 0.0, j.u_P2, 0.0, 0.0, j.u_y, j.u_u;
  // Pressures in MPa: eigenvalues are the same, their rounding is smaller.
  for (const int pressure : {kP1, kP2}) {
    J.row(pressure) *= 1e-6;
    J.col(pressure) *= 1e6;
  }
  std::vector<Mode> found;
  for (const std::complex<double>& value : J.eigenvalues()) {
    if (value.imag() >= 0.0) found.push_back({value.real(), value.imag() / (2.0 * std::numbers::pi)});
  }
  std::sort(found.begin(), found.end(),
            [](const Mode& a, const Mode& b) { return a.growth_1_s > b.growth_1_s; });
  return found;
}

}  // namespace plenum::host::plant::relief_valve
