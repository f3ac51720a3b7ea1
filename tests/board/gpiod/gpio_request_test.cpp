// The board's lines on both versions of libgpiod: the same calls ask the same of the chip. Built once for each (GPIOD_TEST is the
// suite's name); what a line is asked for is written here by hand, from the words of board/drivers.
#include "board/drivers/gpio_request.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "board/check.hpp"
#include "board/config/board_file.hpp"
#include "board/drivers/gpio_lines.hpp"
#include "tests/board/gpiod/fake_chip.hpp"

namespace plenum::board::drivers {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr unsigned kStop = 1;
constexpr unsigned kVent = 3;

GpioLine line(const std::string& name, bool active_low = false) {
  return {.chip = fake::kChip, .line = name, .active_low = active_low};
}

class GPIOD_TEST : public ::testing::Test {
 protected:
  GPIOD_TEST() { chip = {}; }

  std::string failure(const GpioLine& of, GpioUse use = GpioUse::input) const {
    try {
      const GpioRequest taken(of, use);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "no failure";
  }

  fake::Chip& chip = fake::chip();
};

TEST_F(GPIOD_TEST, AnOutputBeginsAtItsLevelAndIsLetGoInTheEnd) {
  {
    GpioRequest power(line("POWER"), GpioUse::output_inactive);
    GpioRequest vent(line("3", true), GpioUse::output_active);
    EXPECT_EQ(chip.line[kVent].holder, "plenumd");
    EXPECT_TRUE(power.set(true));
    EXPECT_TRUE(vent.set(false));
    EXPECT_EQ(power.value(), true);
    EXPECT_EQ(vent.value(), false);
    EXPECT_EQ(power.descriptor(), -1);
  }
  EXPECT_THAT(chip.asked, ElementsAre("POWER output low", "VENT output low", "POWER high", "VENT high"));
  EXPECT_EQ(chip.line[kVent].holder, "");
}

TEST_F(GPIOD_TEST, AnInputTellsItsLevelAndEveryEdge) {
  GpioRequest stop(line("STOP", true), GpioUse::input);
  EXPECT_EQ(stop.descriptor(), fake::kEventDescriptor);
  EXPECT_EQ(stop.value(), true) << "low is active";
  EXPECT_EQ(stop.take_change(), false);
  chip.drive(kStop, true);
  chip.drive(kStop, false);
  EXPECT_EQ(stop.take_change(), true) << "there and back";
  EXPECT_EQ(stop.take_change(), false);
  EXPECT_THAT(chip.asked, ElementsAre("STOP input"));
}

TEST_F(GPIOD_TEST, ALineThatChattersKeepsNoTick) {
  GpioRequest stop(line("STOP"), GpioUse::input);
  for (int i = 0; i < 100; ++i) chip.drive(kStop, i % 2 == 0);
  EXPECT_EQ(stop.take_change(), true);
  EXPECT_EQ(chip.line[kStop].waiting, 100U - 4U * 16U) << "four reads of sixteen";
}

TEST_F(GPIOD_TEST, AsItIsNothingOfALineChanges) {
  chip.line[kVent].output = true;
  chip.line[kVent].high = true;
  {
    GpioRequest vent(line("VENT", true), GpioUse::as_is);
    EXPECT_EQ(vent.value(), false);
    EXPECT_EQ(vent.descriptor(), -1);
  }
  EXPECT_THAT(chip.asked, IsEmpty());
  EXPECT_TRUE(chip.line[kVent].output);
  EXPECT_TRUE(chip.line[kVent].high);
}

TEST_F(GPIOD_TEST, WhoHasALineAndWhetherItDrivesItsPinIsToldWithoutTakingIt) {
  chip.line[kVent].output = true;
  chip.line[kVent].holder = "other";
  EXPECT_EQ(gpio_info(line("VENT")).holder, "other");
  EXPECT_TRUE(gpio_info(line("3")).output);
  EXPECT_EQ(gpio_info(line("STOP")).holder, "");
  EXPECT_FALSE(gpio_info(line("STOP")).output);
  EXPECT_THAT(chip.asked, IsEmpty());
}

TEST_F(GPIOD_TEST, ALineHasOnePlaceByWhateverItIsNamed) {
  const std::string place = gpio_info(line(std::to_string(kVent))).place;
  EXPECT_EQ(place, std::string(fake::kChip) + " " + std::to_string(kVent));
  EXPECT_EQ(gpio_info(line("VENT")).place, place);
  EXPECT_EQ(gpio_info(line("0" + std::to_string(kVent))).place, place);
  EXPECT_NE(gpio_info(line("STOP")).place, place);
}

TEST_F(GPIOD_TEST, WhatCannotBeTakenIsNamed) {
  chip.line[kStop].holder = "other";
  EXPECT_EQ(failure(line("STOP")).rfind("gpio:/fake/gpiochip0 STOP: Device or resource busy, expected", 0),
            0U);
  EXPECT_EQ(failure(line("LOST")),
            "gpio:/fake/gpiochip0 LOST: no such line, expected a name or an offset that `gpioinfo` lists");
  EXPECT_EQ(
      failure({.chip = "/fake/gpiochip7", .line = "0"}),
      "gpio:/fake/gpiochip7 0: No such file or directory, expected the character device of a GPIO chip");
  EXPECT_EQ(chip.line[kStop].holder, "other");
}

TEST_F(GPIOD_TEST, AChipThatIsGoneIsToldByEveryCall) {
  GpioRequest power(line("POWER"), GpioUse::output_inactive);
  GpioRequest stop(line("STOP"), GpioUse::input);
  for (fake::Line& one : chip.line) one.broken = true;
  EXPECT_FALSE(power.set(true));
  EXPECT_EQ(stop.value(), std::nullopt);
  EXPECT_EQ(stop.take_change(), std::nullopt);
}

TEST_F(GPIOD_TEST, TheBoardsLinesAreAskedForTheSame) {
  {
    GpioLines lines({line("POWER"), line("STOP"), line("LAMP"), line("VENT", true)});
    lines.write({.valve_power = true, .fault_lamp = true});
    chip.drive(kStop, true);
    EXPECT_TRUE(lines.read().emergency_stop);
  }
  EXPECT_THAT(chip.asked, ElementsAre("POWER output low", "STOP input", "LAMP output low",
                                      "VENT output low",                       // power off, vented
                                      "POWER high", "VENT high", "LAMP high",  // as written
                                      "POWER low", "VENT low"));               // the end
}

// ---- --check ----

const std::string kBoard = R"(
[can]
interface = "plenum-none"
[analog_input]
rate_Hz = 0
[[chamber]]
in_use = false
[gpio]
valve_power = { chip = "/fake/gpiochip0", line = "POWER" }
emergency_stop = { chip = "/fake/gpiochip0", line = "STOP" }
fault_lamp = { chip = "/fake/gpiochip0", line = "LAMP" }
vent = { chip = "/fake/gpiochip0", line = "VENT", active_low = true }
[store]
folder = "/tmp"
)";

/// The lines of the page that are about digital lines.
std::vector<std::string> checked() {
  ::testing::internal::CaptureStdout();
  check(config::parse_board(kBoard, "board.toml"));
  std::istringstream page(::testing::internal::GetCapturedStdout());
  std::vector<std::string> lines;
  for (std::string one; std::getline(page, one);)
    if (one.find("digital lines") != std::string::npos) lines.push_back(one);
  return lines;
}

TEST_F(GPIOD_TEST, CheckChangesNoLine) {
  for (const unsigned output : {0U, 2U, kVent}) {
    chip.line[output].output = true;
    chip.line[output].high = true;  // valves with power, vent shut
  }
  EXPECT_THAT(
      checked(),
      ElementsAre(
          "ok    digital lines  valve power fitted, vent fitted, lamp fitted, emergency stop closed"));
  EXPECT_THAT(chip.asked, IsEmpty());
  EXPECT_TRUE(chip.line[kVent].output && chip.line[kVent].high);
  chip.line[kStop].high = true;
  EXPECT_THAT(
      checked(),
      ElementsAre("ok    digital lines  valve power fitted, vent fitted, lamp fitted, emergency stop open"));
  EXPECT_EQ(chip.line[kStop].holder, "") << "let go";
}

TEST_F(GPIOD_TEST, CheckNamesALineThatIsHeldAndAStopThatDrivesItsPin) {
  chip.line[kVent].holder = "plenumd";
  chip.line[kStop].output = true;
  EXPECT_THAT(checked(), ElementsAre("FAIL  digital lines  gpio:/fake/gpiochip0 VENT: held by plenumd, "
                                     "expected a line that nobody holds "
                                     "(stop plenumd first)",
                                     "FAIL  digital lines  gpio:/fake/gpiochip0 STOP: drives its pin, "
                                     "expected an input, as a line is that "
                                     "nobody has set up"));
  EXPECT_THAT(chip.asked, IsEmpty());
}

}  // namespace
}  // namespace plenum::board::drivers
