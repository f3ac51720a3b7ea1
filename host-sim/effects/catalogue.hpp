// The catalogue: every effect that the nominal model leaves out, and where its parameters stand among the figures
// of a model. Adding an effect: its own file, a line here, and the place in chamber_model.hpp where it acts.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "host-sim/effects/area_shape.hpp"
#include "host-sim/effects/chamber_leak.hpp"
#include "host-sim/effects/dead_time.hpp"
#include "host-sim/effects/exhaust_backpressure.hpp"
#include "host-sim/effects/flow_function.hpp"
#include "host-sim/effects/heat_transfer.hpp"
#include "host-sim/effects/null_drift.hpp"
#include "host-sim/effects/sensor_bias.hpp"
#include "host-sim/effects/sensor_lag.hpp"
#include "host-sim/effects/spool_lag.hpp"
#include "host-sim/effects/supply_droop.hpp"
#include "host-sim/effects/tube_dynamics.hpp"
#include "host-sim/effects/valve_hysteresis.hpp"
#include "host-sim/effects/volume_error.hpp"

namespace plenum::host::effects {

/// Positions in the catalogue.
enum Id : std::size_t {
  kIdSpoolLag,
  kIdDeadTime,
  kIdValveHysteresis,
  kIdAreaShape,
  kIdNullDrift,
  kIdFlowFunction,
  kIdSupplyDroop,
  kIdExhaustBackpressure,
  kIdChamberLeak,
  kIdTubeDynamics,
  kIdHeatTransfer,
  kIdVolumeError,
  kIdSensorLag,
  kIdSensorBias,
  kEffects
};

inline constexpr std::array<const Effect*, kEffects> kCatalogue{
    &kSpoolLag,     &kDeadTime,    &kValveHysteresis,     &kAreaShape,   &kNullDrift,
    &kFlowFunction, &kSupplyDroop, &kExhaustBackpressure, &kChamberLeak, &kTubeDynamics,
    &kHeatTransfer, &kVolumeError, &kSensorLag,           &kSensorBias};

inline std::span<const Effect* const> catalogue() {
  return kCatalogue;
}

/// Position of the effect of this id.
std::optional<std::size_t> find(std::string_view id);

/// A set of effects: bit i is kCatalogue[i].
using EffectSet = unsigned;

// ---- the figures of a model: those of the [valve] table, then each effect's parameters as coordinates, then the log's ----

enum ValveFigure : std::size_t {
  kOpenAbove,
  kExhaustBelow,
  kInletGain,
  kExhaustGain,
  kInletLeak,
  kExhaustLeak,
  kTransition,
  kValveFigures
};

/// Where the parameters of each effect begin in Figures; the last: where they end. A table, not a function, because the
/// kernels for different processors must have no function in common.
inline constexpr auto kFirstFigure = [] {
  std::array<std::size_t, kEffects + 1> first{};
  first[0] = kValveFigures;
  for (std::size_t i = 0; i < kEffects; ++i) first[i + 1] = first[i] + kCatalogue[i]->parameters.size();
  return first;
}();
/// Last a figure of the log, no effect's: the readings of a row are those of so many seconds later. Zero but where a fit looks for it.
inline constexpr std::size_t kStampedEarly = kFirstFigure[kEffects];
inline constexpr std::size_t kFigures = kStampedEarly + 1;

using Figures = std::array<double, kFigures>;

/// Every effect at the value at which it vanishes; the others zero.
Figures neutral_figures();

}  // namespace plenum::host::effects
