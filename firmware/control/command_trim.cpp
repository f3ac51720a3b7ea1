#include "firmware/control/command_trim.hpp"

namespace plenum::control {

using numeric::clamp;

namespace {

/// Slopes of the correction [V/V]. A steeper rise would multiply the gain of the loop by more than two; a
/// steeper fall would take half of it away, and at -1 turn the command around.
constexpr Scalar kSteepestRise = Scalar(1);
constexpr Scalar kSteepestFall = Scalar(0.5);

}  // namespace

void CommandTrim::configure(const Config& config) noexcept {
  config_ = config;
  nodes_per_V_ = static_cast<Scalar>(kNodes - 1) / (config.high_V - config.low_V);
  const Scalar spacing_V = Scalar(1) / nodes_per_V_;
  most_V_ = kSteepestRise * spacing_V;
  least_V_ = -kSteepestFall * spacing_V;
}

CommandTrim::Place CommandTrim::place(Scalar model_V) const noexcept {
  const Scalar last = static_cast<Scalar>(kNodes - 1);
  // written so that what is no number is at the first
  const Scalar at = numeric::min(numeric::max(Scalar(0), (model_V - config_.low_V) * nodes_per_V_), last);
  const std::size_t floor = static_cast<std::size_t>(at);
  const std::size_t below = floor < kNodes - 1 ? floor : kNodes - 2;
  return {.below = below, .above_share = at - static_cast<Scalar>(below)};
}

Scalar CommandTrim::at(const Place& place) const noexcept {
  const Scalar below_V = correction_V_[place.below];
  return below_V + place.above_share * (correction_V_[place.below + 1] - below_V);
}

Scalar CommandTrim::at(Scalar model_V) const noexcept {
  return at(place(model_V));
}

Scalar CommandTrim::reach(const Place& at) noexcept {
  const Scalar above = at.above_share;
  return above * above + (Scalar(1) - above) * (Scalar(1) - above);
}

void CommandTrim::move(const Place& at, Scalar step_V) noexcept {
  const auto shift = [&](std::size_t node, Scalar share) noexcept {
    correction_V_[node] = clamp(correction_V_[node] + share * step_V, -config_.limit_V, config_.limit_V);
  };
  shift(at.below, Scalar(1) - at.above_share);
  shift(at.below + 1, at.above_share);
  level(at.below);
}

void CommandTrim::level(std::size_t below) noexcept {
  // The taught pair gives way together, the nodes on either side follow it: those beyond one that need not have not moved.
  Scalar& low_V = correction_V_[below];
  Scalar& high_V = correction_V_[below + 1];
  const Scalar rise_V = high_V - low_V;
  const Scalar excess_V = numeric::shifted_down<1>(rise_V - clamp(rise_V, least_V_, most_V_));
  low_V += excess_V;
  high_V -= excess_V;
  const auto follow = [this](std::size_t node, Scalar from_V, Scalar to_V) noexcept {
    const Scalar before_V = correction_V_[node];
    correction_V_[node] = clamp(before_V, from_V, to_V);
    return correction_V_[node] != before_V;
  };
  for (std::size_t i = below; i > 0; --i) {
    if (!follow(i - 1, correction_V_[i] - most_V_, correction_V_[i] - least_V_)) break;
  }
  for (std::size_t i = below + 2; i < kNodes; ++i) {
    if (!follow(i, correction_V_[i - 1] + least_V_, correction_V_[i - 1] + most_V_)) break;
  }
}

}  // namespace plenum::control
