// A staged model against the one in force, over the log that the board has of the chamber.
//
// Both predict the recorded pressure from the recorded commands and volumes, running free, and begin anew from the
// measured pressure every 0.2 s: long enough that an error of the model adds up, short enough that what the model leaves
// out does not drown it. (Measured on the simulated MPYE valve, models fitted to a capture: their RMS error grows from 2 kPa
// over one tick to 31 over 0.2 s and 54 over 0.5 s. A rate that is 30 % low raises it by 20 and 7 % over 0.2 s in the two
// channels, by 7 and 4 % over 0.5 s; one that is 40 % high by 13 and 33 %, where a single tick shows 1 % in the first.)
//
//   start        p = (mean of the tick before the row + mean of the tick after it) / 2: what the pressure was between
//                (a sensor that lags shows that; the pressure is ahead of it by the lag)
//   each tick    commands as the valve answers them (ValvePath, SentCommands: as in the regulator); volume and its rate
//                from this row's and the next. After a gap as many rows are left out as a valve is late.
//   error        predicted minus measured mean of the tick
//
// The staged model is `worse` when its RMS error exceeds both 1.05 times that of the active one and that plus
// kNoise_kPa. 5 %: the RMS of the fifty or so stretches of a log scatters by 10 % for one model (1 / sqrt(2 n)); two
// models share their inputs and their noise, and differ by far less of that. kNoise_kPa: twice the noise of a pressure
// sensor (0.1 kPa), which is in the start and in the comparison.
// `not_compared`: fewer than kLeastMoved stretches in which the pressure moves by ten times that noise (RMS about where
// the stretch began): what holds still is predicted by every model.
//
// Cost: kRowsPerTick rows of one chamber a tick, some 24,000 instructions (callgrind, x86-64) besides what a tick costs;
// a full log of one chamber takes kLogTicks / kRowsPerTick = 32 ticks, chambers one after the other.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/config/limits.hpp"
#include "firmware/config/parameter_slots.hpp"
#include "firmware/control/any_model.hpp"
#include "firmware/control/model_paths.hpp"
#include "firmware/control/pressure_model.hpp"
#include "firmware/control/sensor_lag.hpp"
#include "firmware/control/sent_commands.hpp"
#include "firmware/control/supply_line.hpp"
#include "firmware/telemetry/recorder.hpp"

namespace plenum {

class ShadowRun final : public config::ModelTrial {
 public:
  static constexpr std::uint32_t kRowsPerTick = 32;
  static constexpr std::uint32_t kStretchTicks = 20;
  static constexpr std::uint32_t kLeastMoved = 10;
  static constexpr float kNoise_kPa = 0.2F;
  static constexpr float kMoved_kPa = 10.0F * kNoise_kPa;
  static constexpr float kWorse = 1.05F;

  /// `valve_delay_ticks`: for a model that leaves it out, as in the regulator. The recorder must outlive the run.
  ShadowRun(const telemetry::Recorder& recorder, numeric::Scalar valve_delay_ticks) noexcept
      : recorder_(recorder), delay_ticks_(valve_delay_ticks) {}

  bool begin(std::uint8_t chamber) noexcept override;

  /// One tick: compares on, and judges in `slots` what is done.
  void step(config::ParameterSlots& slots) noexcept;

 private:
  static constexpr std::size_t kNobody = config::kChambers;

  /// What the log says of one tick.
  struct Tick {
    float before_V;  ///< the command of the tick before
    float command_V;
    control::ChamberMotion motion;
    float mean_kPa;  ///< measured
  };

  /// One model on its way through a stretch, and its error over all of them.
  struct Runner {
    control::AnyModel known;
    control::ValvePath valve;
    control::SentCommands sent;
    control::SensorLag sensor;
    control::SupplyLine line;
    numeric::Scalar sensor_lag_ticks = 0;
    numeric::Scalar pressure_kPa = 0;
    float squares = 0.0F;

    void take(const config::ModelParameters& parameters, numeric::Scalar delay_ticks) noexcept;
    /// `command_V` has been sent for long.
    void rest(float command_V) noexcept;
    void send(float command_V) noexcept { sent.push({.model_V = valve.sent(command_V)}); }
    /// The sensor shows `shown_kPa`, which rises by `rise_kPa` a tick.
    void start(float shown_kPa, float rise_kPa) noexcept;
    /// Over a tick whose command was sent.
    void advance(const Tick& tick) noexcept;
    float rms_kPa(std::uint32_t ticks) const noexcept;
  };

  void start(std::size_t chamber, const config::ParameterSlots& slots) noexcept;
  bool take_row() noexcept;
  void follow(const Tick& tick, float mean_before_kPa) noexcept;
  void compare(const Tick& tick, float mean_before_kPa) noexcept;
  Tick tick_from(std::uint32_t number) const noexcept;
  config::TrialResult result() const noexcept;

  const telemetry::Recorder& recorder_;
  numeric::Scalar delay_ticks_;
  std::uint8_t waiting_ = 0;  ///< mask of chambers
  std::size_t chamber_ = kNobody;
  Runner staged_;
  Runner active_;
  std::uint32_t next_ = 0;  ///< number of the row that is taken next
  std::uint32_t end_ = 0;
  std::size_t followed_ = 0;         ///< rows without a gap before the next one
  std::uint32_t stretch_ticks_ = 0;  ///< done of the stretch; 0: it begins with the next row
  float start_kPa_ = 0.0F;
  float moved_squares_ = 0.0F;
  std::uint32_t moved_ = 0;  ///< stretches in which the pressure moved
  std::uint32_t ticks_ = 0;  ///< compared
};

}  // namespace plenum
