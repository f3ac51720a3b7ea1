// A CAN interface that may go away and come again while the board runs: an adapter pulled out, a driver loaded anew.
//
// While it is away the bus counts as off, which the firmware makes a fault of, and every frame is refused. It counts as on
// again with the first frame that goes out or comes in: an interface that is there and down proves nothing.
#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <string>

#include "firmware/ports/can_bus.hpp"

namespace plenum::board {

/// `Interface` is a ports::CanBus with is_down() and descriptor(), as drivers::SocketCan is.
template <class Interface>
class ReopenedBus final : public ports::CanBus {
 public:
  /// Makes an interface, or throws a std::exception.
  using Open = std::function<std::unique_ptr<Interface>()>;

  static constexpr int kPause_ticks = 100;  ///< between two attempts to open it

  explicit ReopenedBus(Open open) : open_(std::move(open)) { on_ = reopen(); }

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

  /// Once a tick: opens an interface that has gone down anew, now and then.
  void tend() noexcept {
    if (interface_ != nullptr && !interface_->is_down()) {
      pause_ticks_ = 0;
      return;
    }
    on_ = false;
    if (++pause_ticks_ < kPause_ticks) return;
    pause_ticks_ = 0;
    reopen();
  }

  /// To wait on; another one after each opening. -1: there is no interface.
  int descriptor() const noexcept { return interface_ == nullptr ? -1 : interface_->descriptor(); }

  /// Why it could not be opened the last time; empty: it could.
  const std::string& trouble() const noexcept { return trouble_; }

 private:
  /// Allocates, and may throw and catch: only while there is no bus to serve.
  bool reopen() noexcept try {
    lost_before_ = lost();
    interface_.reset();
    interface_ = open_();
    trouble_.clear();
    return true;
  } catch (const std::exception& error) {
    trouble_ = error.what();
    return false;
  }

  Open open_;
  std::unique_ptr<Interface> interface_;
  bool on_ = false;  ///< a frame has gone out or come in since it was away, or it was never away
  int pause_ticks_ = 0;
  std::uint32_t lost_before_ = 0;  ///< by the interfaces before
  std::string trouble_;
};

}  // namespace plenum::board
