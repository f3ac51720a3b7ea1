#include "board/drivers/worker.hpp"

#include <signal.h>

#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>

namespace plenum::board::drivers {
namespace {

// A thread's default of 8 MiB would be locked into memory with the rest.
constexpr std::size_t kStackBytes = std::size_t{64} * 1024;

/// Returns an error of pthread_create.
int start(pthread_t& thread, void* (*run)(void*), void* worker) {
  pthread_attr_t attributes;
  ::pthread_attr_init(&attributes);
  ::pthread_attr_setstacksize(&attributes, kStackBytes);
  ::pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
  sigset_t all;
  sigset_t before;
  ::sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  const int error = ::pthread_create(&thread, &attributes, run, worker);
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  ::pthread_attr_destroy(&attributes);
  return error;
}

}  // namespace

Worker::Worker(std::function<void()> work) : work_(std::move(work)) {
  ::sem_init(&wake_, 0, 0);
  const auto run = [](void* worker) -> void* {
    static_cast<Worker*>(worker)->run();
    return nullptr;
  };
  if (const int error = start(thread_, run, this); error != 0) {
    ::sem_destroy(&wake_);
    throw std::runtime_error(std::string("no worker thread: ") + std::strerror(error) +
                             ", expected a limit on threads (TasksMax, RLIMIT_NPROC) that admits one more");
  }
}

Worker::~Worker() {
  stop_.store(true);
  wake();
  ::pthread_join(thread_, nullptr);
  ::sem_destroy(&wake_);
}

void Worker::run() noexcept {
  for (;;) {
    while (::sem_wait(&wake_) != 0) {  // EINTR: a debugger, or the process was stopped and continued
    }
    work_();
    if (stop_.load()) return;
  }
}

}  // namespace plenum::board::drivers
