// Whether logs say anything of the valve that moved the pressure in them.
//
// Rows are averaged over blocks of 1, 5, 25 and 125 ticks. Y_b is a block's mean pressure, U_b its mean command, both less the
// means over their log. Least squares predict the next block from this one alone, and from the command besides:
//
//   Y_(b+1) = a Y_b + m K_b + n K_(b-1)                          squares of the errors S_0, over N blocks
//   Y_(b+1) = a Y_b + m K_b + n K_(b-1) + c U_b + d U_(b-1)      S_1
//
// K_b is what an isothermal compression makes of the block's pressure until the next, p (v_b/v_(b+1) - 1), again less its mean over the
// log: in a large chamber that is far more than a valve does in a block. Two of them, because a sample is from the time before it. Where
// m + n is not above 0 it is no compression, but a volume that grows with its pressure, as of a bellows: such a one tells the next
// pressure and would leave the command nothing to say, so that both are 0 then.
//
// Where the command has no part, (N - 5 - the logs) (S_0 - S_1)/S_1 is about chi-square with 2 degrees of freedom. What is left in S_1
// is noise and thus comes from the logs themselves. It is not taken from differences of the pressure: those take fast motion for noise,
// which here the command explains. Long blocks average noise out of a chamber that moves little in a tick; U_(b-1) leaves room for dead
// time.
#pragma once

#include "host-sim/identify/ticks.hpp"

namespace plenum::host::identify {

/// Throws CannotIdentify, in one line: a command that is constant, a volume that is not above 0, a pressure that is constant or
/// follows the command at no length of block beyond its noise.
void require_excitation(const Ticks& ticks);

}  // namespace plenum::host::identify
