#include "host-sim/identify/regulator_valve/swarm_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify::regulator_valve {
namespace {

constexpr std::size_t kFewest = 8;
constexpr double kGainRoom = 10.0 / 3.0;  // of the ratio of the spans, either way
constexpr double kFastest = 0.3;          // residue of a single pole at 14 ms
constexpr double kWidest = 3.0;           // a_1 and a_2 of a stable model lie within +-3

double span_of(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return *high - *low;
}

DiscreteModel model_at(const Eigen::VectorXd& place, double sample_s) {
  const double residue = place[1];
  return {.b_Pa_m = place[0] * residue,
          .a = {place[2], place[3], residue - 1.0 - place[2] - place[3]},
          .sample_s = sample_s};
}

// |y^ - y|^2 without keeping y^; infinite as soon as the run has left every scale.
double free_run_squares(const DiscreteModel& model, const Branch& branch, double limit) {
  const auto& p = branch.pressure_Pa;
  const double b = model.b_Pa_m;
  const auto [a1, a2, a3] = model.a;
  double p1 = p[2];
  double p2 = p[1];
  double p3 = p[0];
  double squares = 0.0;
  for (std::size_t k = 3; k < p.size(); ++k) {
    const double next = b * branch.screw_m[k - 1] - a1 * p1 - a2 * p2 - a3 * p3;
    p3 = std::exchange(p2, std::exchange(p1, next));
    squares += (next - p[k]) * (next - p[k]);
    if (!(squares < limit)) return std::numeric_limits<double>::infinity();
  }
  return squares;
}

}  // namespace

SwarmFit fit_swarm(const Branch& branch, const swarm::Settings& settings,
                   const std::function<void(double)>& progress) {
  validate(branch);
  const std::size_t samples = branch.pressure_Pa.size();
  if (samples < kFewest)
    throw CannotIdentify(fmt::format("swarm fit: {} samples, expected at least {}", samples, kFewest));
  const double screw_span_m = span_of(branch.screw_m);
  const double pressure_span_Pa = span_of(branch.pressure_Pa);
  if (!(screw_span_m > 0.0)) throw CannotIdentify("swarm fit: the screw never changes");
  if (!(pressure_span_Pa > 0.0)) throw CannotIdentify("swarm fit: the pressure never changes");

  const double gain = pressure_span_Pa / screw_span_m;
  const swarm::Box box{.low = Eigen::Vector4d(gain / kGainRoom, 0.0, -kWidest, -kWidest),
                       .high = Eigen::Vector4d(gain * kGainRoom, kFastest, kWidest, kWidest)};
  const double limit = 1e6 * pressure_span_Pa * pressure_span_Pa * static_cast<double>(samples);
  const auto cost = [&](const Eigen::VectorXd& place) {
    return free_run_squares(model_at(place, branch.sample_s), branch, limit);
  };
  SwarmFit fit{.model = {}, .search = swarm::minimise(cost, box, settings, progress)};
  for (const auto& [variable, name] : {std::pair{0, "static gain [Pa/m]"}, std::pair{1, "residue"}}) {
    const double found = fit.search.best[variable];
    if (found > box.low[variable] && found < box.high[variable]) continue;
    throw CannotIdentify(fmt::format("swarm fit: the {} ends at its bound of {}", name, found));
  }
  fit.model = model_at(fit.search.best, branch.sample_s);
  return fit;
}

}  // namespace plenum::host::identify::regulator_valve
