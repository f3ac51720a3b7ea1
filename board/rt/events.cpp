#include "board/rt/events.hpp"

#include <pthread.h>
#include <sys/signalfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <stdexcept>
#include <string>

namespace plenum::board::rt {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;

bool has_come(const pollfd& one) noexcept {
  return one.revents != 0;
}

/// The device behind it has gone; a socket that reports an error gives it away when it is read.
bool has_gone(const pollfd& one) noexcept {
  return (one.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0;
}

sigset_t stop_signals() noexcept {
  sigset_t signals;
  ::sigemptyset(&signals);
  ::sigaddset(&signals, SIGTERM);
  ::sigaddset(&signals, SIGINT);
  ::sigaddset(&signals, SIGCHLD);
  return signals;
}

}  // namespace

void block_stop_signals() noexcept {
  const sigset_t signals = stop_signals();
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

std::uint64_t monotonic_ns() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * kSecond_ns + static_cast<std::uint64_t>(now.tv_nsec);
}

KernelEvents::KernelEvents(int emergency_stop, std::span<const int> scans) {
  const sigset_t stop = stop_signals();
  const int moment_fd = ::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
  const int stop_fd = ::signalfd(-1, &stop, SFD_NONBLOCK | SFD_CLOEXEC);
  for (const int descriptor : {moment_fd, stop_fd, -1, emergency_stop})
    polled_.push_back({.fd = descriptor, .events = POLLIN, .revents = 0});
  for (const int descriptor : scans) polled_.push_back({.fd = descriptor, .events = POLLIN, .revents = 0});
  if (moment_fd < 0 || stop_fd < 0) {
    const std::string found = std::strerror(errno);
    ::close(moment_fd);
    ::close(stop_fd);
    throw std::runtime_error("loop: " + found + ", expected a timerfd and a signalfd of the kernel");
  }
}

KernelEvents::~KernelEvents() {
  ::close(polled_[kMoment].fd);
  ::close(polled_[kStop].fd);
}

std::uint64_t KernelEvents::now_ns() noexcept {
  return monotonic_ns();
}

Happened KernelEvents::wait(std::uint64_t until_ns, WaitFor what) noexcept {
  itimerspec moment{};
  moment.it_value.tv_sec = static_cast<time_t>(until_ns / kSecond_ns);
  moment.it_value.tv_nsec = static_cast<long>(until_ns % kSecond_ns);
  ::timerfd_settime(polled_[kMoment].fd, TFD_TIMER_ABSTIME, &moment, nullptr);
  const std::size_t count = what == WaitFor::anything ? polled_.size() : std::size_t{kFrames};
  for (pollfd& one : polled_) one.revents = 0;
  while (::poll(polled_.data(), count, -1) < 0 && errno == EINTR) continue;

  Happened happened;
  signalfd_siginfo signal{};
  if (has_come(polled_[kStop]) && ::read(polled_[kStop].fd, &signal, sizeof signal) > 0) {
    happened.child = signal.ssi_signo == SIGCHLD;
    happened.stop = !happened.child;
  }
  happened.frames = has_come(polled_[kFrames]);
  happened.emergency_stop = has_come(polled_[kEmergencyStop]);
  for (std::size_t i = kFirstScans; i < polled_.size(); ++i) happened.scans |= has_come(polled_[i]);
  for (std::size_t i = kEmergencyStop; i < polled_.size(); ++i) {
    if (has_gone(polled_[i])) polled_[i].fd = -1;
  }
  return happened;
}

}  // namespace plenum::board::rt
