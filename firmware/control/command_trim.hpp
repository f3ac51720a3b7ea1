// What the valve really needs, learned in operation: a correction of the command as a function of the
// command.
//
//   valve command = model command + c(model command)
//
// c is piecewise linear over kNodes commands. The identified curve of a valve is a smooth formula; a real
// valve has a dead band, a bent area curve and a null that drifts. The slope of c is bounded: that carries
// the curve over commands at which nothing can be learned (sealed ports), and keeps the gain of the loop
// within a factor of two. c stays within its limit, and is zero until something is learned.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/config/seal.hpp"
#include "firmware/numeric/scalar.hpp"

namespace plenum::control {

using numeric::Scalar;

class CommandTrim {
 public:
  static constexpr std::size_t kNodes = 17;

  struct Config {
    Scalar low_V = Scalar(3);    ///< first node
    Scalar high_V = Scalar(7);   ///< last node, above low_V
    Scalar limit_V = Scalar(1);  ///< largest correction believed
  };

  void configure(const Config& config) noexcept;
  void reset() noexcept { correction_V_.fill(Scalar(0)); }

  /// Of what configure() alone writes: config/seal.hpp.
  std::uint64_t sum_of_constants() const noexcept {
    return config::sum_of_object(config_) + config::sum_of_object(nodes_per_V_) +
           config::sum_of_object(most_V_) + config::sum_of_object(least_V_);
  }

  /// Of what it has learned.
  std::uint64_t sum_of_estimates() const noexcept { return config::sum_of_object(correction_V_); }

  /// The correction at a model command [V].
  Scalar at(Scalar model_V) const noexcept;

  /// Of a command among the nodes.
  struct Place {
    std::size_t below;   ///< node at or below the command
    Scalar above_share;  ///< how far it is to the next one
  };
  Place place(Scalar model_V) const noexcept;
  Scalar at(const Place& place) const noexcept;

  /// The sum of the squares of the two nodes' shares in the correction there: how much of it one learning step of unit size moves.
  static Scalar reach(const Place& at) noexcept;

  /// Moves the two nodes by `step_V`, each by its share.
  void move(const Place& at, Scalar step_V) noexcept;

 private:
  void level(std::size_t below) noexcept;

  Config config_;
  Scalar nodes_per_V_ = Scalar(4);
  Scalar most_V_ = Scalar(0.25);     ///< from node to node the correction rises by so much at most ...
  Scalar least_V_ = Scalar(-0.125);  ///< ... and by so much at least
  std::array<Scalar, kNodes> correction_V_{};
};

}  // namespace plenum::control
