#include "firmware/config/seal.hpp"

#include <algorithm>
#include <cstring>

namespace plenum::config {

std::uint64_t sum_of(std::span<const std::byte> bytes) noexcept {
  constexpr std::size_t kWord = sizeof(std::uint64_t);
  std::uint64_t sum = 0;
  std::uint64_t word = 0;
  const std::byte* at = bytes.data();
  for (std::size_t words = bytes.size() / kWord; words > 0; --words, at += kWord) {
    std::memcpy(&word, __builtin_assume_aligned(at, kSealAlignment), kWord);
    sum += word;
  }
  if (const std::size_t rest = bytes.size() % kWord; rest != 0) {
    word = 0;
    std::memcpy(&word, at, rest);
    sum += word;
  }
  return sum;
}

void LongSeal::close(std::span<const std::byte> memory) noexcept {
  *this = LongSeal{};
  seal_ = sum_of(memory);
}

bool LongSeal::look(std::span<const std::byte> memory) noexcept {
  if (at_ > memory.size()) at_ = 0;  // whatever has flipped
  const std::span<const std::byte> piece = memory.subspan(at_, std::min(kPiece, memory.size() - at_));
  sum_ += sum_of(piece);
  at_ += piece.size();
  if (at_ == memory.size()) {
    intact_ = intact_ && sum_ == seal_;
    at_ = 0;
    sum_ = 0;
  }
  return intact_;
}

}  // namespace plenum::config
