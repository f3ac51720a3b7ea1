// SUNDIALS CVODE as the second route: the same equations without constraints in force, another method and
// code.
#include <cvode/cvode.h>
#include <gtest/gtest.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <cmath>

#include "host-sim/plant/relief_valve/inch_units.hpp"
#include "host-sim/plant/relief_valve/two_stage_run.hpp"
#include "host-sim/plant/relief_valve/two_stage_static.hpp"

namespace {

using namespace plenum::host::plant::relief_valve;

struct Case {
  const TwoStagePhysics* physics;
  double from_m3_s, to_m3_s, ramp_s;
  double supply(double t) const { return from_m3_s + (to_m3_s - from_m3_s) * std::min(t / ramp_s, 1.0); }
};

int rate(realtype t, N_Vector y, N_Vector dy, void* data) {
  const Case& c = *static_cast<const Case*>(data);
  TwoStageState s;
  std::copy_n(N_VGetArrayPointer(y), 6, s.begin());
  const TwoStageState d = c.physics->rate(s, c.supply(t));
  std::copy(d.begin(), d.end(), N_VGetArrayPointer(dy));
  return 0;
}

TwoStageState by_cvode(const Case& c, const TwoStageState& start, double duration_s) {
  SUNContext context = nullptr;
  SUNContext_Create(nullptr, &context);
  N_Vector y = N_VNew_Serial(6, context);
  N_Vector tolerance = N_VNew_Serial(6, context);
  std::copy(start.begin(), start.end(), N_VGetArrayPointer(y));
  const double floor[] = {1e-3, 1e-3, 1e-13, 1e-10, 1e-13, 1e-10};
  std::copy_n(floor, 6, N_VGetArrayPointer(tolerance));
  void* cvode = CVodeCreate(CV_BDF, context);
  CVodeInit(cvode, rate, 0.0, y);
  CVodeSVtolerances(cvode, 1e-10, tolerance);
  CVodeSetUserData(cvode, const_cast<Case*>(&c));
  CVodeSetMaxNumSteps(cvode, 1000000);
  SUNMatrix A = SUNDenseMatrix(6, 6, context);
  SUNLinearSolver solver = SUNLinSol_Dense(y, A, context);
  CVodeSetLinearSolver(cvode, solver, A);
  realtype t = 0.0;
  for (const double stop : {c.ramp_s, duration_s}) {  // the supply's corner is a stop
    CVodeSetStopTime(cvode, stop);
    EXPECT_GE(CVode(cvode, stop, y, &t, CV_NORMAL), 0);
  }
  TwoStageState s;
  std::copy_n(N_VGetArrayPointer(y), 6, s.begin());
  SUNLinSolFree(solver);
  SUNMatDestroy(A);
  CVodeFree(&cvode);
  N_VDestroy(tolerance);
  N_VDestroy(y);
  SUNContext_Free(&context);
  return s;
}

TEST(TwoStageRun, AgreesWithCvodeWhileNoConstraintIsMet) {
  for (const double wider : {1.0, 2.0}) {  // the chamber: as printed, and softer
    TwoStageConfig config = appendix_a_settling();
    config.chamber_volume_m3 *= wider;
    const TwoStagePhysics physics(config);
    const double flow = 200.0 * kInch3_m3;
    const TwoStageState rest = two_stage_at_rest(physics, flow);
    const Case c{&physics, flow, 1.05 * flow, 0.003};
    constexpr double kDuration_s = 0.03;
    TwoStageValve valve(config, rest, 1e-10);
    valve.advance(c.from_m3_s, c.to_m3_s, c.ramp_s);
    valve.advance(c.to_m3_s, c.to_m3_s, kDuration_s - c.ramp_s);
    ASSERT_EQ(valve.effort().events, 0);
    const TwoStageState other = by_cvode(c, rest, kDuration_s);
    const double size[] = {1e5, 1e5, 1e-4, 1e-2, 1e-5, 1e-2};
    for (std::size_t n = 0; n < 6; ++n)
      EXPECT_NEAR(valve.state()[n], other[n], 1e-5 * size[n])
          << "state " << n << ", which moved by " << other[n] - rest[n];
  }
}

}  // namespace
