// Whether the command of a log is the one that acted. A column of the other sign, written a row late, or beside a pressure or a volume
// written early, has no effect of the catalogue as its cause, and would get one: nothing else makes a chamber answer before it is asked.
#pragma once

#include "host-sim/diagnose/other_reading.hpp"
#include "host-sim/identify/chamber/fit.hpp"

namespace plenum::host::diagnose {

/// `recalibrated`: of the scene's records, without effects. Throws trace::InputError naming the log, the column and what was found where
/// the valve's figures explain the log far better by commands mirrored about the valve's null, or one or two rows earlier, by
/// pressures one or two rows later, or by volumes half a row to two later. Where no log tells the sign from a lag
/// (identify/sign_of_command.hpp), only a mirror image that comes near the noise counts. Does nothing where the recalibrated model is near the noise.
void require_acting_command(const identify::chamber::Scene& scene, const identify::chamber::Fit& recalibrated,
                            unsigned threads);
/// The same of logs that a model errs by so much of, judged by what it errs of other readings.
void require_acting_command(const identify::chamber::Scene& scene, double as_logged_Pa,
                            const ErrorOf& error_of, unsigned threads);

}  // namespace plenum::host::diagnose
