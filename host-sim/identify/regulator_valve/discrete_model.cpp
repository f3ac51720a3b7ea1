#include "host-sim/identify/regulator_valve/discrete_model.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

#include "host-sim/plant/refuse.hpp"

namespace plenum::host::identify::regulator_valve {
namespace {

using plant::regulator_valve::ThirdOrder;

// Of z^3 + a z^2 + b z + c.
std::array<std::complex<double>, 3> cubic_roots(double a, double b, double c) {
  Eigen::Matrix3d companion;
  companion << -a, -b, -c, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0;
  const Eigen::Vector3cd roots = companion.eigenvalues();
  return {roots[0], roots[1], roots[2]};
}

}  // namespace

DiscreteModel discretise(const ThirdOrder& model, double sample_s) {
  plant::require_above("discretise sample_s", sample_s, 0.0);
  const double t = sample_s;
  const auto [c1, c2, c3, c4] = model;
  return {.b_Pa_m = c1 * t * t * t,
          .a = {c2 * t - 3.0, c3 * t * t - 2.0 * c2 * t + 3.0, c4 * t * t * t - c3 * t * t + c2 * t - 1.0},
          .sample_s = sample_s};
}

ThirdOrder read_back(const DiscreteModel& model) {
  plant::require_above("read_back sample_s", model.sample_s, 0.0);
  const double t = model.sample_s;
  const auto [a1, a2, a3] = model.a;
  return {.gain_Pa_m_s3 = model.b_Pa_m / (t * t * t),
          .square_1_s = (a1 + 3.0) / t,
          .linear_1_s2 = (a2 + 2.0 * a1 + 3.0) / (t * t),
          .constant_1_s3 = model.residue() / (t * t * t)};
}

std::array<std::complex<double>, 3> poles(const DiscreteModel& model) {
  auto roots = cubic_roots(model.a[0], model.a[1], model.a[2]);
  std::sort(roots.begin(), roots.end(),
            [](const auto& left, const auto& right) { return std::abs(left) > std::abs(right); });
  return roots;
}

std::array<std::complex<double>, 3> poles(const ThirdOrder& model) {
  auto roots = cubic_roots(model.square_1_s, model.linear_1_s2, model.constant_1_s3);
  std::sort(roots.begin(), roots.end(),
            [](const auto& left, const auto& right) { return left.real() > right.real(); });
  return roots;
}

bool stable(const DiscreteModel& model) {
  return std::abs(poles(model)[0]) < 1.0;
}

bool stable(const ThirdOrder& model) {
  return poles(model)[0].real() < 0.0;
}

double slowest_time_constant_s(const DiscreteModel& model) {
  if (!stable(model)) return std::numeric_limits<double>::infinity();
  return -model.sample_s / std::log(std::abs(poles(model)[0]));
}

double slowest_time_constant_s(const ThirdOrder& model) {
  if (!stable(model)) return std::numeric_limits<double>::infinity();
  return -1.0 / poles(model)[0].real();
}

std::vector<double> free_run(const DiscreteModel& model, const std::vector<double>& screw_m,
                             const std::vector<double>& pressure_Pa) {
  if (screw_m.size() != pressure_Pa.size() || screw_m.size() < 3) {
    throw std::invalid_argument(
        fmt::format("free_run: {} screw positions and {} pressures, expected as many and at least 3",
                    screw_m.size(), pressure_Pa.size()));
  }
  std::vector<double> run(pressure_Pa.begin(), pressure_Pa.begin() + 3);
  run.reserve(screw_m.size());
  for (std::size_t k = 3; k < screw_m.size(); ++k) {
    run.push_back(model.b_Pa_m * screw_m[k - 1] - model.a[0] * run[k - 1] - model.a[1] * run[k - 2] -
                  model.a[2] * run[k - 3]);
  }
  return run;
}

}  // namespace plenum::host::identify::regulator_valve
