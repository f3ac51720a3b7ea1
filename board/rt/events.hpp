// What the loop waits for: the drivers' descriptors, a moment on the monotonic clock, and a request to stop.
#pragma once

#include <poll.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace plenum::board::rt {

/// What ended a wait; none of them: the moment has come.
struct Happened {
  bool stop = false;   ///< SIGTERM or SIGINT, once a signal
  bool child = false;  ///< one has ended or was stopped: the guard, or one that this program was started with
  bool frames = false;
  bool scans = false;
  bool emergency_stop = false;  ///< its line has changed
};

enum class WaitFor : std::uint8_t {
  anything,
  moment_or_stop  ///< the drivers may wait
};

class Events {
 public:
  virtual std::uint64_t now_ns() noexcept = 0;
  /// Returns at `until_ns` at the latest.
  virtual Happened wait(std::uint64_t until_ns, WaitFor what) noexcept = 0;

 protected:
  ~Events() = default;
};

/// From here on SIGTERM and SIGINT end no thread of the process, but a KernelEvents::wait(), as SIGCHLD does. Before the first
/// thread or child is made.
void block_stop_signals() noexcept;

/// The kernel's.
class KernelEvents final : public Events {
 public:
  /// Descriptors to be readable when something has come; negative ones are left out. Throws std::runtime_error.
  KernelEvents(int emergency_stop, std::span<const int> scans);
  ~KernelEvents();
  KernelEvents(const KernelEvents&) = delete;
  KernelEvents& operator=(const KernelEvents&) = delete;

  /// The bus to wait on from here on; it may be opened anew while the loop runs.
  void watch_frames(int descriptor) noexcept { polled_[kFrames].fd = descriptor; }

  std::uint64_t now_ns() noexcept override;
  /// A descriptor whose device has gone is left out from then on: it would end every wait at once.
  Happened wait(std::uint64_t until_ns, WaitFor what) noexcept override;

 private:
  enum Place : std::uint8_t { kMoment, kStop, kFrames, kEmergencyStop, kFirstScans };

  std::vector<pollfd> polled_;
};

/// The clock of all deadlines [ns]: monotonic.
std::uint64_t monotonic_ns() noexcept;

}  // namespace plenum::board::rt
