// A sum over memory that only its owner writes: taken when it was written, compared now and then, it tells of a bit that
// has flipped in between.
//
// The words of 64 bits are added up modulo 2^64, a last one that is shorter filled with zeros. So every change within one word
// changes the sum; two in different words may cancel. It is no CRC and guards nothing that crosses a wire: it costs three
// instructions a word, a CRC by nibbles over a hundred.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace plenum::config {

/// What is sealed begins at a multiple of it: a processor that reads no word from anywhere else would spend a call on each.
inline constexpr std::size_t kSealAlignment = 4;

std::uint64_t sum_of(std::span<const std::byte> bytes) noexcept;

/// Of one object, padding and all: nobody writes that either.
template <class T>
std::uint64_t sum_of_object(const T& object) noexcept {
  static_assert(alignof(T) >= kSealAlignment);
  return sum_of(std::as_bytes(std::span(&object, 1)));
}

/// The seal of memory that is too long to be looked at in one tick: a piece a call, all of it in ceil(bytes / kPiece) calls.
class LongSeal {
 public:
  static constexpr std::size_t kPiece = 128;  ///< bytes, a multiple of a word's

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
