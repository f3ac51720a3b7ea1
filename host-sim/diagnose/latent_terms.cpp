#include "host-sim/diagnose/latent_terms.hpp"

#include <algorithm>
#include <cmath>

namespace plenum::host::diagnose {
namespace {

bool moves(const std::vector<const Record*>& records) {
  return std::any_of(records.begin(), records.end(),
                     [](const Record* record) { return volume_swing(*record) > 0.02; });
}

}  // namespace

LatentScene::LatentScene(const Scene& of, const std::vector<const Record*>& records)
    : scene(of),
      chamber(of),
      gain(0.5 * (of.nominal[effects::kInletGain] + of.nominal[effects::kExhaustGain])),
      flow_scale(gain * chamber.plate().phi(of.around.supply_Pa, of.around.ambient_Pa)),
      volume_moves(moves(records)) {}

double hat(std::span<const double> centres, std::size_t i, double x) {
  if (i > 0 && x < centres[i])
    return std::clamp((x - centres[i - 1]) / (centres[i] - centres[i - 1]), 0.0, 1.0);
  if (i + 1 < centres.size() && x > centres[i])
    return std::clamp((centres[i + 1] - x) / (centres[i + 1] - centres[i]), 0.0, 1.0);
  return 1.0;
}

std::vector<double> smoothed(std::vector<double> x, double tau, double tick_s) {
  const double keep = tau > 0.0 ? std::exp(-tick_s / tau) : 0.0;
  double s = 0.0;
  for (double& value : x) {
    s = keep * s + (1.0 - keep) * value;
    value = s;
  }
  return x;
}

}  // namespace plenum::host::diagnose
