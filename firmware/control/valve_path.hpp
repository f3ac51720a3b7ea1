// From the command that is sent to the place of the spool that lets gas through, and back.
//
//   z = clamp(z-, u - w/2, u + w/2)                      hysteresis: the play operator of width w
//   lambda x' = z - x, over a tick: x+ = z + (x - z) e^(-1/lambda)          (V1)
//   acts on the flow d ticks later, from then on for a tick
//
// u valve command, z and x places of the spool as the commands that hold it there at rest [V]; lambda [ticks]. (V1) is met
// at the end of the tick: over the tick the place is in the mean still the share
//   w_m = lambda - e^(-1/lambda)/(1 - e^(-1/lambda))                          (V2)
// of its way behind, as if it had jumped w_m ticks late: delay_ticks() counts that to d. 0 for a prompt spool, 1/2 at most.
//
// The inverse is exact: command_for(x) is the command after which the spool stands at x when the tick ends. It asks for
// more than x where x moves, by 1/(1 - e^(-1/lambda)); the valve's limits are the caller's.
//
// Source: Visintin, Differential Models of Hysteresis (1994), III.2, for the play and its inverse; (V1) is the first-order
// equation with a held input.
#pragma once

#include <cstdint>

#include "firmware/config/limits.hpp"
#include "firmware/config/seal.hpp"
#include "firmware/numeric/scalar.hpp"

namespace plenum::control {

using numeric::Scalar;

class ValvePath {
 public:
  static constexpr Scalar kMostDelay_ticks = Scalar(config::kMostValveDelay_ticks);

  struct Config {
    Scalar dead_ticks = 0;  ///< d
    Scalar lag_ticks = 0;   ///< lambda
    Scalar play_V = 0;      ///< w
  };

  void configure(const Config& config) noexcept;

  /// The spool rests where `command_V` has put it.
  void reset(Scalar command_V) noexcept;

  /// From a command to its act on the flow, at most kMostDelay_ticks.
  Scalar delay_ticks() const noexcept { return delay_ticks_; }

  /// The command that puts the spool at `place_V` at this tick's end.
  Scalar command_for(Scalar place_V) const noexcept;

  /// A command was sent for this tick. Returns the place of the spool at its end.
  Scalar sent(Scalar command_V) noexcept;

  /// Of what configure() alone writes: config/seal.hpp.
  std::uint64_t sum_of_constants() const noexcept {
    return config::sum_of_object(half_play_V_) + config::sum_of_object(done_) +
           config::sum_of_object(delay_ticks_);
  }
  std::uint64_t sum_of_places() const noexcept {
    return config::sum_of_object(command_V_) + config::sum_of_object(held_V_) +
           config::sum_of_object(place_V_);
  }

 private:
  Scalar half_play_V_ = 0;
  Scalar done_ = 1;  ///< 1 - e^(-1/lambda)
  Scalar delay_ticks_ = 0;
  Scalar command_V_ = 0;  ///< the last one
  Scalar held_V_ = 0;     ///< z
  Scalar place_V_ = 0;    ///< x
};

}  // namespace plenum::control
