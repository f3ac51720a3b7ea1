#include "host-sim/identify/swarm/swarm.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/plant/random.hpp"

namespace plenum::host::identify::swarm {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

// (x - centre)^T H (x - centre), H positive definite with a condition of at most 26.
struct Quadratic {
  Eigen::MatrixXd H;
  Eigen::VectorXd centre;

  static Quadratic drawn(plant::Random& random, int size, double low, double high) {
    Quadratic q{Eigen::MatrixXd(size, size), Eigen::VectorXd(size)};
    Eigen::MatrixXd any(size, size);
    for (int i = 0; i < size; ++i) {
      q.centre[i] = random.uniform(low, high);
      for (int j = 0; j < size; ++j) any(i, j) = random.uniform(-1.0, 1.0);
    }
    const Eigen::MatrixXd turn = any.householderQr().householderQ();
    Eigen::VectorXd curvature(size);
    for (int i = 0; i < size; ++i) curvature[i] = random.uniform(1.0, 26.0);
    q.H = turn * curvature.asDiagonal() * turn.transpose();
    return q;
  }
  double operator()(const Eigen::VectorXd& x) const { return (x - centre).dot(H * (x - centre)); }
};

Box cube(int size, double low, double high) {
  return {Eigen::VectorXd::Constant(size, low), Eigen::VectorXd::Constant(size, high)};
}

TEST(Constriction, IsTheClosedFormOfItsUsualSetting) {
  // phi = 4.1: phi^2 - 4 phi = 0.41, chi = 2 / (2.1 + sqrt(0.41))
  EXPECT_NEAR(constriction_factor(4.1), 2.0 / (2.1 + std::sqrt(0.41)), 1e-15);
  EXPECT_NEAR(constriction_factor(4.1), 0.7298, 5e-5);
  EXPECT_EQ(constriction_factor(4.0), 1.0);
}

RC_GTEST_PROP(Constriction, SolvesItsCharacteristicEquation, ()) {
  // chi and 1/chi are the two roots of l^2 + (2 - phi) l + 1 = 0 (Clerc and Kennedy)
  const double phi = 4.0 + *rc::gen::inRange(0, 1000) * 0.01;
  const double chi = constriction_factor(phi);
  RC_ASSERT(std::abs(chi * chi + (2.0 - phi) * chi + 1.0) < 1e-12);
  RC_ASSERT(chi <= 1.0);
  RC_ASSERT(std::abs(constriction_factor(phi, 0.5) - 0.5 * chi) < 1e-15);
}

TEST(Constriction, RefusesWhereTheRootIsNotReal) {
  EXPECT_THAT([] { constriction_factor(3.9); }, ThrowsMessage<std::invalid_argument>(HasSubstr("phi: 3.9")));
  EXPECT_THAT([] { constriction_factor(4.1, 0.0); }, ThrowsMessage<std::invalid_argument>(HasSubstr("k: 0")));
}

RC_GTEST_PROP(Swarm, FindsTheMinimumOfAConvexQuadraticInside, ()) {
  plant::Random random(*rc::gen::arbitrary<std::uint64_t>());
  const int size = *rc::gen::inRange(1, 6);
  const Quadratic cost = Quadratic::drawn(random, size, -3.0, 3.0);
  const Solution found = minimise(cost, cube(size, -5.0, 5.0), {.iterations = 400, .seed = random.bits()});
  RC_ASSERT((found.best - cost.centre).norm() < 1e-5);
  RC_ASSERT(found.cost == cost(found.best));
}

RC_GTEST_PROP(Swarm, FindsTheMinimumOnTheFaceThatCutsTheQuadratic, ()) {
  plant::Random random(*rc::gen::arbitrary<std::uint64_t>());
  Quadratic cost = Quadratic::drawn(random, 2, -1.0, 1.0);
  cost.centre[0] = 2.0 + random.uniform();
  // on x_0 = 1 the other one is at c_1 + H_01/H_11 (c_0 - 1), within the box for the curvatures drawn here
  const double other = cost.centre[1] + cost.H(0, 1) / cost.H(1, 1) * (cost.centre[0] - 1.0);
  Box box = cube(2, -30.0, 30.0);
  box.high[0] = 1.0;
  RC_PRE(std::abs(other) < 29.0);
  const Solution found = minimise(cost, box, {.iterations = 400, .seed = random.bits()});
  RC_ASSERT(found.best[0] == 1.0);
  RC_ASSERT(std::abs(found.best[1] - other) < 1e-4);
}

RC_GTEST_PROP(Swarm, NeverLooksOutsideTheBox, ()) {
  plant::Random random(*rc::gen::arbitrary<std::uint64_t>());
  const Quadratic cost = Quadratic::drawn(random, 3, -9.0, 9.0);  // mostly outside
  const Box box = cube(3, -1.0, 2.0);
  bool inside = true;
  minimise(
      [&](const Eigen::VectorXd& x) {
        inside = inside && (x.array() >= -1.0).all() && (x.array() <= 2.0).all();
        return cost(x);
      },
      box, {.particles = 10, .iterations = 60, .seed = random.bits()});
  RC_ASSERT(inside);
}

RC_GTEST_PROP(Swarm, BestSoFarNeverRisesAndEndsAtTheAnswer, ()) {
  plant::Random random(*rc::gen::arbitrary<std::uint64_t>());
  const Quadratic cost = Quadratic::drawn(random, 4, -3.0, 3.0);
  const Solution found =
      minimise(cost, cube(4, -5.0, 5.0), {.particles = 8, .iterations = 50, .seed = random.bits()});
  RC_ASSERT(found.best_so_far.size() == 51U);
  RC_ASSERT(std::is_sorted(found.best_so_far.rbegin(), found.best_so_far.rend()));
  RC_ASSERT(found.best_so_far.back() == found.cost);
}

RC_GTEST_PROP(Swarm, TheSameSeedIsTheSameSearchAndAnotherIsNot, ()) {
  const auto seed = *rc::gen::arbitrary<std::uint64_t>();
  const auto cost = [](const Eigen::VectorXd& x) { return x.squaredNorm() + std::cos(5.0 * x[0]); };
  const Settings settings{.particles = 12, .iterations = 20, .seed = seed};
  Settings other = settings;
  other.seed = seed + 1;
  const Solution first = minimise(cost, cube(3, -2.0, 3.0), settings);
  RC_ASSERT(first.best == minimise(cost, cube(3, -2.0, 3.0), settings).best);
  RC_ASSERT(first.best_so_far != minimise(cost, cube(3, -2.0, 3.0), other).best_so_far);
}

RC_GTEST_PROP(Swarm, ScalingCostAndBoxByPowersOfTwoScalesTheSearch, ()) {
  const auto seed = *rc::gen::arbitrary<std::uint64_t>();
  const auto cost = [](const Eigen::VectorXd& x) { return (x.array() - 0.7).square().sum(); };
  const auto scaled = [&](const Eigen::VectorXd& x) { return 8.0 * cost(x / 4.0); };
  const Settings settings{.particles = 12, .iterations = 30, .seed = seed};
  const Solution plain = minimise(cost, cube(2, -1.0, 2.0), settings);
  const Solution large = minimise(scaled, cube(2, -4.0, 8.0), settings);
  RC_ASSERT(large.best == 4.0 * plain.best);
  RC_ASSERT(large.cost == 8.0 * plain.cost);
}

// Two particles on a line, watched over their first two moves. The cost goes by the order of the looks, so that
// the first particle is the best of all and the second one's start stays its own best.
struct TwoMoves {
  double best;
  double x0, x1, x2;  // of the second particle
};
TwoMoves watch(std::uint64_t seed) {
  std::vector<double> looks;
  minimise(
      [&](const Eigen::VectorXd& x) {
        looks.push_back(x[0]);
        return std::min(2.0, static_cast<double>(looks.size()));
      },
      cube(1, 0.0, 1.0), {.particles = 2, .iterations = 2, .seed = seed});
  return {looks[0], looks[1], looks[3], looks[5]};
}

// How far `moved` is from its mean, in standard errors.
class Mean {
 public:
  void add(double off) {
    sum_ += off;
    squares_ += off * off;
    ++count_;
  }
  int count() const { return count_; }
  double errors() const { return std::abs(sum_) / std::sqrt(squares_); }

 private:
  double sum_ = 0.0;
  double squares_ = 0.0;
  int count_ = 0;
};

TEST(Swarm, MovesAreThoseOfEq35InTheMean) {
  constexpr double kChi = 0.7298437881283576;
  Mean first;
  Mean second;
  Mean after_a_face;
  for (std::uint64_t seed = 0; seed < 200000; ++seed) {
    const auto [s, x0, x1, x2] = watch(seed);
    if (std::abs(s - 0.5) < 0.1 && std::abs(x0 - 0.5) < 0.1) {  // no face in reach
      EXPECT_LE(std::abs(x1 - x0), kChi * 2.05 * std::abs(s - x0));
      first.add(x1 - x0 - kChi * 1.025 * (s - x0));
      second.add(x2 - x1 - kChi * ((x1 - x0) + 1.025 * (x0 - x1) + 1.025 * (s - x1)));
    }
    if (x1 == 1.0 && s > 0.7 && x0 > 0.7)  // on the face: the speed is lost, what draws it is within
      after_a_face.add(x2 - 1.0 - kChi * 1.025 * ((x0 - 1.0) + (s - 1.0)));
  }
  ASSERT_GT(first.count(), 5000);
  ASSERT_GT(after_a_face.count(), 500);
  EXPECT_LT(first.errors(), 4.0);
  EXPECT_LT(second.errors(), 4.0);
  EXPECT_LT(after_a_face.errors(), 4.0);
}

TEST(Swarm, FindsTheLeastOfManyMinima) {
  // Rastrigin in two variables: 121 minima in the box, the least one at the origin
  const auto rastrigin = [](const Eigen::VectorXd& x) {
    return (x.array().square() - 10.0 * (2.0 * M_PI * x.array()).cos() + 10.0).sum();
  };
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Solution found = minimise(rastrigin, cube(2, -5.12, 5.12), {.seed = seed});
    EXPECT_LT(found.best.norm(), 1e-6) << "seed " << seed;
  }
}

TEST(Swarm, PassesOverPlacesWhereTheCostIsNoNumber) {
  const auto cost = [](const Eigen::VectorXd& x) {
    return x[0] < 0.5 ? std::numeric_limits<double>::quiet_NaN() : x[0];
  };
  EXPECT_NEAR(minimise(cost, cube(1, 0.0, 1.0)).best[0], 0.5, 1e-6);
}

TEST(Swarm, SaysThatTheCostWasFiniteNowhere) {
  const auto cost = [](const Eigen::VectorXd&) { return std::numeric_limits<double>::infinity(); };
  EXPECT_THAT([&] { minimise(cost, cube(2, 0.0, 1.0), {.particles = 3, .iterations = 4}); },
              ThrowsMessage<CannotIdentify>(HasSubstr("none of 15 places")));
}

TEST(Swarm, RefusesABoxThatIsNone) {
  const auto cost = [](const Eigen::VectorXd& x) { return x.squaredNorm(); };
  EXPECT_THAT([&] { minimise(cost, cube(2, 1.0, 0.0)); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("variable 0: 1 to 0")));
  EXPECT_THAT([&] { minimise(cost, cube(0, 0.0, 1.0)); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("swarm box")));
  EXPECT_THAT([&] { minimise(cost, cube(1, 0.0, 1.0), {.particles = 0}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("particles: 0")));
  EXPECT_THAT([&] { minimise(cost, cube(1, 0.0, 1.0), {.iterations = 0}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("iterations: 0")));
}

}  // namespace
}  // namespace plenum::host::identify::swarm
