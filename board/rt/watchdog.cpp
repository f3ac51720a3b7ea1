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

HardwareWatchdog::HardwareWatchdog(const std::filesystem::path& device)
    : feeding_(device.empty() ? 0 : kTimeout_s * kSecond_ns / kFeedings) {
  if (device.empty()) return;
  file_ = ::open(device.c_str(), O_WRONLY | O_CLOEXEC);
  int timeout_s = kTimeout_s;
  if (file_ >= 0 && ::ioctl(file_, WDIOC_SETTIMEOUT, &timeout_s) == 0) return;
  const std::string found = std::strerror(errno);
  if (file_ >= 0) {
    (void)!::write(file_, "V", 1);
    ::close(file_);
  }
  throw std::runtime_error(device.string() + ": " + found + ", expected a watchdog that takes " +
                           std::to_string(kTimeout_s) + " s");
}

HardwareWatchdog::~HardwareWatchdog() {
  if (file_ < 0) return;
  (void)!::write(file_, "V", 1);  // the magic that disarms it
  ::close(file_);
}

void HardwareWatchdog::ticked(std::uint64_t now_ns, std::uint32_t tick_count) noexcept {
  if (feeding_.due(now_ns, tick_count)) (void)!::write(file_, "\0", 1);
}

}  // namespace plenum::board::rt
