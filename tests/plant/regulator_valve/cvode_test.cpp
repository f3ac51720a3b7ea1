// The plant against SUNDIALS CVODE with its own right side and its own search for the crossing of x = 0.
#include <cvode/cvode.h>
#include <gtest/gtest.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "host-sim/plant/regulator_valve/valve.hpp"

namespace plenum::host::plant::regulator_valve {
namespace {

struct Truth {
  ValveConfig c;
  bool joined = true;
  double screw_from_m = 0.0;
  double screw_rate_m_s = 0.0;
};

double nozzle_kg_s_m2(double up_Pa, double down_Pa) {
  const double RT = 287.04 * 298.0;
  const double r = std::max(down_Pa / up_Pa, std::pow(2.0 / 2.4, 3.5));
  return r >= 1.0
             ? 0.0
             : up_Pa * std::sqrt(2.0 * 1.4 / (0.4 * RT) * (std::pow(r, 2.0 / 1.4) - std::pow(r, 2.4 / 1.4)));
}

int slope(double t, N_Vector y, N_Vector dy, void* data) {
  const Truth& truth = *static_cast<const Truth*>(data);
  const ValveConfig& c = truth.c;
  const double* const s = N_VGetArrayPointer(y);
  double* const d = N_VGetArrayPointer(dy);
  const double x = s[0];
  const double v = s[1];
  const double p = s[2];
  const double x_p = truth.screw_from_m + truth.screw_rate_m_s * t;
  const double lap = c.dead_band_m * c.plunger_spring_N_m / (c.plunger_spring_N_m + c.spool_spring_N_m);
  const double q_m = c.inlet_width_m * std::max(x - lap, 0.0) * nozzle_kg_s_m2(c.supply_Pa, p);
  const double q_e = c.exhaust_width_m * std::max(-x, 0.0) * nozzle_kg_s_m2(p, c.ambient_Pa);
  d[0] = v;
  if (truth.joined) {  // (24)
    d[1] = (-(c.plunger_damping_N_s_m + c.spool_damping_N_s_m) * v -
            (c.plunger_spring_N_m + c.spool_spring_N_m) * x + c.diaphragm_area_m2 * (c.ambient_Pa - p) +
            c.plunger_spring_N_m * x_p) /
           (c.plunger_mass_kg + c.spool_mass_kg);
  } else {  // (25)
    d[1] = (-c.plunger_damping_N_s_m * v - c.plunger_spring_N_m * x +
            c.diaphragm_area_m2 * (c.ambient_Pa - p) + c.plunger_spring_N_m * x_p) /
           c.plunger_mass_kg;
  }
  d[2] = 1.4 * 287.04 * 298.0 / c.volume_m3 * (q_m - q_e);
  return 0;
}

int stop(double, N_Vector y, double* root, void*) {
  root[0] = N_VGetArrayPointer(y)[0];
  return 0;
}

void require(int flag) {
  if (flag < 0) throw std::runtime_error("CVODE returned " + std::to_string(flag));
}

TEST(RegulatorValveAgainstCvode, TheStaircaseAgreesTo1e5OfSpan) {
  const ValveConfig config = bench_valve();
  const double start_m = 1.2e-3;
  const double start_Pa = 1.6e5;
  Valve valve(config, start_m, start_Pa);
  Truth truth{.c = config, .joined = true, .screw_from_m = start_m};

  SUNContext context = nullptr;
  require(SUNContext_Create(nullptr, &context));
  N_Vector y = N_VNew_Serial(3, context);
  double* const s = N_VGetArrayPointer(y);
  s[0] = valve.state().plunger_m;
  s[1] = 0.0;
  s[2] = start_Pa;
  ASSERT_TRUE(valve.joined());
  void* memory = CVodeCreate(CV_ADAMS, context);
  require(CVodeInit(memory, slope, 0.0, y));
  require(CVodeSetUserData(memory, &truth));
  require(CVodeSStolerances(memory, 1e-11, 1e-13));
  require(CVodeSetMaxNumSteps(memory, 1000000));
  SUNNonlinearSolver solver = SUNNonlinSol_FixedPoint(y, 0, context);
  require(CVodeSetNonlinearSolver(memory, solver));
  require(CVodeRootInit(memory, 1, stop));

  double worst_Pa = 0.0;
  int crossings = 0;
  for (const double target_m : {2.0e-3, 3.1e-3, 1.2e-3, 1.5e-3, 0.3e-3, 2.5e-3}) {
    const double from_m = valve.screw_m();
    for (int k = 0; k < 400; ++k) {
      const double to_m = from_m + (target_m - from_m) * std::min(1.0, (k + 1) / 40.0);
      truth.screw_from_m = valve.screw_m();
      truth.screw_rate_m_s = (to_m - valve.screw_m()) / 0.005;
      valve.advance(to_m, 0.005);
      double t = 0.0;
      require(CVodeReInit(memory, 0.0, y));
      while (t < 0.005) {
        require(CVodeSetStopTime(memory, 0.005));
        const int flag = CVode(memory, 0.005, y, &t, CV_NORMAL);
        require(flag);
        if (flag != CV_ROOT_RETURN) break;
        truth.joined = s[1] > 0.0;
        if (truth.joined) s[1] *= config.plunger_mass_kg / (config.plunger_mass_kg + config.spool_mass_kg);
        ++crossings;
        require(CVodeReInit(memory, t, y));
      }
      worst_Pa = std::max(worst_Pa, std::abs(s[2] - valve.state().pressure_Pa));
    }
  }
  EXPECT_GE(crossings, 3);
  EXPECT_LT(worst_Pa, 1e-5 * 4e5);

  CVodeFree(&memory);
  SUNNonlinSolFree(solver);
  N_VDestroy(y);
  SUNContext_Free(&context);
}

}  // namespace
}  // namespace plenum::host::plant::regulator_valve
