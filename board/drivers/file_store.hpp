// The parameter store of a board: two files in a folder, slot-a.bin and slot-b.bin, written in place.
//
// A disk may take hundreds of milliseconds for a write or a sync, so neither is done by the caller: one worker thread does
// them, one at a time, and the caller asks again each tick. Nothing here locks: the tick waits for nobody.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "board/drivers/worker.hpp"
#include "firmware/ports/parameter_store.hpp"

namespace plenum::board::drivers {

class FileStore final : public ports::ParameterStore {
 public:
  /// Opens the slots, and makes those that do not exist. The folder must exist, and no other program hold it. Throws std::runtime_error: which file, what
  /// was found, what was expected.
  explicit FileStore(const std::filesystem::path& folder);
  /// Throws as opening would, as far as looking tells. Opens and makes nothing.
  static void look(const std::filesystem::path& folder);
  /// Waits for the order under way, which on a failing disk may take long: make the outputs safe before.
  ~FileStore();
  FileStore(const FileStore&) = delete;
  FileStore& operator=(const FileStore&) = delete;

  bool read(std::uint8_t slot, std::size_t offset, std::span<std::uint8_t> bytes) noexcept override;
  /// Busy from the first call on until the worker is done; the call after that says how it ended. An order with other
  /// arguments than the one under way is taken up when that one has ended.
  ports::StoreResult write(std::uint8_t slot, std::size_t offset,
                           std::span<const std::uint8_t> bytes) noexcept override;
  ports::StoreResult sync(std::uint8_t slot) noexcept override;

 private:
  enum class Kind : std::uint8_t { write, sync };
  struct Order {
    Kind kind = Kind::write;
    std::uint8_t slot = 0;
    std::size_t offset = 0;
    std::span<const std::uint8_t> bytes;  ///< says which order it is, and is not read again

    bool operator==(const Order& other) const noexcept;
  };

  void close() noexcept;
  ports::StoreResult ask(const Order& order) noexcept;
  bool carry_out() const noexcept;
  void work() noexcept;

  enum class State : std::uint8_t { idle, ordered, done, failed };

  std::array<int, kSlots> file_{-1, -1};
  int held_ = -1;  ///< the folder
  Order order_;    ///< these two the worker's while `ordered`, the caller's otherwise
  std::array<std::uint8_t, kMostBytes> bytes_{};  ///< of the order: the worker may outlive whoever gave it
  std::atomic<State> state_{State::idle};
  std::optional<Worker> worker_;
};

}  // namespace plenum::board::drivers
