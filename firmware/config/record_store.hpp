// One set of parameters in two slots: a power cut at any moment leaves the old set or the new one.
//
//   load(body)                 before the first tick: the newest slot that is whole
//   begin(body), step()...     the set goes into the other slot: body, sync, header, sync; one of these, or
//                              kPieceBytes of the body, a step
//
// The slot in force is never written. The header is what makes a slot the newest, it comes last, and both CRCs
// must agree: a slot whose writing was cut off is no set, whatever part of it arrived.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/config/parameter_record.hpp"
#include "firmware/ports/parameter_store.hpp"

namespace plenum::config {

enum class LoadResult : std::uint8_t {
  empty,      ///< nothing was ever stored
  good,       ///< the newest set
  fell_back,  ///< a whole set, but a slot is damaged that may have held a newer one
  lost        ///< something was stored, and nothing of it is whole
};

class RecordStore {
 public:
  static constexpr std::size_t kPieceBytes = 512;
  static_assert(kPieceBytes <= ports::ParameterStore::kMostBytes);

  /// The medium must outlive the store.
  explicit RecordStore(ports::ParameterStore& medium) noexcept : medium_(medium) {}

  struct Loaded {
    LoadResult result = LoadResult::empty;
    std::size_t size = 0;  ///< of the body; 0 unless good or fell_back
  };
  /// Reads both slots. `body` has kMaxBodyBytes.
  Loaded load(std::span<std::uint8_t> body) noexcept;

  /// Begins to store `body`, at most kMaxBodyBytes; it must stay as it is until step() has said done or failed.
  void begin(std::span<const std::uint8_t> body) noexcept;

  /// One bounded piece of work. `done`: the set is durable and in force. `failed`: the store is as if begin() had
  /// not been called, but that after the next start either set may stand.
  ports::StoreResult step() noexcept;

  /// Of the set in force; 0 before the first.
  std::uint32_t generation() const noexcept { return generation_; }

 private:
  enum class SlotState : std::uint8_t { blank, good, damaged, unreadable };
  enum class Phase : std::uint8_t { body, sync_body, header, sync_header };
  struct Slot {
    SlotState state = SlotState::blank;
    RecordHeader header;
  };

  void read_header(std::uint8_t slot) noexcept;
  bool read_body(std::uint8_t slot, std::span<std::uint8_t> body) noexcept;
  std::uint8_t target() const noexcept;
  ports::StoreResult advance() noexcept;

  static constexpr std::uint8_t kNone = ports::ParameterStore::kSlots;

  ports::ParameterStore& medium_;
  std::array<Slot, ports::ParameterStore::kSlots> slot_{};
  std::uint8_t in_force_ = kNone;
  std::uint32_t generation_ = 0;
  std::uint32_t newest_ = 0;  ///< of every header that was read, its body whole or not

  std::span<const std::uint8_t> body_;
  Phase phase_ = Phase::body;
  std::uint8_t to_ = kNone;  ///< kNone: no slot can be written without risk to a set
  std::size_t written_ = 0;
  RecordHeader header_;
  HeaderBytes header_bytes_{};
};

}  // namespace plenum::config
