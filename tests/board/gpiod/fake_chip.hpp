// A GPIO chip in memory, behind both versions of libgpiod: fake_gpiod_v1.cpp and fake_gpiod_v2.cpp put their calls before it. What a
// call does here is what the kernel's character device does (Documentation/userspace-api/gpio/chardev.rst).
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace plenum::board::drivers::fake {

inline constexpr const char* kChip = "/fake/gpiochip0";
inline constexpr int kEventDescriptor = 42;

struct Line {
  std::string name;
  bool output = false;
  bool high = false;     ///< the pin
  std::string holder{};  ///< empty: free
  bool active_low = false;
  bool edges = false;    ///< its holder is told of them
  unsigned waiting = 0;  ///< events
  bool broken = false;   ///< the chip is gone: every call on it fails
};

enum class Direction { as_is, input, output };

struct Request {
  Direction direction = Direction::as_is;
  bool active_low = false;
  bool active = false;  ///< of an output
  bool edges = false;
};

class Chip {
 public:
  std::array<Line, 4> line{{{.name = "POWER"}, {.name = "STOP"}, {.name = "LAMP"}, {.name = "VENT"}}};
  /// Every direction and level that was asked for, in order: "POWER input", "VENT output high", "LAMP low".
  std::vector<std::string> asked;

  std::optional<unsigned> offset(const std::string& name) const;
  /// Each: 0, or -1 and errno.
  int request(unsigned offset, const Request& request, const char* consumer);
  void release(unsigned offset);
  int value(unsigned offset) const;  ///< 1: active
  int set(unsigned offset, bool active);
  int events(unsigned offset) const;
  int take_events(unsigned offset, unsigned at_most);

  /// The world outside: an input's pin changes.
  void drive(unsigned offset, bool high);
};

/// The one that every open of kChip finds.
Chip& chip();

}  // namespace plenum::board::drivers::fake
