#include "board/guard.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/timerfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>

#include "board/rt/real_time.hpp"
#include "board/say.hpp"

extern "C" {
#include <sys/pidfd.h>  // which does not say so itself in glibc 2.36
}

namespace plenum::board {
namespace {

constexpr std::uint64_t kSecond_ns = 1'000'000'000;

/// Tells the guard that the loop's thread has ended. The process may take long for the rest: its memory is given back by the
/// last of its threads, which is of ordinary priority.
constexpr int kLoopEnded = SIGUSR1;

/// The guard's own process.
class Sentry final : public GuardPost {
 public:
  Sentry(int loop, int timer, int ended, SafeOutputs& outputs) noexcept
      : loop_(loop),
        outputs_(outputs),
        polled_{pollfd{.fd = ended, .events = POLLIN, .revents = 0},
                pollfd{.fd = loop, .events = POLLIN, .revents = 0},
                pollfd{.fd = timer, .events = POLLIN, .revents = 0}} {}

  Seen watch() noexcept override {
    while (!end(kForEver, polled_.size())) {
      if (end(Guard::kGrace_ms, kEnds)) return Seen::end;
      // a beat that came in between has taken the silence back
      std::uint64_t expired = 0;
      if (::read(polled_[kEnds].fd, &expired, sizeof expired) == sizeof expired) return Seen::silence;
    }
    return Seen::end;
  }

  void kill() noexcept override { ::pidfd_send_signal(loop_, SIGKILL, nullptr, 0); }

  void wait_for_end() noexcept override {
    while (!end(kForEver, kEnds)) {
    }
  }

  void make_safe() noexcept override { outputs_.make_safe(); }

  void report(std::string_view line) noexcept override { say(line); }

 private:
  static constexpr int kForEver = -1;
  static constexpr std::size_t kEnds = 2;  // the first of what is polled tell the end

  /// Waits on the first `count`. Whether the loop has ended.
  bool end(int time_ms, std::size_t count) noexcept {
    for (pollfd& one : polled_) one.revents = 0;
    ::poll(polled_.data(), count, time_ms);
    return polled_[0].revents != 0 || polled_[1].revents != 0;
  }

  int loop_;
  SafeOutputs& outputs_;
  std::array<pollfd, kEnds + 1> polled_;
};

/// What ends or stops the loop's process is not to reach the guard as well: a key of the terminal, the service manager.
void stand_apart() noexcept {
  sigset_t all;
  ::sigfillset(&all);
  ::pthread_sigmask(SIG_BLOCK, &all, nullptr);
  ::setpgid(0, 0);
  ::prctl(PR_SET_NAME, "plenumd-guard");
}

[[noreturn]] void be_guard(int priority, int loop, int timer, SafeOutputs& outputs, int stands) noexcept {
  stand_apart();
  sigset_t ended;
  ::sigemptyset(&ended);
  ::sigaddset(&ended, kLoopEnded);
  const int ended_fd = ::signalfd(-1, &ended, SFD_CLOEXEC);
  if (ended_fd < 0 || ::prctl(PR_SET_PDEATHSIG, kLoopEnded) != 0) ::_exit(1);
  Sentry sentry(loop, timer, ended_fd, outputs);
  // what is refused here is refused to the loop, too, which tells it
  (void)rt::enter_real_time(priority, std::nullopt);
  (void)!::write(stands, "", 1);
  ::close(stands);
  stand_guard(sentry);
  ::_exit(0);
}

}  // namespace

void stand_guard(GuardPost& post) noexcept {
  const bool silent = post.watch() == GuardPost::Seen::silence;
  if (silent) {
    post.kill();
    post.make_safe();
    post.wait_for_end();
  }
  post.make_safe();
  // last: who reads it may let it wait
  post.report(
      silent ? "<3>plenumd: the loop was silent: killed, and the outputs made safe, by its guard\n"
             : "<3>plenumd: the loop has ended without a farewell: the outputs made safe by its guard\n");
}

Guard::Guard(const Config& config, SafeOutputs& outputs) : silence_ns_(config.silence_ns) {
  if (post(config.priority, outputs)) return;
  const std::string found = std::strerror(errno);
  dismiss();
  throw std::runtime_error("guard: " + found +
                           ", expected a second process that stands and outlives this one");
}

bool Guard::post(int priority, SafeOutputs& outputs) {
  loop_ = ::pidfd_open(::getpid(), 0);
  timer_ = ::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
  std::array<int, 2> stands{};
  if (loop_ < 0 || timer_ < 0 || ::pipe2(stands.data(), O_CLOEXEC) != 0) return false;
  guard_ = ::fork();
  if (guard_ == 0) be_guard(priority, loop_, timer_, outputs, stands[1]);
  const int cause = errno;
  ::close(stands[1]);
  char said = 0;
  const bool told = guard_ > 0 && ::read(stands[0], &said, 1) == 1;
  ::close(stands[0]);
  errno = guard_ < 0 ? cause : ECHILD;
  return told;
}

Guard::~Guard() {
  dismiss();
}

void Guard::dismiss() noexcept {
  if (guard_ > 0) {
    ::kill(guard_, SIGKILL);
    ::waitpid(guard_, nullptr, 0);
  }
  for (const int descriptor : {timer_, loop_}) {
    if (descriptor >= 0) ::close(descriptor);
  }
}

void Guard::beat() noexcept {
  constexpr std::uint64_t kGrace_ns = kGrace_ms * std::uint64_t{1'000'000};
  set_timer(silence_ns_ - kGrace_ns);
}

void Guard::rest() noexcept {
  set_timer(0);
}

void Guard::set_timer(std::uint64_t time_ns) noexcept {
  itimerspec moment{};
  moment.it_value.tv_sec = static_cast<time_t>(time_ns / kSecond_ns);
  moment.it_value.tv_nsec = static_cast<long>(time_ns % kSecond_ns);
  ::timerfd_settime(timer_, 0, &moment, nullptr);
}

bool Guard::stands() const noexcept {
  siginfo_t changed{};
  return ::waitid(P_PID, static_cast<id_t>(guard_), &changed, WEXITED | WSTOPPED | WNOHANG | WNOWAIT) == 0 &&
         changed.si_pid == 0;
}

}  // namespace plenum::board
