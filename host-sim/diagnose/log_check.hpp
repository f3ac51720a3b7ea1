// What a log must be before its gap is looked for. A diagnosis answers any log with a cause: one in the wrong
// unit, of gauge pressure, or that hardly moves would get a wrong one.
//
// The thresholds leave room for what a diagnosis is to find: a supply or a sensor gain that is off by a fifth,
// a bias of 10 kPa, valve areas that are off by tens of times, pressures below ambient because a closed
// chamber grows.
#pragma once

#include <string>
#include <vector>

#include "host-sim/diagnose/cannot_diagnose.hpp"
#include "host-sim/trace/log.hpp"
#include "host-sim/trace/rig_toml.hpp"

namespace plenum::host::diagnose {

using trace::NamedLog;

/// Logs shorter than this together tell too little [s].
inline constexpr double kShortest_s = 3.0;

/// Units and reference of each log. Throws trace::InputError naming the log, the column, what was found, what it
/// looks like, and what was expected, for: pressure in kPa, bar, MPa, psi, hPa or cmH2O, gauge pressure (which comes near 0), a vacuum,
/// pressure far above the supply; volume in litres or millilitres, not positive, or outside 1 mL to 100 L; command in per cent,
/// normalised, or otherwise no volts that a valve with the rig's thresholds is given; a supply_Pa column far from the rig's supply.
void require_units(const std::vector<NamedLog>& logs, const trace::RigDescription& rig);

/// What of a log is taken as it is, though it may not be what its user thinks, a line each: supply_Pa off the rig's supply by more
/// than a twentieth where it is highest (the 0.9 quantile), since all but supply_droop run on the rig's; pressures above that supply; a
/// pressure that stands still to the last digit although a port is open.
std::vector<std::string> notices(const std::vector<NamedLog>& logs, const trace::RigDescription& rig);

/// Likewise where the rest of each log after `fitted_share` of its rows is held out: a rest that moves over less than a quarter of the
/// pressures that what is fitted moves over, or over more than four times as many.
std::vector<std::string> notices_of_rests(const std::vector<NamedLog>& logs, double fitted_share);

/// Throws trace::InputError for a log of another rate than the rig's.
void require_rate(const std::vector<NamedLog>& logs, const trace::RigDescription& rig);

/// Throws CannotDiagnose for logs that are shorter than kShortest_s, taken together.
void require_length(const std::vector<NamedLog>& logs);

/// As require_units and require_rate; then, of the logs taken together, throws CannotDiagnose: as require_length; a
/// command that rests or opens no port; a pressure that does not move beyond noise; 95 % of the rows saturated
/// (at supply or ambient, or still although a port is open); a sensor that clips.
void require_diagnosable(const std::vector<NamedLog>& logs, const trace::RigDescription& rig);

}  // namespace plenum::host::diagnose
