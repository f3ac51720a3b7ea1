// One chamber, one tick: measure, observe, command. What is common to all chambers is the Controller's.
#pragma once

#include <cstdint>

#include "firmware/canopen/process_image.hpp"
#include "firmware/config/chamber_settings.hpp"
#include "firmware/config/model_image.hpp"
#include "firmware/config/seal.hpp"
#include "firmware/control/any_model.hpp"
#include "firmware/control/excitation.hpp"
#include "firmware/control/model_paths.hpp"
#include "firmware/control/reference_shaper.hpp"
#include "firmware/control/regulator.hpp"
#include "firmware/control/volume_observer.hpp"
#include "firmware/ports/analog.hpp"
#include "firmware/safety/monitors.hpp"
#include "firmware/safety/supervisor.hpp"

namespace plenum {

class ChamberLoop {
 public:
  /// Takes over settings that config::validate() has passed, at a tick's edge. take_over() must follow where a model is in
  /// force.
  void configure(const config::ChamberSettings& settings,
                 const control::Regulator::Config& regulator) noexcept;

  /// A model comes into force at this tick's edge, or none (kind none). The chamber goes on from where it
  /// stands.
  void take_over(const config::ModelParameters& parameters) noexcept;

  bool has_model() const noexcept { return known_.in_force() != nullptr; }
  bool in_use() const noexcept { return settings_.in_use; }
  /// A usable pressure has come this tick.
  bool pressure_fresh() const noexcept { return pressure_fresh_; }

  /// No bit has flipped in the settings, in what configure() made of them, nor in the piece of the model that is looked at with
  /// this call. Settings of which the other copy is whole are mended.
  bool intact() noexcept;

  /// No bit has flipped since the last command() in what runs on from tick to tick and does not come back by itself: the volume's
  /// estimate, the regulator's estimates, and the reference or the excitation that is followed. These are begun anew when one has.
  /// Before measure().
  bool state_intact() noexcept;

  struct Measured {
    std::uint32_t ticks = 1;  ///< since the last, this one among them
    ports::AnalogReading pressure;
    ports::AnalogReading position;
    numeric::Scalar supply_kPa = 0;  ///< 0: none that can be believed
  };

  /// First half of a tick: readings in, estimates of pressure and volume, causes of faults out.
  safety::FaultSet measure(const Measured& readings, bool regulation_asked, bool model_needed) noexcept;

  struct Order {
    safety::Drive drive = safety::Drive::vent;
    bool must_vent = false;
    bool powered = true;     ///< the valve has its supply; without it its springs shut both ports
    bool commanded = false;  ///< 6040h has taken the board to DISABLED or beyond
    canopen::ControlMode mode = canopen::ControlMode::pressure_closed_loop;
    std::uint8_t preview_ticks = 0;
    std::uint32_t excitation_seed = 1;  ///< this chamber's own
  };

  /// Second half: the command [V] to hold until the next tick. Reads set points and excitation in `image`, writes the
  /// rest of it.
  float command(const Order& order, canopen::ChamberImage& image) noexcept;

  /// What the output holds at rest [V].
  float resting_V() const noexcept { return safety::resting_command_V(resting_, safety::Drive::safe, false); }

 private:
  numeric::Scalar driven_V(const Order& order, canopen::ChamberImage& image) noexcept;
  void begin_excitation(const Order& order, const canopen::ExcitationImage& asked) noexcept;
  numeric::Scalar regulated_V(const Order& order, canopen::ChamberImage& image) noexcept;
  void rest_by_settings() noexcept;
  std::uint64_t sum_of_constants() const noexcept;
  std::uint64_t sum_of_paths() const noexcept;
  std::uint64_t sum_of_state() const noexcept;
  void observe_volume(numeric::Scalar measured_mL) noexcept;
  numeric::Scalar within_stroke(numeric::Scalar volume_mL) const noexcept;
  void bridge_volume() noexcept;
  void begin_anew() noexcept;
  void observe_pressure(const control::PressureModel& model) noexcept;

  config::ChamberSettings settings_;
  config::ChamberSettings
      resting_;  ///< what a resting output follows: settings_ as of the last DISABLED or beyond
  safety::ChamberMonitor monitor_;
  control::VolumeObserver volume_;
  control::ReferenceShaper shaper_;
  control::Regulator regulator_;
  control::Excitation excitation_;
  control::AnyModel known_;
  config::LongSeal model_seal_;  ///< of the one in force
  std::uint64_t settings_seal_ = 0;
  std::uint64_t resting_seal_ = 0;
  std::uint64_t constants_seal_ = 0;       ///< of what configure() makes of them
  std::uint64_t paths_seal_ = 0;           ///< of what take_over() makes of a model besides known_
  std::uint64_t state_seal_ = 0;           ///< from one tick to the next
  numeric::Scalar valve_delay_ticks_ = 0;  ///< for a model that leaves it out

  struct Allowed {
    numeric::Scalar low_V = 0;
    numeric::Scalar high_V = 0;
  };
  Allowed allowed_;                   ///< the settings' range of commands, as the core computes
  numeric::Scalar farthest_mL_ = 0;   ///< that a believed estimate of the volume is off its measurement
  numeric::Scalar pressure_kPa_ = 0;  ///< last usable measurement
  control::ChamberMotion motion_;     ///< of the tick at hand
  numeric::Scalar residual_kPa_ = 0;
  numeric::Scalar drift_kPa_ = 0;        ///< 2210h:5
  numeric::Scalar drift_limit_kPa_ = 0;  ///< of the model in force
  numeric::Scalar command_V_ = 0;        ///< held over the tick just past
  numeric::Scalar reference_kPa_ = 0;    ///< mean over the tick just past, where it was regulated
  numeric::Scalar held_kPa_ = 0;         ///< the pressure at which holding began
  bool rests_by_settings_ = false;       ///< resting_ is settings_
  bool has_commanded_ = false;           ///< an output stands, and no setting alone moves it
  bool pressure_fresh_ = false;          ///< a usable measurement has come this tick
  bool pressure_seen_ = false;           ///< a usable measurement has come since the start
  bool volume_seen_ = false;
  std::uint8_t volume_unseen_ticks_ = 0;  ///< since it was measured
  bool was_regulating_ = false;
  bool was_holding_ = false;
  bool was_exciting_ = false;
  std::uint8_t seen_ = 0;    ///< what the monitor says of 2230h
  bool may_excite_ = false;  ///< what was asked of the excitation, and the settings, leave it a range
};

}  // namespace plenum
