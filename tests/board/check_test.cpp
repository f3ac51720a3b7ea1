// --check where some of a board's devices are missing, and some are not.
#include "board/check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "board/config/board_file.hpp"
#include "board/resting_volts.hpp"
#include "tests/board/drivers/iio_stand_in.hpp"

namespace plenum::board {
namespace {

using testing::HasSubstr;

const std::string kBoard = R"(
[can]
interface = "plenum-none"
[analog_input]
rate_Hz = 0
[[chamber]]
pressure = { device = "adc-here", channel = "voltage0" }
position = { device = "adc-gone", channel = "voltage0" }
command = { device = "dac-gone", channel = "voltage0" }
[[chamber]]
pressure = { device = "adc-lost", channel = "voltage0" }
position = { device = "adc-gone", channel = "voltage1" }
command = { device = "dac-here", channel = "voltage0" }
[[chamber]]
pressure = { device = "adc-lost", channel = "voltage1" }
position = { device = "adc-gone", channel = "voltage2" }
command = { device = "dac-here", channel = "voltage9" }
[gpio]
valve_power = { chip = "chip-gone", line = "0" }
vent = { chip = "chip-lost", line = "0" }
[store]
folder = "/tmp"
)";

class CheckTest : public drivers::IioStandIn {
 protected:
  void SetUp() override {
    IioStandIn::SetUp();
    if (IsSkipped()) return;
    add_device("iio:device0", "adc-here");
    put("iio:device0", "in_voltage0_raw", "0");
    put("iio:device0", "in_voltage0_scale", "1");
    add_capture("iio:device0", {"voltage0"}, "le:s16/16>>0");
    add_device("iio:device1", "dac-here");
    put("iio:device1", "out_voltage0_raw", "777");
    put("iio:device1", "out_voltage0_scale", "0.152587890");
  }

  /// The lines of the page that are about `what`.
  static std::vector<std::string> lines_on(const std::string& what, bool& good) {
    testing::internal::CaptureStdout();
    good = check(config::parse_board(kBoard, "board.toml"));
    std::istringstream page(testing::internal::GetCapturedStdout());
    std::vector<std::string> lines;
    for (std::string line; std::getline(page, line);)
      if (line.substr(6).starts_with(what)) lines.push_back(line);
    return lines;
  }

  bool good = true;
};

MATCHER_P(Fails, what, "") {
  return arg.starts_with("FAIL") && arg.find(what) != std::string::npos;
}

TEST_F(CheckTest, EachConverterThatIsMissingIsNamedOnceAndTheOthersAreRead) {
  std::vector<std::uint8_t> scans;
  for (int i = 0; i < 64; ++i) scans.insert(scans.end(), {0xE8, 0x03});  // 1000 mV
  bring("iio:device0", scans);
  const std::vector<std::string> lines = lines_on("analog input", good);
  EXPECT_THAT(lines, testing::UnorderedElementsAre(HasSubstr("pressure 1 (adc-here voltage0): "),
                                                   Fails("iio:adc-gone: no such device"),
                                                   Fails("iio:adc-lost: no such device")));
  EXPECT_THAT(lines, testing::Contains(HasSubstr("(1.000 V")));
  EXPECT_FALSE(good);
}

TEST_F(CheckTest, EachOutputThatIsMissingIsNamedAndNoneIsWritten) {
  EXPECT_THAT(lines_on("analog output", good),
              testing::ElementsAre(Fails("iio:dac-gone: no such device"),
                                   Fails("iio:dac-here voltage9: no such output")));
  EXPECT_EQ(text("iio:device1", "out_voltage0_raw"), "777");
  EXPECT_FALSE(good);
}

TEST_F(CheckTest, ACommandThatAnOutputCannotHoldIsNamed) {
  put("iio:device1", "out_voltage0_raw_available", "[0 1 39321]");  // 6 V, and chamber 2 may ask for 7
  EXPECT_THAT(
      lines_on("analog output", good),
      testing::Contains(Fails("dac-here voltage0: command_high_V = 7 of chamber 2 lies beyond its range")));
}

TEST_F(CheckTest, AConverterThatEndsBelowTheOverPressureIsNamed) {
  put("iio:device0", "in_voltage0_scale", "0.152588");  // 5 V, and chamber 1 trips at 900 kPa, 9 V
  EXPECT_THAT(lines_on("analog input", good),
              testing::Contains(Fails("adc-here voltage0: its range ends at 5.000 V, 500.0 kPa")));
}

TEST_F(CheckTest, EachLineThatIsMissingIsNamed) {
  EXPECT_THAT(lines_on("digital lines", good), testing::ElementsAre(Fails("gpio:chip-gone 0: no such chip"),
                                                                    Fails("gpio:chip-lost 0: no such chip")));
  EXPECT_FALSE(good);
}

/// --safe, of a board whose last loop has left something.
class SafeTest : public CheckTest {
 protected:
  SafeTest() {
    std::filesystem::create_directory(left_);
    ::setenv("RUNTIME_DIRECTORY", left_.c_str(), 1);
  }
  ~SafeTest() override {
    ::unsetenv("RUNTIME_DIRECTORY");
    std::filesystem::remove_all(left_);
  }

  void leave(float second_V) const {
    RestingVolts resting(board.analog_out.safe_V, left_);
    resting.set(1, second_V);
  }

  const config::BoardFile board = config::parse_board(kBoard, "board.toml");

 private:
  const std::filesystem::path left_ =
      std::filesystem::temp_directory_path() / ("plenum-check-" + std::to_string(::getpid()));
};

TEST_F(SafeTest, SetsTheOutputsThatThereAreToWhatTheLastLoopHasLeft) {
  EXPECT_FALSE(make_safe(board)) << "others are missing";
  EXPECT_EQ(text("iio:device1", "out_voltage0_raw"), "32768") << "null_V, 5 V";
  leave(2.5F);
  EXPECT_FALSE(make_safe(board));
  EXPECT_EQ(text("iio:device1", "out_voltage0_raw"), "16384");
}

TEST_F(SafeTest, SetsAnOutputThatCannotHoldWhatWasLeftAsFarAsItGoesAsTheLoopDoes) {
  put("iio:device1", "out_voltage0_raw_available", "[0 1 39321]");  // 6 V
  leave(9.0F);
  EXPECT_FALSE(make_safe(board));
  EXPECT_EQ(text("iio:device1", "out_voltage0_raw"), "39321");
}

}  // namespace
}  // namespace plenum::board
