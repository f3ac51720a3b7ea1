#include "host-sim/tools/useful.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "host-sim/identify/cannot_identify.hpp"

namespace plenum::host::tools {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::vector<trace::Log> logs_of(const std::vector<std::vector<double>>& commands_V) {
  std::vector<trace::Log> logs;
  for (const std::vector<double>& command_V : commands_V) {
    trace::Log log;
    log.command_V = command_V;
    logs.push_back(log);
  }
  return logs;
}

/// What is said of a model whose error is that share of 10 kPa, where a fit with the command turned has the other.
std::string refusal(double share, double turned_share) {
  try {
    require_useful(
        {.model_kPa = 10.0 * share, .held_kPa = 10.0, .held = "means"},
        [&](const std::vector<trace::Log>&) { return 10.0 * turned_share; }, logs_of({{0.0, 10.0}}));
  } catch (const identify::CannotIdentify& error) {
    return error.what();
  }
  return {};
}

TEST(Useful, AModelThatFollowsItsLogsIsTakenWhateverTheMirrorImageGives) {
  EXPECT_THAT(refusal(0.4, 0.001), IsEmpty());
}

TEST(Useful, AModelOfAMachineThatIsHardlyAValveIsTaken) {
  EXPECT_THAT(refusal(0.8, 0.75), IsEmpty());
}

TEST(Useful, ACommandOfAnotherSignIsToldBeforeTheModelIsWorthNothing) {
  EXPECT_THAT(refusal(0.8, 0.4),
              AllOf(HasSubstr("0.8 times"), HasSubstr("0.4 times"), HasSubstr("another sign")));
  EXPECT_THAT(refusal(1.5, 0.4), HasSubstr("another sign"));
}

TEST(Useful, AModelNoBetterThanHoldingIsNone) {
  EXPECT_THAT(refusal(0.95, 0.9), AllOf(HasSubstr("0.95 times"), HasSubstr("means"), Not(HasSubstr("sign"))));
}

/// Two seconds of a sine about 5 V, and of steps where those are asked for.
trace::Log sine(double at_Hz, bool steps) {
  trace::Log log;
  for (int row = 0; row < 400; ++row) {
    const bool stepping = steps && row >= 200;
    log.command_V.push_back(5.0 + (stepping ? (row / 20) * (row / 20) % 7 - 3.0
                                            : 3.0 * std::sin(0.02 * std::numbers::pi * at_Hz * row)));
  }
  return log;
}

TEST(Useful, TheSignIsNotBlamedWhereALagWouldLookAlike) {
  const auto turned = [](const std::vector<trace::Log>&) { return 1.0; };
  const auto said = [&](double share, const std::vector<trace::Log>& logs) -> std::string {
    try {
      require_useful({.model_kPa = 10.0 * share, .held_kPa = 10.0, .held = "means"}, turned, logs);
    } catch (const identify::CannotIdentify& error) {
      return error.what();
    }
    return {};
  };
  EXPECT_THAT(said(0.8, {sine(1.25, false)}), IsEmpty());
  EXPECT_THAT(said(2.0, {sine(1.25, false)}), AllOf(HasSubstr("follow late"), HasSubstr("look alike")));
  for (const double share : {0.8, 2.0}) {
    EXPECT_THAT(said(share, {sine(1.25, true)}), HasSubstr("has the command another sign"));
    EXPECT_THAT(said(share, {sine(0.25, false)}), HasSubstr("has the command another sign"))
        << "2 s is no lag";
    EXPECT_THAT(said(share, {sine(1.25, false), sine(1.25, true)}),
                HasSubstr("has the command another sign"));
  }
}

TEST(Useful, AModelWhoseErrorIsNoNumberIsNone) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(refusal(none, none), HasSubstr("another time or unit"));
}

TEST(Useful, AMirrorImageThatGivesNoModelSaysNothingOfTheSign) {
  const auto none = [](const std::vector<trace::Log>&) -> double { throw identify::CannotIdentify("none"); };
  const auto logs = logs_of({{0.0, 10.0}});
  EXPECT_NO_THROW(require_useful({.model_kPa = 8.0, .held_kPa = 10.0, .held = "means"}, none, logs));
  try {
    require_useful({.model_kPa = 9.5, .held_kPa = 10.0, .held = "means"}, none, logs);
    FAIL() << "taken";
  } catch (const identify::CannotIdentify& error) {
    EXPECT_THAT(error.what(), HasSubstr("time or unit"));
  }
}

TEST(Useful, CommandsAreTurnedAboutTheMiddleOfWhatAllLogsCommand) {
  std::vector<trace::Log> seen;
  const auto look = [&](const std::vector<trace::Log>& turned) {
    seen = turned;
    return 10.0;
  };
  require_useful({.model_kPa = 8.0, .held_kPa = 10.0, .held = "means"}, look,
                 logs_of({{2.0, 3.0}, {8.0, 5.0, 4.0}}));
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_THAT(seen[0].command_V, ElementsAre(8.0, 7.0));
  EXPECT_THAT(seen[1].command_V, ElementsAre(2.0, 5.0, 6.0));
}

TEST(Useful, AFitThatDidNotConvergeIsToldWithItsModelAndWhatToDo) {
  EXPECT_NO_THROW(require_converged(true, "converged", "m.json"));
  try {
    require_converged(false, "stopped after the 3 iterations allowed, not converged", "m.json");
    FAIL() << "taken";
  } catch (const identify::CannotIdentify& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("after the 3 iterations allowed"),
                                    HasSubstr("m.json is written"), HasSubstr("judge it by its errors")));
  }
}

}  // namespace
}  // namespace plenum::host::tools
