// The parts on the first chambers of the population: enough for every claim that does not count all 76.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <variant>

#include "host-sim/reproduce/actuators/parts.hpp"

namespace plenum::host::reproduce::actuators {
namespace {

constexpr std::size_t kChambers = 4;

/// The one finding of the part whose quantity holds `words`.
Finding finding(const Part& part, const std::string& words) {
  std::vector<Finding> found;
  for (const Finding& one : part.findings) {
    if (one.quantity.find(words) != std::string::npos) found.push_back(one);
  }
  if (found.size() != 1) throw std::runtime_error(std::to_string(found.size()) + " findings of " + words);
  return found.front();
}

TEST(ReproduceActuators, EveryFindingThatIsNotReproducedSaysWhyAndEveryCurveIsWhole) {
  const std::vector<Part> parts = parts_of(study_population(kChambers, {}), {});
  std::size_t charts = 0;
  const auto check_curves = [](const auto& chart) {
    if constexpr (requires { chart.curves; }) {
      for (const report::Curve& curve : chart.curves) {
        EXPECT_FALSE(curve.x.empty()) << chart.title << ", " << curve.name;
        EXPECT_EQ(curve.x.size(), curve.y.size()) << chart.title << ", " << curve.name;
      }
    }
  };
  for (const Part& part : parts) {
    EXPECT_FALSE(part.findings.empty()) << part.title;
    for (const Finding& one : part.findings) {
      EXPECT_FALSE(one.item.empty()) << one.quantity;
      EXPECT_EQ(verdict(one) == Verdict::kReproduced, one.why.empty()) << one.quantity;
    }
    for (const report::Chart& chart : part.charts) std::visit(check_curves, chart);
    charts += part.charts.size();
  }
  EXPECT_GE(charts, 12U);
}

TEST(ReproduceActuators, BothBranchesOfThePortMeetAtTheChokedLimit) {
  const Part part = gas_and_port_constants();
  EXPECT_EQ(verdict(finding(part, "jump of the flow at p_u/p_d = theta")), Verdict::kReproduced);
  EXPECT_EQ(verdict(finding(part, "slope of the subsonic shape")), Verdict::kReproduced);
}

// By hand: 0.72 sqrt(2 * 0.029/(0.99 * 8.31 * 293.15) * 3.5), 0.72 sqrt(1.4 * 0.029/(...) (2/2.4)^6), 1.2^3.5.
TEST(ReproduceActuators, PlantHasTheConstantsOfTheAppendix) {
  const Part part = gas_and_port_constants();
  const auto is = [&](const char* words, double by_hand, double half_digit) {
    const Finding one = finding(part, words);
    EXPECT_NEAR(one.paper, by_hand, half_digit) << words;
    EXPECT_EQ(verdict(one), Verdict::kReproduced) << words;
    EXPECT_FALSE(by_construction(one.source)) << words;
  };
  is("alpha of the plant", 6.606e-3, 0.0005e-3);
  is("beta of the plant", 1.7096e-3, 0.00005e-3);
  is("theta of the plant", 1.89293, 0.000005);
}

TEST(ReproduceActuators, WhatIsSetToThePaperOrKeptByABoundIsCountedApart) {
  for (const Finding& one : gas_and_port_constants().findings) {
    EXPECT_EQ(one.source == Source::kSetToPaper, one.item == "Table II") << one.quantity;
  }
  const Study study = study_population(1, {});
  const Part table = parameters(study);
  EXPECT_EQ(finding(table, "c_gamma").source, Source::kSetToPaper);
  EXPECT_EQ(finding(table, "fits outside").source, Source::kSetToPaper);
}

TEST(ReproduceActuators, ExactStepLeavesLessThanTheWholeDistanceAtEveryRate) {
  const Finding left = finding(proposed_model(), "stable for any time-step");
  EXPECT_NEAR(left.ours, std::exp(-0.01), 1e-12);  // of the least rate over the least step
  EXPECT_EQ(verdict(left), Verdict::kReproduced);
}

TEST(ReproduceActuators, PaperCountsSeventyEightPairsOnSeventySixValves) {
  EXPECT_EQ(verdict(finding(numbers_of_the_text(), "valve-chamber pairs")), Verdict::kPaperContradictsItself);
}

TEST(ReproduceActuators, EqualAreasRestAtTheRootOfTheirClosedForm) {
  // alpha sqrt(x^(10/7) - x^(12/7)) = beta x at p = x P_c: the supply subsonic, the exhaust choked
  const double ratio = 7.0 / (1.4 * std::pow(2.0 / 2.4, 6.0));  // (alpha/beta)^2
  double low = 0.6;
  double high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double x = 0.5 * (low + high);
    (ratio * (std::pow(x, 10.0 / 7.0) - std::pow(x, 12.0 / 7.0)) > x * x ? low : high) = x;
  }
  EXPECT_NEAR(finding(steady_state(), "steady state at (U_c + U_r)/2").ours, 620.0 * low, 1e-3);
}

TEST(ReproduceActuators, ChambersAtRestDriftLessThanThePaperSaysAndMovingOnesMore) {
  const Part part = drift_of_prediction(study_population(kChambers, {}));
  const std::string largest = "largest standard deviation of any valve within 2 s, ";
  EXPECT_EQ(verdict(finding(part, largest + "at rest")), Verdict::kReproduced);
  EXPECT_EQ(verdict(finding(part, "share of the curves below 4 %, at rest")), Verdict::kReproduced);
  EXPECT_EQ(verdict(finding(part, largest + "moving")), Verdict::kDiffers);
}

TEST(ReproduceActuators, MovingChambersDriftNoMoreThanThePaperSaysWithTheVolumeRateInItsPlace) {
  const Part part = volume_rate(study_population(kChambers, {}));
  EXPECT_EQ(verdict(finding(part, "v' as in (4a), fitted to the record")), Verdict::kReproduced);
}

// (13) of 1.4 chokes both ends: 2 pi mm2 beta 620 kPa, as air of 101.325 kPa, is 5.47e3 cm3/s.
TEST(ReproduceActuators, FlowOfTwoPortsSpansTheScaleThatThePaperStates) {
  const Finding scale = finding(two_port_chamber(), "the vertical scale");
  EXPECT_EQ(verdict(scale), Verdict::kReproduced);
  EXPECT_NEAR(scale.ours, std::log10(5.47e3), 1e-3);
}

TEST(ReproduceActuators, WhatRestsOnOurValvesNeverContradictsThePaper) {
  for (const Part& part : {two_port_chamber(), valve_areas(), steady_state()}) {
    for (const Finding& one : part.findings) EXPECT_EQ(one.source, Source::kOurModel) << one.quantity;
  }
  const Finding shift = finding(volume_rate(study_population(1, {})), "ds/dv'");
  EXPECT_EQ(verdict(shift), Verdict::kDiffers);
}

TEST(ReproduceActuators, IdentifiedRateOverPressureStandsBesideThePlants) {
  const Part part = identified_curves(study_population(kChambers, {}));
  const auto fig_4 = std::find_if(part.charts.begin(), part.charts.end(), [](const report::Chart& chart) {
    const auto* xy = std::get_if<report::XyChart>(&chart);
    return xy != nullptr && xy->title.rfind("Fig. 4", 0) == 0;
  });
  ASSERT_NE(fig_4, part.charts.end());
  EXPECT_EQ(std::get<report::XyChart>(*fig_4).curves.size(), 6U);
  EXPECT_EQ(verdict(finding(part, "rate of the pressure over the pressure")), Verdict::kDiffers);
}

// A line through s = P_c has (P_c - P_r)/(P_c - P_c/theta) at P_r, of what it has at the choked limit.
TEST(ReproduceActuators, IdentifiedFlowOfAFillingPortHasNoChokedLimit) {
  const Part part = identified_ports(study_population(kChambers, {}));
  const Finding gain = finding(part, "independent of the downstream pressure");
  EXPECT_NEAR(gain.ours, (620.0 - 101.325) / (620.0 * (1.0 - 1.0 / std::pow(1.2, 3.5))), 1e-3);
  EXPECT_NEAR(gain.paper, 1.0, 0.1);
  EXPECT_EQ(verdict(gain), Verdict::kDiffers);
  EXPECT_EQ(verdict(finding(part, "flow of a filling port, p_d from")), Verdict::kDiffers);
  EXPECT_EQ(verdict(finding(part, "flow of an emptying port")), Verdict::kReproduced);
}

TEST(ReproduceActuators, IdentifiedModelHasTheAreaOfTheExhaustAndNotOfTheSupply) {
  const Part part = identified_ports(study_population(kChambers, {}));
  EXPECT_EQ(verdict(finding(part, "identified a_r by the choked ends")), Verdict::kReproduced);
  EXPECT_EQ(verdict(finding(part, "identified a_c by the choked ends")), Verdict::kDiffers);
  EXPECT_EQ(verdict(finding(part, "areas by the slope at rest")), Verdict::kDiffers);
  EXPECT_EQ(verdict(finding(part, "falling steps of a_c and rising steps of a_r by the choked ends")),
            Verdict::kDiffers);
  ASSERT_EQ(part.charts.size(), 2U);
  EXPECT_EQ(std::get<report::XyChart>(part.charts[0]).curves.size(), 4U);
  EXPECT_EQ(std::get<report::XyChart>(part.charts[1]).curves.size(), 6U);
}

TEST(ReproduceActuators, IdentifiedSigmoidLosesTheFlatKinkOfThePlants) {
  const Part part = identified_curves(study_population(2 * kChambers, {}));
  EXPECT_EQ(verdict(finding(part, "slope of the identified s at c_1")), Verdict::kDiffers);
  EXPECT_EQ(verdict(finding(part, "the same, refined on free runs")), Verdict::kReproduced);
  EXPECT_EQ(verdict(finding(part, "s fitted straight to the plant's steady states")), Verdict::kDiffers);
}

TEST(ReproduceActuators, ProgressRisesToOne) {
  std::vector<double> seen;
  const Study study = study_population(1, [&](double done) { seen.push_back(done); });
  ASSERT_FALSE(seen.empty());
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_EQ(seen.back(), 1.0);
}

}  // namespace
}  // namespace plenum::host::reproduce::actuators
