#include "host-sim/identify/relief_valve/static_fit.hpp"

#include <fmt/core.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/relief_valve/greater_of.hpp"
#include "host-sim/plant/refuse.hpp"

namespace plenum::host::identify::relief_valve {
namespace {

using plant::relief_valve::StaticGreyBox;

// Columns of unit length nearer to dependent than this leave parameters to the noise.
constexpr double kRankThreshold = 1e-9;

void require_sensible(const StaticPoint& point) {
  plant::require_above("static point pressure_Pa", point.pressure_Pa, 0.0);
  plant::require_within("static point flow_m3_s", point.flow_m3_s, 0.0, std::numeric_limits<double>::max());
}

Eigen::VectorXd least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& B) {
  const Eigen::VectorXd length = A.colwise().norm().cwiseMax(std::numeric_limits<double>::min());
  const Eigen::MatrixXd scaled = A * length.cwiseInverse().asDiagonal();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  qr.setThreshold(kRankThreshold);
  if (qr.rank() < A.cols())
    throw CannotIdentify(fmt::format(
        "static fit: the {} points determine {} of {} parameters; expected more spread in pressure and flow",
        A.rows(), qr.rank(), A.cols()));
  return Eigen::VectorXd(qr.solve(B)).cwiseQuotient(length);
}

}  // namespace

StaticGreyBox fit_static(std::span<const StaticPoint> points, double density_kg_m3, FlowForce flow_force) {
  plant::require_above("static fit density_kg_m3", density_kg_m3, 0.0);
  const Eigen::Index unknowns = flow_force == FlowForce::kFitted ? 3 : 2;
  const auto rows = static_cast<Eigen::Index>(points.size());
  if (rows < unknowns)
    throw CannotIdentify(fmt::format("static fit: {} points, expected at least {}", rows, unknowns));
  Eigen::MatrixXd A(rows, unknowns);  // the constant last, so that it can be left out
  Eigen::VectorXd B(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const StaticPoint& point = points[static_cast<std::size_t>(i)];
    require_sensible(point);
    A(i, 0) = point.pressure_Pa;
    if (unknowns == 3) A(i, 1) = point.flow_m3_s * std::sqrt(point.pressure_Pa);
    A(i, unknowns - 1) = 1.0;
    B(i) = plant::relief_valve::opening_m2(point.flow_m3_s, point.pressure_Pa, density_kg_m3);
  }
  Eigen::VectorXd k = least_squares(A, B);
  const Eigen::VectorXd pressure = A.col(0).array() - A.col(0).mean();
  if (pressure.dot(B) <= 0.0)
    throw CannotIdentify(
        "static fit: the opening falls as pressure rises; expected a relief valve, which opens");
  if (k(unknowns - 1) > 0.0) {
    k.head(unknowns - 1) = least_squares(A.leftCols(unknowns - 1), B);
    k(unknowns - 1) = 0.0;
  }
  if (k(0) <= 0.0)
    throw CannotIdentify(
        fmt::format("static fit: k1 = {:.3g} m2/Pa, expected above 0; the points do not tell pressure and "
                    "flow force apart",
                    k(0)));
  return {k(0), unknowns == 3 ? k(1) : 0.0, k(unknowns - 1), density_kg_m3};
}

StaticError static_error(const StaticGreyBox& valve, std::span<const StaticPoint> points,
                         FlowForce flow_force) {
  const bool fits_k2 = flow_force == FlowForce::kFitted;
  const bool fits_k3 = valve.k3_m2 != 0.0;
  const auto rows = static_cast<Eigen::Index>(points.size());
  const Eigen::Index unknowns = 1 + (fits_k2 ? 1 : 0) + (fits_k3 ? 1 : 0);
  if (rows <= unknowns) {
    throw CannotIdentify(fmt::format(
        "static fit: {} points for {} parameters, expected more to know how well", rows, unknowns));
  }
  const Eigen::Index k2 = fits_k2 ? 1 : -1;
  const Eigen::Index k3 = fits_k3 ? unknowns - 1 : -1;
  Eigen::MatrixXd A(rows, unknowns);
  double squares = 0.0;
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto& [P, Q] = points[static_cast<std::size_t>(i)];
    A(i, 0) = P;
    if (fits_k2) A(i, k2) = Q * std::sqrt(P);
    if (fits_k3) A(i, k3) = 1.0;
    const double a = valve.k1_m2_Pa * P + valve.k2_s_m_sqrtPa * Q * std::sqrt(P) + valve.k3_m2;
    squares += std::pow(plant::relief_valve::opening_m2(Q, P, valve.density_kg_m3) - a, 2);
  }
  const Eigen::VectorXd length = A.colwise().norm().cwiseMax(std::numeric_limits<double>::min());
  const Eigen::MatrixXd scaled = A * length.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd root =
      length.cwiseInverse().asDiagonal() * scaled.completeOrthogonalDecomposition().pseudoInverse();
  const Eigen::MatrixXd covariance = squares / static_cast<double>(rows - unknowns) * root * root.transpose();
  StaticError error;
  error.k1_m2_Pa = std::sqrt(covariance(0, 0));
  if (fits_k3) {
    error.k3_m2 = std::sqrt(covariance(k3, k3));
    // -k3/k1 over k1 and k3
    const double over_k1 = valve.k3_m2 / (valve.k1_m2_Pa * valve.k1_m2_Pa);
    const double over_k3 = -1.0 / valve.k1_m2_Pa;
    error.cracking_Pa =
        std::sqrt(over_k1 * over_k1 * covariance(0, 0) + over_k3 * over_k3 * covariance(k3, k3) +
                  2.0 * over_k1 * over_k3 * covariance(0, k3));
  }
  if (fits_k2) {
    error.k2_s_m_sqrtPa = std::sqrt(covariance(k2, k2));
    error.maximum_Pa = valve.k2_s_m_sqrtPa > 0.0
                           ? maximum_pressure_Pa(valve) * error.k2_s_m_sqrtPa / valve.k2_s_m_sqrtPa
                           : std::numeric_limits<double>::infinity();
  }
  return error;
}

StaticGreyBox static_through(double cracking_Pa, const StaticPoint& rated, double density_kg_m3) {
  require_sensible(rated);
  plant::require_above("static line density_kg_m3", density_kg_m3, 0.0);
  plant::require_above("static line cracking_Pa", cracking_Pa, 0.0);
  plant::require_above("static line rated pressure_Pa", rated.pressure_Pa, cracking_Pa);
  plant::require_above("static line rated flow_m3_s", rated.flow_m3_s, 0.0);
  const double opens_m2 = plant::relief_valve::opening_m2(rated.flow_m3_s, rated.pressure_Pa, density_kg_m3);
  const double k1 = opens_m2 / (rated.pressure_Pa - cracking_Pa);
  return {k1, 0.0, -k1 * cracking_Pa, density_kg_m3};
}

double worst_pressure_error(const StaticGreyBox& valve, std::span<const StaticPoint> points) {
  double worst = 0.0;
  for (const StaticPoint& point : points) {
    if (point.flow_m3_s <= 0.0) continue;
    const double P = plant::relief_valve::pressure_Pa(valve, point.flow_m3_s);
    worst = greater_of(worst, std::abs(P - point.pressure_Pa) / point.pressure_Pa);
  }
  return worst;
}

}  // namespace plenum::host::identify::relief_valve
