// Where a board keeps its parameter sets across power cycles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace plenum::ports {

/// Numbered records of bytes. A store replaces a record whole or not at all.
class ParameterStore {
 public:
  /// Copies record `id` into `bytes`. Returns its size; 0 when there is none or it does not fit.
  virtual std::size_t load(std::uint8_t id, std::span<std::uint8_t> bytes) noexcept = 0;
  /// Replaces record `id`. Returns false, keeping the old record, when it could not be made durable.
  virtual bool store(std::uint8_t id, std::span<const std::uint8_t> bytes) noexcept = 0;

 protected:
  ~ParameterStore() = default;
};

}  // namespace plenum::ports
