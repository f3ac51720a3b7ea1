// The seam between the bus and the controller: plain values that CAN objects read and write.
//
// The node (canopen/) writes the "from the bus" members when a frame arrives and reads the "to the bus"
// members when one leaves; the controller does the opposite once a tick. Neither knows the other.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/canopen/objects.hpp"
#include "firmware/config/limits.hpp"
#include "firmware/config/record_store.hpp"
#include "firmware/config/twice.hpp"
#include "firmware/config/units.hpp"
#include "firmware/numeric/scalar.hpp"
#include "firmware/safety/faults.hpp"
#include "firmware/telemetry/latency_histogram.hpp"

namespace plenum::canopen {

/// Control modes of object 6043h (own values; CiA 408 leaves them to the device).
enum class ControlMode : std::int8_t {
  excitation = -1,  ///< identification: random valve commands inside pressure limits, no model needed
  pressure_open_loop = 3,
  pressure_closed_loop = 4,
};

/// Of the board, and of each chamber at its number from 1, as an emergency counts them.
using StandingFaults = std::array<safety::FaultSet, config::kChambers + 1>;

/// Absolute pressure [Pa], as it came.
using Setpoint = config::Twice<numeric::Scalar>;

/// What a chamber is excited by (2310h).
struct ExcitationImage {
  std::uint32_t seed = 1;  ///< of two chambers with the same seed each has a sequence of its own
  float command_low_V = 3.0F;
  float command_high_V = 7.0F;
  float pressure_low_Pa = 130000.0F;
  float pressure_high_Pa = 600000.0F;

  friend bool operator==(const ExcitationImage&, const ExcitationImage&) noexcept = default;
};

struct ChamberImage {
  // from the bus; 0: the lowest that the limits allow
  Setpoint setpoint_Pa{0};       ///< 6380h / 2150h:1
  Setpoint hold_setpoint_Pa{0};  ///< 6394h; 0: the pressure at which holding begins
  ExcitationImage excitation;    ///< 2310h
  // to the bus
  config::Pascals actual_Pa;  ///< 6381h / 2150h:2, mean over the tick just past
  config::Pascals demand_Pa;  ///< 6390h, what is followed: the set point after limits and ramp
  config::Pascals
      deviation_Pa;  ///< 63D0h, what was followed minus the pressure, means over the tick just past
  config::CubicMetres volume_m3;  ///< 2150h:3
  float position_V =
      0.0F;  ///< 2150h:4, mean at the position sensor's pin over the last tick in which a sample came
  config::Volts command_V;      ///< 2210h:3, the command now held at the valve
  config::Volts feedforward_V;  ///< 2210h:1
  config::Volts feedback_V;     ///< 2210h:2
  config::Pascals residual_Pa;  ///< 2210h:4, measured minus predicted pressure of this tick
  config::Pascals drift_Pa;  ///< 2210h:5, mean magnitude of what the model alone misses of a tick's pressure
  std::uint8_t regulation = 0;  ///< 2230h

  friend bool operator==(const ChamberImage&, const ChamberImage&) noexcept = default;
};

enum class StorePhase : std::uint8_t {
  idle = 0,     ///< the stored set is the one in force
  writing = 1,  ///< a set waits to be stored, or is being written
  failing = 2   ///< as writing, after an attempt that failed
};

/// The parameter store, as 2130h shows it.
struct StoreImage {
  StorePhase phase = StorePhase::idle;
  config::LoadResult loaded = config::LoadResult::empty;  ///< what the start found
  std::uint32_t generation = 0;                           ///< of the stored set; 0: none
  std::uint16_t skipped_rows = 0;  ///< of the set found at start: unknown to this firmware, or not admissible
  std::uint32_t first_skipped = 0;  ///< the first of them: index << 8 | sub-index
  std::uint32_t failures = 0;       ///< attempts to store that failed, since the start

  friend bool operator==(const StoreImage&, const StoreImage&) noexcept = default;
};

/// What a volume's code on the bus counts. No frame is to wait for a division.
struct VolumeCode {
  float lsb_m3 = kVolumeLsb_m3;  ///< 2228h:2
  numeric::Scalar per_mL = numeric::Scalar(config::kM3_per_mL / kVolumeLsb_m3);

  friend bool operator==(const VolumeCode&, const VolumeCode&) noexcept = default;
};

/// Yes by any byte but 0. A bool in which a bit has flipped is neither true nor false: shifted to the place of a fault it becomes
/// another one, or none that there is.
class Flag {
 public:
  constexpr Flag(bool yes) noexcept : byte_(yes ? 1 : 0) {}
  constexpr operator bool() const noexcept { return byte_ != 0; }

 private:
  std::uint8_t byte_;
};

struct ProcessImage {
  // from the bus
  config::Twice<std::uint16_t> control_word{0};  ///< 6040h
  config::Twice<std::uint16_t> reset_word{0};  ///< the 6040h since the last tick in which R rose; 0: in none
  config::Twice<ControlMode> control_mode{ControlMode::pressure_closed_loop};  ///< 6043h
  std::uint32_t parameter_set_code = 0;  ///< 6056h, the master's own mark
  std::uint32_t sync_count = 0;  ///< counts SYNCs taken while operational: the watchdog's food in excitation
  /// Goes on each time that every set-point PDO which has come in ACTIVE has come again, and where none has with each set point by
  /// SDO: the watchdog's food.
  std::uint32_t setpoint_count = 0;
  std::uint8_t setpoints_came = 0;  ///< bit c: that of chamber c was written since the last tick
  Flag setpoint_lost = false;   ///< the event timer of an RPDO (1400h:5) ran out while 6040h asks for ACTIVE
  Flag heartbeat_lost = false;  ///< a node of 1016h has fallen silent
  Flag pdo_short = false;     ///< within the last ten seconds a PDO has come that is shorter than its mapping
  Flag pdo_long = false;      ///< likewise one that is longer
  Flag sync_misfits = false;  ///< likewise a SYNC with a counter that 1019h does not allow, or without
  VolumeCode volume_code;
  config::Twice<std::uint8_t> preview_ticks{
      0};  ///< 2160h: a set point is to be met this many ticks after its SYNC
  // to the bus
  std::uint16_t status_word = 0;     ///< 6041h
  std::uint16_t error_code = 0;      ///< 604Eh, as in the emergency message
  std::uint8_t error_register = 0;   ///< 1001h
  std::uint8_t fault_chamber = 0;    ///< chamber of the error + 1; 0: the whole board
  StandingFaults standing_faults{};  ///< 2831h
  std::uint8_t must_vent = 0;        ///< chambers that a fault vents (bit c: chamber c)
  bool bus_off = false;              ///< the CAN controller has left the bus
  float supply_Pa = 0.0F;            ///< 2158h, mean over the tick just past
  std::uint32_t tick_count = 0;
  std::uint32_t overrun_count = 0;
  telemetry::LatencyHistogram latency;  ///< of the ticks since the start: 2200h, 2201h
  std::uint32_t scan_age_us = 0;        ///< of the newest scan of the analog inputs as the tick began
  std::uint32_t saturation_count = 0;   ///< results of fixed-point numbers that did not fit, since the start
  StoreImage store;                     ///< 2130h
  std::array<ChamberImage, config::kChambers> chamber{};

  friend bool operator==(const ProcessImage&, const ProcessImage&) noexcept = default;
};

}  // namespace plenum::canopen
