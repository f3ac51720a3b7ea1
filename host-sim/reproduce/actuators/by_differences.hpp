// A small least-squares problem by difference quotients, for identify::minimise_in_box: for the few fits of
// this folder whose model is no part of host-sim/identify.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "host-sim/identify/box_solver.hpp"

namespace plenum::host::reproduce::actuators {

using Variables = identify::BoxVector<Eigen::Dynamic>;

/// Errors at z, of a length that does not depend on z. Variables and errors should be of order one.
using Errors = std::function<Eigen::VectorXd(const Variables& z)>;

/// The z within [low, high] with the least sum of squared errors, from `start`; the Jacobian by forward
/// differences of 1e-6.
Variables least_squares(const Errors& errors, const Variables& start, const Variables& low,
                        const Variables& high);

}  // namespace plenum::host::reproduce::actuators
