// A thread for what the kernel may take long over, so that its owner's never waits.
#pragma once

#include <pthread.h>
#include <semaphore.h>

#include <atomic>
#include <functional>

namespace plenum::board::drivers {

/// Of the ordinary scheduler, whatever its maker's; takes no signal.
class Worker {
 public:
  /// `work` is done after each wake(), and once more at the end: it looks itself whether there is any. It may not throw.
  /// Throws std::runtime_error when the kernel gives no thread.
  explicit Worker(std::function<void()> work);
  /// Waits for what is under way.
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Never waits.
  void wake() noexcept { ::sem_post(&wake_); }

 private:
  void run() noexcept;

  std::function<void()> work_;
  std::atomic<bool> stop_{false};
  sem_t wake_{};
  pthread_t thread_{};
};

}  // namespace plenum::board::drivers
