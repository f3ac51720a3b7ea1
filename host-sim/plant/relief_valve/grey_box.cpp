#include "host-sim/plant/relief_valve/grey_box.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "host-sim/plant/refuse.hpp"
#include "host-sim/plant/root_between.hpp"

namespace plenum::host::plant::relief_valve {
namespace {

constexpr double kGamma = 1.0 - 0.5 * std::numbers::sqrt2;  // of the L-stable SDIRK method of two stages
constexpr int kNewtonAtMost = 50;
constexpr double kNewtonDone = 1e-7;  // relative: quadratic convergence leaves 1e-14
// With a lag that depends on pressure, it is held at the middle of parts in which pressure changes by this
// share.
constexpr double kSmallShare = 0.01;

double root_half(double density_kg_m3) {
  return std::sqrt(0.5 * density_kg_m3);
}

/// a(t) under s(t) = s_m2 + slope t with a constant lag.
struct LagResponse {
  double a_m2, s_m2, slope_m2_s, lag_s;

  double at(double t) const {
    const double behind = slope_m2_s * lag_s;
    return s_m2 + slope_m2_s * t - behind + (a_m2 - s_m2 + behind) * std::exp(-t / lag_s);
  }
  /// When a, above 0 now, gets to 0 within `duration_s`; infinite where it does not.
  double shuts_s(double duration_s) const {
    double lowest_s = duration_s;
    const double behind = slope_m2_s * lag_s;
    if (behind > 0.0 && a_m2 > s_m2)
      lowest_s = std::min(duration_s, lag_s * std::log((a_m2 - s_m2 + behind) / behind));
    if (at(lowest_s) > 0.0) return std::numeric_limits<double>::infinity();
    return root_between([this](double t) { return at(t); }, 0.0, lowest_s);
  }
};

}  // namespace

void validate(const StaticGreyBox& valve) {
  require_above("grey box k1_m2_Pa", valve.k1_m2_Pa, 0.0);
  require_finite("grey box k2_s_m_sqrtPa", valve.k2_s_m_sqrtPa);
  require_within("grey box k3_m2", valve.k3_m2, -std::numeric_limits<double>::max(), 0.0);
  require_above("grey box density_kg_m3", valve.density_kg_m3, 0.0);
}

double cracking_pressure_Pa(const StaticGreyBox& valve) {
  return (0.0 - valve.k3_m2) / valve.k1_m2_Pa;
}

double maximum_pressure_Pa(const StaticGreyBox& valve) {
  if (valve.k2_s_m_sqrtPa <= 0.0) return std::numeric_limits<double>::infinity();
  return root_half(valve.density_kg_m3) / valve.k2_s_m_sqrtPa;
}

double flow_m3_s(const StaticGreyBox& valve, double pressure_Pa) {
  const double opens_m2 = valve.k1_m2_Pa * pressure_Pa + valve.k3_m2;
  if (opens_m2 <= 0.0) return 0.0;
  const double remaining = root_half(valve.density_kg_m3) - valve.k2_s_m_sqrtPa * pressure_Pa;
  if (remaining <= 0.0) {
    throw std::invalid_argument("grey box pressure_Pa: " + std::to_string(pressure_Pa) +
                                ", expected below the maximum pressure " +
                                std::to_string(maximum_pressure_Pa(valve)) + " Pa");
  }
  return opens_m2 * std::sqrt(pressure_Pa) / remaining;
}

double pressure_Pa(const StaticGreyBox& valve, double flow_m3_s) {
  require_above("grey box flow_m3_s", flow_m3_s, 0.0);
  // Q (sqrt(rho/2) - k2 P) = (k1 P + k3) sqrt(P): the difference rises from the cracking pressure on.
  const auto missing = [&](double P) {
    return (valve.k1_m2_Pa * P + valve.k3_m2) * std::sqrt(P) -
           flow_m3_s * (root_half(valve.density_kg_m3) - valve.k2_s_m_sqrtPa * P);
  };
  const double low_Pa = cracking_pressure_Pa(valve);
  double high_Pa = 2.0 * low_Pa + 1.0;
  while (missing(high_Pa) <= 0.0 && std::isfinite(high_Pa)) high_Pa *= 2.0;
  require_finite("grey box pressure at the flow", high_Pa);
  return root_between(missing, low_Pa, high_Pa);
}

double opening_m2(double flow_m3_s, double pressure_Pa, double density_kg_m3) {
  return flow_m3_s * root_half(density_kg_m3) / std::sqrt(pressure_Pa);
}

void validate(const GreyBoxConfig& config) {
  validate(StaticGreyBox{config.k1_m2_Pa, 0.0, config.k3_m2, config.density_kg_m3});
  require_within("grey box lag_s", config.lag_s, 0.0, std::numeric_limits<double>::max());
  if (config.damping == Damping::kOverPressure)
    require_above("grey box lag_pressure_Pa", config.lag_pressure_Pa, 0.0);
}

double pressure_rate_Pa_s(const GreyBoxConfig& config, double pressure_Pa, double flow_m3_s,
                          double flow_rate_m3_s2) {
  const double root_P = std::sqrt(pressure_Pa);
  const double a = opening_m2(flow_m3_s, pressure_Pa, config.density_kg_m3);
  const double opens =
      (config.k1_m2_Pa * pressure_Pa + config.k3_m2 - a) / (config.lag_s * root_half(config.density_kg_m3));
  return 2.0 * root_P / flow_m3_s * (flow_rate_m3_s2 * root_P - pressure_Pa * opens);
}

double flow_rate_m3_s2(const GreyBoxConfig& config, double pressure_Pa, double flow_m3_s,
                       double pressure_rate_Pa_s) {
  const double root_P = std::sqrt(pressure_Pa);
  const double a = opening_m2(flow_m3_s, pressure_Pa, config.density_kg_m3);
  const double opens =
      (config.k1_m2_Pa * pressure_Pa + config.k3_m2 - a) / (config.lag_s * root_half(config.density_kg_m3));
  return (pressure_Pa * opens + flow_m3_s * pressure_rate_Pa_s / (2.0 * root_P)) / root_P;
}

GreyBoxValve::GreyBoxValve(const GreyBoxConfig& config, double pressure_Pa) : config_(config) {
  validate(config);
  require_within("grey box pressure_Pa", pressure_Pa, 0.0, std::numeric_limits<double>::max());
  opening_m2_ = std::max(0.0, config.k1_m2_Pa * pressure_Pa + config.k3_m2);
}

double GreyBoxValve::flow_m3_s(double pressure_Pa) const {
  return opening_m2_ * std::sqrt(2.0 * pressure_Pa / config_.density_kg_m3);
}

double GreyBoxValve::pressure_Pa(double flow_m3_s) const {
  const double speed_m_s = flow_m3_s / opening_m2_;
  return 0.5 * config_.density_kg_m3 * speed_m_s * speed_m_s;
}

void GreyBoxValve::drive_pressure(double from_Pa, double to_Pa, double duration_s) {
  require_within("grey box from_Pa", from_Pa, 0.0, std::numeric_limits<double>::max());
  require_within("grey box to_Pa", to_Pa, 0.0, std::numeric_limits<double>::max());
  require_above("grey box duration_s", duration_s, 0.0);
  if (config_.lag_s == 0.0) {
    opening_m2_ = std::max(0.0, config_.k1_m2_Pa * to_Pa + config_.k3_m2);
    return;
  }
  if (config_.damping == Damping::kOverPressure &&
      std::abs(to_Pa - from_Pa) > kSmallShare * std::max(from_Pa, to_Pa)) {
    const double middle_Pa = 0.5 * (from_Pa + to_Pa);
    drive_pressure(from_Pa, middle_Pa, 0.5 * duration_s);
    drive_pressure(middle_Pa, to_Pa, 0.5 * duration_s);
    return;
  }
  LagResponse response{.a_m2 = opening_m2_,
                       .s_m2 = config_.k1_m2_Pa * from_Pa + config_.k3_m2,
                       .slope_m2_s = config_.k1_m2_Pa * (to_Pa - from_Pa) / duration_s,
                       .lag_s = lag_s(0.5 * (from_Pa + to_Pa))};
  double left_s = duration_s;
  const auto pass = [&](double t) {
    response.s_m2 += response.slope_m2_s * t;
    left_s -= t;
  };
  if (response.a_m2 > 0.0) {
    const double shuts_s = response.shuts_s(left_s);
    if (shuts_s > left_s) {
      opening_m2_ = response.at(left_s);
      return;
    }
    pass(shuts_s);
    response.a_m2 = 0.0;
  }
  // Shut: it stays so until the static line gets above 0.
  if (response.s_m2 < 0.0)
    pass(response.slope_m2_s > 0.0 ? std::min(left_s, -response.s_m2 / response.slope_m2_s) : left_s);
  opening_m2_ = left_s > 0.0 ? std::max(0.0, response.at(left_s)) : 0.0;
}

// a - weight da/dt = known at the flow given, for a > 0. The left side rises with a and is concave, so
// Newton's method comes to the root from below whatever it starts from.
double GreyBoxValve::implicit_stage(double known_m2, double weight_s, double flow_m3_s,
                                    double guess_m2) const {
  const double c = 0.5 * config_.density_kg_m3 * flow_m3_s * flow_m3_s;  // P = c / a^2
  double a = guess_m2;
  for (int i = 0; i < kNewtonAtMost; ++i) {
    const double P = c / (a * a);
    const double share = weight_s / lag_s(P);
    const double dshare = config_.damping == Damping::kOverPressure ? -2.0 * share / a : 0.0;
    const double short_of = config_.k1_m2_Pa * P + config_.k3_m2 - a;
    const double rest = a - share * short_of - known_m2;
    const double slope = 1.0 - dshare * short_of + share * (2.0 * config_.k1_m2_Pa * P / a + 1.0);
    const double next = std::max(a - rest / slope, 0.1 * a);
    const bool done = std::abs(next - a) <= kNewtonDone * a;
    a = next;
    if (done) return a;
  }
  throw std::runtime_error("grey box: the implicit step did not converge; shorten it");
}

void GreyBoxValve::drive_flow(double from_m3_s, double to_m3_s, double duration_s) {
  require_above("grey box from_m3_s", from_m3_s, 0.0);
  require_above("grey box to_m3_s", to_m3_s, 0.0);
  require_above("grey box duration_s", duration_s, 0.0);
  if (config_.lag_s == 0.0) {
    const double P = relief_valve::pressure_Pa(
        StaticGreyBox{config_.k1_m2_Pa, 0.0, config_.k3_m2, config_.density_kg_m3}, to_m3_s);
    opening_m2_ = relief_valve::opening_m2(to_m3_s, P, config_.density_kg_m3);
    return;
  }
  const double weight_s = kGamma * duration_s;
  // Pressure changes little, so the opening's first guess goes with the flow; from shut it is any that lets
  // flow pass.
  const double guess_m2 = opening_m2_ > 0.0 ? opening_m2_ / from_m3_s : config_.k1_m2_Pa / from_m3_s;
  const double stage_m3_s = from_m3_s + kGamma * (to_m3_s - from_m3_s);
  const double first = implicit_stage(opening_m2_, weight_s, stage_m3_s, guess_m2 * stage_m3_s);
  const double rate = (first - opening_m2_) / weight_s;
  opening_m2_ =
      implicit_stage(opening_m2_ + (1.0 - kGamma) * duration_s * rate, weight_s, to_m3_s, guess_m2 * to_m3_s);
}

}  // namespace plenum::host::plant::relief_valve
