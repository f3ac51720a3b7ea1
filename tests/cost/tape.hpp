// Random numbers that can be drawn again, and the search for the dearest of what is made of them.
//
// What is drawn from a tape is drawn alike from a copy of it, and almost alike from one that differs in a few numbers. So one
// search serves everything that a generator of random cases can make: it keeps the tapes whose cases are the dearest and varies
// them. The seed determines what it finds.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace plenum::cost {

/// A generator for the distributions of <random>.
class Tape {
 public:
  using result_type = std::uint64_t;
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }

  explicit Tape(std::uint64_t seed) : beyond_(seed) {}

  result_type operator()() {
    if (at_ == numbers_.size()) numbers_.push_back(beyond_());
    return numbers_[at_++];
  }

  /// The same numbers from the first on.
  void rewind() { at_ = 0; }

  /// A copy, rewound, in which up to four of the numbers drawn are replaced or moved a little.
  template <class Random>
  Tape varied(Random& random) const {
    Tape copy = *this;
    copy.rewind();
    if (numbers_.empty()) return copy;
    for (std::uint64_t left = 1 + random() % 4; left > 0; --left) {
      std::uint64_t& number = copy.numbers_[random() % numbers_.size()];
      const std::uint64_t fresh = random();
      number = random() % 2 == 0 ? fresh : number + (fresh >> 6U) - (max() >> 7U);
    }
    return copy;
  }

 private:
  std::vector<std::uint64_t> numbers_;
  std::size_t at_ = 0;
  std::mt19937_64 beyond_;
};

/// How far a search goes: so many cases at random, then so many variations of the dearest.
struct Effort {
  int drawn = 0;
  int varied = 0;
};

/// The highest of `cost_of`(Tape&) that is found.
template <class CostOf>
std::uint64_t dearest(std::uint64_t seed, Effort effort, CostOf&& cost_of) {
  struct Found {
    Tape tape;
    std::uint64_t cost;
  };
  constexpr std::size_t kKept = 4;
  std::vector<Found> kept;
  std::mt19937_64 random(seed);
  const auto weigh = [&](Tape tape) {
    const std::uint64_t cost = cost_of(tape);
    const auto behind =
        std::find_if(kept.begin(), kept.end(), [cost](const Found& found) { return found.cost <= cost; });
    kept.insert(behind, {std::move(tape), cost});
    if (kept.size() > kKept) kept.pop_back();
  };
  for (int i = 0; i < effort.drawn; ++i) weigh(Tape(random()));
  for (int i = 0; i < effort.varied; ++i) weigh(kept[random() % kept.size()].tape.varied(random));
  return kept.front().cost;
}

}  // namespace plenum::cost
