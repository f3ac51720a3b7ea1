#include "host-sim/trace/log_csv.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "host-sim/trace/input_error.hpp"

namespace plenum::host::trace {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kHeader = "time_s,command_V,pressure_Pa,volume_m3\n";

Log parse(const std::string& text, std::vector<std::string>* notices = nullptr) {
  return parse_log(text, "a.csv", notices);
}

/// The one line that a reader answers `text` with.
std::string refusal(const std::string& text) {
  try {
    parse(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::filesystem::path scratch(const std::string& name) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("plenum-trace-test-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  return folder / name;
}

TEST(LogCsv, ReadsTheColumnsOfTheContractInAnyOrder) {
  const Log log = parse("volume_m3,time_s,pressure_Pa,command_V\n1e-4,0,101325,5\n2e-4,0.01,2e5,5.5\n");
  EXPECT_THAT(log.time_s, ElementsAre(0.0, 0.01));
  EXPECT_THAT(log.command_V, ElementsAre(5.0, 5.5));
  EXPECT_THAT(log.pressure_Pa, ElementsAre(101325.0, 2e5));
  EXPECT_THAT(log.volume_m3, ElementsAre(1e-4, 2e-4));
  EXPECT_EQ(log.period_s, 0.01);
  EXPECT_TRUE(log.supply_Pa.empty());
}

TEST(LogCsv, ToleratesByteOrderMarkCarriageReturnsSpacesAndPlusSigns) {
  const Log log =
      parse("\xEF\xBB\xBFtime_s, command_V,pressure_Pa ,volume_m3\r\n0,+5,1e5, 1e-4\r\n0.01,5,1e5,1e-4\r\n");
  EXPECT_THAT(log.command_V, ElementsAre(5.0, 5.0));
}

TEST(LogCsv, IgnoresAnUnknownColumnWithANoticeEvenIfItIsNoNumber) {
  std::vector<std::string> notices;
  const Log log =
      parse("time_s,note,command_V,pressure_Pa,volume_m3\n0,hello,5,1e5,1e-4\n0.01,,5,1e5,1e-4\n", &notices);
  EXPECT_EQ(log.size(), 2U);
  EXPECT_THAT(notices, ElementsAre(AllOf(HasSubstr("a.csv"), HasSubstr("'note'"))));
}

TEST(LogCsv, ShowsNamesAndCellsOfAFileInShortAndInPrintableCharacters) {
  std::vector<std::string> notices;
  parse("time_s,command_V,pressure_Pa,volume_m3,\x1b[31mred\n0,5,1e5,1e-4,\n0.01,5,1e5,1e-4,\n", &notices);
  EXPECT_THAT(notices, ElementsAre(HasSubstr("'\\x1B[31mred'")));
  const std::string endless(200'000, 'n');
  std::string many;
  for (int i = 0; i < 1000; ++i) many += fmt::format(",c{}", i);
  for (const std::string& text :
       {"\x1f\x8b\b\x1b]0;title\a" + endless + "\n1\n", endless + "," + endless + "\n1,1\n",
        kHeader + ("0," + ("\x1b" + endless) + ",1,1\n"), "a" + many + "\n"}) {
    const std::string line = refusal(text);
    EXPECT_LT(line.size(), 2000U);
    EXPECT_TRUE(std::all_of(line.begin(), line.end(), [](char c) { return c >= ' ' && c <= '~'; })) << line;
  }
}

TEST(LogCsv, IgnoresUnknownColumnsThatShareAName) {
  std::vector<std::string> notices;
  EXPECT_EQ(
      parse("time_s,command_V,pressure_Pa,volume_m3,,note,note,\n0,5,1e5,1e-4,,a,b,\n0.01,5,1e5,1e-4,,,,\n",
            &notices)
          .size(),
      2U);
  EXPECT_EQ(notices.size(), 4U);
}

TEST(LogCsv, TakesCellsInDoubleQuotesAndTheirCommas) {
  std::vector<std::string> notices;
  const Log log = parse(
      "\"time_s\",\"a \"\"dry\"\" run, cold\", \"command_V\" ,pressure_Pa,volume_m3\n"
      "0,\"x, y\",\"5\",1e5,1e-4\n\"0.01\",\"\"\"a, b\"\"\",5.5,\"2e5\",1e-4\n",
      &notices);
  EXPECT_THAT(log.time_s, ElementsAre(0.0, 0.01));
  EXPECT_THAT(log.command_V, ElementsAre(5.0, 5.5));
  EXPECT_THAT(log.pressure_Pa, ElementsAre(1e5, 2e5));
  EXPECT_EQ(notices.size(), 1U);
}

TEST(LogCsv, TellsOfSemicolonsAndTabsThatTheySeparateColumns) {
  EXPECT_THAT(refusal("time_s;command_V;pressure_Pa;volume_m3\n0,01;5,5;101325;0,001\n"),
              AllOf(HasSubstr("a.csv: header"), HasSubstr("semicolons"), HasSubstr("expected commas"),
                    HasSubstr("decimal points")));
  EXPECT_THAT(refusal("time_s\tcommand_V\n0\t5\n"), HasSubstr("tabs"));
}

TEST(LogCsv, NamesTheColumnOfAnotherUnitThatStandsForAMissingOne) {
  EXPECT_THAT(refusal("time_s,command_V,pressure_kPa,volume_m3\n0,5,101,1e-4\n0.01,5,101,1e-4\n"),
              HasSubstr("header: found column 'pressure_kPa', expected 'pressure_Pa', in Pa"));
  EXPECT_THAT(refusal("Time [s],command_V,pressure_Pa,volume_m3\n0,5,1e5,1e-4\n"),
              HasSubstr("found column 'Time [s]', expected 'time_s', in s"));
}

TEST(LogCsv, TakesEmptyLinesAtTheEndForNoRows) {
  std::vector<std::string> notices;
  EXPECT_EQ(parse(kHeader + std::string("0,5,1e5,1e-4\n0.01,5,1e5,1e-4\n\r\n \n\n"), &notices).size(), 2U);
  EXPECT_TRUE(notices.empty());
}

// "1" may be what is left of "1e-4".
TEST(LogCsv, LeavesOutALastRowWithoutLineEndWithANotice) {
  std::vector<std::string> notices;
  const std::string rows = "0,5,1e5,1e-4\n0.01,5,1e5,1e-4\n";
  EXPECT_THAT(parse(kHeader + rows + "0.02,5,1e5,1", &notices).volume_m3, ElementsAre(1e-4, 1e-4));
  EXPECT_THAT(notices, ElementsAre(AllOf(HasSubstr("row 3"), HasSubstr("left out"))));
  for (const char* cut : {"0.02,5,1e5", "0", "0.02,5,1e5,1,1"}) {
    EXPECT_THAT(
        [&] {
          notices.clear();
          parse(kHeader + rows + cut, &notices);
        },
        testing::ThrowsMessage<InputError>(HasSubstr("row 3: the file ends within")))
        << cut;
  }
}

TEST(LogCsv, TakesStampsThatAreRoundedForUniform) {
  const auto log_at = [](double rate_Hz, int digits, double from_s) {
    std::string text = kHeader;
    for (int k = 0; k < 500; ++k) text += fmt::format("{:.{}f},5,1e5,1e-4\n", from_s + k / rate_Hz, digits);
    return parse(text);
  };
  for (const double rate_Hz : {60.0, 128.0, 300.0}) {
    EXPECT_NEAR(log_at(rate_Hz, 3, 0.0).period_s * rate_Hz, 1.0, 1e-3) << rate_Hz << " Hz, to milliseconds";
  }
  std::string single = kHeader;
  for (int k = 0; k < 500; ++k) {
    single += fmt::format("{},5,1e5,1e-4\n", static_cast<double>(static_cast<float>(600.0 + 1e-3 * k)));
  }
  EXPECT_NEAR(parse(single).period_s, 1e-3, 1e-6) << "[s], in single precision after ten minutes";
}

TEST(LogCsv, ReadsBackToTheSameBits) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Log log;
  for (int k = 0; k < 500; ++k) {
    log.time_s.push_back(3.0 + 0.01 * k);
    log.command_V.push_back(10.0 * unit(random));
    log.pressure_Pa.push_back(std::ldexp(unit(random), 20));
    log.volume_m3.push_back(1e-4 * unit(random));
    log.supply_Pa.push_back(7e5 + unit(random));
    log.position_m.push_back(-unit(random));
    log.temperature_K.push_back(290.0 + unit(random));
    log.reference_Pa.push_back(std::numeric_limits<double>::denorm_min() * static_cast<double>(k));
  }
  const auto path = scratch("round.csv");
  write_log(path, log);
  const Log read = read_log(path);
  EXPECT_EQ(read.time_s, log.time_s);
  EXPECT_EQ(read.command_V, log.command_V);
  EXPECT_EQ(read.pressure_Pa, log.pressure_Pa);
  EXPECT_EQ(read.volume_m3, log.volume_m3);
  EXPECT_EQ(read.supply_Pa, log.supply_Pa);
  EXPECT_EQ(read.position_m, log.position_m);
  EXPECT_EQ(read.temperature_K, log.temperature_K);
  EXPECT_EQ(read.reference_Pa, log.reference_Pa);
  EXPECT_EQ(read.period_s, 0.01) << "[s]";
}

struct BadLog {
  const char* what;
  std::string text;
  std::vector<std::string> says;
};

class LogCsvRefuses : public testing::TestWithParam<BadLog> {};

TEST_P(LogCsvRefuses, WithFileRowColumnAndExpectation) {
  const std::string said = refusal(GetParam().text);
  EXPECT_THAT(said, HasSubstr("a.csv"));
  EXPECT_THAT(said, HasSubstr("expected"));
  EXPECT_EQ(said.find('\n'), std::string::npos);
  for (const std::string& part : GetParam().says) EXPECT_THAT(said, HasSubstr(part));
}

const std::string kGoodRow = "0,5,1e5,1e-4\n";

INSTANTIATE_TEST_SUITE_P(
    All, LogCsvRefuses,
    testing::Values(
        BadLog{"Empty", "", {"empty", "header"}}, BadLog{"NoRows", kHeader, {"no rows"}},
        BadLog{"OneRow", kHeader + kGoodRow, {"1 row", "at least 2"}},
        BadLog{"MissingColumn", "time_s,command_V,pressure_Pa\n0,5,1e5\n0.01,5,1e5\n", {"'volume_m3'"}},
        BadLog{"TwiceTheColumn", "time_s,time_s\n0,0\n", {"'time_s'", "twice"}},
        BadLog{"EmptyCell", kHeader + kGoodRow + "0.01,,1e5,1e-4\n", {"row 2", "command_V", "missing"}},
        BadLog{"ShortRow", kHeader + kGoodRow + "0.01,5,1e5\n", {"row 2", "volume_m3", "missing"}},
        BadLog{"LongRow", kHeader + kGoodRow + "0.01,5,1e5,1e-4,7\n", {"row 2", "more than 4"}},
        BadLog{"NotANumber", kHeader + kGoodRow + "0.01,5,1e5x,1e-4\n", {"row 2", "pressure_Pa", "'1e5x'"}},
        BadLog{"Nan", kHeader + kGoodRow + "0.01,nan,1e5,1e-4\n", {"row 2", "command_V", "finite"}},
        BadLog{"Infinite", kHeader + kGoodRow + "0.01,5,-inf,1e-4\n", {"row 2", "pressure_Pa", "finite"}},
        BadLog{"Overflow", kHeader + kGoodRow + "0.01,5,1e999,1e-4\n", {"row 2", "pressure_Pa", "finite"}},
        BadLog{"LostRow",
               kHeader + kGoodRow + "0.01,5,1e5,1e-4\n0.03,5,1e5,1e-4\n",
               {"row 3", "time_s", "0.03"}},
        BadLog{"OddFirstStep",
               kHeader + kGoodRow + "0.02,5,1e5,1e-4\n0.03,5,1e5,1e-4\n0.04,5,1e5,1e-4\n",
               {"row 2", "time_s", "0.02", "0.01 s", "split the log"}},
        BadLog{"StampsThatJitter",
               kHeader + kGoodRow + "0.01,5,1e5,1e-4\n0.02,5,1e5,1e-4\n0.034,5,1e5,1e-4\n0.04,5,1e5,1e-4\n",
               {"row 4", "time_s", "0.034", "2 of 4 steps", "resample"}},
        BadLog{"TimeBackwards", kHeader + kGoodRow + "-0.01,5,1e5,1e-4\n", {"row 2", "time_s", "advance"}},
        BadLog{"EmptyLine", kHeader + kGoodRow + "\n0.01,5,1e5,1e-4\n", {"row 2", "time_s", "missing"}},
        BadLog{"EmptyLineAfterTheHeader",
               std::string(kHeader) + "\n" + kGoodRow,
               {"row 1", "the line is empty", "4 cells"}},
        BadLog{"CommentForAHeader",
               std::string("# of Monday\n") + kHeader + kGoodRow,
               {"header", "'# of Monday' is a comment"}},
        BadLog{"Utf16", std::string("\xFF\xFEt\0i\0", 6), {"looks like UTF-16", "UTF-8"}},
        BadLog{"Utf16WithoutItsMark", std::string("\0t\0i", 4), {"looks like UTF-16", "UTF-8"}},
        BadLog{"Truncated", kHeader + kGoodRow + "0.01,5,1e5,1e-4\n0.02,5,1e5,1", {"row 3", "ends within"}}),
    [](const testing::TestParamInfo<BadLog>& bad) { return bad.param.what; });

TEST(LogCsv, NamesAFileThatIsNotThere) {
  try {
    read_log("no/such/log.csv");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("no/such/log.csv"), HasSubstr("No such file")));
  }
}

TEST(LogCsv, TakesTheAveragingTimeFromTheRigAndRefusesAnotherRate) {
  const auto path = scratch("rate.csv");
  std::ofstream(path) << kHeader << kGoodRow << "0.01,5,1e5,1e-4\n";
  RigDescription rig;
  rig.sampling.pressure_average_s = 0.004;
  EXPECT_EQ(read_log(path, rig).pressure_average_s, 0.004);
  rig.sampling.rate_Hz = 200;
  EXPECT_THROW(read_log(path, rig), InputError);
  std::ofstream(path) << kHeader << kGoodRow << "5,5,1e5,1e-4\n";
  EXPECT_THAT([&] { read_log(path, rig); },
              testing::ThrowsMessage<InputError>(
                  AllOf(HasSubstr("0.2 Hz, looks like milliseconds"), HasSubstr("200"))));
}

TEST(LogCsv, TakesARateThatIsOffByLessThanAHundredthAndKeepsItsOwn) {
  const auto path = scratch("late.csv");
  std::ofstream(path) << kHeader << kGoodRow << "0.02017,5,1e5,1e-4\n";
  RigDescription rig;
  rig.sampling = {.rate_Hz = 49.5, .pressure_average_s = 0.0};
  EXPECT_EQ(read_log(path, rig).period_s, 0.02017);
  rig.sampling.rate_Hz = 50.5;
  EXPECT_THAT([&] { read_log(path, rig); },
              testing::ThrowsMessage<InputError>(
                  AllOf(HasSubstr("49.5786 Hz, expected the rig's sampling.rate_Hz = 50.5 within 1 %"),
                        HasSubstr("correct the rig"))));
}

TEST(LogCsv, AveragesOverNoMoreThanATickWhereTheRecordersClockIsFastOrItsStampsAreRounded) {
  for (const double rate_Hz : {60.0, 100.002, 300.0}) {
    for (const int rows : {298, 299, 300, 301}) {
      const auto path = scratch("fast.csv");
      std::string text = kHeader;
      for (int k = 0; k < rows; ++k) text += fmt::format("{:.6f},5,1e5,1e-4\n", k / rate_Hz);
      std::ofstream(path) << text;
      RigDescription rig;
      rig.sampling = {.rate_Hz = std::round(rate_Hz), .pressure_average_s = 1.0 / std::round(rate_Hz)};
      const Log log = read_log(path, rig);
      EXPECT_LE(log.pressure_average_s, log.period_s) << rate_Hz << " Hz, " << rows << " rows";
      EXPECT_NEAR(log.pressure_average_s, log.period_s, 1e-4 * log.period_s);
    }
  }
}

TEST(LogCsv, LeavesTheOldFileAndNothingElseWhenALogCannotBeWritten) {
  const auto path = scratch("keep/log.csv");
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path) << "old";
  Log log;
  log.time_s = {0.0, 0.01};
  log.command_V = {5.0, std::numeric_limits<double>::quiet_NaN()};
  log.pressure_Pa = log.volume_m3 = {1.0, 1.0};
  EXPECT_THROW(write_log(path, log), InputError);
  log.command_V = {5.0};
  EXPECT_THROW(write_log(path, log), InputError);
  std::string text;
  std::getline(std::ifstream(path), text);
  EXPECT_EQ(text, "old");
  const auto folder = std::filesystem::directory_iterator(path.parent_path());
  EXPECT_EQ(std::distance(begin(folder), end(folder)), 1);
}

}  // namespace
}  // namespace plenum::host::trace
