// safety.fault_runs_lost: runs of the fault matrix (tests/safety) in which a claim did not hold.
//
// usage: plenum_safety_bench          10,000 runs, the seeds in turn
//        plenum_safety_bench SEED     one of them again
#include <fmt/core.h>

#include <atomic>
#include <charconv>
#include <cstdint>
#include <mutex>
#include <string_view>
#include <thread>
#include <vector>

#include "tests/bench/row.hpp"
#include "tests/safety/fault_matrix.hpp"

namespace {

using namespace plenum::safety_case;

constexpr std::uint64_t kRuns = 10'000;

int again(std::string_view word) {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), seed);
  if (error != std::errc{} || end != word.data() + word.size()) {
    fmt::print(stderr, "safety: {}: expected a seed, a whole number\n", word);
    return 2;
  }
  const std::string lost = lost_in_run(seed);
  fmt::print("{}\n", lost.empty() ? fmt::format("seed {}: {}: nothing lost", seed, row_of(seed)) : lost);
  return lost.empty() ? 0 : 1;
}

void all() {
  std::atomic<std::uint64_t> next = 0;
  std::atomic<std::uint64_t> lost = 0;
  std::mutex telling;
  const auto work = [&] {
    for (std::uint64_t seed = next++; seed < kRuns; seed = next++) {
      const std::string what = lost_in_run(seed);
      if (what.empty()) continue;
      ++lost;
      const std::lock_guard<std::mutex> lock(telling);
      fmt::print(stderr, "{}; again: plenum_safety_bench {}\n", what, seed);
    }
  };
  std::vector<std::jthread> workers;
  for (unsigned i = std::thread::hardware_concurrency(); i > 1; --i) workers.emplace_back(work);
  work();
  workers.clear();
  plenum::bench::print(
      {"safety.fault_runs_lost", static_cast<double>(lost.load()), "of 10,000 runs", "lower", 0.0});
}

}  // namespace

int main(int count, char** words) {
  if (count > 1) return again(words[1]);
  all();
}
