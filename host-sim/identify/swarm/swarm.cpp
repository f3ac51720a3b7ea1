#include "host-sim/identify/swarm/swarm.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/plant/random.hpp"

namespace plenum::host::identify::swarm {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

struct Particle {
  Eigen::VectorXd place;
  Eigen::VectorXd speed;
  Eigen::VectorXd best;
  double least = kInfinite;
};

void validate(const Box& box, const Settings& settings) {
  if (box.low.size() == 0 || box.low.size() != box.high.size()) {
    throw std::invalid_argument(
        fmt::format("swarm box: {} low and {} high bounds, expected as many and at least one", box.low.size(),
                    box.high.size()));
  }
  for (Eigen::Index i = 0; i < box.low.size(); ++i) {
    if (std::isfinite(box.low[i]) && std::isfinite(box.high[i]) && box.low[i] <= box.high[i]) continue;
    throw std::invalid_argument(fmt::format(
        "swarm box, variable {}: {} to {}, expected finite bounds, low first", i, box.low[i], box.high[i]));
  }
  if (settings.particles < 1) {
    throw std::invalid_argument(fmt::format("swarm particles: {}, expected at least 1", settings.particles));
  }
  if (settings.iterations < 1) {
    throw std::invalid_argument(
        fmt::format("swarm iterations: {}, expected at least 1", settings.iterations));
  }
}

double finite_or_worst(double cost) {
  return std::isfinite(cost) ? cost : kInfinite;
}

void keep_inside(Particle& particle, const Box& box) {
  for (Eigen::Index i = 0; i < box.low.size(); ++i) {
    double& x = particle.place[i];
    if (x >= box.low[i] && x <= box.high[i]) continue;
    x = x < box.low[i] ? box.low[i] : box.high[i];
    particle.speed[i] = 0.0;
  }
}

}  // namespace

double constriction_factor(double phi, double k) {
  if (!(phi >= 4.0 && std::isfinite(phi))) {
    throw std::invalid_argument(
        fmt::format("constriction phi: {}, expected a finite number of at least 4", phi));
  }
  if (!(k > 0.0 && k <= 1.0))
    throw std::invalid_argument(fmt::format("constriction k: {}, expected above 0 to 1", k));
  return 2.0 * k / std::abs(2.0 - phi - std::sqrt(phi * phi - 4.0 * phi));
}

Solution minimise(const Cost& cost, const Box& box, const Settings& settings,
                  const std::function<void(double)>& progress) {
  validate(box, settings);
  const double chi = constriction_factor(settings.cognitive + settings.social, settings.k);
  plant::Random random(settings.seed);

  Solution solution{.best = box.low, .cost = kInfinite, .best_so_far = {}};
  std::vector<Particle> swarm(static_cast<std::size_t>(settings.particles));
  const auto look = [&] {  // every particle where it is; then the best of all
    for (Particle& particle : swarm) {
      const double found = finite_or_worst(cost(particle.place));
      if (found >= particle.least) continue;
      particle.least = found;
      particle.best = particle.place;
    }
    for (const Particle& particle : swarm) {
      if (particle.least >= solution.cost) continue;
      solution.cost = particle.least;
      solution.best = particle.best;
    }
    solution.best_so_far.push_back(solution.cost);
  };

  for (Particle& particle : swarm) {
    particle.place = box.low;
    for (Eigen::Index i = 0; i < box.low.size(); ++i)
      particle.place[i] += random.uniform() * (box.high[i] - box.low[i]);
    particle.speed = Eigen::VectorXd::Zero(box.low.size());
    particle.best = particle.place;
  }
  look();
  for (int iteration = 0; iteration < settings.iterations; ++iteration) {
    for (Particle& particle : swarm) {
      for (Eigen::Index i = 0; i < box.low.size(); ++i) {
        const double own = settings.cognitive * random.uniform() * (particle.best[i] - particle.place[i]);
        const double shared = settings.social * random.uniform() * (solution.best[i] - particle.place[i]);
        particle.speed[i] = chi * (particle.speed[i] + own + shared);  // (35)
      }
      particle.place += particle.speed;  // (36)
      keep_inside(particle, box);
    }
    look();
    if (progress) progress(static_cast<double>(iteration + 1) / settings.iterations);
  }
  if (solution.cost == kInfinite) {
    throw CannotIdentify(
        fmt::format("swarm: the cost was finite at none of {} places",
                    static_cast<std::size_t>(settings.particles) * solution.best_so_far.size()));
  }
  return solution;
}

}  // namespace plenum::host::identify::swarm
