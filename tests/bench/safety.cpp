// safety.fault_runs_lost: runs of the fault matrix (tests/safety) in which a claim did not hold.
// safety.upsets_unsafe: single bits flipped in the controller's memory after which a command, a pressure, a state or the outputs
// were not what they may be, or it did not obey its master. safety.upsets_strayed: those after which it went on within its limits
// and untold, but two seconds later not as the same machine without the flip. safety.upsets_ended: those that ended the process,
// which is for systemd and its watchdog. All others were detected, or harmless as tests/safety/upset.hpp has it. The bits are drawn
// alike for each part of the controller; the shares by part, and those of a bit drawn from all of its memory, go to standard
// error.
//
// usage: plenum_safety_bench               10,000 runs of the matrix and 12,000 upsets, the seeds in turn
//        plenum_safety_bench SEED          a run of the matrix again
//        plenum_safety_bench upset SEED    an upset again
//        plenum_safety_bench upsets FIRST  12,000 others, the seeds from FIRST on
#include <fmt/core.h>

#include <array>
#include <atomic>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <string_view>
#include <thread>
#include <vector>

#include "tests/bench/row.hpp"
#include "tests/safety/fault_matrix.hpp"
#include "tests/safety/upset.hpp"

namespace {

using namespace plenum::safety_case;

constexpr std::uint64_t kRuns = 10'000;
constexpr std::uint64_t kUpsets = 12'000;

std::uint64_t seed_of(std::string_view word) {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), seed);
  if (error != std::errc{} || end != word.data() + word.size()) {
    fmt::print(stderr, "safety: {}: expected a seed, a whole number\n", word);
    std::exit(2);
  }
  return seed;
}

int play_again(std::uint64_t seed) {
  const std::string lost = lost_in_run(seed);
  fmt::print("{}\n", lost.empty() ? fmt::format("seed {}: {}: nothing lost", seed, row_of(seed)) : lost);
  return lost.empty() ? 0 : 1;
}

void play_matrix() {
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

void play_upsets(std::uint64_t first) {
  const std::vector<Part> all = parts();
  std::vector<std::array<std::size_t, kEnds>> ends(all.size());
  std::array<std::size_t, kEnds> sum{};
  for (const Upset& upset : upsets(first, first + kUpsets)) {
    const auto end = static_cast<std::size_t>(upset.end);
    ++ends[upset.part][end];
    ++sum[end];
    if (upset.end == End::unsafe || upset.end == End::deaf || upset.end == End::strayed)
      fmt::print(stderr, "seed {}: {}; again: plenum_safety_bench upset {}\n", upset.seed, upset.what,
                 upset.seed);
  }
  std::array<double, kEnds> share{};  // of a bit drawn from all of the memory
  std::size_t bytes = 0;
  for (const Part& part : all) bytes += part.bytes;
  fmt::print(stderr, "{:<28}{:>8}", "of each part [%]", "bytes");
  for (std::size_t end = 0; end < kEnds; ++end) fmt::print(stderr, "{:>10}", describe(static_cast<End>(end)));
  for (std::size_t i = 0; i < all.size(); ++i) {
    fmt::print(stderr, "\n{:<28}{:>8}", all[i].name, all[i].bytes);
    std::size_t flips = 0;
    for (const std::size_t count : ends[i]) flips += count;
    for (std::size_t end = 0; end < kEnds; ++end) {
      const double percent = 100.0 * static_cast<double>(ends[i][end]) / static_cast<double>(flips);
      share[end] += percent * static_cast<double>(all[i].bytes) / static_cast<double>(bytes);
      fmt::print(stderr, "{:>10.1f}", percent);
    }
  }
  fmt::print(stderr, "\n{:<28}{:>8}", "all of the memory", bytes);
  for (const double percent : share) fmt::print(stderr, "{:>10.2f}", percent);
  fmt::print(stderr, "\n");
  const auto count = [&](End end) { return static_cast<double>(sum[static_cast<std::size_t>(end)]); };
  plenum::bench::print(
      {"safety.upsets_unsafe", count(End::unsafe) + count(End::deaf), "of 12,000 flips", "lower", 0.0});
  plenum::bench::print(
      {"safety.upsets_strayed", count(End::strayed), "of 12,000 flips, untold", "lower", 0.0});
  plenum::bench::print({"safety.upsets_ended", count(End::ended), "of 12,000 flips ended the process"});
}

}  // namespace

int main(int count, char** words) {
  const std::string_view word = count > 1 ? words[1] : "";
  if (count > 2 && word == "upset") {
    const std::uint64_t seed = seed_of(words[2]);
    fmt::print("seed {}: {}\n", seed, upsets(seed, seed + 1).front().what);
    return 0;
  }
  if (count > 2 && word == "upsets") {
    play_upsets(seed_of(words[2]));
    return 0;
  }
  if (count > 1) return play_again(seed_of(word));
  play_upsets(0);  // before there are threads: it forks
  play_matrix();
}
