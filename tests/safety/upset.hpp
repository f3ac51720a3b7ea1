// Single-event upsets: one bit of the controller's memory flips while a machine is at work, at rest, or waits for a reset.
//
// A run draws the part of the controller (in turn), the bit, and what the board is doing. Half of what a controller holds are
// addresses and counts, of which a flip may end the process, so each run has a process of its own: a copy of the machine.
//
// Each is compared, tick by tick, with a copy of the same machine and the same noise of which no bit flips:
//
//   harmless  in the last half second of the two after the flip no command and no pressure is farther from the copy's than
//             kAlike_V and kAlike_kPa
//   detected  a fault stands, with its reaction
//   strayed   goes on untold with other commands than before, within what the installer allows and below the over-pressure limit:
//             a flip in what nothing seals, or in an estimate or a sequence that does not come back to what it was
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

enum class End : std::uint8_t { harmless, detected, strayed, ended, deaf, unsafe };
inline constexpr std::size_t kEnds = 6;
const char* describe(End end);

/// A member of the controller, or of its chambers; chambers count together.
struct Part {
  const char* name;
  std::size_t bytes;
};
std::vector<Part> parts();

/// How far a run and that of the same machine without the flip were apart, at the chamber that was farthest.
struct Apart {
  double most_kPa = 0.0;  ///< in any of the ticks
  double late_kPa = 0.0;  ///< in the last half second
  double late_V = 0.0;    ///< the commands, in the last half second
};
/// Runs that are no farther apart are alike: three thousandths of the supply, an eightieth of the range of commands.
inline constexpr double kAlike_kPa = 2.0;
inline constexpr double kAlike_V = 0.05;

struct Upset {
  std::uint64_t seed = 0;
  std::size_t part = 0;
  End end = End::harmless;
  Apart apart;
  std::string what;  ///< in one line: part, byte, bit, scene, and of an unsafe end what was wrong
};

/// Those of the seeds `first` to `last` - 1; every 64 in a row share a machine. Throws std::system_error where no process can be
/// made.
std::vector<Upset> upsets(std::uint64_t first, std::uint64_t last);

}  // namespace plenum::safety_case
