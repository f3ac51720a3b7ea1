// A parameter store whose power can be cut at any of its writes and syncs, and within a write at any byte.
//
// A write goes to a cache; a sync of its slot makes it durable. The cut leaves of each write that was not synced
// what survive() says: nothing, all, or a prefix; the write under way is one of them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <stdexcept>
#include <vector>

#include "firmware/config/parameter_record.hpp"
#include "firmware/config/record_store.hpp"
#include "firmware/ports/parameter_store.hpp"

namespace plenum::config {

using Bytes = std::vector<std::uint8_t>;
using Slots = std::array<Bytes, ports::ParameterStore::kSlots>;

class PowerCutMedium final : public ports::ParameterStore {
 public:
  static constexpr int kNever = -1;

  struct Write {
    std::uint8_t slot = 0;
    std::size_t offset = 0;
    Bytes bytes;
  };

  PowerCutMedium() : PowerCutMedium(blank()) {}
  explicit PowerCutMedium(Slots slots) : durable(std::move(slots)), seen_(durable) {}

  static Slots blank() { return {Bytes(kMaxSlotBytes), Bytes(kMaxSlotBytes)}; }

  bool read(std::uint8_t slot, std::size_t offset, std::span<std::uint8_t> bytes) noexcept override {
    if (off || unreadable.at(slot)) return false;
    std::copy_n(seen_.at(slot).begin() + static_cast<std::ptrdiff_t>(offset), bytes.size(), bytes.begin());
    return true;
  }
  ports::StoreResult write(std::uint8_t slot, std::size_t offset,
                           std::span<const std::uint8_t> bytes) noexcept override {
    const bool cut = begins_cut();
    if (off && !cut) return ports::StoreResult::failed;
    if (refuses) return ports::StoreResult::failed;
    if (wait()) return ports::StoreResult::busy;
    ++operations;
    unsynced.push_back({slot, offset, {bytes.begin(), bytes.end()}});
    if (cut) return ports::StoreResult::failed;
    apply(seen_, unsynced.back(), bytes.size());
    return ports::StoreResult::done;
  }
  ports::StoreResult sync(std::uint8_t slot) noexcept override {
    if (begins_cut() || off || refuses) return ports::StoreResult::failed;
    if (wait()) return ports::StoreResult::busy;
    ++operations;
    for (const Write& write : unsynced) {
      if (write.slot == slot) apply(durable, write, write.bytes.size());
    }
    std::erase_if(unsynced, [slot](const Write& write) { return write.slot == slot; });
    return ports::StoreResult::done;
  }

  /// What the slots hold after the cut, when of unsynced[i] the first kept[i] bytes have survived.
  Slots survive(std::span<const std::size_t> kept) const {
    Slots slots = durable;
    for (std::size_t i = 0; i < unsynced.size(); ++i) apply(slots, unsynced[i], kept[i]);
    return slots;
  }

  Slots durable;
  std::vector<Write> unsynced;
  std::array<bool, kSlots> unreadable{};
  int operations = 0;    ///< writes and syncs so far
  int cut_at = kNever;   ///< the operation during which the power goes
  bool off = false;      ///< it has gone
  bool refuses = false;  ///< no write or sync succeeds
  int patience = 0;      ///< how often each operation answers "busy" first

 private:
  bool begins_cut() noexcept {
    if (off || operations != cut_at) return false;
    off = true;
    return true;
  }
  bool wait() noexcept {
    waited_ = waited_ < patience ? waited_ + 1 : 0;
    return waited_ != 0;
  }
  static void apply(Slots& slots, const Write& write, std::size_t count) {
    std::copy_n(write.bytes.begin(), count,
                slots.at(write.slot).begin() + static_cast<std::ptrdiff_t>(write.offset));
  }

  Slots seen_;  ///< what a read gives while the power is on
  int waited_ = 0;
};

/// Every way in which the writes that a cut found unsynced may have come through: of each all, nothing, or half; and
/// of one of them every prefix, while the others are all there, or all gone.
inline void for_each_survival(const PowerCutMedium& cut, const std::function<void(const Slots&)>& check) {
  const std::size_t count = cut.unsynced.size();
  const auto size = [&](std::size_t i) { return cut.unsynced[i].bytes.size(); };
  std::size_t ways = 1;
  for (std::size_t i = 0; i < count; ++i) ways *= 3;
  std::vector<std::size_t> kept(count);
  for (std::size_t way = 0; way < ways; ++way) {
    for (std::size_t i = 0, rest = way; i < count; ++i, rest /= 3) kept[i] = size(i) * (rest % 3) / 2;
    check(cut.survive(kept));
  }
  for (std::size_t torn = 0; torn < count; ++torn) {
    for (const bool others : {false, true}) {
      for (std::size_t i = 0; i < count; ++i) kept[i] = others ? size(i) : 0;
      for (kept[torn] = 0; kept[torn] < size(torn); ++kept[torn]) check(cut.survive(kept));
    }
  }
}

/// Stores a body to its end.
inline ports::StoreResult store_all(RecordStore& store, std::span<const std::uint8_t> body) {
  store.begin(body);
  for (int i = 0; i < 10'000; ++i) {
    if (const auto result = store.step(); result != ports::StoreResult::busy) return result;
  }
  throw std::runtime_error("a store of 16 KiB in pieces of 512 bytes takes no 10,000 steps");
}

}  // namespace plenum::config
