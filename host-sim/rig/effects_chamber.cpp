#include "host-sim/rig/effects_chamber.hpp"

#include <cmath>
#include <stdexcept>
#include <variant>

namespace plenum::host::rig {
namespace {

constexpr int kSteps = 16;

const plant::ThinPlateValveConfig& sheet_of(const plant::Valve& valve) {
  const auto* plate = std::get_if<plant::ThinPlateValve>(&valve);
  if (plate == nullptr)
    throw std::invalid_argument("effects act on thin-plate valves, not on measured tables");
  return plate->config();
}

effects::Figures figures_of(const plant::ThinPlateValveConfig& sheet,
                            const effects::ChamberEffects& effects) {
  effects::Figures figures = effects.figures;
  figures[effects::kOpenAbove] = sheet.open_above_V;
  figures[effects::kExhaustBelow] = sheet.exhaust_below_V;
  figures[effects::kInletGain] = sheet.inlet_area_per_V_m2;
  figures[effects::kExhaustGain] = sheet.exhaust_area_per_V_m2;
  figures[effects::kInletLeak] = sheet.inlet_leak_m2;
  figures[effects::kExhaustLeak] = sheet.exhaust_leak_m2;
  figures[effects::kTransition] = sheet.transition_m2;
  return figures;
}

}  // namespace

EffectsChamber::EffectsChamber(const plant::Valve& valve, const plant::ChamberConfig& config,
                               const plant::VolumeMotion& volume, const effects::ChamberEffects& effects,
                               double tick_s)
    : volume_(volume),
      supply_Pa_(config.supply_Pa),
      tick_s_(tick_s),
      figures_(std::make_unique<const effects::Figures>(figures_of(sheet_of(valve), effects))),
      model_({.gas = config.gas,
              .supply_Pa = config.supply_Pa,
              .ambient_Pa = config.ambient_Pa,
              .discharge_coefficient = sheet_of(valve).discharge_coefficient,
              .volume_m3 = volume.mean_m3()},
             {.tick_s = tick_s, .average_s = tick_s, .steps = kSteps}, effects.on, figures_->data(),
             config.initial_pressure_Pa, config.initial_command_V, volume.at(0.0).volume_m3) {
  if (config.spool) throw std::invalid_argument("a chamber with effects has its spool among them: spool_lag");
  // a position sensor with a dead time says where the volume was: where it is then, the motion knows
  const double ahead =
      (*figures_)[effects::kFirstFigure[effects::kIdVolumeError] + effects::kVolumeDelay] * kSteps / tick_s;
  volume_m3_.resize(kSteps + 1 + (ahead > 0.0 ? static_cast<std::size_t>(std::ceil(ahead)) + 2 : 0));
}

double EffectsChamber::advance(double command_V) {
  const plant::VolumeMotion::Interval motion(volume_, time_s());
  for (std::size_t i = 0; i < volume_m3_.size(); ++i) {
    volume_m3_[i] = motion.at(tick_s_ * static_cast<double>(i) / kSteps).volume_m3;
  }
  ++ticks_;
  return model_.tick(command_V, volume_m3_);
}

}  // namespace plenum::host::rig
