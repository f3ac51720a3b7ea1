#include "board/rt/watchdog.hpp"

#include <fcntl.h>
#include <linux/watchdog.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <stdexcept>

#include "board/environment.hpp"

namespace plenum::board::rt {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;
constexpr std::uint64_t kFeedings = 3;  // in the time allowed

/// 0: none.
std::uint64_t number(std::string_view text) noexcept {
  std::uint64_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

/// As sd_watchdog_enabled(3) has it: what is allowed to another process is not this one's.
std::uint64_t interval_ns() noexcept {
  const std::string_view process = environment("WATCHDOG_PID");
  if (!process.empty() && number(process) != static_cast<std::uint64_t>(::getpid())) return 0;
  return number(environment("WATCHDOG_USEC")) * 1000 / kFeedings;
}

/// kTimeout_s, or what the driver has instead; 0: it says none, and errno why.
int timeout_of(int watchdog) noexcept {
  int timeout_s = HardwareWatchdog::kTimeout_s;
  if (::ioctl(watchdog, WDIOC_SETTIMEOUT, &timeout_s) == 0) return timeout_s;
  return ::ioctl(watchdog, WDIOC_GETTIMEOUT, &timeout_s) == 0 ? timeout_s : 0;
}

}  // namespace

ServiceManager::ServiceManager() noexcept : feeding_(interval_ns()) {
  const std::string_view name = environment("NOTIFY_SOCKET");
  if (name.empty() || name.size() >= sizeof address_.sun_path) return;
  address_.sun_family = AF_UNIX;
  name.copy(address_.sun_path, name.size());
  if (name[0] == '@') address_.sun_path[0] = '\0';  // in no folder
  length_ = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
}

ServiceManager::~ServiceManager() {
  if (socket_ >= 0) ::close(socket_);
}

void ServiceManager::ticked(std::uint64_t now_ns, std::uint32_t tick_count) noexcept {
  if (socket_ < 0) return;
  if (!ready_) ready_ = tell("READY=1");
  if (feeding_.due(now_ns, tick_count)) tell("WATCHDOG=1");
}

bool ServiceManager::tell(std::string_view state) noexcept {
  return ::sendto(socket_, state.data(), state.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                  reinterpret_cast<const sockaddr*>(&address_), length_) >= 0;
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
