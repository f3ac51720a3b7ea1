#include "firmware/config/twice.hpp"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "firmware/numeric/fixed.hpp"

namespace plenum::config {
namespace {

enum class Order : std::int8_t { back = -1, stop = 0, go = 4 };

template <class T>
void expect_every_flip_seen(T value) {
  const Twice<T> whole(value);
  EXPECT_TRUE(whole.intact());
  EXPECT_EQ(whole.value(), value);
  EXPECT_EQ(whole.second(), value);
  for (std::size_t bit = 0; bit < 8 * sizeof whole; ++bit) {
    auto bytes = std::bit_cast<std::array<unsigned char, sizeof whole>>(whole);
    bytes[bit / 8] = static_cast<unsigned char>(bytes[bit / 8] ^ 1U << bit % 8);
    const auto flipped = std::bit_cast<Twice<T>>(bytes);
    EXPECT_FALSE(flipped.intact()) << "bit " << bit;
    EXPECT_TRUE(flipped.value() == value || flipped.second() == value)
        << "one of the two is whole, bit " << bit;
  }
}

TEST(Twice, TellsEverySingleBitAndKeepsTheValueInTheOtherCopy) {
  expect_every_flip_seen(std::uint16_t{0xF0A5});
  expect_every_flip_seen(std::uint32_t{0});
  expect_every_flip_seen(Order::back);
  expect_every_flip_seen(Order::go);
  expect_every_flip_seen(301250.0F);
  expect_every_flip_seen(0.0F);
  expect_every_flip_seen(numeric::Fixed(-301250.25));
}

TEST(Twice, IsWholeAgainWhenItIsWritten) {
  auto flipped = std::bit_cast<Twice<std::uint8_t>>(std::array<std::uint8_t, 2>{3, 0x7F});
  ASSERT_FALSE(flipped.intact());
  flipped = std::uint8_t{9};
  EXPECT_TRUE(flipped.intact());
  EXPECT_EQ(flipped, 9);
}

}  // namespace
}  // namespace plenum::config
