// Whether the converters of the pressures reach what is to trip. Above its end a converter says the same for every pressure: the
// firmware then takes it for none (ports::AnalogReading::at_end), but over_pressure_kPa never comes.
#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

#include "board/config/board_file.hpp"
#include "board/drivers/iio_input.hpp"

namespace plenum::board {

/// A line for each converter that ends at or below its chamber's over_pressure_kPa, by the installer's settings.
/// `opened`: what of the board's inputs `input` has open.
inline std::vector<std::string> short_ranges(const config::BoardFile& board,
                                             const drivers::IioInputConfig& opened,
                                             const drivers::IioInput& input) {
  std::vector<std::string> lines;
  for (std::size_t c = 0; c < plenum::config::kChambers; ++c) {
    const plenum::config::ChamberSettings& settings = board.settings.chamber[c];
    const drivers::IioChannel& channel = opened.channels[c];
    if (!settings.in_use || !channel.fitted()) continue;
    const auto end_V = static_cast<float>(input.end_V(c));
    const float end_kPa = pressure_kPa(settings, end_V);
    if (!(end_kPa > settings.over_pressure_kPa)) {
      lines.push_back(
          fmt::format("iio:{}: its range ends at {:.3f} V, {:.1f} kPa, expected more than over_pressure_kPa "
                      "= {} of chamber {} "
                      "(analog_input.scale_mV chooses the range)",
                      channel.where(), end_V, end_kPa, settings.over_pressure_kPa, c + 1));
    }
  }
  return lines;
}

}  // namespace plenum::board
