#include "host-sim/reproduce/proportional_valve/reproduce_proportional_valve.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <string>

#include "host-sim/reproduce/proportional_valve/parts.hpp"

namespace plenum::host::reproduce::proportional_valve {
namespace {

Finding finding(const Part& part, const std::string& item, const std::string& quantity) {
  const auto found = std::find_if(part.findings.begin(), part.findings.end(), [&](const Finding& f) {
    return f.item == item && f.quantity.find(quantity) != std::string::npos;
  });
  if (found == part.findings.end()) throw std::logic_error("no finding of " + item + ": " + quantity);
  return *found;
}

TEST(ProportionalValve, PrintedFlowFunctionContradictsItsTextAndTheReadOneDoesNot) {
  const Part part = flow_function_part();
  EXPECT_EQ(verdict(finding(part, "(6) as printed", "ISO")), Verdict::kPaperContradictsItself);
  EXPECT_EQ(verdict(finding(part, "(6) as read", "ISO")), Verdict::kReproduced);
}

// By hand: sqrt(V) = sqrt(0.4e-3) = 0.02.
TEST(ProportionalValve, PrintedPressureRateIsOffByTheRootOfTheVolume) {
  const Part part = vessel_part();
  const Finding printed = finding(part, "(8)", "as printed");
  EXPECT_EQ(verdict(printed), Verdict::kPaperContradictsItself);
  EXPECT_NEAR(printed.ours / printed.paper, 0.02, 1e-9);
  EXPECT_EQ(verdict(finding(part, "(7), (4)", "choked rate")), Verdict::kReproduced);
}

TEST(ProportionalValve, SilencerDoesNotExplainAWiderExhaust) {
  const Finding asymmetry = finding(tables_part(), "Fig. 6", "exhaust over inlet");
  EXPECT_EQ(verdict(asymmetry), Verdict::kPaperContradictsItself);
  EXPECT_NEAR(asymmetry.ours, 6.13 / 3.98, 1e-9);
}

TEST(ProportionalValve, TwoOrdinaryLeaksGiveTheRowsAtNeutral) {
  const Part part = cracking_part();
  for (const char* item : {"Table 2, 5.0 V", "Table 3, 5.0 V", "Table 4, 5.0 V", "Table 5, 5.0 V"}) {
    EXPECT_EQ(verdict(finding(part, item, "b fitted")), Verdict::kReproduced) << item;
    EXPECT_EQ(verdict(finding(part, item, "beta fitted")), Verdict::kReproduced) << item;
  }
  EXPECT_EQ(verdict(finding(part, "Table 3, 5.0 V", "A foretold")), Verdict::kReproduced);
  EXPECT_EQ(verdict(finding(part, "Table 5, 5.0 V", "A foretold")), Verdict::kReproduced);
}

TEST(ProportionalValve, PorousLeaksAskForMoreThanThePapersBounds) {
  const Part part = leak_part();
  EXPECT_EQ(verdict(finding(part, "Abstract", "Ultimaker_015, the paper's bounds")), Verdict::kDiffers);
  EXPECT_EQ(verdict(finding(part, "Abstract", "Ultimaker_015, beta")), Verdict::kReproduced);
}

// One run of the whole, because it takes seconds.
TEST(ProportionalValve, TablesComeBackErrorsStayBelowTheirLimitsAndEveryDisagreementSaysWhy) {
  double latest = 0.0;
  bool rises = true;
  const std::vector<Part> parts = reproduce_proportional_valve([&](double fraction) {
    rises = rises && fraction >= latest && fraction <= 1.0;
    latest = fraction;
  });
  EXPECT_TRUE(rises);
  EXPECT_EQ(latest, 1.0);
  for (const Part& part : parts) {
    EXPECT_FALSE(part.text.empty()) << part.title;
    EXPECT_FALSE(part.findings.empty()) << part.title;
    for (const Finding& f : part.findings) {
      if (verdict(f) != Verdict::kReproduced) {
        EXPECT_FALSE(f.why.empty()) << f.item << ": " << f.quantity;
      }
      if (part.title == "Tables 2 to 5: identified from the pressure itself" || f.item == "Fig. 9(c)") {
        EXPECT_EQ(verdict(f), Verdict::kReproduced) << f.item << ": " << f.quantity << ", " << f.ours;
      }
      if (f.quantity.find("greatest MAE") != std::string::npos &&
          f.quantity.find("spool") == std::string::npos) {
        EXPECT_EQ(verdict(f), Verdict::kReproduced) << f.item << ": " << f.quantity << ", " << f.ours;
      }
    }
  }
}

}  // namespace
}  // namespace plenum::host::reproduce::proportional_valve
