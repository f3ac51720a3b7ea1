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
  /// With a folder, the slots are files in it, written in place and synced to the disk; the folder is made when it does
  /// not exist, a slot when it is written first. Throws trace::InputError when they cannot be, and while another program has this store.
  explicit SimulatedStore(const std::optional<std::filesystem::path>& folder = std::nullopt);
  ~SimulatedStore();
  SimulatedStore(const SimulatedStore&) = delete;
  SimulatedStore& operator=(const SimulatedStore&) = delete;

  bool read(std::uint8_t slot, std::size_t offset, std::span<std::uint8_t> bytes) noexcept override;
  plenum::ports::StoreResult write(std::uint8_t slot, std::size_t offset,
                                   std::span<const std::uint8_t> bytes) noexcept override;
  plenum::ports::StoreResult sync(std::uint8_t slot) noexcept override;

 private:
  bool open(std::uint8_t slot, int flags) noexcept;
  void close() noexcept;

  std::optional<std::filesystem::path> folder_;
  int held_ = -1;                                         ///< the folder
  std::array<int, kSlots> file_{-1, -1};                  ///< descriptors; -1: no such file yet
  std::array<std::vector<std::uint8_t>, kSlots> memory_;  ///< without a folder
};

}  // namespace plenum::host::rig
