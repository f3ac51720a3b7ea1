// The checks that raise faults: one monitor a chamber, one for the board. They see causes; FaultRegister
// remembers.
//
// What the converters say, which may be no number at all, they judge in float, whatever the core computes in: each chamber's by its bits,
// as numeric/nearest.hpp has them. What the core has computed they judge as it has it.
//
// A limit of n ticks means: the cause is raised in the n-th tick on end. What lasts is counted in time, with the ticks that a late
// board has left out; what must be seen several times, in ticks that there were. Counters saturate; no check divides, loops or
// waits.
#pragma once

#include <algorithm>
#include <cstdint>

#include "firmware/config/chamber_settings.hpp"
#include "firmware/numeric/scalar.hpp"
#include "firmware/safety/faults.hpp"

namespace plenum::safety {

/// Ticks on end for which a condition has held, saturating.
class TickCount {
 public:
  /// `ticks` have passed since the last step, this one among them: the condition has held in all of them.
  std::uint16_t step(bool condition, std::uint32_t ticks = 1) noexcept {
    const auto left = static_cast<std::uint32_t>(UINT16_MAX - count_);
    count_ = !condition ? std::uint16_t{0} : static_cast<std::uint16_t>(count_ + std::min(ticks, left));
    return count_;
  }

  /// Likewise, of a condition that is seen: it has held in those before this one if it was seen before them, too.
  std::uint16_t go_on(bool condition, std::uint32_t ticks) noexcept {
    return step(condition, count_ == 0 ? 1 : ticks);
  }

  std::uint16_t ticks() const noexcept { return count_; }

 private:
  std::uint16_t count_ = 0;
};

/// A pressure sensor is stuck whose reading equals the one before to the bit for ChamberSettings::stuck_ticks on end, while the
/// command went over this share of the installer's range. With the least noise of a converter ten equal readings do not come; without
/// any, as in a simulation, a chamber that is at rest has a command at rest, or one that stays within a valve's dead band.
inline constexpr float kStuckMoved = 0.125F;

/// A model has drifted until it misses less than this share of what raised the warning.
inline constexpr numeric::Scalar kDriftGone = numeric::Scalar(0.7F);

/// From where on a drift is told, of a model that missed so much of a tick's pressure when it was fitted; 0: that is not stated, and no
/// drift is told.
numeric::Scalar drift_limit_kPa(const config::ChamberSettings& settings, float fit_error_kPa) noexcept;

class ChamberMonitor {
 public:
  struct Input {
    std::uint32_t ticks = 1;      ///< since the last step, this one among them
    float pressure_V = 0.0F;      ///< mean at the pressure sensor's pin over the tick
    bool pressure_fresh = false;  ///< a sample arrived in the tick
    bool pressure_at_end =
        false;  ///< at the most that its converter can tell: whatever is above looks like it
    float position_V = 0.0F;
    bool position_fresh = false;
    numeric::Scalar residual_kPa =
        0;  ///< measured minus predicted, as known a tick ago; 0 while nothing is predicted
    numeric::Scalar drift_kPa =
        0;  ///< mean magnitude of what the model alone misses of a tick's pressure ...
    numeric::Scalar drift_limit_kPa = 0;  ///< ... and from where on it is told: drift_limit_kPa(); 0: never
    bool regulated = false;               ///< over the tick ...
    numeric::Scalar reference_kPa = 0;    ///< ... to this, in the mean
    numeric::Scalar command_V = 0;        ///< held over the tick
    bool driven = false;                  ///< regulated or excited over the tick
    bool regulation_asked = false;        ///< 6040h asks for HOLD or ACTIVE
    bool model_ready = false;             ///< this chamber has a model, or the control mode needs none
  };
  struct Output {
    FaultSet causes = 0;
    bool pressure_usable = false;  ///< fresh, finite and in range: may be regulated on
    bool position_usable = false;
    bool on_target = false;     ///< within the target window for as long as it asks for
    float pressure_kPa = 0.0F;  ///< what the sensor says, where usable
  };

  /// One tick. Of a chamber that is not in use nothing is raised.
  Output step(const config::ChamberSettings& settings, const Input& input) noexcept;

 private:
  void watch_deviation(const config::ChamberSettings& settings, const Input& in, const Output& seen) noexcept;

  TickCount pressure_stale_, position_stale_, over_pressure_, residual_;
  float pressure_before_V_ = 0.0F;
  numeric::Scalar lowest_V_ = 0, highest_V_ = 0;  ///< commands while it stood still
  TickCount still_;
  bool over_pressure_tripped_ = false;
  bool drifted_ = false;
  TickCount deviating_, within_target_;
};

/// Whether the set point of a chamber is of now: written since ACTIVE began, or within the ticks before it for which the set-point
/// watchdog waits. Where that is off any is.
class SetpointNews {
 public:
  /// One tick, of which `ticks` have passed since the last. `came`: it was written since; `active`: the board was ACTIVE in that.
  void step(bool came, bool active, std::uint16_t watchdog_ticks, std::uint32_t ticks) noexcept {
    const std::uint16_t age = age_.step(!came, ticks);
    is_of_now_ = came || watchdog_ticks == 0 || (is_of_now_ && (active || age < watchdog_ticks));
  }
  bool is_of_now() const noexcept { return is_of_now_; }

 private:
  TickCount age_;
  bool is_of_now_ = false;
};

/// What the supply's sensor says, said lately, is not too low for the board.
bool supply_suffices(const config::BoardSettings& settings, float sensor_V, bool fresh) noexcept;

class BoardMonitor {
 public:
  struct Input {
    std::uint32_t ticks = 1;             ///< since the last step, this one among them
    bool emergency_stop = false;         ///< its circuit is open
    bool outputs_ok = true;              ///< every output took the last write
    bool memory_upset = false;           ///< a bit has flipped in what decides what may move
    bool configuration_refused = false;  ///< the settings stand in for ones that were refused
    bool tick_late = false;              ///< this tick began later than its deadline
    float supply_V = 0.0F;               ///< mean at the supply sensor's pin
    bool supply_fresh = true;            ///< a sample arrived in the tick; an old one vouches for no supply
    bool bus_off = false;
    bool error_passive = false;
    bool frames_lost = false;          ///< a receive queue overflowed since the last tick
    bool heartbeat_lost = false;       ///< a consumed heartbeat is overdue
    bool setpoint_lost = false;        ///< the RPDO event timer ran out
    bool pdo_short = false;            ///< a PDO has come that is shorter than its mapping
    bool pdo_long = false;             ///< one that is longer
    bool sync_misfits = false;         ///< a SYNC has come that 1019h does not allow
    bool stored_set_lost = false;      ///< the start found the stored parameter set damaged
    bool store_failing = false;        ///< a parameter set cannot be stored
    std::uint32_t setpoint_count = 0;  ///< changes when all set points have come anew
    bool setpoints_needed = false;     ///< drive was `active` and the control mode follows set points
  };

  FaultSet step(const config::BoardSettings& settings, const Input& input) noexcept;

 private:
  TickCount late_, supply_low_, setpoint_silence_;
  std::uint32_t setpoint_count_before_ = 0;
};

}  // namespace plenum::safety
