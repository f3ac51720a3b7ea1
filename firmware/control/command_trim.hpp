// What the valve really needs, learned in operation: a correction of the command as a function of the
// command.
//
//   valve command = model command + c(model command)
//
// c is piecewise linear over kNodes commands. The identified curve of a valve is a smooth formula; a real
// valve has a dead band, a bent area curve and a null that drifts. When the pressure moved by `residual` more
// than the model said under a command at which the model's pressure changes by `slope` a volt, the command
// there was too large by about residual/slope; a share of that is taken off the two neighbouring nodes
// (normalised least mean squares). Where the slope is small (sealed ports) nothing is learned: there the
// command says nothing about the flow.
//
// c stays within its limit and vanishes with gain 0.
#pragma once

#include <array>
#include <cstddef>

#include "firmware/numeric/scalar.hpp"

namespace plenum::control {

using numeric::Scalar;

class CommandTrim {
 public:
  static constexpr std::size_t kNodes = 17;

  struct Config {
    Scalar low_V = Scalar(3);              ///< first node
    Scalar high_V = Scalar(7);             ///< last node, above low_V
    Scalar gain = Scalar(0.2);             ///< share of an error that is learned in a tick
    Scalar limit_V = Scalar(1);            ///< largest correction believed
    Scalar slope_floor_kPa_V = Scalar(5);  ///< slopes well below it teach nothing
  };

  void configure(const Config& config) noexcept;
  void reset() noexcept { correction_V_.fill(Scalar(0)); }

  /// The correction at a model command [V].
  Scalar at(Scalar model_V) const noexcept;

  void learn(Scalar model_V, Scalar residual_kPa, Scalar slope_kPa_V) noexcept;

 private:
  struct Place {
    std::size_t below;   ///< node at or below the command
    Scalar above_share;  ///< how far it is to the next one
  };
  Place place(Scalar model_V) const noexcept;

  Config config_;
  Scalar nodes_per_V_ = Scalar(4);
  std::array<Scalar, kNodes> correction_V_{};
};

}  // namespace plenum::control
