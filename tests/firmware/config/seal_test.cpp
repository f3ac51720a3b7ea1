#include "firmware/config/seal.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <vector>

namespace plenum::config {
namespace {

std::vector<std::byte> memory_of(std::size_t size) {
  std::vector<std::byte> memory(size);
  for (std::size_t i = 0; i < size; ++i) memory[i] = static_cast<std::byte>(7 * i + 1);
  return memory;
}

void flip(std::vector<std::byte>& memory, std::size_t bit) {
  memory[bit / 8] ^= static_cast<std::byte>(1U << bit % 8);
}

TEST(Seal, TellsEverySingleBitOfMemoryOfAnyLength) {
  for (std::size_t size = 1; size < 40; ++size) {
    std::vector<std::byte> memory = memory_of(size);
    const std::uint64_t whole = sum_of(memory);
    for (std::size_t bit = 0; bit < 8 * size; ++bit) {
      flip(memory, bit);
      EXPECT_NE(sum_of(memory), whole) << "bit " << bit << " of " << size << " bytes";
      flip(memory, bit);
    }
    EXPECT_EQ(sum_of(memory), whole);
  }
}

TEST(Seal, IsTheSumOfTheWordsModulo2ToThe64) {
  const std::array<std::uint64_t, 3> words = {0x8000'0000'0000'0005U, 0x8000'0000'0000'0001U, 9};
  EXPECT_EQ(sum_of_object(words), 15U);
}

/// Calls that one walk over it takes.
std::size_t walk(std::size_t size) {
  return (size + LongSeal::kPiece - 1) / LongSeal::kPiece;
}

TEST(LongSeal, FindsABitThatFlipsAnywhereAndAtAnyTimeWithinTwoWalks) {
  for (const std::size_t size : {LongSeal::kPiece - 8, LongSeal::kPiece, std::size_t{1300}}) {
    for (std::size_t bit = 3; bit < 8 * size; bit += 97) {
      for (std::size_t before = 0; before < walk(size); ++before) {
        std::vector<std::byte> memory = memory_of(size);
        LongSeal seal;
        seal.close(memory);
        for (std::size_t i = 0; i < before; ++i) ASSERT_TRUE(seal.look(memory));
        flip(memory, bit);
        bool intact = true;
        for (std::size_t i = 0; i < 2 * walk(size); ++i) intact = seal.look(memory);
        ASSERT_FALSE(intact) << "bit " << bit << " of " << size << " bytes, after " << before << " calls";
        seal.close(memory);
        for (std::size_t i = 0; i < 2 * walk(size); ++i) ASSERT_TRUE(seal.look(memory)) << "closed anew";
      }
    }
  }
}

TEST(LongSeal, OfNothingIsIntact) {
  LongSeal seal;
  EXPECT_TRUE(seal.look({}));
}

TEST(LongSeal, RemembersWhatItFoundUntilItIsClosedAnew) {
  std::vector<std::byte> memory = memory_of(100);
  LongSeal seal;
  seal.close(memory);
  flip(memory, 5);
  EXPECT_FALSE(seal.look(memory));
  flip(memory, 5);
  EXPECT_FALSE(seal.look(memory));
}

}  // namespace
}  // namespace plenum::config
