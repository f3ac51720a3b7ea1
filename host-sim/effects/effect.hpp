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

/// The powers of a chamber's size with which a figure grows: a resistance that matters to a valve a tenth as wide is ten times as
/// great.
struct Growth {
  double with_valve = 0.0;
  double with_volume = 0.0;
};
inline constexpr Growth kAsTheValve{.with_valve = 1.0}, kAsItsResistance{.with_valve = -1.0},
    kAsItsDiameter{.with_valve = 0.5}, kAsTheVolume{.with_volume = 1.0};

struct Parameter {
  std::string_view name;  ///< with its unit: natural_frequency_Hz
  std::string_view what;
  double low = 0.0;             ///< least value that a fit may find, in the unit of the name
  double high = 0.0;            ///< greatest
  double vanishes_at = 0.0;     ///< with this value the effect is gone; in a shape parameter: its plain value
  double typical_change = 0.0;  ///< of the coordinate: what a search takes as one step
  Coordinate coordinate = Coordinate::linear;
  bool refines = false;  ///< a fit frees it only where the effect's other parameters do not suffice
  Growth growth{};

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
    const auto times = [](double of, double power) {
      return std::pow(std::clamp(of, 1.0 / kMostSize, kMostSize), power);
    };
    Parameter sized = *this;
    for (double* const value : {&sized.low, &sized.high, &sized.vanishes_at}) {
      *value *= times(size.valve, growth.with_valve);
    }
    sized.typical_change *= coordinate_of(times(size.valve, growth.with_valve)) *
                            coordinate_of(times(size.volume, growth.with_volume));
    return sized;
  }
  /// The same, with the bounds of all sizes.
  Parameter of_any_size() const {
    const double most = std::pow(kMostSize, std::abs(growth.with_valve));
    Parameter any = *this;
    any.low /= most;
    any.high *= most;
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
