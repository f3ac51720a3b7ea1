#include "firmware/control/command_curve.hpp"

namespace plenum::control {
namespace {

/// Distances of the tabulated commands from the null c1 [V]. Dense where the curves bend (c_gamma and the
/// flat kink are tenths of a volt wide), sparse where they are nearly straight; from there to the ends of the
/// command range the two outermost nodes are the ends themselves.
constexpr std::array<Scalar, (CommandCurve::kNodes - 2) / 2> kDistances_V = {
    0.007F, 0.022F, 0.045F, 0.08F, 0.13F, 0.19F, 0.28F, 0.4F, 0.58F, 0.83F, 1.2F, 1.75F, 2.6F, 3.8F, 5.8F};

}  // namespace

void CommandCurve::configure(const Figures& figures, Scalar command_low_V, Scalar command_high_V) noexcept {
  of_ = figures;
  c_b_ = (figures.supply_kPa + figures.ambient_kPa) * Scalar(0.5);
  c_s_ = (figures.supply_kPa - figures.ambient_kPa) * Scalar(0.5);

  constexpr std::size_t kHalf = kDistances_V.size();
  auto& node_V = nodes_.command_V;
  node_V.front() = command_low_V;
  node_V.back() = command_high_V;
  for (std::size_t i = 0; i < kHalf; ++i) {
    node_V[kHalf - i] = numeric::clamp(of_.c1 - kDistances_V[i], command_low_V, command_high_V);
    node_V[kHalf + 1 + i] = numeric::clamp(of_.c1 + kDistances_V[i], command_low_V, command_high_V);
  }
  // u^ is at one of the ends where the root is largest, c8 u^ at one where c8 has its sign
  const Scalar widest_V =
      numeric::max(numeric::abs(command_low_V - of_.c1), numeric::abs(command_high_V - of_.c1));
  nodes_.opening_unit_V = numeric::whole_above(widest_V * (Scalar(1) + numeric::abs(of_.c8)) + of_.c9);
  nodes_.apart = 0;
  for (std::size_t i = 0; i < kNodes; ++i) {
    const Tangent of_node = tangent(node_V[i]);
    nodes_.steady_kPa[place(i)] = of_node.at.steady_kPa;
    nodes_.opening[place(i)] = numeric::part_of(of_node.at.opening_V, nodes_.opening_unit_V);
    nodes_.by_V[i] = of_node.by_V;
    if (i + 1 < kNodes && node_V[i] != node_V[i + 1]) nodes_.apart |= std::uint64_t{1} << i;
  }
}

}  // namespace plenum::control
