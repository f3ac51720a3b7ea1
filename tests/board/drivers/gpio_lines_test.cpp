// What the board's lines do, on lines that are none: GpioRequest is replaced here, at the place where a build chooses between
// the versions of libgpiod. Real lines are in tests/virtual-board.
#include "board/drivers/gpio_lines.hpp"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace plenum::board::drivers {
namespace {

struct Pin {
  bool active = false;
  bool changed = false;
  bool broken = false;
};

std::map<std::string, Pin> pins;
std::vector<std::pair<std::string, bool>> sets;  // every value that an output took, in order

}  // namespace

struct GpioRequest::Handle {
  std::string name;
  Pin& pin;
  bool input;
};

GpioRequest::GpioRequest(const GpioLine& line, GpioUse use) {
  if (!line.fitted()) return;
  if (line.line == "TAKEN") refuse_gpio(line, EBUSY);
  handle_ = std::make_unique<Handle>(Handle{line.line, pins[line.line], use == GpioUse::input});
  if (!handle_->input) set(use == GpioUse::output_active);
}

GpioRequest::~GpioRequest() = default;

std::optional<bool> GpioRequest::value() noexcept {
  if (!handle_) return false;
  return handle_->pin.broken ? std::nullopt : std::optional(handle_->pin.active);
}

bool GpioRequest::set(bool active) noexcept {
  if (!handle_) return true;
  if (handle_->pin.broken) return false;
  handle_->pin.active = active;
  sets.emplace_back(handle_->name, active);
  return true;
}

std::optional<bool> GpioRequest::take_change() noexcept {
  if (!handle_) return false;
  return std::exchange(handle_->pin.changed, false);
}

int GpioRequest::descriptor() const noexcept {
  return handle_ && handle_->input ? 42 : -1;
}

namespace {

GpioLine line(const std::string& name) {
  return {.chip = "gpiochip0", .line = name};
}

class GpioLinesTest : public ::testing::Test {
 protected:
  GpioLinesTest() {
    pins.clear();
    sets.clear();
  }

  const GpioConfig config_{line("POWER"), line("STOP"), line("LAMP"), line("VENT")};
};

using Sets = std::vector<std::pair<std::string, bool>>;

TEST_F(GpioLinesTest, StartWithThePowerOffAndTheVentOpen) {
  const GpioLines lines(config_);
  EXPECT_FALSE(pins["POWER"].active);
  EXPECT_TRUE(pins["VENT"].active);
  EXPECT_FALSE(pins["LAMP"].active);
}

TEST_F(GpioLinesTest, TheVentIsOpenWheneverThePowerIsOff) {
  GpioLines lines(config_);
  lines.write({.valve_power = true, .fault_lamp = true});
  EXPECT_TRUE(pins["POWER"].active);
  EXPECT_FALSE(pins["VENT"].active);
  EXPECT_TRUE(pins["LAMP"].active);
  lines.write({});
  EXPECT_FALSE(pins["POWER"].active);
  EXPECT_TRUE(pins["VENT"].active);
  EXPECT_FALSE(pins["LAMP"].active);
}

TEST_F(GpioLinesTest, EndWithThePowerOffTheVentOpenAndTheLampAsItWas) {
  {
    GpioLines lines(config_);
    lines.write({.valve_power = true, .fault_lamp = true});
    sets.clear();
  }
  EXPECT_EQ(sets, (Sets{{"POWER", false}, {"VENT", true}}));
}

TEST_F(GpioLinesTest, AnEmergencyStopStandsAsLongAsTheCircuitIsOpen) {
  GpioLines lines(config_);
  EXPECT_FALSE(lines.read().emergency_stop);
  pins["STOP"].active = true;
  EXPECT_TRUE(lines.read().emergency_stop);
  EXPECT_TRUE(lines.read().emergency_stop);
  pins["STOP"].active = false;
  EXPECT_FALSE(lines.read().emergency_stop);
}

TEST_F(GpioLinesTest, AnEmergencyStopBetweenTwoReadsIsReportedOnce) {
  GpioLines lines(config_);
  pins["STOP"].changed = true;  // opened and closed again
  EXPECT_TRUE(lines.read().emergency_stop);
  EXPECT_FALSE(lines.read().emergency_stop);
  EXPECT_FALSE(lines.gone());
}

TEST_F(GpioLinesTest, AnEmergencyStopThatCannotBeReadStandsForGood) {
  GpioLines lines(config_);
  EXPECT_EQ(lines.descriptor(), 42);
  pins["STOP"].broken = true;
  EXPECT_TRUE(lines.read().emergency_stop);
  pins["STOP"].broken = false;
  EXPECT_TRUE(lines.read().emergency_stop);
  EXPECT_TRUE(lines.gone());
  EXPECT_EQ(lines.descriptor(), -1) << "nothing to wake up for";
}

TEST_F(GpioLinesTest, AnOutputThatRefusesIsAnEmergencyStop) {
  for (const char* const name : {"POWER", "LAMP", "VENT"}) {
    GpioLines lines(config_);
    pins[name].broken = true;
    EXPECT_FALSE(lines.read().emergency_stop) << name;
    lines.write({.valve_power = true});
    EXPECT_TRUE(lines.read().emergency_stop) << name;
    EXPECT_TRUE(lines.gone()) << name;
    pins[name].broken = false;
  }
}

TEST_F(GpioLinesTest, APowerLineThatRefusesStillOpensTheVent) {
  GpioLines lines(config_);
  lines.write({.valve_power = true});
  pins["POWER"].broken = true;
  lines.write({});
  EXPECT_TRUE(pins["VENT"].active);
}

TEST_F(GpioLinesTest, WhatIsNotFittedStopsNothing) {
  GpioLines lines({});
  EXPECT_EQ(lines.descriptor(), -1);
  lines.write({.valve_power = true, .fault_lamp = true});
  EXPECT_FALSE(lines.read().emergency_stop);
  EXPECT_FALSE(lines.gone());
}

TEST_F(GpioLinesTest, ALineThatIsTakenIsToldByItsName) {
  GpioConfig config = config_;
  config.vent = line("TAKEN");
  try {
    const GpioLines lines(config);
    FAIL() << "no failure";
  } catch (const std::runtime_error& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with("gpio:gpiochip0 TAKEN: Device or resource busy"))
        << error.what();
  }
}

TEST_F(GpioLinesTest, WhereOneIsMissingTheOthersAreTakenAndItIsAnEmergencyStop) {
  GpioConfig config = config_;
  config.emergency_stop = line("TAKEN");
  std::vector<std::string> missing;
  pins["POWER"].active = true;
  GpioLines lines(config, &missing);
  ASSERT_EQ(missing.size(), 1U);
  EXPECT_TRUE(missing[0].starts_with("gpio:gpiochip0 TAKEN:")) << missing[0];
  EXPECT_FALSE(pins["POWER"].active);
  EXPECT_TRUE(pins["VENT"].active);
  EXPECT_TRUE(lines.gone());
  EXPECT_TRUE(lines.read().emergency_stop);
}

}  // namespace
}  // namespace plenum::board::drivers
