// The tapes of random cases: what is kept as a text is the case itself.
#include "tests/cost/tape.hpp"

#include <gtest/gtest.h>

namespace plenum::cost {
namespace {

std::vector<std::uint64_t> drawn(Tape& tape, std::size_t count) {
  std::vector<std::uint64_t> numbers;
  for (std::size_t i = 0; i < count; ++i) numbers.push_back(tape());
  return numbers;
}

TEST(Tape, OfATextDrawsWhatTheVariedTapeDrewAndGoesOnAsItDoes) {
  std::mt19937_64 random(1);
  Tape tape(7);
  for (std::size_t generation = 1; generation <= 50; ++generation) {
    drawn(tape, 20 + generation % 3);
    tape = tape.varied(random);
  }
  Tape again = Tape::from(tape.text());
  EXPECT_EQ(again.text(), tape.text());
  const std::vector<std::uint64_t> numbers = drawn(tape, 40);
  EXPECT_EQ(drawn(again, 40), numbers);
  Tape unvaried(7);
  EXPECT_NE(drawn(unvaried, 40), numbers);
}

TEST(Tape, OfATextThatIsNoneIsRefused) {
  EXPECT_THROW(Tape::from(""), std::invalid_argument);
  EXPECT_THROW(Tape::from("7 3 x"), std::invalid_argument);
  EXPECT_THROW(Tape::from("7 3"), std::invalid_argument);
}

/// The most of the tapes' first numbers, by which a search is to find a high one.
TEST(Dearest, NeverFallsBehindTheCasesThatItBeginsWith) {
  const auto first = [](Tape& tape) { return tape() >> 8U; };
  const Dearest alone = dearest(1, {}, {.drawn = 20, .varied = 20}, first);
  Tape kept = Tape::from(alone.tape.text());
  EXPECT_EQ(first(kept), alone.cost);
  const Dearest from = dearest(2, {Tape::from(alone.tape.text())}, {.drawn = 1, .varied = 20}, first);
  EXPECT_GE(from.cost, alone.cost);
  EXPECT_EQ(dearest(2, {Tape::from(alone.tape.text())}, {}, first).cost, alone.cost);
}

}  // namespace
}  // namespace plenum::cost
