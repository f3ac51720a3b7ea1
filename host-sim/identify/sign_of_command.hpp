// Whether a log's command tells its sign from a lag.
#pragma once

#include <span>

namespace plenum::host::identify {

/// Whether the command turned about its middle is nearly the command of up to a second before: of a sine it is that of half a period
/// before. What follows such a command late seems to follow one of another sign.
bool turned_is_late(std::span<const double> command_V, double period_s);

}  // namespace plenum::host::identify
