#include "host-sim/identify/chamber/rising_areas.hpp"

#include <algorithm>

namespace plenum::host::identify::chamber {
namespace {

constexpr Eigen::Index kSteps = 100;
constexpr double kStep_V = 0.1;
constexpr double kLeastSlope = 0.01;
constexpr double kWeight_Pa = 1e8;

double bent_V(double opening_V, double slope, double curve, double bend) {
  const double g = opening_V / (opening_V + 2.0);
  return opening_V * std::max(1.0 + g * (slope + g * (curve + g * bend)), 0.05);
}

}  // namespace

Eigen::VectorXd falling_areas_Pa(const effects::Figures& figures) {
  const double* const x = figures.data() + effects::kFirstFigure[effects::kIdAreaShape];
  Eigen::VectorXd errors(2 * kSteps);
  for (Eigen::Index port = 0; port < 2; ++port) {
    const double slope = x[2 * port], curve = x[2 * port + 1], bend = x[4 + port];
    double before_V = 0.0;
    for (Eigen::Index i = 0; i < kSteps; ++i) {
      const double here_V = bent_V(kStep_V * static_cast<double>(i + 1), slope, curve, bend);
      errors[port * kSteps + i] = kWeight_Pa * std::max(0.0, kLeastSlope - (here_V - before_V) / kStep_V);
      before_V = here_V;
    }
  }
  return errors;
}

}  // namespace plenum::host::identify::chamber
