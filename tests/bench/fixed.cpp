// The control core in fixed point against itself in double: the largest differences found, and what they do to a closed loop.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <span>

#include "tests/bench/row.hpp"
#include "tests/equivalence/core.hpp"
#include "tests/equivalence/drawn.hpp"

namespace {

using namespace equivalence;
using plenum::config::ModelKind;

constexpr std::array kKinds = {ModelKind::tassa9, ModelKind::tassa9r, ModelKind::greybox};
constexpr double kConverterStep_V = 10.0 / 65536;

struct Worst {
  double prediction_percent = 0;
  double command_steps = 0;
};

/// Over `models` of each kind, ten states each. Commands are compared where a volt moves the pressure by a kPa a tick or more.
Worst compare(int models) {
  constexpr double kLeastSlope_kPa_V = 1.0;
  Worst worst;
  for (const ModelKind kind : kKinds) {
    std::mt19937 random(77);
    std::uniform_real_distribution<double> volts(0.0, 10.0), share(0.0, 1.0);
    for (int i = 0; i < models; ++i) {
      const Drawn drawn = draw(random, kind);
      const auto fixed = core_in_fixed(drawn.kind, drawn.parameters);
      const auto exact = core_in_double(drawn.kind, drawn.parameters);
      const double span_kPa = drawn.supply_kPa - drawn.ambient_kPa;
      for (int k = 0; k < 10; ++k) {
        State from = drawn.state;
        from.pressure_kPa = drawn.ambient_kPa + span_kPa * share(random);
        const double command_V = volts(random);
        const Prediction got = fixed->step(from, command_V), want = exact->step(from, command_V);
        const double off_kPa =
            std::max(std::fabs(got.end_kPa - want.end_kPa), std::fabs(got.mean_kPa - want.mean_kPa));
        worst.prediction_percent = std::max(worst.prediction_percent, 100.0 * off_kPa / span_kPa);

        const double target_kPa = std::clamp(from.pressure_kPa + 0.1 * span_kPa * (2.0 * share(random) - 1.0),
                                             drawn.ambient_kPa, drawn.supply_kPa);
        const double found_V = fixed->inverse(from, target_kPa, command_V).command_V;
        const double exact_V = exact->inverse(from, target_kPa, command_V).command_V;
        if (std::min(std::fabs(slope_kPa_V(*exact, from, found_V)),
                     std::fabs(slope_kPa_V(*exact, from, exact_V))) < kLeastSlope_kPa_V)
          continue;
        worst.command_steps = std::max(worst.command_steps, std::fabs(found_V - exact_V) / kConverterStep_V);
      }
    }
  }
  return worst;
}

/// A chamber that follows the paper's equations, with the compression that they leave out: p' = (s - p) r - 1.4 p v'/v.
class Chamber {
 public:
  explicit Chamber(std::span<const float> parameters) {
    std::copy(parameters.begin(), parameters.end(), shape_.parameters.begin());
  }

  /// The mean over a tick.
  double tick(double command_V, double volume_mL, double rate_mL_s) {
    constexpr int kParts = 50;
    shape_.volume_mL = static_cast<float>(volume_mL);
    shape_.volume_rate_mL_s = static_cast<float>(rate_mL_s);
    const auto [s, r] = plenum::control::testing::reference(shape_, command_V);
    double sum = 0;
    for (int i = 0; i < kParts; ++i) {
      const double rest = s - 1.4 * pressure_kPa * rate_mL_s / volume_mL / r;
      const double end = rest + (pressure_kPa - rest) * std::exp(-r * 0.01 / kParts);
      sum += 0.5 * (pressure_kPa + end);
      pressure_kPa = end;
    }
    return sum / kParts;
  }

  double pressure_kPa = 300;

 private:
  plenum::control::testing::RandomChamber shape_{};
};

/// RMS tracking error [kPa] of 60 s on a sum of sines, the volume swinging by a quarter, with noise on both sensors.
double tracking_rms_kPa(Core& core, std::span<const float> parameters, unsigned seed) {
  constexpr int kTicks = 6000, kSettled = 200;
  constexpr double kMean_mL = 150.0;
  std::mt19937 random(seed);
  std::normal_distribution<double> noise;
  Chamber chamber(parameters);
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
    std::array<float, 12> of = {5.0F,  0.6F, 1.5F,  0.0F, 0.0F,   0.01F,
                                40.0F, 0.1F, 0.02F, 0.1F, 620.0F, 101.3F};
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
