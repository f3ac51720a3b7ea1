// A thin-plate chamber with effects that the nominal model leaves out, as a plant in a rig.
//
// The physics is effects::ChamberModel, at 16 steps a tick (2 Pa RMS from the error-controlled plant; README.md of
// host-sim/effects), on the volume of plant::VolumeMotion. Its sensor effects come before the board's converter.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "host-sim/effects/chamber_effects.hpp"
#include "host-sim/effects/chamber_model.hpp"
#include "host-sim/plant/chamber.hpp"

namespace plenum::host::rig {

class EffectsChamber {
 public:
  /// The chamber begins at rest, as a ChamberPlant. Throws std::invalid_argument when `valve` is no thin plate, or
  /// `config` has a spool: here a spool is an effect.
  EffectsChamber(const plant::Valve& valve, const plant::ChamberConfig& config,
                 const plant::VolumeMotion& volume, const effects::ChamberEffects& effects, double tick_s);

  /// A tick with `command_V` held. Returns the sensor's mean over it.
  double advance(double command_V);

  double pressure_Pa() const { return model_.pressure_Pa(); }
  /// What the sensor reads while the pressure rests, as it does before the first tick.
  double resting_reading_Pa() const { return model_.resting_reading_Pa(); }
  plant::VolumeState volume() const { return volume_.at(time_s()); }
  /// At rest: what a sensor ahead of the source's resistance reads.
  double supply_Pa() const { return supply_Pa_; }

 private:
  double time_s() const { return static_cast<double>(ticks_) * tick_s_; }

  plant::VolumeMotion volume_;
  double supply_Pa_;
  double tick_s_;
  std::uint64_t ticks_ = 0;
  std::unique_ptr<const effects::Figures> figures_;  ///< where model_ looks, also after a move
  effects::ChamberModel<double> model_;
  /// At the ends of a tick's steps, and of as many more as model_ looks ahead.
  std::vector<double> volume_m3_;
};

}  // namespace plenum::host::rig
