#include "host-sim/reproduce/servo/reproduce_servo.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "host-sim/reproduce/servo/parts.hpp"

namespace plenum::host::reproduce::servo {
namespace {

const Finding& finding(const Part& part, const std::string& item, const std::string& quantity) {
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
  EXPECT_EQ(verdict(finding(parts.back(), "(1)-(23)", "physical fit")), Verdict::kReproduced);
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
  for (const char* item : {"(15)", "(18)", "(15), (18)", "(16), (17)", "(13), (14)", "(11)"})
    EXPECT_EQ(verdict(finding(part, item, "")), Verdict::kReproduced) << item;
  for (const char* item : {"(10)", "(12)", "(21)"})
    EXPECT_EQ(verdict(finding(part, item, "")), Verdict::kPaperContradictsItself) << item;
}

TEST(ReproduceServo, StuckPistonDoesNotCreepAndFreeOneGoes) {
  const Part part = friction_part();
  EXPECT_EQ(finding(part, "(22), (23)", "99.8 %").ours, 0.0);
  EXPECT_EQ(verdict(finding(part, "(22), (23)", "110 %")), Verdict::kReproduced);
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
}

TEST(ReproduceServo, WeightsOfTheLinearNetworkAreTheLeastSquaresModel) {
  const Part part = training_part();
  for (const Finding& f : part.findings)
    EXPECT_EQ(verdict(f), Verdict::kReproduced) << f.quantity << ": " << f.ours;
}

}  // namespace
}  // namespace plenum::host::reproduce::servo
