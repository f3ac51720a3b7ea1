// What the odds of a name are worth: no model of the catalogue is a machine's exactly, so that evidence alone is never right as often as it
// says. Placed on blind cases, whose truth is known.
#pragma once

#include <vector>

#include "host-sim/diagnose/gap_report.hpp"
#include "host-sim/effects/catalogue.hpp"

namespace plenum::host::diagnose {

/// Of 40 causes named beside another in blind cases 35 were there.
inline constexpr double kTrustBeside = 0.9;
/// Of 10 names of which the logs say nothing in blind cases 6 were there; on machines that are no valve before a chamber (public logs
/// of regulators, pumps and on/off valves) 7 of 10 names are such.
inline constexpr double kTrustUnknown = 0.5;

/// Probability that the effect named first is there, however long its odds, by the error that is left over the noise: what
/// leaves much is a stranger to the catalogue. Likeliest for 111 first names in blind cases: of 79 that left less than 1.3 times
/// the noise 78 were there, the other with even odds; of 7 that left more than 20 times two.
double probability_of_first(double left_over_floor);

/// Probability that an effect found beside others is one, and not the form of the others that the catalogue does not
/// hold, by the share that it closes of what the others leave: placed by eye on 106 of the cases, where most below 0.5
/// were form and nearly all above 0.75 were there.
double probability_beside_others(double share_of_rest);

/// Whether the logs leave unknown each of an effect's figures: its interval holds the value at which it vanishes, or all that a fit may
/// find.
bool says_nothing(const std::vector<Estimate>& figures, std::size_t effect, effects::Size size);

}  // namespace plenum::host::diagnose
