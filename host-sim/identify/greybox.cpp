#include "host-sim/identify/greybox.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>
#include <utility>

#include "host-sim/effects/chamber_effects.hpp"
#include "host-sim/plant/gas.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::identify {
namespace {

constexpr double kMl_per_m3 = 1e6;
constexpr double kPascals_per_kPa = 1e3;
constexpr double kKg_s_Pa_per_g_s_MPa = 1e-9;
/// Of the transition: a corner that is sharper the board cannot tell from this one.
constexpr double kLeastTransition_mL_s = 1e-3;

/// Of the spool on a board; it knows a spool by its lateness z/(pi f) alone (firmware/control/model_paths.hpp).
constexpr double kMostSpoolDamping = 2.0;

/// Beyond ambient, to which the board's leak goes: one that goes elsewhere, past a piston, is left out.
constexpr double kNearAmbient_kPa = 10.0;

struct Hose {
  double length_m, bore_m;

  double volume_m3() const { return 0.25 * std::numbers::pi * bore_m * bore_m * length_m; }
  /// What a wave takes to go through it.
  double late_s(const plant::Gas& gas) const {
    return length_m / std::sqrt(gas.kappa * gas.specific_gas_constant_J_kg_K() * gas.temperature_K);
  }
};

effects::ChamberEffects effects_of(const trace::RigDescription& rig) {
  try {
    return effects::chamber_effects(rig.effects);
  } catch (const std::invalid_argument& error) {
    throw trace::InputError(std::string("rig: ") + error.what());
  }
}

double null_V(const effects::ChamberEffects& of, double at_s) {
  if ((of.on >> effects::kIdNullDrift & 1U) == 0) return 0.0;
  constexpr double kTick_s = 0.01;
  effects::NullDrift<double> drift;
  drift.prepare(&of.figures[effects::kFirstFigure[effects::kIdNullDrift]], kTick_s);
  for (double t_s = 0.0; t_s < at_s; t_s += kTick_s) drift.end_tick();
  return -drift.at(0.0);
}

/// The refining parameters that a board has, too, each with its place in its effect.
constexpr std::array<std::pair<effects::Id, std::size_t>, 5> kRefinementsOfABoard{
    {{effects::kIdSpoolLag, 3},  // the coil, as a longer period
     {effects::kIdSupplyDroop, 4},
     {effects::kIdHeatTransfer, 1},
     {effects::kIdAreaShape, 4},
     {effects::kIdAreaShape, 5}}};

std::vector<std::string> refinements_left_out(const effects::ChamberEffects& of, effects::Id id) {
  std::vector<std::string> names;
  const std::span<const effects::Parameter> parameters = effects::kCatalogue[id]->parameters;
  for (std::size_t place = 0; place < parameters.size(); ++place) {
    const effects::Parameter& parameter = parameters[place];
    const bool is_plain =
        of.figures[effects::kFirstFigure[id] + place] == parameter.coordinate_of(parameter.vanishes_at);
    const bool is_had =
        std::ranges::find(kRefinementsOfABoard, std::pair{id, place}) != kRefinementsOfABoard.end();
    if (parameter.refines && !is_plain && !is_had) names.emplace_back(parameter.name);
  }
  return names;
}

}  // namespace

std::vector<std::string> GreyboxModel::without() const {
  std::vector<std::string> all = left_out;
  all.insert(all.end(), refinements_left_out.begin(), refinements_left_out.end());
  return all;
}

GreyboxModel greybox_of(const trace::RigDescription& rig, std::optional<unsigned> chamber, double at_s) {
  const effects::ChamberEffects of = effects_of(rig);
  const auto figure = [&](effects::Id id, std::size_t place) {
    return of.figures[effects::kFirstFigure[id] + place];
  };
  const double spool_damping = std::min(figure(effects::kIdSpoolLag, 1), kMostSpoolDamping);
  const double spool_late_s =
      figure(effects::kIdSpoolLag, 0) * figure(effects::kIdSpoolLag, 1) / std::numbers::pi +
      figure(effects::kIdSpoolLag, 3);  // that of its coil
  plant::Gas gas;
  gas.temperature_K = rig.gas.temperature_K;
  const Hose hose{figure(effects::kIdTubeDynamics, 0), 1e-3 * figure(effects::kIdTubeDynamics, 1)};
  const auto plate = plant::thin_plate_constants(gas, rig.valve.discharge_coefficient);
  const double exponent = figure(effects::kIdHeatTransfer, 1);
  const bool leaks_out = figure(effects::kIdChamberLeak, 3) < kNearAmbient_kPa;
  const double mL_Pa_per_kg = exponent * gas.specific_gas_constant_J_kg_K() * gas.temperature_K * kMl_per_m3;
  const double conductance_mL_s_m2 = mL_Pa_per_kg * plate.beta_s_m;
  const auto conductance = [&](double area_m2) { return conductance_mL_s_m2 * area_m2; };

  const double drifted_V = null_V(of, at_s);

  GreyboxModel made;
  made.file.kind = "greybox";
  made.file.chamber = chamber;
  const double leak_mL_s =
      leaks_out ? mL_Pa_per_kg * figure(effects::kIdChamberLeak, 0) * kKg_s_Pa_per_g_s_MPa : 0.0;
  made.file.parameters = {rig.valve.open_above_V + drifted_V,
                          rig.valve.exhaust_below_V + drifted_V,
                          conductance(rig.valve.inlet_area_per_V_m2),
                          conductance(rig.valve.exhaust_area_per_V_m2),
                          conductance(rig.valve.inlet_leak_m2),
                          conductance(rig.valve.exhaust_leak_m2),
                          std::max(conductance(rig.valve.transition_m2), kLeastTransition_mL_s),
                          figure(effects::kIdAreaShape, 0),  // slope, curve and bend of the inlet
                          figure(effects::kIdAreaShape, 1),
                          figure(effects::kIdAreaShape, 4),
                          figure(effects::kIdAreaShape, 2),  // and of the exhaust
                          figure(effects::kIdAreaShape, 3),
                          figure(effects::kIdAreaShape, 5),
                          figure(effects::kIdFlowFunction, 0),
                          figure(effects::kIdFlowFunction, 1),
                          figure(effects::kIdFlowFunction, 2),
                          figure(effects::kIdFlowFunction, 3),
                          figure(effects::kIdVolumeError, 0) + kMl_per_m3 * hose.volume_m3(),
                          exponent,
                          leak_mL_s,
                          figure(effects::kIdDeadTime, 0) + hose.late_s(gas),
                          std::numbers::pi * spool_late_s / spool_damping,  // 1/f
                          spool_damping,
                          figure(effects::kIdValveHysteresis, 0),
                          figure(effects::kIdSensorLag, 0),
                          rig.supply.pressure_Pa / kPascals_per_kPa,
                          rig.ambient.pressure_Pa / kPascals_per_kPa,
                          kPascals_per_kPa * figure(effects::kIdSupplyDroop, 0) /
                              (exponent * gas.specific_gas_constant_J_kg_K() * gas.temperature_K),
                          figure(effects::kIdSupplyDroop, 1),
                          figure(effects::kIdSupplyDroop, 4)};
  constexpr effects::EffectSet kAlways =
      1U << effects::kIdAreaShape | 1U << effects::kIdFlowFunction | 1U << effects::kIdVolumeError |
      1U << effects::kIdDeadTime | 1U << effects::kIdSpoolLag | 1U << effects::kIdValveHysteresis |
      1U << effects::kIdSensorLag | 1U << effects::kIdTubeDynamics | 1U << effects::kIdSupplyDroop;
  const bool keeps_heat =
      figure(effects::kIdHeatTransfer, 0) == 0.0 && figure(effects::kIdHeatTransfer, 4) == 0.0;
  const effects::EffectSet carried = kAlways | (keeps_heat ? 1U << effects::kIdHeatTransfer : 0U) |
                                     (leaks_out ? 1U << effects::kIdChamberLeak : 0U);
  made.rig = rig;
  for (std::size_t id = 0; id < effects::kEffects; ++id) {
    if ((of.on >> id & 1U) == 0) continue;
    const std::string name(effects::kCatalogue[id]->id);
    if ((carried >> id & 1U) != 0) {
      for (const std::string& refinement : refinements_left_out(of, static_cast<effects::Id>(id))) {
        std::string& full = made.refinements_left_out.emplace_back(name);
        full += '.';
        full += refinement;
        made.rig.effects[name].erase(refinement);
      }
    } else {
      made.left_out.push_back(name);
      const bool stays = id == effects::kIdSensorBias || id == effects::kIdNullDrift;
      if (!stays) made.rig.effects.erase(name);
      if (id == effects::kIdHeatTransfer) made.rig.effects[name] = {{"exponent", exponent}};
    }
  }
  trace::parse_model(trace::format_model(made.file), "grey-box model of the rig");
  return made;
}

}  // namespace plenum::host::identify
