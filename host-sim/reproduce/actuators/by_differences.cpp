#include "host-sim/reproduce/actuators/by_differences.hpp"

namespace plenum::host::reproduce::actuators {
namespace {

constexpr double kStep = 1e-6;
constexpr int kMostIterations = 100;
constexpr double kTolerance = 1e-8;

identify::BoxGram<Eigen::Dynamic> gram(const Errors& errors, const Variables& z) {
  const Eigen::VectorXd e = errors(z);
  Eigen::MatrixXd by_z(e.size(), z.size() + 1);
  by_z.col(z.size()) = e;
  for (Eigen::Index i = 0; i < z.size(); ++i) {
    Variables moved = z;
    moved[i] += kStep;
    by_z.col(i) = (errors(moved) - e) / kStep;
  }
  return by_z.transpose() * by_z;
}

}  // namespace

Variables least_squares(const Errors& errors, const Variables& start, const Variables& low,
                        const Variables& high) {
  const identify::BoxProblem<Eigen::Dynamic> problem{
      [&](const Variables& z) { return errors(z).squaredNorm(); },
      [&](const Variables& z) { return gram(errors, z); }, low, high};
  return identify::minimise_in_box<Eigen::Dynamic>(problem, start, kMostIterations, kTolerance).z;
}

}  // namespace plenum::host::reproduce::actuators
