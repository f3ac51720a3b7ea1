// A part of the core in the state that it starts in.
#pragma once

#include <array>
#include <cstddef>
#include <new>

namespace plenum::fuzz {

/// The one T that there is, as it was made. To make a board takes as long as a thousand frames; and as the core has no heap, the
/// bytes of a T are all of it, and hold good where they were taken.
template <class T>
T& fresh() {
  alignas(T) static std::array<std::byte, sizeof(T)> place;
  static T& made = *new (place.data()) T;
  static const std::array<std::byte, sizeof(T)> kAsMade = place;
  place = kAsMade;
  return made;
}

}  // namespace plenum::fuzz
