// What a fit says of its figures, as a report tells it: value, interval, and whether it stopped at a bound.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "host-sim/diagnose/gap_report.hpp"
#include "host-sim/diagnose/trial.hpp"

namespace plenum::host::diagnose {

/// Of a variable of a fit that is a figure of the valve or of an effect; `errors`: standard_errors() of the fit. Throws std::logic_error
/// for a figure of the log.
Estimate estimate_of(const Fit& fit, std::size_t variable, const Eigen::VectorXd& errors);

/// Of the parameters of an effect of the trial's set, its errors being correlated over so many rows.
std::vector<Estimate> parameters_of(const Trial& trial, std::size_t effect, double correlated_rows);

}  // namespace plenum::host::diagnose
