// The devices of a board as board.toml names them, opened, and what the loop asks of them.
#pragma once

#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "board/absent.hpp"
#include "board/config/board_file.hpp"
#include "board/drivers/file_store.hpp"
#include "board/drivers/gpio_lines.hpp"
#include "board/drivers/iio_input.hpp"
#include "board/drivers/iio_output.hpp"
#include "board/drivers/socketcan.hpp"
#include "board/drivers/worker.hpp"
#include "board/guard.hpp"
#include "board/plenumd.hpp"
#include "board/prompt_stop.hpp"
#include "board/reopened_bus.hpp"
#include "board/resting_volts.hpp"
#include "board/rt/events.hpp"
#include "board/rt/watchdog.hpp"

namespace plenum::board {

/// What moves the valves. The lines come first: they need no bus that could stand still.
class ValveOutputs final : public SafeOutputs {
 public:
  /// Both must outlive it.
  ValveOutputs(ports::DigitalIo& lines, drivers::IioOutput& output) noexcept
      : lines_(lines), output_(output) {}

  void make_safe() noexcept override {
    lines_.write({});
    output_.make_safe();
  }

 private:
  ports::DigitalIo& lines_;
  drivers::IioOutput& output_;
};

class LinuxHardware final : public Hardware {
 public:
  /// Opens everything; until `latest`, devices are waited for that the kernel may not have found yet. One that cannot be opened
  /// is absent from then on: the board runs, says so on the bus, and regulates nothing, but has at hand and keeps safe the
  /// lines and outputs that there are. Throws std::runtime_error only for what the kernel itself refuses, and for the guard.
  LinuxHardware(const config::BoardFile& board, std::chrono::steady_clock::time_point latest);

  /// What could not be opened, or will not do, a line each: what, where, expected.
  const std::vector<std::string>& troubles() const noexcept { return troubles_; }

  Drivers drivers() noexcept;
  rt::Events& events() noexcept { return *events_; }

  void begin() noexcept override;
  bool gather() noexcept override;
  bool scans_ready() const noexcept override;
  void look_at_stop() noexcept override { stop_.look(); }
  bool guarded() const noexcept override { return guard_.stands(); }
  void ticked(std::uint64_t now_ns, std::uint32_t tick_count) noexcept override;
  void make_safe() noexcept override;
  void rest_at(std::size_t chamber, float command_V) noexcept override;
  void stopping() noexcept override { manager_.stopping(); }

 private:
  /// As a whole, or, from `latest` on, without what is missing of it.
  template <class Driver, class Config>
  Driver opened(const Config& config, std::chrono::steady_clock::time_point latest);
  template <class Driver, class Config>
  void open(std::optional<Driver>& driver, const Config& config,
            std::chrono::steady_clock::time_point latest);

  std::vector<std::string> troubles_;
  absent::Input no_input_;
  absent::Store no_store_;
  std::array<bool, plenum::config::kChambers> rest_stated_;  ///< and no setting changes it
  RestingVolts resting_;
  drivers::GpioLines lines_;
  drivers::IioOutput output_;
  PromptStop stop_;
  ValveOutputs valves_;
  Guard guard_;  // has open what stands above it, and nothing of what stands below
  std::optional<drivers::IioInput> input_;
  std::optional<drivers::FileStore> store_;
  ReopenedBus<drivers::SocketCan> bus_;
  drivers::Worker opener_{[this] { bus_.open_anew(); }};
  std::optional<rt::KernelEvents> events_;
  rt::ServiceManager manager_;
  std::optional<rt::HardwareWatchdog> watchdog_;
};

}  // namespace plenum::board
