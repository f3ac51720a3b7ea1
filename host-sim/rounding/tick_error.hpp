// What fixed point makes of a model at most, for the very parameter set.
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace plenum::host::rounding {

/// A bound of what rounding in Q31.32 changes in the prediction of a tick [kPa]: its end, and its mean. For
///   pressures from ambient to supply,   commands of 0 to 10 V,   volumes of 1 mL to 10 L,
///   speeds that change the volume by half in a tick at most, and 1.5 L/s;
/// infinite where a number on the way may pass the range. A grey box's volumes count with its dead one and are not below that (a sensor
/// that reads less than nothing is outside of this), and its bound is infinite, too, where a difference may grow beyond use in a tick.
/// None for a kind that is none.
/// Method: the box of these states is split, the worst part first, until its bound is near what some state in it has; of a grey box
/// greybox_error.hpp.
/// `parameters`: in the order of the image. Throws std::invalid_argument for another number of them.
std::optional<double> tick_error_kPa(std::string_view kind, std::span<const double> parameters);

}  // namespace plenum::host::rounding
