#include "host-sim/diagnose/detectable.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "host-sim/diagnose/look.hpp"
#include "host-sim/identify/in_parallel.hpp"

namespace plenum::host::diagnose {
namespace {

using effects::kCatalogue;

constexpr int kPasses = 2;
static_assert(std::ranges::none_of(kCatalogue,
                                   [](const effects::Effect* e) { return e->parameters.front().refines; }));

/// Of the first parameter of `effect` at this coordinate, in its typical changes.
double standard_error(const Scene& scene, const Fit& used, std::size_t effect, double at,
                      double correlated_rows) {
  const std::size_t figure = effects::kFirstFigure[effect];
  effects::Figures figures = used.figures;
  figures[figure] = at;
  Fit beside =
      fit(scene, used.on | bit(effect), figures, used.start, {.most_iterations = 0, .refined = used.refined});
  beside.squares = used.rms_Pa() * used.rms_Pa() * static_cast<double>(beside.rows);
  const auto variable = std::ranges::find(beside.variables, figure, &identify::chamber::Variable::figure);
  return standard_errors(beside, correlated_rows)[variable - beside.variables.begin()];
}

}  // namespace

std::vector<Detectable> detectable(const Scene& scene, const Fit& used,
                                   const std::vector<std::size_t>& others, double correlated_rows,
                                   unsigned threads) {
  const Scene seen = coarse(scene, std::numeric_limits<double>::infinity());
  std::vector<Detectable> all(others.size());
  identify::in_parallel(others.size(), threads, [&](std::size_t i) {
    const effects::Effect& effect = *kCatalogue[others[i]];
    const effects::Parameter p = effect.parameters.front().of(size_of(scene));
    double least = p.neutral() + p.typical_change;
    for (int pass = 0; pass < kPasses; ++pass) {
      const double at = std::min(least, p.greatest());
      least = p.neutral() +
              kShownErrors * p.typical_change * standard_error(seen, used, others[i], at, correlated_rows);
    }
    all[i] = {std::string(effect.id), std::string(p.name),
              least < p.greatest() ? p.value_of(least) : std::numeric_limits<double>::quiet_NaN()};
  });
  return all;
}

}  // namespace plenum::host::diagnose
