// What a node wants to say, until the bus takes it: the boot-up message, then four classes, served in the order emergency,
// heartbeat, PDO, SDO.
//
// No class can crowd out another. Emergencies, heartbeats and SDO responses stand in rings of fixed size; a
// TPDO has one slot of its own, where a newer value replaces the older one, so that PDOs never pile up behind
// a slow bus.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "firmware/canopen/objects.hpp"
#include "firmware/ports/can_bus.hpp"

namespace plenum::canopen {

template <std::size_t capacity>
class FrameRing {
 public:
  bool push(const ports::CanFrame& frame) noexcept {
    if (size_ == capacity) return false;
    frames_[(first_ + size_) % capacity] = frame;
    ++size_;
    return true;
  }
  bool pop(ports::CanFrame& frame) noexcept {
    if (size_ == 0) return false;
    frame = frames_[first_];
    first_ = (first_ + 1) % capacity;
    --size_;
    return true;
  }
  void clear() noexcept { size_ = 0; }

 private:
  std::array<ports::CanFrame, capacity> frames_{};
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

class TransmitQueue {
 public:
  bool push_boot_up(const ports::CanFrame& frame) noexcept { return boot_up_.push(frame); }
  bool push_emergency(const ports::CanFrame& frame) noexcept { return emergency_.push(frame); }
  bool push_heartbeat(const ports::CanFrame& frame) noexcept { return heartbeat_.push(frame); }
  bool push_sdo(const ports::CanFrame& frame) noexcept { return sdo_.push(frame); }

  /// Returns false when an older value of this TPDO was still waiting; the newer one stands in its place.
  bool put_pdo(std::size_t number, const ports::CanFrame& frame) noexcept {
    const std::uint32_t bit = std::uint32_t{1} << number;
    const bool was_free = (pdo_waiting_ & bit) == 0;
    pdo_[number] = frame;
    pdo_waiting_ |= bit;
    return was_free;
  }

  bool pop(ports::CanFrame& frame) noexcept {
    if (boot_up_.pop(frame) || emergency_.pop(frame) || heartbeat_.pop(frame)) return true;
    if (pdo_waiting_ != 0) {
      frame = pdo_[static_cast<std::size_t>(std::countr_zero(pdo_waiting_))];
      pdo_waiting_ &= pdo_waiting_ - 1;
      return true;
    }
    return sdo_.pop(frame);
  }

  void clear_pdos() noexcept { pdo_waiting_ = 0; }
  void clear() noexcept {
    boot_up_.clear();
    emergency_.clear();
    heartbeat_.clear();
    sdo_.clear();
    clear_pdos();
  }

 private:
  static_assert(kTpdos <= 32, "one bit of pdo_waiting_ each");
  FrameRing<1> boot_up_;
  FrameRing<8> emergency_;
  FrameRing<4> heartbeat_;
  FrameRing<8> sdo_;
  std::array<ports::CanFrame, kTpdos> pdo_{};
  std::uint32_t pdo_waiting_ = 0;
};

}  // namespace plenum::canopen
