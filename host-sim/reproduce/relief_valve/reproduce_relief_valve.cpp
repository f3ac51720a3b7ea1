#include "host-sim/reproduce/relief_valve/reproduce_relief_valve.hpp"

#include <iterator>

#include "host-sim/reproduce/relief_valve/parts.hpp"

namespace plenum::host::reproduce::relief_valve {

std::vector<Part> reproduce_relief_valve(const Progress& progress) {
  using Make = Part (*)();
  constexpr Make kParts[] = {static_characteristics, cracking_and_maximum, static_identification,
                             dynamic_equations,      multi_input_valve,    printed_dynamics,
                             classical_static,       classical_step,       identified_valve,
                             identified_softer_valve};
  std::vector<Part> parts;
  for (const Make make : kParts) {
    parts.push_back(make());
    if (progress) progress(static_cast<double>(parts.size()) / static_cast<double>(std::size(kParts)));
  }
  return parts;
}

}  // namespace plenum::host::reproduce::relief_valve
