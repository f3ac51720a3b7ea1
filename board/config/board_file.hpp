// board.toml: what an installer says of one board. service/board.toml is the commented example.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "board/config/toml_table.hpp"
#include "board/drivers/gpio_lines.hpp"
#include "board/drivers/iio_input.hpp"
#include "board/drivers/iio_output.hpp"
#include "firmware/controller.hpp"
#include "firmware/tick_timing.hpp"

namespace plenum::board::config {

/// What begins a tick.
enum class Pacing : std::uint8_t {
  adc,   ///< the scans of one tick have come; the timer stands in for an ADC that stalls
  timer  ///< the clock alone
};

struct RealTime {
  Pacing pacing = Pacing::adc;       ///< timer where the devices run freely
  int priority = 80;                 ///< of SCHED_FIFO, 1..98; 0: the ordinary scheduler
  std::optional<int> cpu{};          ///< the only processor to run on; empty: any
  Overrun overrun = Overrun::fault;  ///< what is made of one; the ticks between are left out in any case
  int guard_ticks = 5;               ///< without a tick for so long, the guard makes the outputs safe
};

struct BoardFile {
  std::string text;                              ///< as it was read
  std::string interface;                         ///< of CAN: "can0"
  std::optional<std::uint16_t> bit_rate_kbit{};  ///< of the bus, one of CiA 305; empty: LSS gives it
  std::string model_url;                         ///< of 6055h, empty unless stated
  drivers::IioInputConfig analog_in;
  drivers::IioOutputConfig analog_out;
  std::array<bool, plenum::config::kChambers>
      safe_V_stated{};  ///< safe_V is the file's, whatever the settings become
  drivers::GpioConfig gpio;
  std::filesystem::path store;  ///< folder of the parameter slots
  RealTime real_time;
  std::filesystem::path watchdog;  ///< of the hardware, "/dev/watchdog0"; empty: none
  Settings settings;               ///< have passed firmware/config's validate()
};

/// Throws ConfigError with the name `file`: of each table its first mistake at least, its unknown keys when all else is right.
BoardFile parse_board(std::string_view text, const std::string& file);

/// Throws ConfigError, also for a file that cannot be read.
BoardFile read_board(const std::filesystem::path& path);

}  // namespace plenum::board::config
