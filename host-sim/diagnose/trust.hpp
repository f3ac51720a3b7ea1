// What the odds of a name are worth: no model of the catalogue is a machine's exactly, so that evidence alone is never right as often as it
// says. Placed on blind cases, whose truth is known.
#pragma once

#include <optional>
#include <vector>

#include "host-sim/diagnose/gap_report.hpp"
#include "host-sim/effects/catalogue.hpp"

namespace plenum::host::diagnose {

/// Of 41 causes named beside another that closed nearly all of what the others left, in blind cases, 40 were there; of an earlier search's 35 of
/// 40.
inline constexpr double kTrustBeside = 0.95;
/// Of 10 names of which the logs say nothing in blind cases 6 were there; on machines that are no valve before a chamber (public logs
/// of regulators, pumps and on/off valves) 7 of 10 names are such.
inline constexpr double kTrustUnknown = 0.5;

/// A cause is named alone from this share of the odds on.
inline constexpr double kNamedAlone = 0.8;

/// Probability that the effect named first is there, however long its odds, by the error that is left over the noise: what
/// leaves much is a stranger to the catalogue. Of 199 first names without an alias in blind cases all 189 that left less than 8 times
/// the noise were there, four of six up to 20 times, and one of four beyond; before them, of 79 that left less than 1.3 times, 78.
/// Likeliest would be even odds at 20 times and a width of 0.4: the tail is wider here, as machines are stranger than blind cases.
double probability_of_first(double left_over_floor);

/// Probability that an effect found beside others is one, and not the form of the others that the catalogue does not
/// hold, by the share that it closes of what the others leave: placed by eye on 106 of the cases, where most below 0.5
/// were form and nearly all above 0.75 were there.
double probability_beside_others(double share_of_rest);

/// What the odds of a name are worth: of one beside the first besides by the share that it closes of what the others leave. Where all of
/// them leave much the machine is a stranger to each.
double worth_of_name(double left_over_floor, std::optional<double> share_of_rest);

/// Whether the logs leave unknown each of an effect's figures: its interval holds the value at which it vanishes, or all that a fit may
/// find.
bool says_nothing(const std::vector<Estimate>& figures, std::size_t effect, effects::Size size);

}  // namespace plenum::host::diagnose
