// A chamber integrated by SUNDIALS CVODE: the second route to what host-sim/plant/chamber.hpp integrates.
//
//   pdot = (R T / v)(n_c mdot_c - n_r mdot_r) - kappa (vdot / v) p,    q' = p
//   x'' = omega^2 (u - x) - 2 zeta omega x'                            with a spool
//
// p [Pa]; q the integral of p since the command was set [Pa s]; x effective command [V]. The port flows and
// the motion of the volume are the plant's own functions: what is compared is the integration alone.
//
// States: p; p, q; or p, q, x, x'. The Jacobian is given where there is no spool; with one, the slope of the
// openings by x is left to CVODE's difference quotients. The command steps at the edge of a tick, so CVODE is
// restarted there and never looks beyond the end of the tick.
#pragma once

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "host-sim/plant/chamber.hpp"

namespace plenum::host::plant::oracle {

enum class CvodeMethod {
  kBdfNewton,
  kAdamsNewton,
  kAdamsFixedPoint,
};

struct CvodeSettings {
  CvodeMethod method = CvodeMethod::kBdfNewton;
  double relative_tolerance = 1e-11;
  double absolute_tolerance_Pa = 1e-5;
  double first_step_s = 0.0;  ///< of each tick; 0: CVODE finds it
  bool with_mean = true;      ///< q beside p; needed where there is a spool
};

/// AnyValve: ThinPlateValve or MpyeValve. Stays where it was made: CVODE holds its address.
template <class AnyValve>
class CvodeChamber {
 public:
  CvodeChamber(const AnyValve& valve, const ChamberConfig& config, const VolumeMotion& volume,
               const CvodeSettings& settings)
      : valve_(valve), config_(config), volume_(volume), settings_(settings), states_(state_count()) {
    SUNContext context = nullptr;
    require(SUNContext_Create(nullptr, &context), "SUNContext_Create");
    context_.reset(context);
    y_.reset(N_VNew_Serial(states_, context));
    double* const y = N_VGetArrayPointer(y_.get());
    y[0] = config.initial_pressure_Pa;
    if (config.spool) {
      y[2] = config.initial_command_V;
      y[3] = 0.0;
    }
    const bool adams = settings.method != CvodeMethod::kBdfNewton;
    memory_.reset(CVodeCreate(adams ? CV_ADAMS : CV_BDF, context));
    require(CVodeInit(memory_.get(), derivative, 0.0, y_.get()), "CVodeInit");
    require(CVodeSetUserData(memory_.get(), this), "CVodeSetUserData");
    require(CVodeSStolerances(memory_.get(), settings.relative_tolerance, settings.absolute_tolerance_Pa),
            "CVodeSStolerances");
    require(CVodeSetMaxNumSteps(memory_.get(), 1000000), "CVodeSetMaxNumSteps");
    if (settings.method == CvodeMethod::kAdamsFixedPoint) {
      fixed_point_.reset(SUNNonlinSol_FixedPoint(y_.get(), 0, context));
      require(CVodeSetNonlinearSolver(memory_.get(), fixed_point_.get()), "CVodeSetNonlinearSolver");
    } else {
      matrix_.reset(SUNDenseMatrix(states_, states_, context));
      linear_.reset(SUNLinSol_Dense(y_.get(), matrix_.get(), context));
      require(CVodeSetLinearSolver(memory_.get(), linear_.get(), matrix_.get()), "CVodeSetLinearSolver");
      if (!config.spool) require(CVodeSetJacFn(memory_.get(), jacobian), "CVodeSetJacFn");
    }
  }
  CvodeChamber(const CvodeChamber&) = delete;
  CvodeChamber& operator=(const CvodeChamber&) = delete;

  /// As ChamberPlant::advance(); the mean is 0 without `with_mean`.
  Interval advance(double command_V, double duration_s) {
    double* const y = N_VGetArrayPointer(y_.get());
    command_V_ = command_V;
    opening_ = valve_.opening(command_V);
    motion_ = VolumeMotion::Interval(volume_, time_s_);
    if (states_ > 1) y[1] = 0.0;
    require(CVodeReInit(memory_.get(), 0.0, y_.get()), "CVodeReInit");
    require(CVodeSetInitStep(memory_.get(), settings_.first_step_s), "CVodeSetInitStep");
    require(CVodeSetStopTime(memory_.get(), duration_s), "CVodeSetStopTime");
    double reached_s = 0.0;
    require(CVode(memory_.get(), duration_s, y_.get(), &reached_s, CV_NORMAL), "CVode");
    time_s_ += duration_s;
    long evaluations = 0;
    require(CVodeGetNumRhsEvals(memory_.get(), &evaluations), "CVodeGetNumRhsEvals");
    evaluations_ += static_cast<std::uint64_t>(evaluations);
    return {y[0], states_ > 1 ? y[1] / duration_s : 0.0};
  }

  double time_s() const { return time_s_; }
  /// Of the right side, since construction.
  std::uint64_t evaluations() const { return evaluations_; }

 private:
  struct Free {
    void operator()(SUNContext context) const { SUNContext_Free(&context); }
    void operator()(N_Vector vector) const { N_VDestroy(vector); }
    void operator()(SUNMatrix matrix) const { SUNMatDestroy(matrix); }
    void operator()(SUNLinearSolver solver) const { SUNLinSolFree(solver); }
    void operator()(SUNNonlinearSolver solver) const { SUNNonlinSolFree(solver); }
    void operator()(void* memory) const { CVodeFree(&memory); }
  };
  template <class Handle>
  using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Free>;

  static void require(int flag, const char* call) {
    if (flag < 0) throw std::runtime_error(std::string(call) + " returned " + std::to_string(flag));
  }

  int state_count() const {
    if (config_.spool) return 4;
    return settings_.with_mean ? 2 : 1;
  }

  struct Rate {
    double rate_Pa_s;
    double slope_1_s;
  };
  Rate rate(double t, double p, const typename AnyValve::Opening& opening) const {
    const FlowExponents n = valve_.exponents();
    const PortFlows m = valve_.flows(opening, p, config_.supply_Pa, config_.ambient_Pa);
    const double n_c = m.inlet_kg_s >= 0.0 ? n.entering : n.leaving;
    const double n_r = m.exhaust_kg_s >= 0.0 ? n.leaving : n.entering;
    const VolumeState v = motion_.at(t);
    const double RT_v = config_.gas.specific_gas_constant_J_kg_K() * config_.gas.temperature_K / v.volume_m3;
    const double compression = config_.gas.kappa * v.rate_m3_s / v.volume_m3;
    return {RT_v * (n_c * m.inlet_kg_s - n_r * m.exhaust_kg_s) - compression * p,
            RT_v * (n_c * m.inlet_slope_kg_s_Pa - n_r * m.exhaust_slope_kg_s_Pa) - compression};
  }

  static int derivative(realtype t, N_Vector state, N_Vector slope, void* self) {
    const auto& chamber = *static_cast<const CvodeChamber*>(self);
    const double* const y = N_VGetArrayPointer(state);
    double* const dy = N_VGetArrayPointer(slope);
    if (!(y[0] > 0.0)) return 1;  // a trial step too long: CVODE retries a shorter one
    if (chamber.states_ > 1) dy[1] = y[0];
    if (chamber.states_ == 4) {
      const SpoolConfig& spool = *chamber.config_.spool;
      const double omega = 2.0 * 3.141592653589793 * spool.natural_frequency_Hz;
      dy[2] = y[3];
      dy[3] = omega * omega * (chamber.command_V_ - y[2]) - 2.0 * spool.damping_ratio * omega * y[3];
      dy[0] = chamber.rate(t, y[0], chamber.valve_.opening(y[2])).rate_Pa_s;
    } else {
      dy[0] = chamber.rate(t, y[0], chamber.opening_).rate_Pa_s;
    }
    return 0;
  }

  static int jacobian(realtype t, N_Vector state, N_Vector, SUNMatrix matrix, void* self, N_Vector, N_Vector,
                      N_Vector) {
    const auto& chamber = *static_cast<const CvodeChamber*>(self);
    double* const J = SUNDenseMatrix_Data(matrix);  // by columns, zeroed by CVODE
    J[0] = chamber.rate(t, N_VGetArrayPointer(state)[0], chamber.opening_).slope_1_s;
    if (chamber.states_ > 1) J[1] = 1.0;
    return 0;
  }

  AnyValve valve_;
  ChamberConfig config_;
  VolumeMotion volume_;
  CvodeSettings settings_;
  int states_;
  double time_s_ = 0.0;
  double command_V_ = 0.0;
  typename AnyValve::Opening opening_{};
  VolumeMotion::Interval motion_{volume_, 0.0};
  std::uint64_t evaluations_ = 0;
  // Freed in the reverse order: what CVODE holds last, the context at the very end.
  Owned<SUNContext> context_;
  Owned<N_Vector> y_;
  Owned<SUNMatrix> matrix_;
  Owned<SUNLinearSolver> linear_;
  Owned<SUNNonlinearSolver> fixed_point_;
  std::unique_ptr<void, Free> memory_;
};

}  // namespace plenum::host::plant::oracle
