#include "host-sim/client/can_link.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "board/drivers/can_bit_rate.hpp"

namespace plenum::host::client {
namespace {

constexpr double kRetry_s = 0.001;  ///< a device's queue that has room again wakes nobody: it is asked

}  // namespace

CanLink::CanLink(const std::string& interface) : interface_(interface), can_(interface) {}

double CanLink::now_s() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

std::optional<std::uint64_t> CanLink::stamp_us() const {
  const std::uint64_t received_ns = can_.received_ns();
  return received_ns == 0 ? std::nullopt : std::optional(received_ns / 1000);
}

std::optional<std::uint32_t> CanLink::bit_rate() const {
  const auto interface = board::drivers::can_interface(interface_);
  return interface ? interface->bit_rate : std::nullopt;
}

void CanLink::send(const CanFrame& frame) {
  unsent_.push_back(frame);
  flush();
  if (unsent_.size() > kUnsent) {
    throw std::runtime_error(fmt::format(
        "can:{}: {} frames wait, expected another node that acknowledges them", interface_, unsent_.size()));
  }
}

std::optional<CanFrame> CanLink::receive(double timeout_s) {
  const double until_s = now_s() + timeout_s;
  while (true) {
    flush();
    CanFrame frame;
    if (can_.receive(frame)) return frame;
    if (can_.is_down())
      throw std::runtime_error(fmt::format("can:{}: the interface is down, expected it up", interface_));
    const double left_s = std::max(until_s - now_s(), 0.0);
    if (left_s == 0.0) return std::nullopt;
    const double wait_s = unsent_.empty() ? left_s : std::min(left_s, kRetry_s);
    const timespec time{static_cast<time_t>(wait_s), static_cast<long>((wait_s - std::floor(wait_s)) * 1e9)};
    pollfd waiting{can_.descriptor(), POLLIN, 0};
    ::ppoll(&waiting, 1, &time, nullptr);
  }
}

void CanLink::flush() {
  while (!unsent_.empty() && can_.send(unsent_.front())) unsent_.pop_front();
}

}  // namespace plenum::host::client
