// The control core in fixed point against itself in double: the largest differences found, and what they do to a closed loop.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <span>

#include "tests/bench/row.hpp"
#include "tests/equivalence/core.hpp"
#include "tests/equivalence/states.hpp"
#include "tests/firmware/control/paper_chamber.hpp"

namespace {

using namespace equivalence;
using plenum::config::ModelKind;

constexpr std::array kKinds = {ModelKind::tassa9, ModelKind::tassa9r, ModelKind::greybox};
constexpr double kConverterStep_V = 10.0 / 65536;

struct Worst {
  double prediction_percent = 0;
  double command_steps = 0;
};

/// Over `models` of each kind, ten states each.
Worst compare(int models) {
  Worst worst;
  const auto raise = [](double& most, double found) { most = std::max(most, std::fabs(found)); };
  for (const ModelKind kind : kKinds) {
    for_each_state(kind, 77, models, 10, [&](const Asked& asked) {
      const Prediction got = asked.fixed.step(asked.from, asked.command_V);
      const Prediction want = asked.exact.step(asked.from, asked.command_V);
      raise(worst.prediction_percent, 100.0 * (got.end_kPa - want.end_kPa) / asked.span_kPa);
      raise(worst.prediction_percent, 100.0 * (got.mean_kPa - want.mean_kPa) / asked.span_kPa);
      const double found_V = asked.fixed.inverse(asked.from, asked.target_kPa, asked.command_V).command_V;
      const double exact_V = asked.exact.inverse(asked.from, asked.target_kPa, asked.command_V).command_V;
      if (commands_matter(asked, found_V, exact_V))
        raise(worst.command_steps, (found_V - exact_V) / kConverterStep_V);
    });
  }
  return worst;
}

/// RMS tracking error [kPa] of 60 s on a sum of sines, the volume swinging by a quarter, with noise on both sensors.
double tracking_rms_kPa(Core& core, const std::array<float, 12>& parameters, unsigned seed) {
  constexpr int kTicks = 6000, kSettled = 200;
  constexpr double kMean_mL = 150.0;
  std::mt19937 random(seed);
  std::normal_distribution<double> noise;
  plenum::control::testing::PaperChamber chamber{.parameters = parameters};
  core.reset(chamber.pressure_kPa, kMean_mL, 5.0);
  const auto wanted_kPa = [](double t_s) {
    return 320.0 + 100.0 * std::sin(2.1 * t_s) + 40.0 * std::sin(7.3 * t_s);
  };
  const auto volume_mL = [](double t_s) {
    return kMean_mL * (1.0 + 0.25 * std::sin(2.0 * std::numbers::pi * 0.8 * t_s));
  };
  double measured_kPa = chamber.pressure_kPa, measured_mL = kMean_mL, squares = 0;
  for (int k = 0; k < kTicks; ++k) {
    const double t_s = 0.01 * k;
    const double command_V = core.regulate(measured_kPa, measured_mL, wanted_kPa(t_s));
    const double before_mL = volume_mL(t_s), after_mL = volume_mL(t_s + 0.01);
    const double middle_mL = 0.5 * (before_mL + after_mL);
    measured_kPa = chamber.tick(command_V, middle_mL, (after_mL - before_mL) / 0.01) + 0.3 * noise(random);
    measured_mL = middle_mL + 0.05 * noise(random);
    if (k >= kSettled) squares += std::pow(chamber.pressure_kPa - wanted_kPa(t_s), 2);
  }
  return std::sqrt(squares / (kTicks - kSettled));
}

/// The largest of twenty chambers about one of an MPYE valve: fixed over double.
double worst_loop_ratio() {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> within(0.8F, 1.25F);
  double worst = 0;
  for (unsigned i = 0; i < 20; ++i) {
    std::array<float, 12> of = plenum::control::testing::kMpyeLike;
    for (const std::size_t varied : {1U, 2U, 5U, 6U, 7U, 8U}) of[varied] *= within(random);
    const auto kind = static_cast<std::uint16_t>(ModelKind::tassa9);
    const double fixed_kPa = tracking_rms_kPa(*core_in_fixed(kind, of), of, i);
    worst = std::max(worst, fixed_kPa / tracking_rms_kPa(*core_in_double(kind, of), of, i));
  }
  return worst;
}

}  // namespace

int main() {
  constexpr int kModels = 10'000;
  using plenum::bench::print;
  const Worst worst = compare(kModels);
  print({.name = "fixed.prediction_error_percent_span",
         .value = worst.prediction_percent,
         .unit = "%",
         .target = 0.02});
  print({.name = "fixed.command_error_lsb", .value = worst.command_steps, .unit = "LSB", .target = 2});
  print({.name = "fixed.closed_loop_rmse_ratio", .value = worst_loop_ratio(), .unit = "x", .target = 1.01});
}
