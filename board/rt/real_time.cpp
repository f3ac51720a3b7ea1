#include "board/rt/real_time.hpp"

#include <malloc.h>
#include <sched.h>
#include <sys/mman.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>

namespace plenum::board::rt {
namespace {

/// More than the deepest tick needs, by far.
constexpr std::size_t kStackBytes = 256 * 1024;

/// Every page of it is there before it is needed.
[[gnu::noinline]] void touch_stack() {
  constexpr std::size_t kPageBytes = 4096;
  std::array<volatile char, kStackBytes> stack;
  for (std::size_t i = 0; i < stack.size(); i += kPageBytes) stack[i] = 0;
}

std::string refused(const std::string& what, const std::string& expected) {
  return what + ": " + std::strerror(errno) + ", expected " + expected;
}

}  // namespace

std::vector<std::string> enter_real_time(int priority, std::optional<int> cpu) {
  std::vector<std::string> refusals;
  ::mallopt(M_TRIM_THRESHOLD, -1);
  ::mallopt(M_MMAP_MAX, 0);
  if (::mlockall(MCL_CURRENT | MCL_FUTURE) != 0)
    refusals.push_back(refused("memory cannot be locked", "CAP_IPC_LOCK, or LimitMEMLOCK=infinity"));
  touch_stack();
  if (cpu) {
    cpu_set_t only;
    CPU_ZERO(&only);
    CPU_SET(static_cast<std::size_t>(*cpu), &only);
    if (::sched_setaffinity(0, sizeof only, &only) != 0)
      refusals.push_back(refused("real_time.cpu = " + std::to_string(*cpu), "a processor of this machine"));
  }
  const sched_param parameters{.sched_priority = priority};
  if (priority > 0 && ::sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters) != 0)
    refusals.push_back(
        refused("real_time.priority = " + std::to_string(priority), "CAP_SYS_NICE, or LimitRTPRIO"));
  return refusals;
}

}  // namespace plenum::board::rt
