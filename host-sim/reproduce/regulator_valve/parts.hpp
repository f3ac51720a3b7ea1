// One function for each equation set, table or figure of the paper.
#pragma once

#include "host-sim/reproduce/finding.hpp"
#include "host-sim/reproduce/regulator_valve/campaign.hpp"

namespace plenum::host::reproduce::regulator_valve {

Part constants();
Part mass_conservation();
Part nozzle();
Part linear_models();
Part discretisation();
Part time_constant();
Part step_experiment(const Campaign& campaign);
Part printed_models();
Part printed_coefficients(const Campaign& campaign);
Part methods(const Campaign& campaign);
Part accuracy(const Campaign& campaign);
Part other_staircases(const Campaign& campaign);
Part influence_of_noise(const Progress& progress);
Part internal_parameters();
Part valve_of_table2();
Part recovered_parameters(const Campaign& campaign);

}  // namespace plenum::host::reproduce::regulator_valve
