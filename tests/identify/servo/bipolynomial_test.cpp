#include "host-sim/identify/servo/bipolynomial.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::identify::servo {
namespace {

std::vector<FlowSample> grid(const Bipolynomial& truth) {
  std::vector<FlowSample> samples;
  for (double u = 5.0; u <= 10.0; u += 0.5)
    for (double P = 1e5; P <= 7e5; P += 5e4) samples.push_back({u, P, truth.flow_kg_s(u, P)});
  return samples;
}

Bipolynomial some() {
  Bipolynomial p;
  p.c = {{{1e-3, -2e-9, 1e-15}, {3e-4, 5e-10, -1e-15}, {-1e-5, 2e-11, 3e-17}}};
  return p;
}

TEST(Bipolynomial, IsFoundAgainInItsOwnSamples) {
  const Bipolynomial truth = some();
  const BipolynomialFit fit = fit_bipolynomial(grid(truth), Terms::kWhole);
  EXPECT_LT(fit.largest_kg_s, 1e-12 * fit.full_scale_kg_s);
  for (std::size_t m = 0; m < 3; ++m)
    for (std::size_t n = 0; n < 3; ++n)
      EXPECT_NEAR(fit.polynomial.c[m][n] / truth.c[m][n], 1.0, 1e-6) << "u^" << m << " P^" << n;
}

TEST(Bipolynomial, AsPrintedCannotFollowATermInTheCommandAlone) {
  Bipolynomial truth;
  truth.c[1][0] = 1e-3;
  EXPECT_LT(fit_bipolynomial(grid(truth), Terms::kWhole).rms_kg_s, 1e-15);
  const BipolynomialFit printed = fit_bipolynomial(grid(truth), Terms::kAsPrinted);
  EXPECT_GT(printed.rms_kg_s, 1e-6);
  EXPECT_EQ(printed.polynomial.c[1][0], 0.0);
}

TEST(Bipolynomial, ResidualIsAtRightAnglesToEveryTerm) {
  std::vector<FlowSample> samples = grid(some());
  for (FlowSample& s : samples) s.flow_kg_s += 1e-4 * std::sin(3.0 * s.command_V + 1e-5 * s.pressure_Pa);
  const BipolynomialFit fit = fit_bipolynomial(samples, Terms::kWhole);
  for (int m = 0; m < 3; ++m) {
    for (int n = 0; n < 3; ++n) {
      double dot = 0.0;
      for (const FlowSample& s : samples)
        dot += std::pow(s.command_V / 10.0, m) * std::pow(s.pressure_Pa / 7e5, n) *
               (fit.polynomial.flow_kg_s(s.command_V, s.pressure_Pa) - s.flow_kg_s);
      EXPECT_NEAR(dot, 0.0, 1e-12) << "u^" << m << " P^" << n;
    }
  }
}

TEST(Bipolynomial, SaysWhenTwoPressuresAreTooFew) {
  std::vector<FlowSample> samples;
  for (double u = 0.0; u < 10.0; u += 0.5)
    for (const double P : {1e5, 3e5}) samples.push_back({u, P, 1e-3 * u});
  try {
    fit_bipolynomial(samples, Terms::kWhole);
    FAIL() << "two pressures were accepted for a parabola";
  } catch (const CannotIdentify& e) {
    EXPECT_NE(std::string(e.what()).find("6 of 9"), std::string::npos) << e.what();
  }
  samples[0].flow_kg_s = std::nan("");
  EXPECT_THROW(fit_bipolynomial(samples, Terms::kWhole), std::invalid_argument);
}

}  // namespace
}  // namespace plenum::host::identify::servo
