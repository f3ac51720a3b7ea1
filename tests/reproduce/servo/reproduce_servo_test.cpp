#include "host-sim/reproduce/servo/reproduce_servo.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <variant>

#include "host-sim/reproduce/servo/parts.hpp"

namespace plenum::host::reproduce::servo {
namespace {

Finding finding(const Part& part, const std::string& item, const std::string& quantity) {
  const auto found = std::find_if(part.findings.begin(), part.findings.end(), [&](const Finding& f) {
    return f.item == item && f.quantity.find(quantity) != std::string::npos;
  });
  if (found == part.findings.end()) throw std::logic_error("no finding of " + item + ": " + quantity);
  return *found;
}

TEST(ReproduceServo, SaysWhyWhateverIsNotReproducedAndHowFarItIs) {
  double last = 0.0;
  const std::vector<Part> parts = reproduce_servo([&](double share) {
    EXPECT_GE(share, last);
    last = share;
  });
  EXPECT_EQ(last, 1.0);
  for (const Part& part : parts) {
    EXPECT_FALSE(part.text.empty()) << part.title;
    EXPECT_FALSE(part.findings.empty()) << part.title;
    for (const Finding& f : part.findings) {
      EXPECT_TRUE(verdict(f) == Verdict::kReproduced || !f.why.empty())
          << f.item << ": " << f.quantity << ", paper " << f.paper << ", ours " << f.ours;
    }
  }
  // the rig's own figures leave the noise alone; the fit, whose chambers exchange no heat, leaves more
  const Finding physical = finding(parts.back(), "(1)-(23)", "physical fit");
  EXPECT_GT(physical.paper, 99.0);
  EXPECT_GT(physical.ours, 90.0);
  EXPECT_LT(finding(parts.back(), "Fig. 4", "ARX").ours, 80.0);
  EXPECT_LT(finding(parts.back(), "Fig. 5", "physical fit").ours, 90.0);
}

TEST(ReproduceServo, PrintedOrificeConstantsAreAirsOwnAndNotTheUniversalGasConstants) {
  const Part part = orifice_part();
  EXPECT_EQ(verdict(finding(part, "(3)", "C1 of air")), Verdict::kReproduced);
  EXPECT_EQ(verdict(finding(part, "(3)", "C2 of air")), Verdict::kReproduced);
  EXPECT_EQ(verdict(finding(part, "(3)", "P_cr of air")), Verdict::kReproduced);
  EXPECT_EQ(verdict(finding(part, "(3)", "universal")), Verdict::kPaperContradictsItself);
}

TEST(ReproduceServo, ChamberLawsAgreeInTheirLimitsAndThePrintedSignsDoNot) {
  const Part part = chambers_part();
  for (const char* item : {"(10), (15)", "(10), (18)", "(13)-(15)", "(15), (18)", "(13), (14)", "(13), (18)",
                           "(17)", "(8), (12)", "(11)"})
    EXPECT_EQ(verdict(finding(part, item, "")), Verdict::kReproduced) << item;
  EXPECT_EQ(verdict(finding(part, "(10)", "filled and pressed there")), Verdict::kReproduced);
  EXPECT_EQ(verdict(finding(part, "(10)", "upper sign")), Verdict::kPaperContradictsItself);
  for (const char* item : {"(9)", "(12)", "(21)"})
    EXPECT_EQ(verdict(finding(part, item, "")), Verdict::kPaperContradictsItself) << item;
}

// (10) with the printed sign is the negative of what (6), (7), (20) give; a piston of 804.2 mm2 in mid-stroke
// of 200 mm with 20 mL: 1.2 * 500 kPa * 804.2 / 100420 mm3 = 4805 kPa for each mm/ms.
TEST(ReproduceServo, PrintedPistonTermsAreThoseOfTheirEquations) {
  const Part part = chambers_part();
  EXPECT_NEAR(finding(part, "(10)", "upper sign").paper, 4805.0, 0.1);
  EXPECT_NEAR(finding(part, "(10)", "upper sign").ours, -4805.0, 0.1);
  EXPECT_NEAR(finding(part, "(12)", "").paper, -5429.1, 0.1);
  EXPECT_NEAR(finding(part, "(21)", "").paper, -5429.1, 0.1);
}

// By hand: 691.2 mm2 (100 - 30 mm) + 20 mL and - 20 mL.
TEST(ReproduceServo, DeadVolumeOfChamberTwoIsTakenOffInNine) {
  const Finding nine = finding(chambers_part(), "(9)", "chamber 2");
  EXPECT_NEAR(nine.ours, 68.384, 1e-6);
  EXPECT_NEAR(nine.paper, 28.384, 1e-6);
}

TEST(ReproduceServo, WhatAgreesByConstructionSaysSo) {
  const Part chambers = chambers_part();
  for (const char* quantity : {"alpha = k", "alpha = 1 against"})
    EXPECT_EQ(finding(chambers, "(19)", quantity).source, Source::kTwoForms) << quantity;
  EXPECT_EQ(finding(training_part(), "Fig. 4", "order").source, Source::kSetToPaper);
}

TEST(ReproduceServo, StuckPistonDoesNotCreepAndFreeOneGoes) {
  const Part part = friction_part();
  EXPECT_EQ(finding(part, "(22), (23)", "99.8 %").ours, 0.0);
  EXPECT_EQ(verdict(finding(part, "(22), (23)", "110 %")), Verdict::kReproduced);
  EXPECT_EQ(verdict(finding(part, "(23)", "lets go")), Verdict::kReproduced);
}

TEST(ReproduceServo, ShutChambersKeepTheirPolytrope) {
  const Finding kept = finding(cylinder_part(), "(6), (7)", "P V^n");
  EXPECT_EQ(verdict(kept), Verdict::kReproduced);
  EXPECT_GT(kept.ours, 0.0);
}

TEST(ReproduceServo, ErrorOfTheSamplesStandsBesideThatOfTheirMeansAndSetsTheTolerance) {
  const Part part = measured_friction_part();
  const double means = finding(part, "(23)", "RMS error of the means").ours;
  const double samples = finding(part, "(23)", "RMS error of the samples").ours;
  EXPECT_GT(samples, 1.3 * means);
  EXPECT_NEAR(finding(part, "(23)", "at 7 bar over").tolerance, 0.02 * samples, 1e-12);
}

TEST(ReproduceServo, PlantsFrictionIsComparedWithTheMeasuredOneThroughAReversalAtEachPressure) {
  const Part part = measured_friction_part();
  for (const char* pressure : {"1 bar", "3 bar", "5 bar", "7 bar"}) {
    const Finding f = finding(part, "(22), (23)", std::string("reversal at ") + pressure);
    EXPECT_EQ(verdict(f), Verdict::kDiffers) << pressure;
    EXPECT_LT(f.ours, 25.0) << pressure;
    EXPECT_TRUE(std::any_of(part.charts.begin(), part.charts.end(), [&](const report::Chart& chart) {
      const auto* line = std::get_if<report::LineChart>(&chart);
      return line && line->title == std::string("Friction through a reversal at ") + pressure;
    })) << pressure;
  }
}

TEST(ReproduceServo, LinearModelIsTheJacobianAndThePrintedOneIsNot) {
  const Part part = linear_part();
  EXPECT_EQ(verdict(finding(part, "derived (28)", "roots")), Verdict::kReproduced);
  EXPECT_EQ(verdict(finding(part, "derived (26)", "Jacobian")), Verdict::kReproduced);
  EXPECT_EQ(verdict(finding(part, "derived (27)", "Jacobian")), Verdict::kReproduced);
  EXPECT_EQ(verdict(finding(part, "printed (26), (28)", "Jacobian")), Verdict::kDiffers);
  EXPECT_NEAR(finding(part, "(28)", "order").paper, 3.0, 1e-3);
  EXPECT_NEAR(finding(part, "(28)", "order").ours, 4.0, 1e-3);
  EXPECT_NEAR(finding(part, "(28)", "power").paper, 3.0, 1e-3);
  EXPECT_NEAR(finding(part, "(28)", "power").ours, 2.0, 1e-3);
  EXPECT_NEAR(finding(part, "(24), (26)", "C_f2").ours, -1.0, 1e-9);
  EXPECT_EQ(verdict(finding(part, "(25)", "together")), Verdict::kReproduced);
  EXPECT_LT(finding(part, "(25)", "against +x").ours, 0.0);
}

TEST(ReproduceServo, WeightsOfTheLinearNetworkAreTheLeastSquaresModel) {
  const Part part = training_part();
  for (const Finding& f : part.findings)
    EXPECT_EQ(verdict(f), Verdict::kReproduced) << f.quantity << ": " << f.ours;
}

}  // namespace
}  // namespace plenum::host::reproduce::servo
