#include "firmware/config/crc32.hpp"

#include <gtest/gtest.h>

#include <array>
#include <span>
#include <string_view>
#include <vector>

namespace plenum::config {
namespace {

std::uint32_t crc32_of(std::string_view text) {
  return crc32(std::vector<std::uint8_t>(text.begin(), text.end()));
}

TEST(Crc32, GivesTheCheckValueOfTheCatalogue) {
  EXPECT_EQ(crc32_of("123456789"), 0xCBF43926U);
}

TEST(Crc32, OfNothingIsZero) {
  EXPECT_EQ(crc32({}), 0U);
}

// Values printed by zlib.crc32 of Python.
TEST(Crc32, AgreesWithZlib) {
  EXPECT_EQ(crc32_of("a"), 0xE8B7BE43U);
  EXPECT_EQ(crc32_of("The quick brown fox jumps over the lazy dog"), 0x414FA339U);
  EXPECT_EQ(crc32(std::array<std::uint8_t, 4>{0xFF, 0xFF, 0xFF, 0xFF}), 0xFFFFFFFFU);
}

TEST(Crc32, OfPartsIsThatOfTheWhole) {
  const std::vector<std::uint8_t> whole = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  for (std::size_t cut = 0; cut <= whole.size(); ++cut) {
    const auto parts = std::span(whole);
    EXPECT_EQ(crc32(parts.subspan(cut), crc32(parts.first(cut))), 0xCBF43926U) << "cut at " << cut;
  }
}

}  // namespace
}  // namespace plenum::config
