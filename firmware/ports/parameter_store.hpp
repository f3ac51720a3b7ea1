// Where a board keeps its parameter set across power cycles: two slots of bytes, and no more sense than that.
// What stands in them, and how a set survives a power cut, is config::RecordStore's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace plenum::ports {

/// How a call to a slow medium ended.
enum class StoreResult : std::uint8_t {
  done,
  failed,
  busy  ///< under way: to be called again with the same arguments, whose bytes stay until then
};

/// Two slots that fail apart from each other (two files, two flash sectors). Each holds at least
/// config::kMaxSlotBytes. Before a sync a write may be lost, kept or torn by a power cut, in any order.
class ParameterStore {
 public:
  static constexpr std::uint8_t kSlots = 2;
  static constexpr std::size_t kMostBytes = 512;  ///< of a write

  /// Fills `bytes` from `offset` on; bytes that were never written read as 00h or FFh. Returns false when the
  /// slot cannot be read. Called before the first tick only, where it may take its time.
  virtual bool read(std::uint8_t slot, std::size_t offset, std::span<std::uint8_t> bytes) noexcept = 0;
  virtual StoreResult write(std::uint8_t slot, std::size_t offset,
                            std::span<const std::uint8_t> bytes) noexcept = 0;
  /// Done: every byte written to this slot survives a power cut from here on.
  virtual StoreResult sync(std::uint8_t slot) noexcept = 0;

 protected:
  ~ParameterStore() = default;
};

}  // namespace plenum::ports
