#include "firmware/config/record_store.hpp"

#include <algorithm>

#include "firmware/config/crc32.hpp"

namespace plenum::config {

using ports::StoreResult;

void RecordStore::read_header(std::uint8_t slot) noexcept {
  Slot& of = slot_[slot];
  HeaderBytes bytes{};
  if (!medium_.read(slot, 0, bytes)) {
    of.state = SlotState::unreadable;
    return;
  }
  switch (decode_header(bytes, of.header)) {
    case HeaderState::blank:
      of.state = SlotState::blank;
      break;
    case HeaderState::good:
      of.state = SlotState::good;
      break;
    case HeaderState::damaged:
      of.state = SlotState::damaged;
      break;
  }
}

bool RecordStore::read_body(std::uint8_t slot, std::span<std::uint8_t> body) noexcept {
  Slot& of = slot_[slot];
  const std::span<std::uint8_t> bytes = body.first(of.header.length);
  if (!medium_.read(slot, kRecordHeaderBytes, bytes)) {
    of.state = SlotState::unreadable;
  } else if (crc32(bytes) != of.header.body_crc) {
    of.state = SlotState::damaged;
  }
  return of.state == SlotState::good;
}

RecordStore::Loaded RecordStore::load(std::span<std::uint8_t> body) noexcept {
  read_header(0);
  read_header(1);
  // A slot cut off while it was overwritten still has its old header: it is known to be the older one.
  bool loss = false;
  for (const Slot& slot : slot_) {
    loss = loss || slot.state == SlotState::damaged || slot.state == SlotState::unreadable;
  }
  const bool both = slot_[0].state == SlotState::good && slot_[1].state == SlotState::good;
  const bool second_first = both ? is_newer(slot_[1].header.generation, slot_[0].header.generation)
                                 : slot_[1].state == SlotState::good;
  const std::uint8_t first = second_first ? 1 : 0;
  newest_ = slot_[first].header.generation;
  for (const std::uint8_t slot : {first, static_cast<std::uint8_t>(1 - first)}) {
    if (slot_[slot].state != SlotState::good) continue;
    if (read_body(slot, body)) {
      in_force_ = slot;
      generation_ = slot_[slot].header.generation;
      return {loss ? LoadResult::fell_back : LoadResult::good, slot_[slot].header.length};
    }
    loss = true;
  }
  return {loss ? LoadResult::lost : LoadResult::empty, 0};
}

/// Where a set can be written so that the one in force stays, and none that cannot be read now can turn up later
/// as the newest.
std::uint8_t RecordStore::target() const noexcept {
  if (in_force_ != kNone) return static_cast<std::uint8_t>(1 - in_force_);
  const bool first = slot_[0].state == SlotState::unreadable;
  const bool second = slot_[1].state == SlotState::unreadable;
  if (first && second) return kNone;
  return second ? 1 : 0;
}

void RecordStore::begin(std::span<const std::uint8_t> body) noexcept {
  body_ = body;
  phase_ = Phase::body;
  to_ = target();
  written_ = 0;
  header_ = {
      .generation = newest_ + 1, .length = static_cast<std::uint32_t>(body.size()), .body_crc = crc32(body)};
  header_bytes_ = encode_header(header_);
}

StoreResult RecordStore::step() noexcept {
  const StoreResult result = to_ == kNone ? StoreResult::failed : advance();
  if (result != StoreResult::done) return result;
  switch (phase_) {
    case Phase::body:
      if (written_ == body_.size()) phase_ = Phase::sync_body;
      return StoreResult::busy;
    case Phase::sync_body:
      phase_ = Phase::header;
      return StoreResult::busy;
    case Phase::header:
      phase_ = Phase::sync_header;
      return StoreResult::busy;
    case Phase::sync_header:
      break;
  }
  slot_[to_] = {SlotState::good, header_};
  in_force_ = to_;
  generation_ = newest_ = header_.generation;
  return StoreResult::done;
}

StoreResult RecordStore::advance() noexcept {
  if (phase_ == Phase::header) return medium_.write(to_, 0, header_bytes_);
  if (phase_ != Phase::body) return medium_.sync(to_);
  const auto piece = body_.subspan(written_, std::min(kPieceBytes, body_.size() - written_));
  const StoreResult result = medium_.write(to_, kRecordHeaderBytes + written_, piece);
  if (result == StoreResult::done) written_ += piece.size();
  return result;
}

}  // namespace plenum::config
