#include "host-sim/diagnose/trust.hpp"

#include <algorithm>
#include <cmath>

namespace plenum::host::diagnose {

double probability_of_first(double left_over_floor) {
  constexpr double kMost = 0.99;
  constexpr double kEven = 22.0;
  constexpr double kWidth = 0.5;  ///< of its logarithm
  return kMost / (1.0 + std::pow(left_over_floor / kEven, 1.0 / kWidth));
}

double probability_beside_others(double share_of_rest) {
  constexpr double kEven = 0.63;
  constexpr double kWidth = 0.06;
  return kTrustBeside / (1.0 + std::exp((kEven - share_of_rest) / kWidth));
}

double worth_of_name(double left_over_floor, std::optional<double> share_of_rest) {
  return probability_of_first(left_over_floor) *
         (share_of_rest ? probability_beside_others(*share_of_rest) : 1.0);
}

bool says_nothing(const std::vector<Estimate>& figures, std::size_t effect, effects::Size size) {
  const auto parameters = effects::kCatalogue[effect]->parameters;
  return std::all_of(figures.begin(), figures.end(), [&](const Estimate& of) {
    const auto named = std::find_if(parameters.begin(), parameters.end(),
                                    [&](const effects::Parameter& one) { return one.name == of.name; });
    const effects::Parameter p = named->of(size);
    if (of.is_given()) return true;
    const double a = p.coordinate_of(of.low95);
    const double b = p.coordinate_of(of.high95);
    const double low = std::min(a, b);
    const double high = std::max(a, b);
    return (low <= p.neutral() && p.neutral() <= high) || (low <= p.least() && high >= p.greatest());
  });
}

}  // namespace plenum::host::diagnose
