// Whether pressures count from vacuum. A log that never comes near ambient does not show by its range that it is in gauge pressure, and
// neither does a supply; the error would be named an offset of the sensor, with confidence.
#pragma once

#include "host-sim/diagnose/other_reading.hpp"
#include "host-sim/identify/chamber/fit.hpp"

namespace plenum::host::diagnose {

/// `found`: the fit of the valve's figures to the scene's records, and of the effects that are on. Throws trace::InputError naming the log,
/// and the column or the rig's key, where the same figures explain the pressures far better with ambient pressure added to them, to the
/// supply, or to both. A column that would come above what the supply and a volume that moves can make of it is not gauge pressure. Does nothing where `found` is near the
/// noise.
void require_absolute_pressures(const identify::chamber::Scene& scene, const identify::chamber::Fit& found,
                                unsigned threads);
/// The same of logs that a model errs by so much of, judged by what it errs of other readings.
void require_absolute_pressures(const identify::chamber::Scene& scene, double as_written_Pa,
                                const ErrorOf& error_of, unsigned threads);

/// The same of a log in gauge pressure whose machine has an effect besides, so that no fit tells: where `found` has a sensor that reads less by nearly ambient pressure, as no sensor does. Throws trace::InputError.
void require_no_offset_of_ambient(const identify::chamber::Scene& scene, const identify::chamber::Fit& found);

}  // namespace plenum::host::diagnose
