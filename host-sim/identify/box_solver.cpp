#include "host-sim/identify/box_solver.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace plenum::host::identify {
namespace {

enum class Side { free, low, high };
template <int kSize>
using Sides = Eigen::Matrix<Side, kSize, 1, 0, (kSize > 0 ? kSize : kMostVariables), 1>;

/// Newton direction of the free variables from `d`, zero for the others.
template <int kSize>
BoxVector<kSize> newton_direction(const BoxMatrix<kSize>& H, const BoxVector<kSize>& slope,
                                  const Sides<kSize>& side) {
  BoxMatrix<kSize> reduced = H;
  BoxVector<kSize> rhs = -slope;
  for (Eigen::Index i = 0; i < slope.size(); ++i) {
    if (side[i] == Side::free) continue;
    reduced.row(i).setZero();
    reduced.col(i).setZero();
    reduced(i, i) = 1.0;
    rhs[i] = 0.0;
  }
  return reduced.ldlt().solve(rhs);
}

}  // namespace

template <int kSize>
BoxVector<kSize> quadratic_in_box(const BoxMatrix<kSize>& H, const BoxVector<kSize>& g,
                                  const BoxVector<kSize>& low, const BoxVector<kSize>& high) {
  // Each pass either fixes one more variable, frees the worst one, or ends; 60 is far above what these
  // sizes need.
  constexpr int kMostPasses = 60;
  const Eigen::Index size = g.size();
  Sides<kSize> side = Sides<kSize>::Constant(size, Side::free);
  BoxVector<kSize> d = BoxVector<kSize>::Zero(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    if (high[i] <= 0.0 && g[i] <= 0.0) side[i] = Side::high;
    if (low[i] >= 0.0 && (g[i] >= 0.0 || high[i] <= low[i])) side[i] = Side::low;
  }
  for (int pass = 0; pass < kMostPasses; ++pass) {
    const BoxVector<kSize> direction = newton_direction<kSize>(H, g + H * d, side);
    double reach = 1.0;
    Eigen::Index blocking = -1;
    for (Eigen::Index i = 0; i < size; ++i) {
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
      side[blocking] = up ? Side::high : Side::low;
      d[blocking] = up ? high[blocking] : low[blocking];
      continue;
    }
    const BoxVector<kSize> slope = g + H * d;
    Eigen::Index wrong = -1;
    double worst = 1e-12 * g.cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < size; ++i) {
      const Side at = side[i];
      if (at == Side::free || high[i] <= low[i]) continue;
      const double pull = at == Side::low ? -slope[i] : slope[i];
      if (pull > worst) {
        worst = pull;
        wrong = i;
      }
    }
    if (wrong < 0) break;
    side[wrong] = Side::free;
  }
  return d;
}

namespace {

/// What Gauss-Newton leaves out of the Hessian, sum of e_i times the Hessian of e_i, learnt from the change
/// of the gradient over the steps taken: symmetric rank-one updates, sized down where they no longer fit
/// (Dennis, Gay and Welsch 1981). Used only while it has predicted the last step better than Gauss-Newton
/// did. On chambers that the model does not fit exactly it cuts the iterations near the minimum by half or
/// more.
template <int kSize>
class Curvature {
 public:
  using Vector = BoxVector<kSize>;
  using Matrix = BoxMatrix<kSize>;
  explicit Curvature(Eigen::Index size) : S_(Matrix::Zero(size, size)) {}
  void learn(const Vector& step, const Vector& slope_change, const Matrix& H_there) {
    const Vector missing = slope_change - H_there * step;
    const double known = step.dot(S_ * step);
    const double wanted = step.dot(missing);
    if (std::abs(known) > std::abs(wanted)) S_ *= std::abs(wanted / known);
    const Vector rest = missing - S_ * step;
    const double along = rest.dot(step);
    if (std::abs(along) > 1e-6 * rest.norm() * step.norm()) S_ += rest * rest.transpose() / along;
  }
  void judge(double actual, double by_gauss_newton, double with_curvature) {
    in_use_ = std::abs(with_curvature - actual) < std::abs(by_gauss_newton - actual);
  }
  void stop_using() { in_use_ = false; }
  bool in_use() const { return in_use_; }
  const Matrix& matrix() const { return S_; }

 private:
  Matrix S_;
  bool in_use_ = false;
};

template <class Matrix, class Vector>
double promise(const Matrix& H, const Vector& g, const Vector& d) {
  return -(2.0 * g.dot(d) + d.dot(H * d));
}

template <class Matrix>
bool positive(const Matrix& H) {
  return H.llt().info() == Eigen::Success;
}

}  // namespace

template <int kSize>
BoxSolution<kSize> minimise_in_box(const BoxProblem<kSize>& problem, const BoxVector<kSize>& start,
                                   int most_iterations, double tolerance) {
  using Vector = BoxVector<kSize>;
  using Matrix = BoxMatrix<kSize>;
  const Eigen::Index size = start.size();
  constexpr double kLongestStep =
      1.0;  // of each variable: they are of order one, and the model is not that linear
  constexpr double kShortestStep = 1e-9;
  constexpr double kLeastDamping = 1e-7;
  constexpr double kMostDamping = 1e12;
  constexpr double kAfterRefusal = 1e-3;
  BoxSolution<kSize> solution;
  solution.z = start;
  BoxGram<kSize>& gram = solution.gram = problem.gram(solution.z);
  solution.squares = gram(size, size);
  Curvature<kSize> curvature(size);
  double lambda = 1e-3;
  double growth = 2.0;
  for (solution.iterations = 1; solution.iterations <= most_iterations; ++solution.iterations) {
    const Matrix H = gram.topLeftCorner(size, size);
    const Vector g = gram.col(size).head(size);
    const Vector scale = H.diagonal().cwiseMax(1e-9 * H.diagonal().maxCoeff());
    const Matrix damping = (lambda * scale).asDiagonal();
    Matrix model = H;
    if (curvature.in_use()) {
      model += curvature.matrix();
      if (!positive<Matrix>(model + damping)) model = H;
    }
    const Vector d =
        quadratic_in_box<kSize>(model + damping, g, (problem.low - solution.z).cwiseMax(-kLongestStep),
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
    const Vector trial = (solution.z + d).cwiseMax(problem.low).cwiseMin(problem.high);
    const double squares = problem.squares(trial);
    const double fall = solution.squares - squares;
    const double gain = fall / promised;
    if (std::isfinite(squares) && gain > 1e-4) {
      const Vector taken = trial - solution.z;
      gram = problem.gram(trial);
      const Matrix H_there = gram.topLeftCorner(size, size);
      curvature.judge(fall, promise(H, g, taken), promise(Matrix(H + curvature.matrix()), g, taken));
      const bool had_curvature = !curvature.matrix().isZero(0.0);
      curvature.learn(taken, gram.col(size).head(size) - g, H_there);
      if (!had_curvature)
        curvature.judge(fall, promise(H, g, taken), promise(Matrix(H + curvature.matrix()), g, taken));
      if (gain > 0.75) lambda = std::max(0.1 * lambda, kLeastDamping);
      if (gain < 0.25) lambda *= 2.0;
      growth = 2.0;
      solution.z = trial;
      solution.squares = gram(size, size);
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

template BoxSolution<kFree> minimise_in_box<kFree>(const BoxProblem<kFree>&, const BoxVector<kFree>&, int,
                                                   double);
template BoxVector<kFree> quadratic_in_box<kFree>(const BoxMatrix<kFree>&, const BoxVector<kFree>&,
                                                  const BoxVector<kFree>&, const BoxVector<kFree>&);
template BoxSolution<Eigen::Dynamic> minimise_in_box<Eigen::Dynamic>(const BoxProblem<Eigen::Dynamic>&,
                                                                     const BoxVector<Eigen::Dynamic>&, int,
                                                                     double);
template BoxVector<Eigen::Dynamic> quadratic_in_box<Eigen::Dynamic>(const BoxMatrix<Eigen::Dynamic>&,
                                                                    const BoxVector<Eigen::Dynamic>&,
                                                                    const BoxVector<Eigen::Dynamic>&,
                                                                    const BoxVector<Eigen::Dynamic>&);

}  // namespace plenum::host::identify
