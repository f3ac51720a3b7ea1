// What the regulator knows of a model of chamber pressure: one tick forward, and its inverse.
//
// A new kind of model is a class that implements this interface and a ModelKind with its parameter schema in
// config/model_image.hpp; nothing else in the core changes.
//
// Conventions: absolute pressures [kPa], commands [V], volumes [mL], time in ticks of config::kTick_s.
// Command, volume and volume rate are constant over the tick; the volume is the one at the middle of the
// tick.
#pragma once

#include "firmware/config/limits.hpp"
#include "firmware/numeric/scalar.hpp"

namespace plenum::control {

using numeric::Scalar;

inline constexpr Scalar kTick_s = Scalar(config::kTick_s);

/// What is beyond these is no pressure, volume or speed of a chamber; within them a model's numbers do not overflow.
inline constexpr Scalar kMostPressure_kPa = Scalar(1e5);
inline constexpr Scalar kMostVolume_mL = Scalar(1e7);
inline constexpr Scalar kMostSpeed_mL_s = Scalar(1e7);

/// [bits, kPa/V] A slope of the end by the command need be no steeper than 2^this, where a fixed-point number holds it: a search looks
/// where it leads, and takes no word of it.
inline constexpr int kSteepest = 28;

/// What a chamber is and does over one tick.
struct ChamberMotion {
  Scalar volume_mL = 0;         ///< at the middle of the tick
  Scalar volume_rate_mL_s = 0;  ///< mean over the tick
  Scalar supply = 1;            ///< pressure of the supply, of what the model states [1]
};

/// The pressure at the end of a step and its mean over it (what the averaging sensor will read).
struct Prediction {
  Scalar end_kPa = 0;
  Scalar mean_kPa = 0;
};

/// The command that takes the pressure to a target in one tick.
struct Inverse {
  Scalar command_V = 0;         ///< within the command range
  Scalar reached_kPa = 0;       ///< the pressure that the command leads to
  Scalar by_command_kPa_V = 0;  ///< and how that rises with the command, near there
  bool saturated = false;       ///< no command in the range reaches the target; this one comes closest
};

/// What a command does to the valve, as its model has computed it and alone can read it: s and k of the formulas, the conductances
/// of the grey-box model.
struct Opening {
  Scalar first = 0;
  Scalar second = 0;
};

/// What a motion does to the pressure over a tick, likewise: shares of volume and speed in the rates, and what supply there is.
struct Moving {
  Scalar first = 0;
  Scalar second = 0;
  Scalar third = 0;
};

/// What flows in from the supply [kPa L/s], and how that rises with the supply, of what the model states.
struct Draw {
  Scalar flow_kPa_L_s = 0;
  Scalar by_supply_kPa_L_s = 0;
};

class PressureModel {
 public:
  virtual Opening opening(Scalar command_V) const noexcept = 0;
  virtual Moving moving(const ChamberMotion& motion) const noexcept = 0;

  /// Pressure after `ticks` of a tick (0 to 1) and its mean over that time. Finite for every finite input.
  virtual Prediction step(Scalar pressure_kPa, const Opening& open, const Moving& moves,
                          Scalar ticks) const noexcept = 0;
  Prediction step(Scalar pressure_kPa, Scalar command_V, const ChamberMotion& motion,
                  Scalar ticks) const noexcept {
    return step(pressure_kPa, opening(command_V), moving(motion), ticks);
  }

  /// At a pressure. Nothing by a model that knows no flow.
  virtual Draw draw(Scalar, const Opening&, const Moving&) const noexcept { return {}; }

  /// The command within the model's command range whose step() ends nearest to `target_kPa`.
  ///
  /// Where several commands reach the target, the one at which pressure rises with the command wins
  /// (elsewhere a small error would be driven the wrong way), and among those the nearest to `near_V`,
  /// usually the last command. The number of evaluations is bounded by a constant of the implementation.
  virtual Inverse inverse(Scalar pressure_kPa, Scalar target_kPa, const Moving& moves,
                          Scalar near_V) const noexcept = 0;
  Inverse inverse(Scalar pressure_kPa, Scalar target_kPa, const ChamberMotion& motion,
                  Scalar near_V) const noexcept {
    return inverse(pressure_kPa, target_kPa, moving(motion), near_V);
  }

 protected:
  ~PressureModel() = default;
};

}  // namespace plenum::control
