// Independent tasks on several threads.
#pragma once

#include <cstddef>
#include <functional>

namespace plenum::host::identify {

/// work(0) .. work(count - 1), each once, on `threads` threads, at least one; finished() after each, one at a time. Throws
/// what a work threw.
void in_parallel(std::size_t count, unsigned threads, const std::function<void(std::size_t)>& work,
                 const std::function<void(double done)>& finished = {});

}  // namespace plenum::host::identify
