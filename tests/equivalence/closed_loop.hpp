// The regulator in closed loop in fixed point and in double, each with a model of every kind, each on a chamber of its own that is
// neither, with the same noise.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

#include "firmware/config/greybox_parameters.hpp"
#include "firmware/config/model_image.hpp"
#include "tests/equivalence/core.hpp"
#include "tests/firmware/control/paper_chamber.hpp"

namespace equivalence {

constexpr double kConverterStep_V = 10.0 / 65536;
constexpr double kMostSteps = 2;  ///< between the commands of both

struct Course {
  double rms_kPa = 0;  ///< tracking error, once it has settled
  std::vector<double> command_V;
};

/// 60 s on a sum of sines, the volume swinging by a quarter, with noise on both sensors: of the chamber that has
/// these parameters of the 9-parameter model, and the compression that it leaves out.
inline Course track(Core& core, const std::array<float, 12>& parameters, unsigned seed) {
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
  Course course;
  double measured_kPa = chamber.pressure_kPa, measured_mL = kMean_mL, squares = 0;
  for (int k = 0; k < kTicks; ++k) {
    const double t_s = 0.01 * k;
    const double command_V = core.regulate(measured_kPa, measured_mL, wanted_kPa(t_s));
    course.command_V.push_back(command_V);
    const double before_mL = volume_mL(t_s), after_mL = volume_mL(t_s + 0.01);
    const double middle_mL = 0.5 * (before_mL + after_mL);
    measured_kPa = chamber.tick(command_V, middle_mL, (after_mL - before_mL) / 0.01) + 0.3 * noise(random);
    measured_mL = middle_mL + 0.05 * noise(random);
    if (k >= kSettled) squares += std::pow(chamber.pressure_kPa - wanted_kPa(t_s), 2);
  }
  course.rms_kPa = std::sqrt(squares / (kTicks - kSettled));
  return course;
}

/// The model of a kind that a chamber like those of an MPYE valve may be given: its own parameters, those but for c4, or conductances and
/// an opening that let through what they do.
inline std::vector<float> model_of(plenum::config::ModelKind kind, const std::array<float, 12>& chamber) {
  std::vector<float> model(chamber.begin(), chamber.end());
  if (kind == plenum::config::ModelKind::tassa9) return model;
  if (kind == plenum::config::ModelKind::tassa9r) {
    model.erase(model.begin() + 3);
    return model;
  }
  namespace config = plenum::config;
  // c7/c6 (P_c - P_m) of flow at P_m, half way, where the inlet is choked: C P_c
  const float supply_kPa = chamber[10], ambient_kPa = chamber[11];
  const float conductance = chamber[6] / chamber[5] * 0.5F * (supply_kPa - ambient_kPa) / supply_kPa;
  model.assign(config::kGreyboxParameters, 0.0F);
  model[config::kOpenAbove] = model[config::kExhaustBelow] = chamber[0];
  model[config::kInletConductance] = model[config::kExhaustConductance] = conductance;
  model[config::kInletLeak] = model[config::kExhaustLeak] = conductance * chamber[8];
  model[config::kTransition] = conductance * chamber[9];
  model[config::kCriticalRatio] = 0.528F;
  model[config::kSubsonicIndex] = 0.5F;
  model[config::kCrackingRatio] = 1.0F;
  model[config::kVolumeExponent] = 1.4F;
  model[config::kSpoolDamping] = 0.7F;
  model[config::kSupply] = supply_kPa;
  model[config::kAmbient] = ambient_kPa;
  return model;
}

struct Loops {
  double worst_ratio = 0;     ///< of the RMS tracking errors, fixed over double
  double worst_rms_kPa = 0;   ///< in double
  int ticks = 0, parted = 0;  ///< in which the commands are more than kMostSteps apart
};

/// Of so many chambers about one of an MPYE valve.
inline Loops compare_loops(plenum::config::ModelKind kind, unsigned chambers) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> within(0.8F, 1.25F);
  Loops of;
  for (unsigned i = 0; i < chambers; ++i) {
    std::array<float, 12> chamber = plenum::control::testing::kMpyeLike;
    for (const std::size_t varied : {1U, 2U, 5U, 6U, 7U, 8U}) chamber[varied] *= within(random);
    const std::vector<float> model = model_of(kind, chamber);
    const auto number = static_cast<std::uint16_t>(kind);
    const Course fixed = track(*core_in_fixed(number, model), chamber, i);
    const Course exact = track(*core_in_double(number, model), chamber, i);
    of.worst_ratio = std::max(of.worst_ratio, fixed.rms_kPa / exact.rms_kPa);
    of.worst_rms_kPa = std::max(of.worst_rms_kPa, exact.rms_kPa);
    for (std::size_t k = 0; k < exact.command_V.size(); ++k) {
      ++of.ticks;
      of.parted += std::fabs(fixed.command_V[k] - exact.command_V[k]) > kMostSteps * kConverterStep_V ? 1 : 0;
    }
  }
  return of;
}

}  // namespace equivalence
