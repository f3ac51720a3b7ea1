// (33), (35)-(37): properties by which both methods are those of the paper.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "host-sim/identify/swarm/swarm.hpp"
#include "host-sim/reproduce/regulator_valve/parts.hpp"
#include "host-sim/reproduce/samples.hpp"

namespace plenum::host::reproduce::regulator_valve {
namespace {

namespace swarm = identify::swarm;

// eps times the condition of Psi, some 1e3 of scaled columns, with room for the sums over thousands of rows.
constexpr double kOrthogonal = 1e-9;

// The normal equations of (33), Psi^T (Y - Psi Theta) = 0: the largest cosine between the residual and a column.
double largest_cosine(const Identified& identified) {
  const auto& p = identified.branch.pressure_Pa;
  const auto& x = identified.branch.screw_m;
  const auto& [b, a, sample_s] = identified.least_squares;
  const auto rows = static_cast<Eigen::Index>(p.size() - 3);
  Eigen::Matrix<double, Eigen::Dynamic, 4> Psi(rows, 4);
  Eigen::VectorXd residual(rows);
  for (std::size_t k = 3; k < p.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k - 3);
    Psi.row(row) << -p[k - 1], -p[k - 2], -p[k - 3], x[k - 1];
    residual[row] = p[k] - Psi.row(row).dot(Eigen::RowVector4d(a[0], a[1], a[2], b));
  }
  double largest = 0.0;
  for (Eigen::Index i = 0; i < 4; ++i) {
    largest = greater_of(largest, std::abs(Psi.col(i).dot(residual)) / (Psi.col(i).norm() * residual.norm()));
  }
  return largest;
}

// What one search of the swarm does, move by move, told from where it looks.
struct Moves {
  std::size_t count = 0;      // components of moves that no face of the box has cut
  std::size_t forbidden = 0;  // of them those that (35), (36) cannot make with any U_1, U_2 in [0, 1]
  double drawn =
      0.0;  // v' / chi - v over its mean for uniform U_1, U_2, each weighed by its variance: 1 of (35)
  double error = 0.0;  // standard error of `drawn`
};

struct Particle {
  Eigen::VectorXd before, place, best;
  double least = std::numeric_limits<double>::infinity();
};

class Watch {
 public:
  Watch(const swarm::Box& box, const swarm::Settings& settings)
      : box_(box),
        settings_(settings),
        chi_(swarm::constriction_factor(settings.cognitive + settings.social, settings.k)),
        particles_(static_cast<std::size_t>(settings.particles)) {}

  // The swarm looks at the places of its particles in turn, from the start on; its best is renewed after a round.
  void look(const Eigen::VectorXd& place, double cost) {
    Particle& particle = particles_[looks_ % particles_.size()];
    const std::size_t round = looks_ / particles_.size();
    if (round > 0) judge(particle, place, round == 1);
    particle.before = particle.place;
    particle.place = place;
    if (cost < particle.least) {
      particle.least = cost;
      particle.best = place;
    }
    if (++looks_ % particles_.size() == 0) {
      best_ =
          std::min_element(particles_.begin(), particles_.end(), [](const Particle& a, const Particle& b) {
            return a.least < b.least;
          })->best;
    }
  }

  Moves moves() const {
    Moves moves = moves_;
    moves.drawn = along_ / squares_;
    moves.error = 1.0 / std::sqrt(squares_);
    return moves;
  }

 private:
  bool on_face(const Eigen::VectorXd& place, Eigen::Index i) const {
    return place[i] <= box_.low[i] || place[i] >= box_.high[i];
  }

  void judge(const Particle& particle, const Eigen::VectorXd& next, bool from_rest) {
    for (Eigen::Index i = 0; i < next.size(); ++i) {
      if (on_face(particle.place, i) || on_face(next, i)) continue;  // the speed there is not that of (35)
      const double x = particle.place[i];
      const double speed = from_rest ? 0.0 : x - particle.before[i];
      const double own = settings_.cognitive * (particle.best[i] - x);
      const double shared = settings_.social * (best_[i] - x);
      const double drawn = (next[i] - x) / chi_ - speed;
      const double rounding = 1e-12 * (box_.high[i] - box_.low[i]);
      moves_.forbidden += drawn < std::min(0.0, own) + std::min(0.0, shared) - rounding ||
                          drawn > std::max(0.0, own) + std::max(0.0, shared) + rounding;
      ++moves_.count;
      const double mean = 0.5 * (own + shared);
      const double variance = (own * own + shared * shared) / 12.0;
      if (variance == 0.0) continue;  // the best of all draws itself nowhere
      along_ += drawn * mean / variance;
      squares_ += mean * mean / variance;
    }
  }

  swarm::Box box_;
  swarm::Settings settings_;
  double chi_;
  std::vector<Particle> particles_;
  Eigen::VectorXd best_;
  std::size_t looks_ = 0;
  Moves moves_;
  double along_ = 0.0;
  double squares_ = 0.0;
};

// A bowl in four variables, as many as (30) has, its centre off that of the box.
Moves watched_moves() {
  const swarm::Box box{.low = Eigen::Vector4d::Constant(-1.0), .high = Eigen::Vector4d::Constant(1.0)};
  const swarm::Settings settings{.iterations = 60};
  Watch watch(box, settings);
  swarm::minimise(
      [&](const Eigen::VectorXd& place) {
        const double cost = (place.array() - 0.3).square().sum();
        watch.look(place, cost);
        return cost;
      },
      box, settings);
  return watch.moves();
}

}  // namespace

Part methods(const Campaign& campaign) {
  constexpr double kErrors = 3.0;
  const swarm::Settings usual;
  const Moves moves = watched_moves();
  Part part{.title = "(33), (35)-(37): the methods themselves",
            .text = fmt::format("What makes the fits those of the paper. (33) is the solution of the normal "
                                "equations: the residual of the next sample is orthogonal to every column "
                                "of Psi, on the first staircase. (37) with the phi and k that the paper "
                                "calls usual. (35), (36) on a bowl in four variables, from the places at "
                                "which the swarm of {} particles looks: every move is one that (35) can "
                                "make, and the moves are in the mean those of two uniform drawings. {} "
                                "components of moves that no face of the box has cut.",
                                usual.particles, moves.count),
            .findings = {}};
  for (const Condition& condition : kConditions) {
    part.findings.push_back(
        {.item = "(33)",
         .quantity = fmt::format("normal equations: largest cosine between residual and regressors, {}",
                                 condition.name),
         .paper = 0.0,
         .ours = largest_cosine(campaign.runs.front().*condition.identified),
         .tolerance = kOrthogonal,
         .why = "the model found is not the least of the squares"});
  }
  part.findings.push_back({.item = "(37)",
                           .quantity = "chi with k = 1, phi_1 = phi_2 = 2.05",
                           .paper = 0.7298,
                           .ours = swarm::constriction_factor(usual.cognitive + usual.social, usual.k),
                           .tolerance = 0.5e-4,
                           .instead = "Clerc and Kennedy (2002)",
                           .why = "chi is not that of (37)"});
  part.findings.push_back({.item = "(35), (36)",
                           .quantity = "moves that no U_1, U_2 in [0, 1] make",
                           .paper = 0.0,
                           .ours = static_cast<double>(moves.forbidden),
                           .why = "the swarm does not move as (35), (36) say"});
  part.findings.push_back({.item = "(35)",
                           .quantity = "drawn towards the best places, over the mean of uniform U_1, U_2",
                           .paper = 1.0,
                           .ours = moves.drawn,
                           .tolerance = kErrors * moves.error,
                           .why = "U_1, U_2 are not uniform in [0, 1]"});
  return part;
}

}  // namespace plenum::host::reproduce::regulator_valve
