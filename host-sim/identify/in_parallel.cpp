#include "host-sim/identify/in_parallel.hpp"

#include <algorithm>
#include <atomic>
#include <future>
#include <mutex>
#include <vector>

namespace plenum::host::identify {

void in_parallel(std::size_t count, unsigned threads, const std::function<void(std::size_t)>& work,
                 const std::function<void(double done)>& finished) {
  std::atomic<std::size_t> next{0};
  std::size_t done = 0;
  std::mutex one_at_a_time;
  const auto take_turns = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      work(i);
      const std::lock_guard lock(one_at_a_time);
      ++done;
      if (finished) finished(static_cast<double>(done) / static_cast<double>(count));
    }
  };
  std::vector<std::future<void>> running;
  for (unsigned i = 0; i < std::max(threads, 1U) && i < count; ++i) {
    running.push_back(std::async(std::launch::async, take_turns));
  }
  for (std::future<void>& one : running) one.get();
}

}  // namespace plenum::host::identify
