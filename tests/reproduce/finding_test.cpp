#include "host-sim/reproduce/finding.hpp"

#include <gmock/gmock.h>

#include <limits>

namespace {

using namespace plenum::host::reproduce;

Finding of(double paper, double ours, double tolerance, Expect expect = Expect::kNear) {
  Finding finding{.item = "(1)", .quantity = "a figure", .paper = paper, .ours = ours};
  finding.tolerance = tolerance;
  finding.expect = expect;
  return finding;
}

TEST(Finding, AgreesUpToItsToleranceOnBothSides) {
  EXPECT_EQ(verdict(of(2.0, 2.25, 0.25)), Verdict::kReproduced);
  EXPECT_EQ(verdict(of(2.0, 1.75, 0.25)), Verdict::kReproduced);
  EXPECT_EQ(verdict(of(2.0, 2.26, 0.25)), Verdict::kDiffers);
  EXPECT_EQ(verdict(of(2.0, 1.74, 0.25)), Verdict::kDiffers);
}

TEST(Finding, TheEdgeOfADecimalToleranceIsWithinIt) {
  EXPECT_EQ(verdict(of(5.10, 5.15, 0.05)), Verdict::kReproduced);
  EXPECT_EQ(verdict(of(5.10, 5.1501, 0.05)), Verdict::kDiffers);
  EXPECT_EQ(verdict(of(0.528, 0.5285, 0.0005)), Verdict::kReproduced);
}

TEST(Finding, AnInfiniteToleranceAgreesWithNothing) {
  EXPECT_EQ(verdict(of(1.0, 1.0, std::numeric_limits<double>::infinity())), Verdict::kDiffers);
}

TEST(Finding, BoundIsOneSided) {
  EXPECT_EQ(verdict(of(10.0, -3.0, 0.0, Expect::kAtMost)), Verdict::kReproduced);
  EXPECT_EQ(verdict(of(10.0, 10.5, 0.0, Expect::kAtMost)), Verdict::kDiffers);
  EXPECT_EQ(verdict(of(90.0, 97.0, 0.0, Expect::kAtLeast)), Verdict::kReproduced);
  EXPECT_EQ(verdict(of(90.0, 89.9, 0.0, Expect::kAtLeast)), Verdict::kDiffers);
}

TEST(Finding, WhatIsNotFiniteNeverAgrees) {
  for (const double wrong :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
        -std::numeric_limits<double>::infinity()}) {
    for (const Expect expect : {Expect::kNear, Expect::kAtMost, Expect::kAtLeast}) {
      EXPECT_EQ(verdict(of(1.0, wrong, 1e9, expect)), Verdict::kDiffers);
      EXPECT_EQ(verdict(of(wrong, 1.0, 1e9, expect)), Verdict::kDiffers);
    }
  }
}

TEST(Finding, PapersOwnFiguresThatDisagreeAreItsContradiction) {
  Finding finding = of(1.0, 2.0, 0.1);
  finding.source = Source::kPapersOwnEquation;
  EXPECT_EQ(verdict(finding), Verdict::kPaperContradictsItself);
  finding.source = Source::kDoubtfulReading;
  EXPECT_EQ(verdict(finding), Verdict::kDiffers);
  finding.source = Source::kPapersOwnEquation;
  finding.ours = 1.05;
  EXPECT_EQ(verdict(finding), Verdict::kReproduced);
}

TEST(Finding, WhatAgreesByConstructionIsCountedApart) {
  Finding set = of(0.9, 0.9, 0.01);
  set.source = Source::kSetToPaper;
  Finding twice = set;
  twice.source = Source::kTwoForms;
  Finding slipped = twice;
  slipped.ours = 2.0;
  const Finding found = of(0.9, 0.9, 0.01);
  const std::vector<Part> parts{{"a", "", {set, found}}, {"b", "", {twice, slipped}}};
  EXPECT_EQ(reproduced_by_construction(parts), 2);
  EXPECT_EQ(verdict_counts(parts).at(Verdict::kReproduced), 3);
  EXPECT_EQ(verdict(slipped), Verdict::kDiffers);
}

TEST(Finding, VerdictsAreNamedAsThePageSaysThem) {
  EXPECT_EQ(name_of(Verdict::kReproduced), "reproduced");
  EXPECT_EQ(name_of(Verdict::kDiffers), "differs");
  EXPECT_EQ(name_of(Verdict::kPaperContradictsItself), "paper contradicts itself");
}

}  // namespace
