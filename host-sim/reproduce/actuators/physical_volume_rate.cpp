#include "host-sim/reproduce/actuators/physical_volume_rate.hpp"

#include <algorithm>
#include <cmath>

#include "host-sim/plant/gas.hpp"
#include "host-sim/reproduce/actuators/by_differences.hpp"

namespace plenum::host::reproduce::actuators {
namespace {

constexpr std::size_t kEveryRow = 4;
constexpr double kErrorScale_kPa = 1.0;

identify::SteadyAndRate at(const PhysicalModel& model, const identify::Ticks& ticks, std::size_t row) {
  return steady_and_rate(model, ticks.command_V[row], ticks.volume_mL[row], ticks.volume_rate_mL_s[row]);
}

/// How far sqrt(U^2 + c_gamma^2) - c_gamma + c_8 U falls below 0: c_9 above it keeps k > 0.
double depth_V(const identify::Tassa9& model) {
  return model.c_gamma_V * (1.0 - std::sqrt(1.0 - model.c[7] * model.c[7]));
}

// Variables of order one: c_1, log c_2, asinh c_3, log c_7, c_8, log of what c_9 is above its least.
Variables to_variables(const identify::Tassa9& model) {
  Variables z(6);
  z << model.c[0], std::log(model.c[1]), std::asinh(model.c[2]), std::log(model.c[6]), model.c[7],
      std::log(std::max(model.c[8] - depth_V(model), 1e-4));
  return z;
}

PhysicalModel from_variables(const Variables& z, PhysicalModel model) {
  model.at_rest.c = {z[0], std::exp(z[1]), std::sinh(z[2]), 0.0, 0.0, 0.0, std::exp(z[3]), z[4], 0.0};
  model.at_rest.c[8] = depth_V(model.at_rest) + std::exp(z[5]);
  return model;
}

}  // namespace

identify::SteadyAndRate steady_and_rate(const PhysicalModel& model, double command_V, double volume_mL,
                                        double volume_rate_mL_s) {
  const identify::SteadyAndRate rest = identify::steady_and_rate(model.at_rest, command_V, 0.0, 0.0);
  const double K_mL_s = rest.rate_per_s * model.volume_mL;
  const double driven_mL_s = K_mL_s + plant::Gas{}.kappa * volume_rate_mL_s;
  return {K_mL_s * rest.steady_kPa / driven_mL_s, driven_mL_s / volume_mL};
}

PhysicalModel fit_next_pressure(const trace::Log& log, const PhysicalModel& start) {
  const identify::Ticks ticks = identify::lay_out({log});
  const std::size_t count = (ticks.size() - 2) / kEveryRow;
  const Errors errors = [&](const Variables& z) {
    const PhysicalModel model = from_variables(z, start);
    Eigen::VectorXd e(static_cast<Eigen::Index>(count));
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t row = 1 + i * kEveryRow;
      const double p_kPa = identify::end_from_mean(at(model, ticks, row - 1), ticks.pressure_kPa[row],
                                                   ticks.period_s, ticks.average_s);
      const identify::Step next =
          identify::step(at(model, ticks, row), p_kPa, ticks.period_s, ticks.average_s);
      e[static_cast<Eigen::Index>(i)] = (next.mean_kPa - ticks.pressure_kPa[row + 1]) / kErrorScale_kPa;
    }
    return e;
  };
  Variables low(6);
  Variables high(6);
  low << 2.0, std::log(1e-3), 0.0, std::log(1e-3), -0.9, std::log(1e-4);
  high << 8.0, std::log(50.0), std::asinh(500.0), std::log(200.0), 0.9, std::log(5.0);
  const Variables from = to_variables(start.at_rest).cwiseMax(low).cwiseMin(high);
  return from_variables(least_squares(errors, from, low, high), start);
}

identify::Drift drift(const trace::Log& log, const PhysicalModel& model, std::size_t starts,
                      double horizon_s) {
  const identify::Ticks ticks = identify::lay_out({log});
  const auto predict = [&](std::size_t start_row, std::size_t rows) {
    double p_kPa = ticks.pressure_kPa[start_row];
    if (start_row > 0) {
      p_kPa =
          identify::end_from_mean(at(model, ticks, start_row - 1), p_kPa, ticks.period_s, ticks.average_s);
    }
    std::vector<double> predicted_kPa;
    for (std::size_t row = start_row; row < start_row + rows; ++row) {
      const identify::Step next =
          identify::step(at(model, ticks, row), p_kPa, ticks.period_s, ticks.average_s);
      predicted_kPa.push_back(next.mean_kPa);
      p_kPa = next.end_kPa;
    }
    return predicted_kPa;
  };
  return identify::drift(ticks, model.at_rest.supply_kPa - model.at_rest.ambient_kPa, predict,
                         {.starts = starts, .horizon_s = horizon_s});
}

}  // namespace plenum::host::reproduce::actuators
