#include "host-sim/plant/relief_valve/two_stage.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "host-sim/plant/refuse.hpp"
#include "host-sim/plant/relief_valve/inch_units.hpp"

namespace plenum::host::plant::relief_valve {
namespace {

using std::numbers::pi;

constexpr double kChordBelow_Pa = 1.0;
constexpr double kAny = std::numeric_limits<double>::max();

void validate(const std::string& name, const MeteringElement& element) {
  require_above(name + " seat_diameter_m", element.seat_diameter_m, 0.0);
  require_within(name + " semi_apical_angle_rad", element.semi_apical_angle_rad, 1e-3, pi / 2.0);
  require_above(name + " discharge_coefficient", element.discharge_coefficient, 0.0);
  require_above(name + " mass_kg", element.mass_kg, 0.0);
  require_above(name + " spring_N_m", element.spring_N_m, 0.0);
  require_within(name + " preload_m", element.preload_m, 0.0, kAny);
  require_above(name + " travel_m", element.travel_m, 0.0);
  require_within(name + " damping_length_m", element.damping_length_m, 0.0, kAny);
  require_within(name + " drag_N_s_m", element.drag_N_s_m, 0.0, kAny);
}

TwoStageConfig checked(const TwoStageConfig& config) {
  validate(config);
  return config;
}

}  // namespace

void validate(const TwoStageConfig& config) {
  validate("two-stage valve main", config.main);
  validate("two-stage valve pilot", config.pilot);
  require_above("two-stage valve main_area_m2", config.main_area_m2, 0.0);
  require_above("two-stage valve main_chamber_area_m2", config.main_chamber_area_m2, 0.0);
  require_above("two-stage valve pilot_area_m2", config.pilot_area_m2, 0.0);
  require_above("two-stage valve capillary_diameter_m", config.capillary_diameter_m, 0.0);
  require_above("two-stage valve capillary_length_m", config.capillary_length_m, 0.0);
  require_above("two-stage valve upstream_volume_m3", config.upstream_volume_m3, 0.0);
  require_above("two-stage valve chamber_volume_m3", config.chamber_volume_m3, 0.0);
  require_above("two-stage valve bulk_modulus_Pa", config.bulk_modulus_Pa, 0.0);
  require_above("two-stage valve density_kg_m3", config.density_kg_m3, 0.0);
  require_above("two-stage valve kinematic_viscosity_m2_s", config.kinematic_viscosity_m2_s, 0.0);
  require_within("two-stage valve flow_force_factor", config.flow_force_factor, 0.0, kAny);
}

TwoStageConfig appendix_a_as_printed() {
  constexpr double kDegree_rad = pi / 180.0;
  constexpr double kSpring_N_m = 100.0 * kPoundForce_N / kInch_m;
  constexpr double kClearance_m = 0.004 * kInch_m;
  TwoStageConfig config;
  config.density_kg_m3 = 60.0 * kPoundPerFoot3_kg_m3;
  config.kinematic_viscosity_m2_s = 10e-6;
  const double viscosity_Pa_s = config.kinematic_viscosity_m2_s * config.density_kg_m3;
  const double peripheral_m2 = pi * 1.5 * 1.0 * kInch2_m2;
  config.main = {.seat_diameter_m = 0.5 * kInch_m,
                 .semi_apical_angle_rad = 67.0 * kDegree_rad,
                 .discharge_coefficient = 0.8,
                 .mass_kg = 0.5 * kPound_kg,
                 .spring_N_m = kSpring_N_m,
                 .preload_m = 1.0 * kInch_m,
                 .travel_m = 0.25 * kInch_m,
                 .damping_length_m = 1.0 * kInch_m,
                 .drag_N_s_m = viscosity_Pa_s * peripheral_m2 / kClearance_m};
  config.pilot = {.seat_diameter_m = 0.2 * kInch_m,
                  .semi_apical_angle_rad = 17.0 * kDegree_rad,
                  .discharge_coefficient = 0.75,
                  .mass_kg = 0.1 * kPound_kg,
                  .spring_N_m = kSpring_N_m,
                  .preload_m = 0.2 * kInch_m,
                  .travel_m = 0.12 * kInch_m,
                  .damping_length_m = 0.1 * kInch_m,
                  .drag_N_s_m = 0.0};
  config.main_area_m2 = 1.436 * kInch2_m2;
  config.main_chamber_area_m2 = 1.436 * kInch2_m2;
  config.pilot_area_m2 = pi / 4.0 * 0.2 * 0.2 * kInch2_m2;
  config.capillary_diameter_m = 0.01 * kInch_m;
  config.capillary_length_m = 0.45 * kInch_m;
  config.upstream_volume_m3 = 250.0 * kInch3_m3;
  config.chamber_volume_m3 = 1.0 * kInch3_m3;
  config.bulk_modulus_Pa = 2.0e5 * kPsi_Pa;
  return config;
}

TwoStageConfig appendix_a_settling() {
  TwoStageConfig config = appendix_a_as_printed();
  config.pilot_area_m2 = 0.020 * kInch2_m2;
  config.pilot.drag_N_s_m = 0.02 * kPoundForce_N / kInch_m;
  config.capillary_diameter_m = 0.04 * kInch_m;
  return config;
}

TwoStagePhysics::Element::Element(const MeteringElement& element, const TwoStageConfig& config) {
  const double sine = std::sin(element.semi_apical_angle_rad);
  const double rim = element.discharge_coefficient * pi * element.seat_diameter_m;
  flow = rim * sine * std::sqrt(2.0 / config.density_kg_m3);
  linear = config.flow_force_factor * rim * 0.5 * std::sin(2.0 * element.semi_apical_angle_rad);
  quadratic = config.flow_force_factor * rim * 4.0 * element.discharge_coefficient * sine * sine /
              element.seat_diameter_m;
  drag = element.drag_N_s_m;
  unsteady = element.damping_length_m * rim * sine * std::sqrt(2.0 * config.density_kg_m3);
  spring = element.spring_N_m;
  preload_N = element.spring_N_m * element.preload_m;
  inverse_mass = 1.0 / element.mass_kg;
}

TwoStagePhysics::TwoStagePhysics(const TwoStageConfig& config)
    : config_(checked(config)),
      main_(config.main, config),
      pilot_(config.pilot, config),
      capillary_(
          pi * std::pow(config.capillary_diameter_m, 4) /
          (128.0 * config.kinematic_viscosity_m2_s * config.density_kg_m3 * config.capillary_length_m)),
      upstream_(config.bulk_modulus_Pa / config.upstream_volume_m3),
      chamber_(config.bulk_modulus_Pa / config.chamber_volume_m3) {}

double TwoStagePhysics::root(double P) {
  if (P > kChordBelow_Pa) return std::sqrt(P);
  return P > 0.0 ? P / std::sqrt(kChordBelow_Pa) : 0.0;
}

double TwoStagePhysics::root_slope(double P) {
  if (P > kChordBelow_Pa) return 0.5 / std::sqrt(P);
  return P > 0.0 ? 1.0 / std::sqrt(kChordBelow_Pa) : 0.0;
}

double TwoStagePhysics::main_force_N(const TwoStageState& s) const {
  return config_.main_area_m2 * s[kP1] - config_.main_chamber_area_m2 * s[kP2] - main_.preload_N -
         main_.spring * s[kX] - main_.force(s[kP1], s[kX]) -
         (main_.drag + main_.unsteady * root(s[kP1])) * s[kV];
}

double TwoStagePhysics::pilot_force_N(const TwoStageState& s) const {
  return config_.pilot_area_m2 * s[kP2] - pilot_.preload_N - pilot_.spring * s[kY] -
         pilot_.force(s[kP2], s[kY]) - (pilot_.drag + pilot_.unsteady * root(s[kP2])) * s[kU];
}

TwoStageState TwoStagePhysics::rate(const TwoStageState& s, double supply_m3_s) const {
  const double through_capillary = capillary_ * (s[kP1] - s[kP2]);
  return {upstream_ * (supply_m3_s - main_.flow * s[kX] * root(s[kP1]) - through_capillary -
                       config_.main_area_m2 * s[kV]),
          chamber_ * (through_capillary + config_.main_chamber_area_m2 * s[kV] -
                      pilot_.flow * s[kY] * root(s[kP2]) - config_.pilot_area_m2 * s[kU]),
          s[kV],
          main_force_N(s) * main_.inverse_mass,
          s[kU],
          pilot_force_N(s) * pilot_.inverse_mass};
}

TwoStagePhysics::Slopes TwoStagePhysics::slopes(const TwoStageState& s) const {
  const double root1 = root(s[kP1]);
  const double root2 = root(s[kP2]);
  const double slope1 = root_slope(s[kP1]);
  const double slope2 = root_slope(s[kP2]);
  Slopes j{};
  j.P1_P1 = -upstream_ * (main_.flow * s[kX] * slope1 + capillary_);
  j.P1_P2 = upstream_ * capillary_;
  j.P1_x = -upstream_ * main_.flow * root1;
  j.P1_v = -upstream_ * config_.main_area_m2;
  j.P2_P1 = chamber_ * capillary_;
  j.P2_P2 = -chamber_ * (capillary_ + pilot_.flow * s[kY] * slope2);
  j.P2_v = chamber_ * config_.main_chamber_area_m2;
  j.P2_y = -chamber_ * pilot_.flow * root2;
  j.P2_u = -chamber_ * config_.pilot_area_m2;
  j.v_P1 = main_.inverse_mass * (config_.main_area_m2 - s[kX] * (main_.linear - main_.quadratic * s[kX]) -
                                 main_.unsteady * slope1 * s[kV]);
  j.v_P2 = -main_.inverse_mass * config_.main_chamber_area_m2;
  j.v_x = -main_.inverse_mass * (main_.spring + s[kP1] * (main_.linear - 2.0 * main_.quadratic * s[kX]));
  j.v_v = -main_.inverse_mass * (main_.drag + main_.unsteady * root1);
  j.u_P2 = pilot_.inverse_mass * (config_.pilot_area_m2 - s[kY] * (pilot_.linear - pilot_.quadratic * s[kY]) -
                                  pilot_.unsteady * slope2 * s[kU]);
  j.u_y = -pilot_.inverse_mass * (pilot_.spring + s[kP2] * (pilot_.linear - 2.0 * pilot_.quadratic * s[kY]));
  j.u_u = -pilot_.inverse_mass * (pilot_.drag + pilot_.unsteady * root2);
  return j;
}

}  // namespace plenum::host::plant::relief_valve
