// The control core behind doubles, whatever it computes in: the same sources compiled once in fixed point and once in double.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

namespace equivalence {

/// Pressure [kPa] and motion [mL], [mL/s] of a chamber.
struct State {
  double pressure_kPa = 0;
  double volume_mL = 0;
  double volume_rate_mL_s = 0;
  double supply = 1;  ///< of what the model states
};
struct Prediction {
  double end_kPa = 0;
  double mean_kPa = 0;
};
struct Inverse {
  double command_V = 0;
  double reached_kPa = 0;
  bool saturated = false;
};

/// One chamber: a model, and the regulator that has it.
class Core {
 public:
  virtual ~Core() = default;

  virtual Prediction step(const State& from, double command_V) const = 0;
  virtual Inverse inverse(const State& from, double target_kPa, double near_V) const = 0;

  /// How many results this thread's numbers have cut off: Fixed::saturations(); of double 0.
  virtual std::uint32_t saturations() const = 0;

  /// The regulator begins here, at `command_V`.
  virtual void reset(double pressure_kPa, double volume_mL, double command_V) = 0;
  /// One tick in closed loop: what was measured over the tick just past, and the set point. Returns the command [V].
  virtual double regulate(double measured_kPa, double measured_mL, double setpoint_kPa) = 0;
};

/// Of a model kind's number (config::ModelKind) and its parameters, over commands of 0 to 10 V.
std::unique_ptr<Core> core_in_fixed(std::uint16_t kind, std::span<const float> parameters);
std::unique_ptr<Core> core_in_double(std::uint16_t kind, std::span<const float> parameters);

}  // namespace equivalence
