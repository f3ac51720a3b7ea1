#include "host-sim/identify/box_solver.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

namespace plenum::host::identify {
namespace {

constexpr Eigen::Index kN = static_cast<Eigen::Index>(kFree);
using Matrix9 = Eigen::Matrix<double, kFree, kFree>;

enum class Side { free, low, high };

/// Newton direction of the free variables from `d`, zero for the others.
Vector9 newton_direction(const Matrix9& H, const Vector9& slope, const std::array<Side, kFree>& side) {
  Matrix9 reduced = H;
  Vector9 rhs = -slope;
  for (Eigen::Index i = 0; i < kN; ++i) {
    if (side[static_cast<std::size_t>(i)] == Side::free) continue;
    reduced.row(i).setZero();
    reduced.col(i).setZero();
    reduced(i, i) = 1.0;
    rhs[i] = 0.0;
  }
  return reduced.ldlt().solve(rhs);
}

}  // namespace

Vector9 quadratic_in_box(const Matrix9& H, const Vector9& g, const Vector9& low, const Vector9& high) {
  // Each pass either fixes one more variable, frees the worst one, or ends; 60 is far above what 9 variables
  // need.
  constexpr int kMostPasses = 60;
  std::array<Side, kFree> side{};
  Vector9 d = Vector9::Zero();
  for (Eigen::Index i = 0; i < kN; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (high[i] <= 0.0 && g[i] <= 0.0) side[k] = Side::high;
    if (low[i] >= 0.0 && (g[i] >= 0.0 || high[i] <= low[i])) side[k] = Side::low;
  }
  for (int pass = 0; pass < kMostPasses; ++pass) {
    const Vector9 direction = newton_direction(H, g + H * d, side);
    double reach = 1.0;
    Eigen::Index blocking = -1;
    for (Eigen::Index i = 0; i < kN; ++i) {
      if (direction[i] == 0.0) continue;
      const double room = ((direction[i] > 0.0 ? high[i] : low[i]) - d[i]) / direction[i];
      if (room < reach) {
        reach = std::max(room, 0.0);
        blocking = i;
      }
    }
    d += reach * direction;
    if (blocking >= 0) {
      const bool up = direction[blocking] > 0.0;
      side[static_cast<std::size_t>(blocking)] = up ? Side::high : Side::low;
      d[blocking] = up ? high[blocking] : low[blocking];
      continue;
    }
    const Vector9 slope = g + H * d;
    Eigen::Index wrong = -1;
    double worst = 1e-12 * g.cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < kN; ++i) {
      const Side at = side[static_cast<std::size_t>(i)];
      if (at == Side::free || high[i] <= low[i]) continue;
      const double pull = at == Side::low ? -slope[i] : slope[i];
      if (pull > worst) {
        worst = pull;
        wrong = i;
      }
    }
    if (wrong < 0) break;
    side[static_cast<std::size_t>(wrong)] = Side::free;
  }
  return d;
}

namespace {

/// What Gauss-Newton leaves out of the Hessian, sum of e_i times the Hessian of e_i, learnt from the change
/// of the gradient over the steps taken: symmetric rank-one updates, sized down where they no longer fit
/// (Dennis, Gay and Welsch 1981). Used only while it has predicted the last step better than Gauss-Newton
/// did. On chambers that the model does not fit exactly it cuts the iterations near the minimum by half or
/// more.
class Curvature {
 public:
  void learn(const Vector9& step, const Vector9& slope_change, const Matrix9& H_there) {
    const Vector9 missing = slope_change - H_there * step;
    const double known = step.dot(S_ * step);
    const double wanted = step.dot(missing);
    if (std::abs(known) > std::abs(wanted)) S_ *= std::abs(wanted / known);
    const Vector9 rest = missing - S_ * step;
    const double along = rest.dot(step);
    if (std::abs(along) > 1e-6 * rest.norm() * step.norm()) S_ += rest * rest.transpose() / along;
  }
  void judge(double actual, double by_gauss_newton, double with_curvature) {
    in_use_ = std::abs(with_curvature - actual) < std::abs(by_gauss_newton - actual);
  }
  void stop_using() { in_use_ = false; }
  bool in_use() const { return in_use_; }
  const Matrix9& matrix() const { return S_; }

 private:
  Matrix9 S_ = Matrix9::Zero();
  bool in_use_ = false;
};

double promise(const Matrix9& H, const Vector9& g, const Vector9& d) {
  return -(2.0 * g.dot(d) + d.dot(H * d));
}

bool positive(const Matrix9& H) {
  return H.llt().info() == Eigen::Success;
}

}  // namespace

BoxSolution minimise_in_box(const BoxProblem& problem, const Vector9& start, int most_iterations,
                            double tolerance) {
  constexpr double kLongestStep =
      1.0;  // of each variable: they are of order one, and the model is not that linear
  constexpr double kShortestStep = 1e-9;
  constexpr double kLeastDamping = 1e-7;
  constexpr double kMostDamping = 1e12;
  constexpr double kAfterRefusal = 1e-3;
  BoxSolution solution;
  solution.z = start;
  Gram gram = problem.gram(solution.z);
  solution.squares = gram(kN, kN);
  Curvature curvature;
  double lambda = 1e-3;
  double growth = 2.0;
  for (solution.iterations = 1; solution.iterations <= most_iterations; ++solution.iterations) {
    const Matrix9 H = gram.topLeftCorner<kFree, kFree>();
    const Vector9 g = gram.col(kN).head<kFree>();
    const Vector9 scale = H.diagonal().cwiseMax(1e-9 * H.diagonal().maxCoeff());
    const Matrix9 damping = (lambda * scale).asDiagonal();
    Matrix9 model = H;
    if (curvature.in_use()) {
      model += curvature.matrix();
      if (!positive(model + damping)) model = H;
    }
    const Vector9 d = quadratic_in_box(model + damping, g, (problem.low - solution.z).cwiseMax(-kLongestStep),
                                       (problem.high - solution.z).cwiseMin(kLongestStep));
    const double promised = promise(model, g, d);  // fall of the sum of squares
    if (!(promised > tolerance * solution.squares) && lambda <= 1.0) {
      solution.converged = true;
      solution.stop =
          fmt::format("converged: the next step promises less than {:.0e} of the sum of squares", tolerance);
      return solution;
    }
    // On data without noise the sum itself goes to zero, and no share of it is small: there the step says it.
    if (d.cwiseAbs().maxCoeff() < kShortestStep && lambda <= 1.0) {
      solution.converged = true;
      solution.stop =
          fmt::format("converged: the next step is below {:.0e} in every scaled variable", kShortestStep);
      return solution;
    }
    const Vector9 trial = (solution.z + d).cwiseMax(problem.low).cwiseMin(problem.high);
    const double squares = problem.squares(trial);
    const double fall = solution.squares - squares;
    const double gain = fall / promised;
    if (std::isfinite(squares) && gain > 1e-4) {
      const Vector9 taken = trial - solution.z;
      gram = problem.gram(trial);
      const Matrix9 H_there = gram.topLeftCorner<kFree, kFree>();
      curvature.judge(fall, promise(H, g, taken), promise(H + curvature.matrix(), g, taken));
      const bool had_curvature = !curvature.matrix().isZero(0.0);
      curvature.learn(taken, gram.col(kN).head<kFree>() - g, H_there);
      if (!had_curvature)
        curvature.judge(fall, promise(H, g, taken), promise(H + curvature.matrix(), g, taken));
      if (gain > 0.75) lambda = std::max(0.1 * lambda, kLeastDamping);
      if (gain < 0.25) lambda *= 2.0;
      growth = 2.0;
      solution.z = trial;
      solution.squares = gram(kN, kN);
    } else if (curvature.in_use()) {
      curvature.stop_using();
    } else {
      lambda = std::max(lambda * growth, kAfterRefusal);
      growth *= 2.0;
      if (lambda > kMostDamping || trial == solution.z) {
        solution.converged = true;
        solution.stop = "converged: no step lowers the sum of squares within machine precision";
        return solution;
      }
    }
  }
  solution.iterations = most_iterations;
  solution.stop = fmt::format("stopped after the {} iterations allowed, not converged", most_iterations);
  return solution;
}

}  // namespace plenum::host::identify
