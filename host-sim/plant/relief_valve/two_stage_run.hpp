// The two-stage valve in time, with its stops and its positive pressures as events.
//
// Numerical treatment: the Rosenbrock method RODAS of fourth order (Hairer and Wanner, Solving ODEs II, IV.7;
// L-stable, stiffly accurate) with the exact Jacobian. Of its six unknowns a stage, x and y follow from x'
// and y', and those from the two pressures: what is left to solve is 2 x 2. The step is chosen so that the
// embedded third-order estimate stays below `tolerance` of each quantity's size.
//
// A constraint changes the equations, never the numbers: an element is moving, on its seat or at its stop; a
// pressure is positive or empty. Each such mode has a margin that is positive inside it (a distance from the
// stop, the force that holds the element there, a pressure). The step in which a margin becomes negative is
// repeated, shorter, until it ends there; then velocity is set to 0 (the stop takes the momentum) and the
// mode changes.
#pragma once

#include <array>
#include <functional>

#include "host-sim/plant/relief_valve/two_stage.hpp"

namespace plenum::host::plant::relief_valve {

class TwoStageValve {
 public:
  /// Throws std::invalid_argument when the configuration is not valid, the state is out of the constraints,
  /// or the tolerance is not within 1e-12 to 0.1.
  TwoStageValve(const TwoStageConfig& config, const TwoStageState& start, double tolerance = 1e-6);

  /// Told the time since construction [s] and the state after every step.
  using Watch = std::function<void(double time_s, const TwoStageState& state)>;

  /// Moves on with the supply flow going linearly from one value to the other [m3/s]; duration > 0 [s].
  void advance(double from_m3_s, double to_m3_s, double duration_s, const Watch& watch = {});

  const TwoStageState& state() const { return state_; }
  const TwoStagePhysics& physics() const { return physics_; }
  double time_s() const { return time_s_; }
  double valve_flow_m3_s() const { return physics_.valve_flow_m3_s(state_); }

  struct Effort {
    long steps = 0;    ///< accepted
    long refused = 0;  ///< for their error
    long located = 0;  ///< repeated to end at an event
    long events = 0;
  };
  const Effort& effort() const { return effort_; }

 private:
  enum class Place { kMoving, kOnSeat, kAtStop };
  struct Supply {
    double flow_m3_s, slope_m3_s2;  // at the start of the step
  };
  struct Trial {
    TwoStageState state;
    double error;  // of the tolerance
  };
  using Margins = std::array<double, 6>;

  TwoStageState constrained_rate(const TwoStageState& s, double supply_m3_s) const;
  bool chamber_follows() const;
  Trial step(const Supply& supply, double h) const;
  Margins margins(const TwoStageState& s, double supply_m3_s) const;
  void change_mode(std::size_t margin);
  void settle_modes(double supply_m3_s);
  Trial locate(const Supply& supply, Trial beyond, double& h);

  TwoStagePhysics physics_;
  TwoStageState state_;
  double tolerance_;
  std::array<double, 6> floor_;  // sizes below which a quantity counts as this large
  Place main_ = Place::kMoving;
  Place pilot_ = Place::kMoving;
  bool upstream_empty_ = false;
  bool chamber_empty_ = false;
  double time_s_ = 0.0;
  double next_s_ = 1e-5;
  Effort effort_;
};

}  // namespace plenum::host::plant::relief_valve
