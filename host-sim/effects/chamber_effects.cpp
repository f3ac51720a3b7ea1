#include "host-sim/effects/chamber_effects.hpp"

#include <algorithm>
#include <sstream>
#include <stdexcept>

namespace plenum::host::effects {
namespace {

/// "what 'given', expected a, b, c", from the names of `all`.
template <class All, class Name>
std::invalid_argument unknown(const std::string& what, const std::string& given, const All& all, Name name) {
  std::string names;
  for (const auto& one : all) names += (names.empty() ? "" : ", ") + std::string(name(one));
  return std::invalid_argument(what + " '" + given + "', expected " + names);
}

}  // namespace

ChamberEffects chamber_effects(const std::map<std::string, std::map<std::string, double>>& wanted) {
  ChamberEffects result;
  for (const auto& [id, values] : wanted) {
    const auto found = find(id);
    if (!found) {
      throw unknown("unknown effect", id, catalogue(), [](const Effect* e) { return e->id; });
    }
    result.on |= EffectSet{1} << *found;
    const auto parameters = kCatalogue[*found]->parameters;
    for (const auto& [name, value] : values) {
      const auto of = std::find_if(parameters.begin(), parameters.end(),
                                   [&name = name](const Parameter& p) { return p.name == name; });
      if (of == parameters.end()) {
        throw unknown("effect " + id + ": unknown parameter", name, parameters,
                      [](const Parameter& p) { return p.name; });
      }
      const Parameter allowed = of->of_any_size();
      if (!(value >= allowed.low && value <= allowed.high)) {
        std::ostringstream what;
        what << "effect " << id << ": " << name << " = " << value << ", expected " << allowed.low << " to "
             << allowed.high;
        throw std::invalid_argument(what.str());
      }
      const auto place = static_cast<std::size_t>(of - parameters.begin());
      result.figures[kFirstFigure[*found] + place] = of->coordinate_of(value);
    }
  }
  return result;
}

}  // namespace plenum::host::effects
