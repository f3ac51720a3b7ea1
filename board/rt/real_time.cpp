#include "board/rt/real_time.hpp"

#include <link.h>
#include <malloc.h>
#include <sched.h>
#include <sys/mman.h>

#include <array>
#include <bit>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <span>
#include <utility>

namespace plenum::board::rt {
namespace {

/// More than the deepest tick needs, by far.
constexpr std::size_t kStackBytes = std::size_t{256} * 1024;

/// Every page of it is there before it is needed.
[[gnu::noinline]] void touch_stack() {
  constexpr std::size_t kPageBytes = 4096;
  std::array<volatile char, kStackBytes> stack;
  for (std::size_t i = 0; i < stack.size(); i += kPageBytes) stack[i] = 0;
}

/// Program code and variables of everything that is linked stay in memory. What else a library brings along comes when it is
/// read, and stays from then on: the end of a process takes the longer, the more it has in memory, and it is started anew after
/// that.
int keep_segments(dl_phdr_info* object, std::size_t, void*) {
  const std::span headers(object->dlpi_phdr, object->dlpi_phnum);
  for (const auto& segment : headers) {
    if (segment.p_type != PT_LOAD || (segment.p_flags & (PF_X | PF_W)) == 0) continue;
    if (::mlock(std::bit_cast<const void*>(object->dlpi_addr + segment.p_vaddr), segment.p_memsz) != 0)
      return 1;
  }
  return 0;
}

bool lock_memory() {
  return ::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0 &&
         ::dl_iterate_phdr(keep_segments, nullptr) == 0;
}

std::string refused(const std::string& what, const std::string& expected) {
  return what + ": " + std::strerror(errno) + ", expected " + expected;
}

}  // namespace

std::string run_on(int cpu) {
  cpu_set_t only;
  CPU_ZERO(&only);
  CPU_SET(static_cast<std::size_t>(cpu), &only);
  if (::sched_setaffinity(0, sizeof only, &only) == 0) return {};
  return refused("real_time.cpu = " + std::to_string(cpu), "a processor of this machine");
}

std::vector<std::string> enter_real_time(int priority, std::optional<int> cpu) {
  std::vector<std::string> refusals;
  ::mallopt(M_TRIM_THRESHOLD, -1);
  ::mallopt(M_MMAP_MAX, 0);
  if (!lock_memory())
    refusals.push_back(refused("memory cannot be locked", "CAP_IPC_LOCK, or LimitMEMLOCK=infinity"));
  touch_stack();
  if (std::string refusal = cpu ? run_on(*cpu) : std::string(); !refusal.empty())
    refusals.push_back(std::move(refusal));
  const sched_param parameters{.sched_priority = priority};
  if (priority > 0 && ::sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &parameters) != 0)
    refusals.push_back(
        refused("real_time.priority = " + std::to_string(priority), "CAP_SYS_NICE, or LimitRTPRIO"));
  return refusals;
}

}  // namespace plenum::board::rt
