// Random numbers that can be drawn again, and the search for the dearest of what is made of them.
//
// What is drawn from a tape is drawn alike from a copy of it, and almost alike from one that differs in a few numbers. So one
// search serves everything that a generator of random cases can make: it keeps the tapes whose cases are the dearest and varies
// them. What it finds is a matter of luck, which a change of a few instructions turns: so the dearest tape is kept as a text, and
// the next search begins with it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace plenum::cost {

/// A generator for the distributions of <random>: the numbers of a seed, some of them replaced.
class Tape {
 public:
  using result_type = std::uint64_t;
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }

  explicit Tape(std::uint64_t seed) : seed_(seed), beyond_(seed) {}

  /// Of the seed and, a pair each, place and number of what is replaced, in hexadecimal: what text() gives.
  /// Throws std::invalid_argument.
  static Tape from(const std::string& text) {
    std::istringstream words(text);
    words >> std::hex;
    const auto next = [&](auto& number) {
      if (words >> number) return;
      throw std::invalid_argument("a tape is a seed and pairs of numbers, hexadecimal; found '" +
                                  text.substr(0, 40) + "'");
    };
    std::uint64_t seed = 0;
    next(seed);
    Tape tape(seed);
    while (!(words >> std::ws).eof()) {
      std::size_t place = 0;
      next(place);
      next(tape.replaced_[place]);
    }
    return tape;
  }
  std::string text() const {
    std::ostringstream words;
    words << std::hex << seed_;
    for (const auto& [place, number] : replaced_) words << ' ' << place << ' ' << number;
    return words.str();
  }

  result_type operator()() {
    if (at_ == numbers_.size()) {
      const std::uint64_t fresh = beyond_();
      const auto other = replaced_.find(at_);
      numbers_.push_back(other == replaced_.end() ? fresh : other->second);
    }
    return numbers_[at_++];
  }

  /// A copy, rewound, in which up to four of the numbers drawn are replaced or moved a little.
  template <class Random>
  Tape varied(Random& random) const {
    Tape copy = *this;
    copy.at_ = 0;
    if (numbers_.empty()) return copy;
    for (std::uint64_t left = 1 + random() % 4; left > 0; --left) {
      const auto place = static_cast<std::size_t>(random() % numbers_.size());
      std::uint64_t& number = copy.numbers_[place];
      const std::uint64_t fresh = random();
      number = random() % 2 == 0 ? fresh : number + (fresh >> 6U) - (max() >> 7U);
      copy.replaced_[place] = number;
    }
    return copy;
  }

 private:
  std::uint64_t seed_;
  std::map<std::size_t, std::uint64_t> replaced_;
  std::vector<std::uint64_t> numbers_;  ///< as drawn
  std::size_t at_ = 0;
  std::mt19937_64 beyond_;
};

/// How far a search goes: so many cases at random, then so many variations of the dearest.
struct Effort {
  int drawn = 0;
  int varied = 0;
};

struct Dearest {
  Tape tape;
  std::uint64_t cost = 0;
};

/// The highest of `cost_of`(Tape&) that is found, from `known` cases on.
template <class CostOf>
Dearest dearest(std::uint64_t seed, const std::vector<Tape>& known, Effort effort, CostOf&& cost_of) {
  constexpr std::size_t kKept = 4;
  std::vector<Dearest> kept;
  std::mt19937_64 random(seed);
  const auto weigh = [&](Tape tape) {
    const std::uint64_t cost = cost_of(tape);
    const auto behind =
        std::find_if(kept.begin(), kept.end(), [cost](const Dearest& found) { return found.cost <= cost; });
    kept.insert(behind, {std::move(tape), cost});
    if (kept.size() > kKept) kept.pop_back();
  };
  for (const Tape& tape : known) weigh(tape);
  for (int i = 0; i < effort.drawn; ++i) weigh(Tape(random()));
  for (int i = 0; i < effort.varied; ++i)
    weigh(kept[static_cast<std::size_t>(random() % kept.size())].tape.varied(random));
  return kept.front();
}

}  // namespace plenum::cost
