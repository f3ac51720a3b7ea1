// A CAN interface that may go away and come again while the board runs: an adapter pulled out, a driver loaded anew.
//
// While it is away the bus counts as off, which the firmware makes a fault of, and every frame is refused. It counts as on
// again with the first frame that goes out or comes in: an interface that is there and down proves nothing.
//
// Closing and opening wait for the kernel: for the lock of all network interfaces, which it holds while one of them comes up or
// goes, and for a module that it loads. So another thread does both, and the loop's goes on without a bus meanwhile.
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "firmware/ports/can_bus.hpp"

namespace plenum::board {

/// `Interface` is a ports::CanBus with is_down() and descriptor(), as drivers::SocketCan is.
template <class Interface>
class ReopenedBus final : public ports::CanBus {
 public:
  /// Makes an interface, or throws a std::exception.
  using Open = std::function<std::unique_ptr<Interface>()>;

  static constexpr int kPause_ticks = 100;  ///< between two attempts to open it

  /// Opens it: at the start no tick waits.
  explicit ReopenedBus(Open open) : open_(std::move(open)) {
    try {
      interface_ = open_();
      on_ = true;
    } catch (const std::exception& error) {
      trouble_ = error.what();
    }
  }

  bool send(const ports::CanFrame& frame) noexcept override {
    if (interface_ == nullptr || !interface_->send(frame)) return false;
    on_ = true;
    return true;
  }

  bool receive(ports::CanFrame& frame) noexcept override {
    if (interface_ == nullptr || !interface_->receive(frame)) return false;
    on_ = true;
    return true;
  }

  ports::CanState state() const noexcept override {
    return on_ && interface_ != nullptr && !interface_->is_down() ? interface_->state()
                                                                  : ports::CanState::bus_off;
  }

  std::uint32_t lost() const noexcept override {
    return lost_before_ + (interface_ == nullptr ? 0 : interface_->lost());
  }

  /// Once a tick. True, now and then while there is no interface that is up: open_anew() is to be called, once, by a thread that may
  /// wait. There is none until that has returned.
  bool tend() noexcept {
    if (elsewhere_.load(std::memory_order_acquire)) return false;
    if (handed_over_ != nullptr) interface_ = std::move(handed_over_);
    if (interface_ != nullptr && !interface_->is_down()) {
      pause_ticks_ = 0;
      return false;
    }
    on_ = false;
    if (++pause_ticks_ < kPause_ticks) return false;
    pause_ticks_ = 0;
    lost_before_ = lost();
    handed_over_ = std::move(interface_);
    elsewhere_.store(true, std::memory_order_release);
    return true;
  }

  /// Closes the interface that has gone down, and tries to open another. Does nothing that tend() has not asked for.
  void open_anew() noexcept {
    if (!elsewhere_.load(std::memory_order_acquire)) return;
    handed_over_.reset();
    try {
      handed_over_ = open_();
    } catch (const std::exception&) {  // it is tried again
    }
    elsewhere_.store(false, std::memory_order_release);
  }

  /// To wait on; another one after each opening. -1: there is no interface.
  int descriptor() const noexcept { return interface_ == nullptr ? -1 : interface_->descriptor(); }

  /// Why it could not be opened at the start; empty: it could.
  const std::string& trouble() const noexcept { return trouble_; }

 private:
  Open open_;
  std::unique_ptr<Interface> interface_;
  bool on_ = false;  ///< a frame has gone out or come in since it was away, or it was never away
  int pause_ticks_ = 0;
  std::uint32_t lost_before_ = 0;  ///< by the interfaces before
  std::string trouble_;
  std::atomic<bool> elsewhere_{false};  ///< the next is open_anew()'s, else tend()'s
  std::unique_ptr<Interface> handed_over_;
};

}  // namespace plenum::board
