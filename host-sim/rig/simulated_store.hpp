// The parameter store of a simulated board: in memory, or in a folder of its own as slot-a.bin and slot-b.bin.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "firmware/ports/parameter_store.hpp"

namespace plenum::host::rig {

class SimulatedStore final : public plenum::ports::ParameterStore {
 public:
  /// With a folder, the slots are files in it, written in place and synced to the disk; both are made when they do not
  /// exist. Throws trace::InputError when they cannot be.
  explicit SimulatedStore(const std::optional<std::filesystem::path>& folder = std::nullopt);
  ~SimulatedStore();
  SimulatedStore(const SimulatedStore&) = delete;
  SimulatedStore& operator=(const SimulatedStore&) = delete;

  bool read(std::uint8_t slot, std::size_t offset, std::span<std::uint8_t> bytes) noexcept override;
  plenum::ports::StoreResult write(std::uint8_t slot, std::size_t offset,
                                   std::span<const std::uint8_t> bytes) noexcept override;
  plenum::ports::StoreResult sync(std::uint8_t slot) noexcept override;

 private:
  void close() noexcept;

  std::array<int, kSlots> file_{-1, -1};  ///< descriptors; -1: the slot lives in memory
  std::array<std::vector<std::uint8_t>, kSlots> memory_;
};

}  // namespace plenum::host::rig
