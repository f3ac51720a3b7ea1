// A tick of the core's own models over a box: of all states and parameter sets within, where the pressure ends, and how far at
// most the board's fixed point is from that.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

namespace rounding {

struct Bounds {
  double low = 0, high = 0;
};

struct Box {
  Bounds pressure_kPa, command_V, volume_mL, speed_mL_s;
};

struct Tick {
  Bounds end_kPa, mean_kPa;  ///< in exact numbers
  double error_kPa = 0;      ///< of the board, in either
  double largest = 0;        ///< magnitude of any number on the way, the model's tables included
};

/// What a command does to the valve, or a motion to the pressure: control::Opening, without a third, or control::Moving.
struct Shares {
  Bounds first, second, third;
  double largest = 0;  ///< magnitude of any number on the way
};

class CoreModel {
 public:
  virtual ~CoreModel() = default;
  virtual Tick tick(const Box& box) const = 0;
  /// The same in three: its command, its motion, and what the pressure makes of both.
  virtual Shares opening(const Bounds& command_V) const = 0;
  virtual Shares moving(const Bounds& volume_mL, const Bounds& speed_mL_s) const = 0;
  virtual Tick step(const Bounds& pressure_kPa, const Shares& open, const Shares& moves) const = 0;
  /// So many of a set, from the first, are the chamber's, the last two the supply's and the ambient pressure.
  virtual std::size_t parameters() const = 0;
};

/// Of a kind ("tassa9", "tassa9r"), over commands of 0 to 10 V; `parameters`: in image order. None for another kind: the steps of a
/// grey box compare what a box leaves open (greybox_error.hpp). Throws std::invalid_argument for too few parameters.
std::unique_ptr<CoreModel> core_model(std::string_view kind, std::span<const Bounds> parameters);

}  // namespace rounding
