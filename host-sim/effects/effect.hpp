// What an entry of the catalogue says of itself. How it acts stands beside it, in the effect's own file.
#pragma once

#include <cmath>
#include <limits>
#include <span>
#include <string_view>

namespace plenum::host::effects {

/// The equation of the chamber in which an effect lives.
enum class Equation { command, valve_area, mass_flow, supply, energy, sensor };

constexpr std::string_view name_of(Equation equation) {
  constexpr std::string_view kNames[] = {"command", "valve_area", "mass_flow", "supply", "energy", "sensor"};
  return kNames[static_cast<int>(equation)];
}

/// How a parameter enters a calculation. A frequency that vanishes at infinity enters by its reciprocal, which
/// vanishes at zero, where it can be differentiated; a limit that acts by its square, by the square of that.
enum class Coordinate { linear, reciprocal, reciprocal_square };

struct Parameter {
  std::string_view name;  ///< with its unit: natural_frequency_Hz
  std::string_view what;
  double low = 0.0;             ///< least value allowed, in the unit of the name
  double high = 0.0;            ///< greatest
  double vanishes_at = 0.0;     ///< with this value the effect is gone; in a shape parameter: its plain value
  double typical_change = 0.0;  ///< of the coordinate: what a search takes as one step
  Coordinate coordinate = Coordinate::linear;
  bool refines = false;  ///< a fit frees it only where the effect's other parameters do not suffice

  double coordinate_of(double value) const {
    if (coordinate == Coordinate::linear) return value;
    return coordinate == Coordinate::reciprocal ? 1.0 / value : 1.0 / (value * value);
  }
  double value_of(double at) const {
    if (coordinate == Coordinate::linear) return at;
    return coordinate == Coordinate::reciprocal ? 1.0 / at : 1.0 / std::sqrt(at);
  }
  double least() const { return coordinate == Coordinate::linear ? low : coordinate_of(high); }
  double greatest() const { return coordinate == Coordinate::linear ? high : coordinate_of(low); }
  double neutral() const { return coordinate_of(vanishes_at); }
};

struct Effect {
  std::string_view id;
  Equation equation;
  std::string_view summary;
  std::string_view formula;
  std::string_view source;
  std::span<const Parameter> parameters;
};

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace plenum::host::effects
