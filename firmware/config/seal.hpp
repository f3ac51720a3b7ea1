// A sum over memory that only its owner writes: taken when it was written, compared now and then, it tells of a bit that
// has flipped in between.
//
// The words of 64 bits are added up modulo 2^64, a last one that is shorter filled with zeros. So every change within one word
// changes the sum; two in different words may cancel. It is no CRC and guards nothing that crosses a wire: it costs three
// instructions a word, a CRC by nibbles over a hundred.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

namespace plenum::config {

/// What is sealed begins at a multiple of it: a processor that reads no word from anywhere else would spend a call on each.
inline constexpr std::size_t kSealAlignment = 4;

std::uint64_t sum_of(std::span<const std::byte> bytes) noexcept;

inline constexpr std::size_t kWord = sizeof(std::uint64_t);  ///< bytes of what is summed

/// A word, or the first kBytes of one. A processor of 32 bits reads it by halves: as a whole gcc would copy it to the stack first.
template <std::size_t kBytes>
std::uint64_t word_at(const std::byte* at) noexcept {
  constexpr std::size_t kHalf = kSealAlignment;
  if constexpr (sizeof(std::size_t) == kHalf && kBytes == 2 * kHalf) {
    return word_at<kHalf>(at + kHalf) << (8 * kHalf) | word_at<kHalf>(at);
  } else {
    std::uint64_t word = 0;
    std::memcpy(&word, __builtin_assume_aligned(at, kHalf), kBytes);
    return word;
  }
}

/// Of so many words and kTail bytes behind them, without a loop.
template <std::size_t kTail, std::size_t... kIndex>
std::uint64_t sum_of_words(const std::byte* at, std::index_sequence<kIndex...>) noexcept {
  return (word_at<kTail>(at + sizeof...(kIndex) * kWord) + ... + word_at<kWord>(at + kIndex * kWord));
}

/// Of one object, padding and all: nobody writes that either. A short one at an instruction a word.
template <class T>
std::uint64_t sum_of_object(const T& object) noexcept {
  static_assert(alignof(T) >= kSealAlignment);
  constexpr std::size_t kShort = 256;
  const std::span<const std::byte> bytes = std::as_bytes(std::span(&object, 1));
  if constexpr (sizeof(T) > kShort) {
    return sum_of(bytes);
  } else {
    return sum_of_words<sizeof(T) % kWord>(bytes.data(), std::make_index_sequence<sizeof(T) / kWord>{});
  }
}

/// The seal of memory that is too long to be looked at in one tick: a piece a call, all of it in ceil(bytes / kPiece) calls.
class LongSeal {
 public:
  static constexpr std::size_t kPiece = 512;  ///< bytes, a multiple of a word's

  /// The owner has written it.
  void close(std::span<const std::byte> memory) noexcept;
  /// Looks at the next piece of the memory that was closed last. Returns false once a walk has ended with another sum, until it
  /// is closed anew.
  bool look(std::span<const std::byte> memory) noexcept;

 private:
  std::uint64_t seal_ = 0;
  std::uint64_t sum_ = 0;  ///< of the walk so far
  std::size_t at_ = 0;     ///< where it goes on
  bool intact_ = true;
};

}  // namespace plenum::config
