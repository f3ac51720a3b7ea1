// One function for each equation set, table or figure of the paper.
#pragma once

#include <vector>

#include "host-sim/reproduce/actuators/study.hpp"
#include "host-sim/reproduce/finding.hpp"

namespace plenum::host::reproduce::actuators {

Part numbers_of_the_text();
Part gas_and_port_constants();
Part thin_plate_flow();
Part two_port_chamber();
Part valve_areas();
Part steady_state();
Part proposed_model();
Part volume_rate(const Study& study);
Part identified_curves(const Study& study);
Part identified_ports(const Study& study);
Part parameters(const Study& study);
Part convergence(const Study& study, const Progress& progress);
Part pressure_change(const Study& study);
Part pressure_prediction(const Study& study);
Part drift_of_prediction(const Study& study);

/// All of them, in the paper's order. A reason stays only where the verdict asks for one.
std::vector<Part> parts_of(const Study& study, const Progress& progress);

}  // namespace plenum::host::reproduce::actuators
