// The cylinder against SUNDIALS CVODE: the equations written again in their plainest form, BDF at a tight
// tolerance, stick and slip located by CVODE's own root finding.
#include <cvode/cvode.h>
#include <gtest/gtest.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <array>
#include <cmath>

#include "host-sim/plant/servo/cylinder.hpp"

namespace plenum::host::plant::servo {
namespace {

// (2) with the closed-form constants, upstream temperature T.
double flow(double area, double T, double R, double upstream, double downstream) {
  const double k = 1.4;
  const double r = downstream / upstream;
  const double scale = area * upstream / std::sqrt(T);
  if (r <= std::pow(2.0 / 2.4, 3.5)) return scale * std::sqrt(k / R * std::pow(2.0 / 2.4, 6.0));
  return scale * std::sqrt(2.0 * k / (R * 0.4)) * std::pow(r, 1.0 / k) *
         std::sqrt(1.0 - std::pow(r, 0.4 / 1.4));
}

struct Reference {
  ServoCylinderConfig c;
  ThinPlateValveConfig v;
  double index = 1.4;
  std::array<double, 2> u{5.0, 5.0};
  int direction = 0;  // 0: stuck

  double drive(const double* y) const {
    return y[2] * c.piston_area_1_m2 - y[4] * c.piston_area_2_m2 -
           c.ambient_Pa * (c.piston_area_1_m2 - c.piston_area_2_m2);
  }
  void rates(const double* y, double* dy) const {
    const double R = c.gas.specific_gas_constant_J_kg_K();
    const double T0 = c.gas.temperature_K;
    for (int j = 0; j < 2; ++j) {
      const double A = j == 0 ? c.piston_area_1_m2 : c.piston_area_2_m2;
      const double s = j == 0 ? 1.0 : -1.0;
      const double V = 20e-6 + A * (0.5 * c.stroke_m + s * y[0]);
      const double P = y[2 + 2 * j];
      const double m = y[3 + 2 * j];
      const double T = P * V / (m * R);
      const auto smooth = [&](double gain, double over_V, double leak) {
        const double a = gain * over_V - leak;
        return 0.72 * (leak + 0.5 * (std::sqrt(a * a + v.transition_m2 * v.transition_m2) + a));
      };
      const double uj = u[static_cast<std::size_t>(j)];
      const double a_c = smooth(v.inlet_area_per_V_m2, uj - v.open_above_V, v.inlet_leak_m2);
      const double a_r = smooth(v.exhaust_area_per_V_m2, v.exhaust_below_V - uj, v.exhaust_leak_m2);
      double in = 0.0;
      double out = 0.0;
      (c.supply_Pa >= P ? in : out) +=
          c.supply_Pa >= P ? flow(a_c, T0, R, c.supply_Pa, P) : flow(a_c, T, R, P, c.supply_Pa);
      (c.ambient_Pa > P ? in : out) +=
          c.ambient_Pa > P ? flow(a_r, T0, R, c.ambient_Pa, P) : flow(a_r, T, R, P, c.ambient_Pa);
      dy[2 + 2 * j] = index * (R * T * (in - out) - P * s * A * y[1]) / V;
      dy[3 + 2 * j] = in - out;
    }
    dy[0] = direction == 0 ? 0.0 : y[1];
    dy[1] = 0.0;
    if (direction != 0) {
      const Friction& f = c.friction;
      const double friction =
          direction * (f.coulomb_N + f.stribeck_N * std::exp(-direction * y[1] / f.stribeck_velocity_m_s)) +
          f.viscous_N_s_m * y[1];
      dy[1] = (drive(y) - friction) / c.moving_mass_kg;
    }
  }
};

int cvode_rates(realtype, N_Vector y, N_Vector dy, void* data) {
  static_cast<const Reference*>(data)->rates(N_VGetArrayPointer(y), N_VGetArrayPointer(dy));
  return 0;
}

int cvode_events(realtype, N_Vector y, realtype* g, void* data) {
  const auto& reference = *static_cast<const Reference*>(data);
  const double* p = N_VGetArrayPointer(y);
  const double over = std::abs(reference.drive(p)) - reference.c.friction.breakaway_N();
  g[0] = reference.direction == 0 ? over : reference.direction * p[1] + 1e-14;
  return 0;
}

class Cvode {
 public:
  Cvode(Reference& reference, const CylinderVector& start) : reference_(reference) {
    SUNContext_Create(nullptr, &context_);
    y_ = N_VNew_Serial(6, context_);
    weights_ = N_VNew_Serial(6, context_);
    for (int i = 0; i < 6; ++i) NV_Ith_S(y_, i) = start[i];
    const std::array<double, 6> absolute{1e-11, 1e-10, 1e-5, 1e-14, 1e-5, 1e-14};
    for (int i = 0; i < 6; ++i) NV_Ith_S(weights_, i) = absolute[static_cast<std::size_t>(i)];
    memory_ = CVodeCreate(CV_BDF, context_);
    CVodeInit(memory_, cvode_rates, 0.0, y_);
    CVodeSVtolerances(memory_, 1e-11, weights_);
    CVodeSetUserData(memory_, &reference_);
    matrix_ = SUNDenseMatrix(6, 6, context_);
    solver_ = SUNLinSol_Dense(y_, matrix_, context_);
    CVodeSetLinearSolver(memory_, solver_, matrix_);
    CVodeRootInit(memory_, 1, cvode_events);
    CVodeSetMaxNumSteps(memory_, 1000000);
  }
  ~Cvode() {
    CVodeFree(&memory_);
    SUNLinSolFree(solver_);
    SUNMatDestroy(matrix_);
    N_VDestroy(y_);
    N_VDestroy(weights_);
    SUNContext_Free(&context_);
  }
  Cvode(const Cvode&) = delete;
  Cvode& operator=(const Cvode&) = delete;

  // To `until_s` with the commands of the reference held; returns how many events were passed.
  int advance(double until_s) {
    int events = 0;
    restart(now_s_);
    while (now_s_ < until_s) {
      CVodeSetStopTime(memory_, until_s);
      const int flag = CVode(memory_, until_s, y_, &now_s_, CV_NORMAL);
      EXPECT_GE(flag, 0);
      if (flag < 0) return -1;
      if (flag == CV_ROOT_RETURN) {
        ++events;
        change();
        restart(now_s_);
      }
    }
    return events;
  }
  double operator[](int i) const { return NV_Ith_S(y_, i); }

 private:
  void change() {
    double* y = N_VGetArrayPointer(y_);
    const double drive = reference_.drive(y);
    if (reference_.direction != 0) y[1] = 0.0;
    const bool free = std::abs(drive) >= reference_.c.friction.breakaway_N() * (1.0 - 1e-12);
    reference_.direction = free ? (drive > 0.0 ? 1 : -1) : 0;
    if (free) y[1] = reference_.direction * 1e-12;  // off the root from which it starts
  }
  void restart(double t) { CVodeReInit(memory_, t, y_); }

  Reference& reference_;
  SUNContext context_ = nullptr;
  void* memory_ = nullptr;
  N_Vector y_ = nullptr;
  N_Vector weights_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver solver_ = nullptr;
  double now_s_ = 0.0;
};

TEST(ServoCylinderAgainstCvode, AgreesThroughStickSlipAndReversal) {
  for (const double index : {1.0, 1.4}) {
    ServoCylinderConfig config;
    config.law = Polytropic{index};
    config.initial_pressure_1_Pa = 3.0e5;
    config.initial_pressure_2_Pa = 3.3e5;
    const ThinPlateValveConfig valve;
    ServoCylinder cylinder(std::array<ThinPlateValve, 2>{ThinPlateValve(valve), ThinPlateValve(valve)},
                           config);
    Reference reference;
    reference.c = config;
    reference.v = valve;
    reference.index = index;
    Cvode cvode(reference, initial_state(config));
    int events = 0;
    for (int i = 1; i <= 120; ++i) {
      const double u = i <= 25 ? 5.5 : i <= 60 ? 4.6 : i <= 80 ? 5.02 : 5.3;
      const Commands commands = five_three_commands_V(u);
      reference.u = commands;
      cylinder.advance(commands, 0.01);
      events += cvode.advance(0.01 * i);
      ASSERT_NEAR(cylinder.position_m(), cvode[0], 1e-6) << "index " << index << ", t = " << 0.01 * i << " s";
      ASSERT_NEAR(cylinder.velocity_m_s(), cvode[1], 1e-5) << "t = " << 0.01 * i << " s";
      ASSERT_NEAR(cylinder.pressure_Pa(0), cvode[2], 10.0) << "t = " << 0.01 * i << " s";
      ASSERT_NEAR(cylinder.pressure_Pa(1), cvode[4], 10.0) << "t = " << 0.01 * i << " s";
    }
    EXPECT_GE(events, 4);
    EXPECT_EQ(cylinder.sticks() + cylinder.slips(), static_cast<std::uint64_t>(events));
  }
}

}  // namespace
}  // namespace plenum::host::plant::servo
