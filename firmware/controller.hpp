// The whole board as a pure step: readings and time in, commands out; frames in and out between the steps.
//
// Once a tick, by whoever owns the drivers (board/main.cpp, host-sim/rig):
//
//   receive() every frame that has come  ->  step(inputs)  ->  write the outputs  ->  send what next_frame()
//   yields
//
// receive() may also be called between ticks: SDO requests are answered at once. Neither waits, allocates or
// throws. All calls come from one thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/canopen/node.hpp"
#include "firmware/canopen/process_image.hpp"
#include "firmware/chamber_loop.hpp"
#include "firmware/config/chamber_settings.hpp"
#include "firmware/config/limits.hpp"
#include "firmware/config/parameter_slots.hpp"
#include "firmware/config/settings_desk.hpp"
#include "firmware/inverse_run.hpp"
#include "firmware/ports/analog.hpp"
#include "firmware/ports/can_bus.hpp"
#include "firmware/ports/digital_io.hpp"
#include "firmware/safety/faults.hpp"
#include "firmware/safety/monitors.hpp"
#include "firmware/safety/supervisor.hpp"
#include "firmware/shadow_run.hpp"
#include "firmware/telemetry/recorder.hpp"
#include "firmware/tick_timing.hpp"

namespace plenum {

/// What an installer sets. Board and chambers have a config::validate(); a controller is made of settings that
/// have passed it.
struct Settings {
  canopen::Config node;
  config::BoardSettings board;
  std::array<config::ChamberSettings, config::kChambers> chamber{};
  control::Regulator::Config regulator;
  /// The installer's were refused, and these, accepted before, stand in for them: a fault for as long as the board runs.
  bool configuration_refused = false;
};

/// What the drivers know at the start of a tick.
struct Inputs {
  std::array<ports::AnalogReading, config::kChambers> pressure{};
  std::array<ports::AnalogReading, config::kChambers> position{};
  ports::AnalogReading supply;
  ports::DigitalInputs digital;
  ports::CanState can = ports::CanState::error_active;
  bool frames_lost = false;      ///< frames found the receive queue full since the last tick
  bool outputs_ok = true;        ///< the last write reached every output
  TickTiming timing;             ///< of this tick
  bool stored_set_lost = false;  ///< in the first tick: the stored set, or a newer one, was found damaged
  bool store_failing = false;    ///< the parameter store refuses again and again
  bool configuration_refused = false;  ///< Settings::configuration_refused
};

/// What the drivers do until the next tick.
struct Outputs {
  std::array<float, config::kChambers> command_V{};
  ports::DigitalOutputs digital;
};

class Controller {
 public:
  explicit Controller(const Settings& settings) noexcept;
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  /// Before the first step: what would take long in one.
  void prepare() noexcept { node_.prepare(); }

  /// Before the first step: a model image from the parameter store. Refused images leave the chamber without
  /// a model.
  config::ImageVerdict restore(std::uint8_t chamber, std::span<const std::uint8_t> image) noexcept;

  /// One frame from the bus; bounded work.
  void receive(const ports::CanFrame& frame) noexcept { node_.receive(frame); }

  /// One tick.
  Outputs step(const Inputs& inputs) noexcept;

  /// The next frame to send. Returns false when there is none.
  bool next_frame(ports::CanFrame& frame) noexcept { return node_.next_frame(frame); }

  /// The values of the object dictionary, for the stored set.
  canopen::Node& node() noexcept { return node_; }
  const canopen::Node& node() const noexcept { return node_; }

  /// What 2130h shows from now on.
  void show_store(const canopen::StoreImage& store) noexcept { image_.store = store; }

  /// Chambers whose model has changed since the last call (bit c: chamber c): their active_image() is to be
  /// stored.
  std::uint8_t take_changed() noexcept;
  std::span<const std::uint8_t> active_image(std::uint8_t chamber) const noexcept {
    return slots_.active_image(chamber);
  }

  /// What the output of a chamber holds at rest [V], by the settings in force.
  float resting_V(std::size_t chamber) const noexcept { return chamber_[chamber].resting_V(); }

  const canopen::ProcessImage& image() const noexcept { return image_; }
  safety::State state() const noexcept { return supervisor_.state(); }

 private:
  void configure(std::uint8_t changed) noexcept;
  void take_over(std::uint8_t changed) noexcept;
  bool memory_upset() noexcept;
  safety::FaultReport judge(const Inputs& inputs, bool upset) noexcept;
  Outputs drive(safety::Drive drive, bool powered) noexcept;
  std::uint16_t regulation_bits() const noexcept;
  safety::Drive drive_of(std::size_t chamber, safety::Drive drive) const noexcept;
  void record(safety::Drive drive) noexcept;
  bool model_needed() const noexcept { return image_.control_mode != canopen::ControlMode::excitation; }

  control::Regulator::Config regulator_;
  std::uint64_t regulator_seal_;  ///< of regulator_
  config::SettingsDesk settings_;
  canopen::ProcessImage image_;
  telemetry::Recorder recorder_;
  InverseRun inverse_run_;
  ShadowRun shadow_run_;
  config::ParameterSlots slots_;
  canopen::Node node_;
  std::array<ChamberLoop, config::kChambers> chamber_;
  safety::BoardMonitor monitor_;
  safety::FaultRegister faults_;
  safety::Supervisor supervisor_;
  std::array<safety::SetpointNews, config::kChambers> setpoint_news_{};
  safety::Drive last_drive_ = safety::Drive::vent;
  std::uint8_t changed_ = 0;
  std::uint8_t damaged_ = 0;  ///< bit c: in what is constant of chamber c a bit has flipped
};

}  // namespace plenum
