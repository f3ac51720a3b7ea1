#include "board/rt/watchdog.hpp"

#include <fcntl.h>
#include <linux/watchdog.h>
#include <sys/ioctl.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace plenum::board::rt {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;
constexpr std::uint64_t kFeedings = 3;  // in the time allowed

std::uint64_t interval_ns() noexcept {
  std::uint64_t allowed_us = 0;
  return ::sd_watchdog_enabled(0, &allowed_us) > 0 ? allowed_us * 1000 / kFeedings : 0;
}

/// kTimeout_s, or what the driver has instead; 0: it says none, and errno why.
int timeout_of(int watchdog) noexcept {
  int timeout_s = HardwareWatchdog::kTimeout_s;
  if (::ioctl(watchdog, WDIOC_SETTIMEOUT, &timeout_s) == 0) return timeout_s;
  return ::ioctl(watchdog, WDIOC_GETTIMEOUT, &timeout_s) == 0 ? timeout_s : 0;
}

}  // namespace

ServiceManager::ServiceManager() noexcept : feeding_(interval_ns()) {}

void ServiceManager::ticked(std::uint64_t now_ns, std::uint32_t tick_count) noexcept {
  if (!ready_) {
    ready_ = true;
    ::sd_notify(0, "READY=1");
  }
  if (feeding_.due(now_ns, tick_count)) ::sd_notify(0, "WATCHDOG=1");
}

void ServiceManager::stopping() noexcept {
  ::sd_notify(0, "STOPPING=1");
}

HardwareWatchdog::HardwareWatchdog(const std::filesystem::path& device) : device_(device.string()) {
  if (device.empty()) return;
  file_ = ::open(device.c_str(), O_WRONLY | O_CLOEXEC);
  if (file_ >= 0) timeout_s_ = timeout_of(file_);
  if (timeout_s_ > 0) {
    feeding_ = FeedingTime(static_cast<std::uint64_t>(timeout_s_) * kSecond_ns / kFeedings);
    return;
  }
  const std::string found = std::strerror(errno);
  if (file_ >= 0) {
    (void)!::write(file_, "V", 1);
    ::close(file_);
  }
  throw std::runtime_error(device_ + ": " + found + ", expected a watchdog that takes " +
                           std::to_string(kTimeout_s) + " s");
}

HardwareWatchdog::~HardwareWatchdog() {
  if (file_ < 0) return;
  (void)!::write(file_, "V", 1);  // the magic that disarms it
  ::close(file_);
}

std::string HardwareWatchdog::trouble() const {
  if (file_ < 0 || timeout_s_ == kTimeout_s) return {};
  return device_ + ": resets the machine after " + std::to_string(timeout_s_) +
         " s without a tick, expected " + std::to_string(kTimeout_s);
}

void HardwareWatchdog::ticked(std::uint64_t now_ns, std::uint32_t tick_count) noexcept {
  if (feeding_.due(now_ns, tick_count)) (void)!::write(file_, "\0", 1);
}

}  // namespace plenum::board::rt
