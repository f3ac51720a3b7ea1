// The repaired form against its differential equation integrated in double, and its inverse against a dense scan of all
// commands.
#include "firmware/control/tassa9r.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "firmware/config/model_image.hpp"
#include "firmware/control/tassa9.hpp"
#include "tests/firmware/control/admissible.hpp"
#include "tests/firmware/control/model_properties.hpp"
#include "tests/firmware/scalars.hpp"

namespace plenum::control {
namespace {

using testing::motion_of;
using testing::random_chamber;
using testing::RandomChamber;

constexpr std::size_t kC4 = 3;  // of the published form

std::array<float, Tassa9r::kParameters> without_c4(const RandomChamber& chamber) {
  std::array<float, Tassa9r::kParameters> values{};
  std::size_t filled = 0;
  for (std::size_t i = 0; i < chamber.parameters.size(); ++i) {
    if (i != kC4) values[filled++] = chamber.parameters[i];
  }
  return values;
}

constexpr auto model_of = [](const RandomChamber& chamber, float low_V = 0.0F, float high_V = 10.0F) {
  Tassa9r model;
  model.configure(scalars(without_c4(chamber)), low_V, high_V);
  return model;
};

/// (R1) in double: p' = flow s0 - (flow + moved) p.
struct Rate {
  double flow_per_s, moved_per_s, steady_kPa;

  double exponent_per_s() const { return flow_per_s + moved_per_s; }
};

Rate rate_of(const RandomChamber& chamber, double command_V) {
  std::array<double, 12> c{};
  for (std::size_t i = 0; i < c.size(); ++i) c[i] = static_cast<double>(chamber.parameters[i]);
  const double u = command_V - c[0];
  const double x = c[1] * u + c[2] * u * u * u;
  const double k = std::sqrt(u * u + c[9] * c[9]) - c[9] + c[8] + c[7] * u;
  const double volume = 1 + c[5] * static_cast<double>(chamber.volume_mL);
  return {c[6] * k / volume, c[4] * static_cast<double>(chamber.volume_rate_mL_s) / volume,
          (c[10] + c[11]) / 2 + (c[10] - c[11]) / 2 * (x / std::sqrt(x * x + 1))};
}

struct Exact {
  double end_kPa, mean_kPa;
};

/// By Runge-Kutta.
Exact integrated(const Rate& of, double pressure_kPa, double duration_s) {
  constexpr int kSteps = 2000;
  const double h = duration_s / kSteps;
  const auto slope = [&](double p) { return of.flow_per_s * of.steady_kPa - of.exponent_per_s() * p; };
  double p = pressure_kPa, area = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double k1 = slope(p), k2 = slope(p + 0.5 * h * k1), k3 = slope(p + 0.5 * h * k2),
                 k4 = slope(p + h * k3);
    area += h * (p + h / 6.0 * (k1 + k2 + k3));
    p += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return {p, duration_s > 0.0 ? area / duration_s : pressure_kPa};
}

/// By (R2), which is another route than the model's: not at its pole.
double end_by_steady_state(const RandomChamber& chamber, double command_V) {
  const Rate of = rate_of(chamber, command_V);
  const double s = of.flow_per_s * of.steady_kPa / of.exponent_per_s();
  return s + (static_cast<double>(chamber.pressure_kPa) - s) * std::exp(-of.exponent_per_s() * 0.01);
}

TEST(Tassa9r, AdmissibleSetsOfThePublishedFormAreSoWithoutTheirC4) {
  std::mt19937 random(7);
  for (int i = 0; i < 5'000; ++i) {
    config::ModelParameters parameters;
    parameters.kind = config::ModelKind::tassa9r;
    parameters.count = Tassa9r::kParameters;
    const auto values = without_c4(random_chamber(random));
    std::copy(values.begin(), values.end(), parameters.value.begin());
    const config::ImageVerdict verdict = config::validate(parameters);
    ASSERT_TRUE(verdict) << "set " << i << ": " << config::describe(verdict.error) << " parameter "
                         << int{verdict.parameter} << " = " << verdict.value;
  }
}

TEST(Tassa9r, FollowsItsEquationOverATickWhateverTheSignOfItsRate) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> command(0.0F, 10.0F), part(0.0F, 1.0F);
  int growing = 0;
  for (int i = 0; i < 4'000; ++i) {
    const RandomChamber chamber = random_chamber(random);
    // every other one near the null, where a moving volume outweighs the valve
    const float u = i % 2 == 0 ? command(random) : chamber.parameters[0] + 0.02F * (part(random) - 0.5F);
    const float ticks = i % 3 == 0 ? part(random) : 1.0F;
    const Rate of = rate_of(chamber, static_cast<double>(u));
    const double p = static_cast<double>(chamber.pressure_kPa);
    const Exact exact = integrated(of, p, 0.01 * static_cast<double>(ticks));
    growing += of.exponent_per_s() < 0.0;
    const Prediction got = model_of(chamber).step(chamber.pressure_kPa, u, motion_of(chamber), ticks);
    const double tolerance = 4e-6 * (p + of.steady_kPa + std::abs(exact.end_kPa)) + 1e-3;
    ASSERT_NEAR(real(got.end_kPa), exact.end_kPa, tolerance) << "set " << i << " u " << u;
    ASSERT_NEAR(real(got.mean_kPa), exact.mean_kPa, tolerance) << "set " << i << " u " << u;
  }
  EXPECT_GT(growing, 40) << "the population must hold chambers that shrink faster than they let out";
}

TEST(Tassa9r, IsThePublishedFormWhileTheVolumeRests) {
  std::mt19937 random(8);
  std::uniform_real_distribution<float> command(0.0F, 10.0F);
  for (int i = 0; i < 5'000; ++i) {
    RandomChamber chamber = random_chamber(random);
    chamber.volume_rate_mL_s = 0.0F;
    Tassa9 published;
    published.configure(scalars(chamber.parameters), 0.0F, 10.0F);
    const float u = command(random);
    const Prediction want = published.step(chamber.pressure_kPa, u, motion_of(chamber), 1.0F);
    const Prediction got = model_of(chamber).step(chamber.pressure_kPa, u, motion_of(chamber), 1.0F);
    const float tolerance = 4e-6F * chamber.parameters[10];
    ASSERT_NEAR(real(got.end_kPa), real(want.end_kPa), tolerance) << "set " << i;
    ASSERT_NEAR(real(got.mean_kPa), real(want.mean_kPa), tolerance) << "set " << i;
  }
}

TEST(Tassa9r, CompressesASealedChamberAlongTheIsotherm) {
  // c5 = c6, both large: p' = -v'/v p, where the valve is as good as shut
  const std::array<float, Tassa9r::kParameters> sealed = {5, 1,     2,    1000, 1000, 1e-6F,
                                                          0, 1e-5F, 0.1F, 700,  100};
  Tassa9r model;
  model.configure(scalars(sealed), 0.0F, 10.0F);
  const Prediction got = model.step(300.0F, 5.0F, {.volume_mL = 100.0F, .volume_rate_mL_s = -1000.0F}, 1.0F);
  EXPECT_NEAR(real(got.end_kPa), 300.0 * std::exp(0.1), 0.005);
  EXPECT_NEAR(real(got.mean_kPa), 300.0 * std::expm1(0.1) / 0.1, 0.005);
}

TEST(Tassa9r, TwoPartsOfATickAreTheTick) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> command(0.0F, 10.0F), part(0.0F, 1.0F);
  for (int i = 0; i < 5'000; ++i) {
    const RandomChamber chamber = random_chamber(random);
    const Tassa9r model = model_of(chamber);
    const float u = command(random), first = part(random);
    const Prediction whole = model.step(chamber.pressure_kPa, u, motion_of(chamber), 1.0F);
    const Prediction begun = model.step(chamber.pressure_kPa, u, motion_of(chamber), first);
    const Prediction ended = model.step(begun.end_kPa, u, motion_of(chamber), 1.0F - first);
    const double tolerance =
        1e-5 * (std::fabs(real(whole.end_kPa)) + static_cast<double>(chamber.parameters[10]));
    ASSERT_NEAR(real(ended.end_kPa), real(whole.end_kPa), tolerance) << "set " << i;
    ASSERT_NEAR(real(first * begun.mean_kPa + (1.0F - first) * ended.mean_kPa), real(whole.mean_kPa),
                tolerance)
        << "set " << i;
  }
}

TEST(Tassa9rInverse, TellsTheSlopeOfTheEndWhereItAnswers) {
  testing::expect_inverses_to_tell_the_slope(
      model_of, end_by_steady_state, [](const RandomChamber& chamber, double command_V) {
        const double x = rate_of(chamber, command_V).exponent_per_s() * 0.01;
        return std::abs(x) >= 1e-3 && x >= -2.0 && x <= 20.0;  // the pole of (R2), and where all is done
      });
}

TEST(Tassa9rInverse, ComesAsCloseAsTheBestOfADenseScanForEveryAdmissibleSet) {
  testing::expect_as_close_as_a_dense_scan(model_of, 6'000, 50);
}

TEST(Tassa9rInverse, TakesTheBranchOnWhichPressureRisesWithTheCommand) {
  testing::expect_the_rising_branch(model_of);
}

TEST(Tassa9rInverse, SaysWhenTheTargetIsOutOfReach) {
  Tassa9r model;
  const std::array<float, Tassa9r::kParameters> typical = {5, 1,     2,    0.01F, 0.01F, 50,
                                                           0, 0.02F, 0.1F, 620,   101.3F};
  model.configure(scalars(typical), 3.0F, 7.0F);
  testing::expect_limits_out_of_reach(model);
}

TEST(Tassa9r, AnswersEveryFiniteInputWithNumbers) {
  constexpr float kHuge = std::numeric_limits<float>::max();
  std::mt19937 random(9);
  for (int i = 0; i < 50; ++i) {
    RandomChamber chamber = random_chamber(random);
    if (i % 5 == 0) chamber.parameters[4] = i % 2 == 0 ? 1000.0F : -1000.0F;
    const Tassa9r model = model_of(chamber);
    for (const float p : {-kHuge, -1.0F, 0.0F, 101.325F, kHuge}) {
      for (const float u : {-kHuge, 5.0F, kHuge}) {
        for (const float v : {-kHuge, 0.0F, 1e-30F, 100.0F, kHuge}) {
          for (const float s : {-kHuge, 0.0F, kHuge}) {
            const ChamberMotion motion{.volume_mL = v, .volume_rate_mL_s = s};
            const Prediction step = model.step(p, u, motion, 1.0F);
            const Inverse back = model.inverse(p, 300.0F, motion, u);
            for (const Scalar value :
                 {step.end_kPa, step.mean_kPa, back.command_V, back.reached_kPa, back.by_command_kPa_V}) {
              ASSERT_TRUE(numeric::is_finite(value))
                  << "set " << i << " p " << p << " u " << u << " v " << v << " " << s;
            }
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace plenum::control
