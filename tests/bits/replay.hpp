// A controller that is shown what was recorded, tick by tick and frame by frame, and a digest of what it answers.
//
// A recording is text, a line an event in the order in which they came:
//   F ID BYTES                    a frame from the bus, in hexadecimal
//   T FLAGS STALE READINGS        a tick: flags (Flag), which readings did not come (bit i: reading i), and all kReadings of
//                                 them in hexadecimal, of 16 bits each, one bit 10 V / 2^15: exact in single precision
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "firmware/config/crc32.hpp"
#include "firmware/controller.hpp"

namespace plenum::bits {

inline constexpr std::size_t kReadings = 2 * config::kChambers + 1;  ///< pressures, positions, supply
inline constexpr float kReadingLsb_V = 10.0F / 32768.0F;
inline constexpr std::uint8_t kNode = 1;

enum Flag : std::uint32_t {
  kEmergencyStop = 1,
  kLate = 2,
  kOutputsRefused = 4,
  kFramesLost = 8,
  kCanPassive = 16,
  kBusOff = 32
};

struct Tick {
  std::uint32_t flags = 0;
  std::uint32_t stale = 0;
  std::array<std::uint16_t, kReadings> reading{};
};

/// What the recorded board was set to: sensors of 0 to 1000 kPa and 0 to 400 mL.
inline Settings settings() {
  Settings settings;
  settings.node.node_id = kNode;
  settings.board.supply_low_kPa = 500.0F;
  for (config::ChamberSettings& chamber : settings.chamber) {
    chamber.volume_gain_mL_per_V = 40.0F;
    chamber.volume_offset_mL = 0.0F;
    chamber.over_pressure_kPa = 800.0F;
    chamber.pressure_high_kPa = 700.0F;
  }
  return settings;
}

class Replay {
 public:
  /// CRC-32 of each chamber's commands as they lie in memory, and of the frames sent.
  using Digest = std::array<std::uint32_t, config::kChambers + 1>;

  Replay() { controller_.prepare(); }

  void receive(const ports::CanFrame& frame) {
    controller_.receive(frame);
    take_sent();
  }

  Outputs step(const Tick& tick) {
    Inputs inputs;
    for (std::size_t c = 0; c < config::kChambers; ++c) {
      inputs.pressure[c] = reading(tick, c);
      inputs.position[c] = reading(tick, config::kChambers + c);
    }
    inputs.supply = reading(tick, 2 * config::kChambers);
    inputs.digital.emergency_stop = (tick.flags & kEmergencyStop) != 0;
    inputs.timing.overrun = (tick.flags & kLate) != 0 ? Overrun::fault : Overrun::none;
    inputs.outputs_ok = (tick.flags & kOutputsRefused) == 0;
    inputs.frames_lost = (tick.flags & kFramesLost) != 0;
    inputs.can = (tick.flags & kBusOff) != 0       ? ports::CanState::bus_off
                 : (tick.flags & kCanPassive) != 0 ? ports::CanState::error_passive
                                                   : ports::CanState::error_active;
    const Outputs outputs = controller_.step(inputs);
    for (std::size_t c = 0; c < config::kChambers; ++c)
      add(digest_[c], std::bit_cast<std::uint32_t>(outputs.command_V[c]), 4);
    take_sent();
    return outputs;
  }

  /// What the controller has sent since the last call.
  std::vector<ports::CanFrame> sent() { return std::exchange(sent_, {}); }

  const Digest& digest() const { return digest_; }
  const Controller& controller() const { return controller_; }

 private:
  static ports::AnalogReading reading(const Tick& tick, std::size_t i) {
    if ((tick.stale >> i & 1U) != 0) return {};
    return {.mean_V = static_cast<float>(static_cast<std::int16_t>(tick.reading[i])) * kReadingLsb_V,
            .fresh = true};
  }

  static void add(std::uint32_t& crc, std::uint32_t value, unsigned bytes) {
    for (unsigned i = 0; i < bytes; ++i) {
      const std::array<std::uint8_t, 1> byte = {static_cast<std::uint8_t>(value >> (8 * i))};
      crc = config::crc32(byte, crc);
    }
  }

  void take_sent() {
    ports::CanFrame frame;
    while (controller_.next_frame(frame)) {
      add(digest_.back(), frame.id, 4);
      add(digest_.back(), frame.length, 1);
      for (const std::uint8_t byte : frame.data) add(digest_.back(), byte, 1);
      sent_.push_back(frame);
    }
  }

  Controller controller_{settings()};
  Digest digest_{};
  std::vector<ports::CanFrame> sent_;
};

}  // namespace plenum::bits
