#include "host-sim/reproduce/relief_valve/recorded.hpp"

#include <algorithm>
#include <cmath>

#include "host-sim/identify/relief_valve/dynamic_fit.hpp"
#include "host-sim/plant/relief_valve/inch_units.hpp"
#include "host-sim/plant/relief_valve/two_stage_run.hpp"
#include "host-sim/plant/relief_valve/two_stage_static.hpp"

namespace plenum::host::reproduce::relief_valve {

using plant::relief_valve::kLitrePerMinute_m3_s;
using plant::relief_valve::TwoStagePhysics;

const std::vector<FlowChange>& table_v() {
  static const std::vector<FlowChange> rows{
      {"1", 9.3, 89.0, 568.0, 0.28},   {"5", 7.6, 100.3, 1900.0, 0.26}, {"3", 77.1, 94.0, 106.0, 0.28},
      {"4", 65.8, 88.6, 163.0, 0.23},  {"2", 85.6, 107.8, 158.5, 0.23}, {"6", 99.7, 76.0, 297.0, 0.20},
      {"7", 107.8, 84.4, 167.0, 0.23},
  };
  return rows;
}

plant::relief_valve::TwoStageConfig softer_valve() {
  using namespace plant::relief_valve;
  constexpr double kSettling_N_s_m = 1000.0;
  TwoStageConfig config = appendix_a_settling();
  const double area_m2 = 0.2 * kInch2_m2;
  config.main.preload_m *= area_m2 / config.main_area_m2;
  config.main_area_m2 = area_m2;
  config.main_chamber_area_m2 = area_m2;
  config.main.drag_N_s_m = kSettling_N_s_m;
  return config;
}

identify::relief_valve::Transient recorded(const TwoStagePhysics& physics, const FlowChange& change) {
  constexpr double kStep_s = 1e-3;
  constexpr double kBefore_s = 0.02;
  const double ramp_s = std::abs(change.to_l_min - change.from_l_min) / change.rate_l_min_s;
  const auto supply = [&](double t) {
    const double share = std::clamp((t - kBefore_s) / ramp_s, 0.0, 1.0);
    return (change.from_l_min + (change.to_l_min - change.from_l_min) * share) * kLitrePerMinute_m3_s;
  };
  plant::relief_valve::TwoStageValve valve(
      physics.config(), two_stage_at_rest(physics, change.from_l_min * kLitrePerMinute_m3_s));
  identify::relief_valve::Transient record{.step_s = kStep_s};
  const auto keep = [&] {
    record.pressure_Pa.push_back(valve.state()[plant::relief_valve::kP1]);
    record.flow_m3_s.push_back(valve.valve_flow_m3_s());
  };
  keep();
  const int rows = static_cast<int>(std::lround((kBefore_s + change.duration_s) / kStep_s));
  for (int k = 0; k < rows; ++k) {
    valve.advance(supply(kStep_s * k), supply(kStep_s * (k + 1)), kStep_s);
    keep();
  }
  return record;
}

std::vector<identify::relief_valve::StaticPoint> static_points(const TwoStagePhysics& physics,
                                                               double from_l_min, double to_l_min,
                                                               int points) {
  std::vector<identify::relief_valve::StaticPoint> curve;
  for (int i = 0; i < points; ++i) {
    const double flow = (from_l_min + (to_l_min - from_l_min) * i / (points - 1)) * kLitrePerMinute_m3_s;
    curve.push_back({two_stage_at_rest(physics, flow)[plant::relief_valve::kP1], flow});
  }
  return curve;
}

plant::relief_valve::GreyBoxConfig identified_in_two_stages(
    const TwoStagePhysics& physics, const std::vector<identify::relief_valve::StaticPoint>& curve) {
  using namespace identify::relief_valve;
  const double density = physics.config().density_kg_m3;
  const plant::relief_valve::StaticGreyBox line = fit_static(curve, density, FlowForce::kLeftOut);
  const std::vector<Transient> run_1{recorded(physics, table_v().front())};
  return fit_lag(run_1,
                 {.k1_m2_Pa = line.k1_m2_Pa, .k3_m2 = line.k3_m2, .lag_s = 1.0, .density_kg_m3 = density},
                 1e-5, 1.0)
      .valve;
}

double crossing_frequency_Hz(const std::vector<double>& samples, double step_s, double level) {
  std::vector<double> crossings_s;
  for (std::size_t k = 1; k < samples.size(); ++k) {
    const double before = samples[k - 1] - level;
    const double after = samples[k] - level;
    if ((before < 0.0) != (after < 0.0))
      crossings_s.push_back(step_s * (static_cast<double>(k) - after / (after - before)));
  }
  if (crossings_s.size() < 2) return 0.0;
  return 0.5 * static_cast<double>(crossings_s.size() - 1) / (crossings_s.back() - crossings_s.front());
}

}  // namespace plenum::host::reproduce::relief_valve
