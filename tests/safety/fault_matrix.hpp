// The fault matrix: every fault that the board knows, at a random moment of a machine at work, and what must come of it.
//
// A run draws from its seed the row (in turn, so that all come up alike), the kind of model, the chamber, what the board is
// doing, its safe output and the tick. Claims, each for every run:
//
//   1  until the fault is visible nothing is reported; two ticks later at the latest every output that it concerns is safe
//   2  604Eh, 1001h, 1003h and the emergency message bear its code, its register and its chamber
//   3  no command leaves what the installer allows, and no pressure what limit and air in flight explain (machine.hpp)
//   4  the end of the cause, and every control word but a reset from rest, change nothing; after the reset the machine works again
//   5  a fault without a reaction is reported while it lasts, and stops nothing
//
// The rows are written from the tables of firmware/safety/README.md and the bus contract, not from the firmware's own table.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace plenum::safety_case {

/// The name of the row that a seed draws.
std::string row_of(std::uint64_t seed);
std::size_t rows();

/// One run. Empty when every claim held; otherwise what was lost, in one line: row, scene, tick, what was expected.
std::string lost_in_run(std::uint64_t seed);

}  // namespace plenum::safety_case
