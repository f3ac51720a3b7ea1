// Single-event upsets: one bit of the controller's memory flips while a machine is at work, at rest, or waits for a reset.
//
// A run draws the part of the controller (in turn), the bit, and what the board is doing. Half of what a controller holds are
// addresses and counts, of which a flip may end the process, so each run has a process of its own: a copy of the machine.
//
//   harmless  the board goes on as before, its commands within what the installer allows
//   detected  a fault stands, with its reaction
//   ended     the process crashed or hung: systemd and its watchdog start it anew, with the valves at rest
//   deaf      as harmless, but the board does not obey its master any more; what is left is the emergency stop
//   unsafe    none of these: a command beyond the converter, a pressure that is not explained (machine.hpp), motion without an
//             order, a fault forgotten, or outputs that are not what the state says, two seconds after the flip
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace plenum::safety_case {

enum class End : std::uint8_t { harmless, detected, ended, deaf, unsafe };
inline constexpr std::size_t kEnds = 5;
const char* describe(End end);

/// A member of the controller, or of its chambers; chambers count together.
struct Part {
  const char* name;
  std::size_t bytes;
};
std::vector<Part> parts();

struct Upset {
  std::uint64_t seed = 0;
  std::size_t part = 0;
  End end = End::harmless;
  std::string what;  ///< in one line: part, byte, bit, scene, and of an unsafe end what was wrong
};

/// Those of the seeds `first` to `last` - 1; every 64 in a row share a machine. Throws std::system_error where no process can be
/// made.
std::vector<Upset> upsets(std::uint64_t first, std::uint64_t last);

}  // namespace plenum::safety_case
