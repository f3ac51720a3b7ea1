#include "host-sim/identify/orifice/bounded_squares.hpp"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "host-sim/identify/box_solver.hpp"

namespace plenum::host::identify::orifice {
namespace {

constexpr double kUndetermined = 1e-13;  // of the greatest eigenvalue

Eigen::MatrixXd jacobian_at(const BoundedSquares& problem, const double* variables) {
  const auto count = static_cast<Eigen::Index>(problem.low.size());
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(problem.rows, count);
  std::vector<double> z(variables, variables + count);
  Eigen::VectorXd above(problem.rows);
  Eigen::VectorXd below(problem.rows);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto n = static_cast<std::size_t>(i);
    if (problem.low[n] == problem.high[n]) continue;
    const double middle = z[n];
    z[n] = middle + problem.step[n];
    problem.at(z.data(), above.data());
    z[n] = middle - problem.step[n];
    problem.at(z.data(), below.data());
    z[n] = middle;
    jacobian.col(i) = (above - below) / (2.0 * problem.step[n]);
  }
  return jacobian;
}

Eigen::VectorXd standard_errors(const Eigen::MatrixXd& jacobian, const std::vector<Eigen::Index>& free,
                                double variance) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const auto count = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd columns(jacobian.rows(), count);
  Eigen::VectorXd length(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    columns.col(i) = jacobian.col(free[static_cast<std::size_t>(i)]);
    length(i) = columns.col(i).norm();
    if (length(i) > 0.0) columns.col(i) /= length(i);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(columns.transpose() * columns);
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < count; ++j) {
      const double share = eigen.eigenvectors()(i, j) * eigen.eigenvectors()(i, j);
      const double value = eigen.eigenvalues()(j);
      if (value > kUndetermined * eigen.eigenvalues()(count - 1))
        errors(i) += share / value;
      else if (share > 1e-8)
        errors(i) = kInfinite;
    }
    errors(i) = length(i) > 0.0 ? std::sqrt(errors(i) * variance) / length(i) : kInfinite;
  }
  return errors;
}

}  // namespace

SquaresMinimum minimise(const BoundedSquares& problem, std::vector<double> start, double tolerance,
                        int most_iterations) {
  using Vector = BoxVector<Eigen::Dynamic>;
  const std::size_t count = problem.low.size();
  const auto size = static_cast<Eigen::Index>(count);
  const Eigen::Map<const Eigen::VectorXd> low(problem.low.data(), size);
  const Eigen::Map<const Eigen::VectorXd> high(problem.high.data(), size);
  Eigen::VectorXd errors(problem.rows);

  BoxProblem<Eigen::Dynamic> box;
  box.low = low;
  box.high = high;
  box.squares = [&](const Vector& z) {
    problem.at(z.data(), errors.data());
    return errors.squaredNorm();
  };
  box.gram = [&](const Vector& z) -> BoxGram<Eigen::Dynamic> {
    Eigen::MatrixXd columns(problem.rows, size + 1);
    columns.leftCols(size) = jacobian_at(problem, z.data());
    problem.at(z.data(), errors.data());
    columns.col(size) = errors;
    return columns.transpose() * columns;
  };
  const Vector first = Eigen::Map<const Eigen::VectorXd>(start.data(), size).cwiseMax(low).cwiseMin(high);
  const BoxSolution<Eigen::Dynamic> solution =
      minimise_in_box<Eigen::Dynamic>(box, first, most_iterations, tolerance);

  SquaresMinimum minimum;
  minimum.variables.assign(solution.z.data(), solution.z.data() + size);
  minimum.squares = solution.squares;
  minimum.iterations = solution.iterations;
  minimum.converged = solution.converged;
  minimum.stop = solution.stop;
  std::vector<Eigen::Index> free;
  minimum.standard_errors.assign(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    minimum.at_bound.push_back(bound_of(minimum.variables[i], problem.low[i], problem.high[i]));
    if (minimum.at_bound[i] != Bound::none)
      minimum.standard_errors[i] = std::numeric_limits<double>::quiet_NaN();
    else if (problem.low[i] != problem.high[i])
      free.push_back(static_cast<Eigen::Index>(i));
  }
  if (free.empty()) return minimum;
  const double freedom = std::max(problem.rows - static_cast<int>(free.size()), 1);
  const Eigen::VectorXd deviations =
      standard_errors(jacobian_at(problem, minimum.variables.data()), free, minimum.squares / freedom);
  for (std::size_t i = 0; i < free.size(); ++i)
    minimum.standard_errors[static_cast<std::size_t>(free[i])] = deviations(static_cast<Eigen::Index>(i));
  return minimum;
}

}  // namespace plenum::host::identify::orifice
