// Whether logs say anything of the valve that moved the pressure in them.
//
// Rows are averaged over blocks of 1, 5, 25 and 125 ticks. Y_b is a block's mean pressure, U_b its mean command, both less the
// means over their log. Least squares predict the next block from this one alone, and from the command besides:
//
//   Y_(b+1) = a Y_b                          squares of the errors S_0, over N blocks
//   Y_(b+1) = a Y_b + c U_b + d U_(b-1)      S_1
//
// Where the command has no part in it, (N - 3 - the logs) (S_0 - S_1)/S_1 is about chi-square with 2 degrees of freedom. The noise is
// what is left in S_1 and thus comes from the logs themselves. It is not taken from differences of the pressure: those take fast
// motion for noise, which here the command explains. Long blocks average noise out of a chamber that moves little in a tick; U_(b-1)
// leaves room for dead time and for a volume that moves beside.
#pragma once

#include "host-sim/identify/ticks.hpp"

namespace plenum::host::identify {

/// Throws CannotIdentify, in one line: a command that is constant, a volume that is not above 0, a pressure that is constant or
/// follows the command at no length of block beyond its noise.
void require_excitation(const Ticks& ticks);

}  // namespace plenum::host::identify
