// What an entry of the catalogue says of itself. How it acts stands beside it, in the effect's own file.
#pragma once

#include <algorithm>
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

/// How large a chamber is, over those that the figures of the catalogue are for.
struct Size {
  double valve = 1.0;   ///< opening of the ports for a volt, over kSizedForGain_m2_V
  double volume = 1.0;  ///< in the mean, over kSizedForVolume_m3
};
inline constexpr double kSizedForGain_m2_V = 1.5e-6;
inline constexpr double kSizedForVolume_m3 = 150e-6;
/// Beyond this the size of a chamber changes nothing more.
inline constexpr double kMostSize = 100.0;

/// What a figure grows with: a resistance that matters to a valve a tenth as wide is ten times as great.
enum class GrowsWith { nothing, valve, narrow_valve, root_of_valve, volume };

struct Parameter {
  std::string_view name;  ///< with its unit: natural_frequency_Hz
  std::string_view what;
  double low = 0.0;             ///< least value that a fit may find, in the unit of the name
  double high = 0.0;            ///< greatest
  double vanishes_at = 0.0;     ///< with this value the effect is gone; in a shape parameter: its plain value
  double typical_change = 0.0;  ///< of the coordinate: what a search takes as one step
  Coordinate coordinate = Coordinate::linear;
  bool refines = false;  ///< a fit frees it only where the effect's other parameters do not suffice
  GrowsWith grows_with = GrowsWith::nothing;

  double coordinate_of(double value) const {
    if (coordinate == Coordinate::linear) return value;
    return coordinate == Coordinate::reciprocal ? 1.0 / value : 1.0 / (value * value);
  }
  double value_of(double at) const {
    if (coordinate == Coordinate::linear) return at;
    return coordinate == Coordinate::reciprocal ? 1.0 / at : 1.0 / std::sqrt(at);
  }
  /// As it is for a chamber of this size: with the valve bounds, plain value and typical change, with the volume the last.
  Parameter of(Size size) const {
    const double valve = std::clamp(size.valve, 1.0 / kMostSize, kMostSize);
    const double volume = std::clamp(size.volume, 1.0 / kMostSize, kMostSize);
    Parameter sized = *this;
    if (grows_with == GrowsWith::nothing) return sized;
    const double times = grows_with == GrowsWith::valve          ? valve
                         : grows_with == GrowsWith::narrow_valve ? 1.0 / valve
                         : grows_with == GrowsWith::volume       ? volume
                                                                 : std::sqrt(valve);
    sized.typical_change *= times;
    if (grows_with == GrowsWith::volume) return sized;
    sized.low *= times;
    sized.high *= times;
    sized.vanishes_at *= times;
    return sized;
  }
  /// The same, with the bounds of all sizes.
  Parameter of_any_size() const {
    Parameter any = *this;
    if (grows_with == GrowsWith::nothing || grows_with == GrowsWith::volume) return any;
    const double most = grows_with == GrowsWith::root_of_valve ? std::sqrt(kMostSize) : kMostSize;
    any.low = low / most;
    any.high = high * most;
    return any;
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
