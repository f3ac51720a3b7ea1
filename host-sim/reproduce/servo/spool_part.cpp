#include <array>
#include <cmath>
#include <numbers>

#include "host-sim/plant/runge_kutta.hpp"
#include "host-sim/plant/spool.hpp"
#include "host-sim/reproduce/samples.hpp"
#include "host-sim/reproduce/servo/parts.hpp"

namespace plenum::host::reproduce::servo {
namespace {

// (1) in its own letters, for a spool and coil of 20 g on two springs.
constexpr double kMass_kg = 0.020;       // M_s
constexpr double kDamping_N_s_m = 11.4;  // C_s
constexpr double kSpring_N_m = 1668.0;   // k_s
constexpr double kCoilForce_N_A = 4.0;   // K_fc
constexpr double kCurrent_A = 0.5;       // i_c
constexpr double kStop_s = 0.03;

}  // namespace

Part spool_part() {
  const double omega = std::sqrt(2.0 * kSpring_N_m / kMass_kg);
  const double zeta = kDamping_N_s_m / (2.0 * std::sqrt(2.0 * kSpring_N_m * kMass_kg));
  plant::Spool spool({omega / (2.0 * std::numbers::pi), zeta}, 0.0);
  const double settled_m = kCoilForce_N_A * kCurrent_A / (2.0 * kSpring_N_m);
  // (1) by Runge-Kutta, against the spool's closed form scaled to the settled displacement
  using State = std::array<double, 2>;  // x, dx/dt
  const auto rate = [](double, const State& y) -> State {
    return {y[1],
            (kCoilForce_N_A * kCurrent_A - kDamping_N_s_m * y[1] - 2.0 * kSpring_N_m * y[0]) / kMass_kg};
  };
  State y{};
  double largest = 0.0;
  report::Curve ours{.name = "closed form", .x = {}, .y = {}};
  report::Curve paper{.name = "(1), integrated", .x = {}, .y = {}, .stroke = report::Stroke::kPoints};
  const double h = 2e-5;
  const int steps = static_cast<int>(std::lround(kStop_s / h));
  for (int i = 0; i <= steps; ++i) {
    largest = greater_of(largest, std::abs(y[0] / settled_m - spool.effective_V()));
    if (i % 5 == 0) {
      ours.x.push_back(i * h);
      ours.y.push_back(1e3 * settled_m * spool.effective_V());
    }
    if (i % 50 == 0) {
      paper.x.push_back(i * h);
      paper.y.push_back(1e3 * y[0]);
    }
    y = plant::runge_kutta_step(i * h, y, h, rate);
    spool.advance(1.0, h);
  }
  Part part;
  part.title = "(1): spool dynamics";
  part.text =
      "The spool's closed form against (1) integrated in its own letters, for a spool of 20 g: 65 Hz, "
      "damping ratio 0.7. The paper prints no "
      "figures for it. The friction F_f is neglected, as it allows.";
  part.findings.push_back({.item = "(1)",
                           .quantity = "largest difference of a step response, of the step",
                           .paper = 0.0,
                           .ours = largest,
                           .tolerance = 1e-6});
  part.findings.push_back({.item = "(1)",
                           .quantity = "displacement at rest over K_fc i_c / (2 k_s)",
                           .paper = 1.0,
                           .ours = spool.effective_V(),
                           .tolerance = 1e-3});
  part.charts.push_back(report::LineChart{.title = "Spool after a step of the coil current",
                                          .y = {"Displacement", "mm"},
                                          .curves = {ours, paper}});
  return part;
}

}  // namespace plenum::host::reproduce::servo
