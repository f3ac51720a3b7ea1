// What makes a thread of an ordinary kernel keep its deadlines.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace plenum::board::rt {

/// Puts the calling thread on this processor. What the kernel refuses comes back as a line; empty: nothing.
std::string run_on(int cpu);

/// Locks the memory of the process, keeps the heap from giving any back, touches the stack, and puts the calling thread on
/// `cpu` and under SCHED_FIFO at `priority` (0: the ordinary scheduler). Threads made before and after keep the ordinary
/// one. What the kernel refuses is left as it was, and comes back as a line: what, why, what it takes.
std::vector<std::string> enter_real_time(int priority, std::optional<int> cpu);

}  // namespace plenum::board::rt
