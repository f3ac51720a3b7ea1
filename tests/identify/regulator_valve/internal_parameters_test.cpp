#include "host-sim/identify/regulator_valve/internal_parameters.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify::regulator_valve {
namespace {

using plant::regulator_valve::bench_valve;
using plant::regulator_valve::ValveConfig;
using testing::HasSubstr;
using testing::ThrowsMessage;

SystemConstants of_the_bench(const ValveConfig& valve) {
  SystemConstants constants;
  constants.gamma_R_T_J_kg = plant::regulator_valve::gamma_R_T_J_kg(valve.gas);
  constants.blocked_flow_s_m = plant::regulator_valve::blocked_flow_s_m(valve.gas);
  return constants;
}

TEST(InternalParameters, AreThoseOfTheValveWhoseLinearModelsAreGiven) {
  const ValveConfig valve = bench_valve();
  const SystemConstants constants = of_the_bench(valve);
  const double rest_Pa = 1.56e8 * constants.rest_screw_m;
  const InternalParameters found =
      internal_parameters(discretise(linear_pressurisation(valve), 0.0005),
                          discretise(linear_exhaustion(valve, rest_Pa), 0.0005), constants);
  EXPECT_NEAR(found.plunger_mass_kg / valve.plunger_mass_kg, 1.0, 1e-9);
  EXPECT_NEAR(found.spool_mass_kg / valve.spool_mass_kg, 1.0, 1e-9);
  EXPECT_NEAR(found.plunger_spring_N_m / valve.plunger_spring_N_m, 1.0, 1e-8);
  EXPECT_NEAR(found.spool_spring_N_m / valve.spool_spring_N_m, 1.0, 1e-8);
  EXPECT_NEAR(found.diaphragm_area_m2 / valve.diaphragm_area_m2, 1.0, 1e-6);
  EXPECT_NEAR(found.exhaustion_diaphragm_area_m2 / valve.diaphragm_area_m2, 1.0, 1e-6);
  EXPECT_NEAR(found.inlet_width_m / valve.inlet_width_m, 1.0, 1e-6);
  EXPECT_NEAR(found.exhaust_width_m / valve.exhaust_width_m, 1.0, 1e-6);
  EXPECT_NEAR(found.rest_Pa / rest_Pa, 1.0, 1e-6);
}

TEST(InternalParameters, SaysWhichCoefficientIsNothing) {
  const DiscreteModel integrator{.b_Pa_m = 1.0, .a = {-3.0, 3.0, -1.0}};  // c_2 = c_3 = c_4 = 0
  const DiscreteModel any = discretise(linear_pressurisation(bench_valve()), 0.0005);
  EXPECT_THAT([&] { internal_parameters(integrator, any); },
              ThrowsMessage<CannotIdentify>(HasSubstr("c_2 is 0")));
  EXPECT_THAT([&] { internal_parameters(any, integrator); },
              ThrowsMessage<CannotIdentify>(HasSubstr("c_6 is 0")));
}

}  // namespace
}  // namespace plenum::host::identify::regulator_valve
