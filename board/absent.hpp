// What stands where a device could not be opened, so that the board can still be reached and says so: each makes a fault of
// the firmware.
#pragma once

#include <algorithm>

#include "firmware/ports/analog.hpp"
#include "firmware/ports/parameter_store.hpp"

namespace plenum::board::absent {

class Input final : public ports::AnalogInput {
 public:
  void read(std::span<ports::AnalogReading> readings) noexcept override {
    std::fill(readings.begin(), readings.end(), ports::AnalogReading{});
  }
};

class Store final : public ports::ParameterStore {
 public:
  bool read(std::uint8_t, std::size_t, std::span<std::uint8_t>) noexcept override { return false; }
  ports::StoreResult write(std::uint8_t, std::size_t, std::span<const std::uint8_t>) noexcept override {
    return ports::StoreResult::failed;
  }
  ports::StoreResult sync(std::uint8_t) noexcept override { return ports::StoreResult::failed; }
};

}  // namespace plenum::board::absent
