#include "host-sim/reproduce/servo/driven_friction.hpp"

#include <algorithm>
#include <cmath>

#include "host-sim/identify/servo/friction_fit.hpp"
#include "host-sim/plant/servo/cylinder.hpp"
#include "host-sim/reproduce/servo/sealed_ports.hpp"

namespace plenum::host::reproduce::servo {
namespace {

using identify::servo::SlidingRow;

constexpr double kStiffness_N_m = 1e6;
constexpr double kDamping_N_s_m = 2e3;  // critical with 1 kg
constexpr double kMass_kg = 1.0;
constexpr double kHold_s = 1e-4;  // of the coupling's force: a tenth of its time constant
constexpr std::size_t kHalfWidth = 5;
constexpr double kSettled_s = 0.05;  // the plant's piston starts at rest, the measured one slides

// Every sample that has a velocity, the slow ones and the ends of the stroke included.
std::vector<SlidingRow> with_velocity(const std::vector<PulledSample>& samples) {
  identify::servo::PulledRecord record;
  for (const PulledSample& s : samples) {
    record.time_s.push_back(1e-3 * (s.time_ms - samples.front().time_ms));
    record.position_m.push_back(1e-3 * s.position_mm);
    record.pressure_Pa.push_back(1e5 * s.pressure_bar);
    record.force_N.push_back(s.force_N);
  }
  return identify::servo::sliding_rows(
      record, {.half_width = kHalfWidth, .slowest_m_s = 0.0, .from_m = -1.0, .to_m = 1.0});
}

plant::servo::ServoCylinder piston(const plant::servo::Friction& friction) {
  plant::servo::ServoCylinderConfig config;
  config.friction = friction;
  config.moving_mass_kg = kMass_kg;
  config.dead_volume_1_m3 = config.dead_volume_2_m3 = 10.0;
  return {sealed_ports(), config};
}

}  // namespace

double DrivenFriction::rms_N() const {
  double square = 0.0;
  for (std::size_t i = 0; i < plant_N.size(); ++i) square += std::pow(plant_N[i] - measured_N[i], 2.0);
  return std::sqrt(square / static_cast<double>(plant_N.size()));
}

double DrivenFriction::span_N() const {
  const auto [least, most] = std::minmax_element(measured_N.begin(), measured_N.end());
  return *most - *least;
}

DrivenFriction driven_friction(const std::vector<PulledSample>& samples, const PullingBench& bench,
                               const plant::servo::Friction& friction) {
  const std::vector<SlidingRow> rows = with_velocity(samples);
  plant::servo::ServoCylinder cylinder = piston(friction);
  DrivenFriction driven;
  double asked_m = 0.0;  // x_m
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
    const double duration_s = rows[i + 1].time_s - rows[i].time_s;
    const int holds = std::max(static_cast<int>(std::lround(duration_s / kHold_s)), 1);
    const double h = duration_s / holds;
    for (int n = 0; n < holds; ++n) {
      const double v = std::lerp(rows[i].velocity_m_s, rows[i + 1].velocity_m_s, (n + 0.5) / holds);
      asked_m += h * v;
      cylinder.set_external_force_N(-kStiffness_N_m * (asked_m - cylinder.position_m()) -
                                    kDamping_N_s_m * (v - cylinder.velocity_m_s()));
      cylinder.advance({5.0, 5.0}, h);
      const bool settled = rows[i].time_s > rows.front().time_s + kSettled_s;
      if (settled && cylinder.motion() == plant::servo::Motion::kStuck) driven.stuck_s += h;
    }
    const SlidingRow& row = rows[i + 1];
    if (row.time_s < rows.front().time_s + kSettled_s) continue;
    driven.time_s.push_back(row.time_s);
    driven.measured_N.push_back(row.force_N - bench.area_m2 * row.pressure_Pa - bench.zero_N);
    driven.plant_N.push_back(cylinder.friction_N());
  }
  return driven;
}

}  // namespace plenum::host::reproduce::servo
