#include "host-sim/effects/catalogue.hpp"

namespace plenum::host::effects {

std::optional<std::size_t> find(std::string_view id) {
  for (std::size_t i = 0; i < kEffects; ++i) {
    if (kCatalogue[i]->id == id) return i;
  }
  return std::nullopt;
}

Figures neutral_figures() {
  Figures figures{};
  for (std::size_t i = 0; i < kEffects; ++i) {
    std::size_t at = kFirstFigure[i];
    for (const Parameter& parameter : kCatalogue[i]->parameters) figures[at++] = parameter.neutral();
  }
  return figures;
}

}  // namespace plenum::host::effects
