#include "firmware/config/seal.hpp"

#include <algorithm>
#include <cstring>

namespace plenum::config {

std::uint64_t sum_of(std::span<const std::byte> bytes) noexcept {
  constexpr std::size_t kAtOnce = 4 * kWord;
  std::uint64_t sum = 0;
  const std::byte* at = bytes.data();
  std::size_t left = bytes.size();
  for (; left >= kAtOnce; left -= kAtOnce, at += kAtOnce) {  // the loop itself costs as much as a word
    sum += word_at<kWord>(at) + word_at<kWord>(at + kWord) + word_at<kWord>(at + 2 * kWord) +
           word_at<kWord>(at + 3 * kWord);
  }
  for (; left >= kWord; left -= kWord, at += kWord) sum += word_at<kWord>(at);
  if (left == 0) return sum;
  std::uint64_t rest = 0;
  std::memcpy(&rest, at, left);
  return sum + rest;
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
