// Who starts the program, or the whole machine, anew when the ticks stop: systemd (WatchdogSec), and the hardware's watchdog.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace plenum::board::rt {

/// When to feed: after an interval, and only if a tick has been done since the last time. Pure.
class FeedingTime {
 public:
  /// 0: never.
  explicit FeedingTime(std::uint64_t interval_ns) noexcept : interval_ns_(interval_ns) {}

  bool due(std::uint64_t now_ns, std::uint32_t tick_count) noexcept {
    if (interval_ns_ == 0 || tick_count == fed_at_tick_ || now_ns - fed_ns_ < interval_ns_) return false;
    fed_ns_ = now_ns;
    fed_at_tick_ = tick_count;
    return true;
  }

 private:
  std::uint64_t interval_ns_;
  std::uint64_t fed_ns_ = 0;
  std::uint32_t fed_at_tick_ = 0;  ///< no tick has been done
};

/// The service manager, by the protocol of sd_notify(3). Without one (NOTIFY_SOCKET is not set) all of it does nothing. Not by
/// sd_notify() itself, which waits for a manager that does not read: no tick may.
class ServiceManager {
 public:
  /// Feeds three times in the time that WatchdogSec allows.
  ServiceManager() noexcept;
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  /// After each tick. The first one that the manager takes says that the service is ready.
  void ticked(std::uint64_t now_ns, std::uint32_t tick_count) noexcept;
  void stopping() noexcept { tell("STOPPING=1"); }

 private:
  /// False: it was not taken.
  bool tell(std::string_view state) noexcept;

  sockaddr_un address_{};  ///< the manager's
  socklen_t length_ = 0;
  int socket_ = -1;  ///< there is no manager
  FeedingTime feeding_;
  bool ready_ = false;
};

/// A watchdog device, /dev/watchdog0. It resets the machine when it is not fed for timeout_s(), also after a crash; only an
/// orderly stop disarms it.
class HardwareWatchdog {
 public:
  static constexpr int kTimeout_s = 5;  ///< what is asked for

  /// Empty: none. Arms it; throws std::runtime_error when it is no watchdog. One that has another timeout stays armed, and is fed
  /// in time: a driver with "nowayout" would reset the machine again and again once it was opened and let go.
  explicit HardwareWatchdog(const std::filesystem::path& device);
  ~HardwareWatchdog();
  HardwareWatchdog(const HardwareWatchdog&) = delete;
  HardwareWatchdog& operator=(const HardwareWatchdog&) = delete;

  /// What the driver has made of kTimeout_s: it may round, clamp, or know only its own. 0: there is no watchdog.
  int timeout_s() const noexcept { return timeout_s_; }
  /// That it is another one, in a line; empty: it is not.
  std::string trouble() const;

  /// After each tick. Feeds three times in timeout_s().
  void ticked(std::uint64_t now_ns, std::uint32_t tick_count) noexcept;

 private:
  std::string device_;
  int file_ = -1;
  int timeout_s_ = 0;
  FeedingTime feeding_{0};
};

}  // namespace plenum::board::rt
