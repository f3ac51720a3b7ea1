#include "firmware/control/command_trim.hpp"

namespace plenum::control {

using numeric::clamp;

void CommandTrim::configure(const Config& config) noexcept {
  config_ = config;
  nodes_per_V_ = static_cast<Scalar>(kNodes - 1) / (config.high_V - config.low_V);
}

CommandTrim::Place CommandTrim::place(Scalar model_V) const noexcept {
  const Scalar last = static_cast<Scalar>(kNodes - 1);
  const Scalar at = clamp((model_V - config_.low_V) * nodes_per_V_, Scalar(0), last);
  const std::size_t floor = static_cast<std::size_t>(at);
  const std::size_t below = floor < kNodes - 1 ? floor : kNodes - 2;
  return {.below = below, .above_share = at - static_cast<Scalar>(below)};
}

Scalar CommandTrim::at(Scalar model_V) const noexcept {
  const Place here = place(model_V);
  const Scalar below_V = correction_V_[here.below];
  return below_V + here.above_share * (correction_V_[here.below + 1] - below_V);
}

void CommandTrim::learn(Scalar model_V, Scalar residual_kPa, Scalar slope_kPa_V) noexcept {
  const Scalar floor = config_.slope_floor_kPa_V;
  const Scalar excess_V = residual_kPa * slope_kPa_V / (slope_kPa_V * slope_kPa_V + floor * floor);
  const Place here = place(model_V);
  const auto move = [&](Scalar& node_V, Scalar share) noexcept {
    node_V = clamp(node_V - config_.gain * share * excess_V, -config_.limit_V, config_.limit_V);
  };
  move(correction_V_[here.below], Scalar(1) - here.above_share);
  move(correction_V_[here.below + 1], here.above_share);
}

}  // namespace plenum::control
