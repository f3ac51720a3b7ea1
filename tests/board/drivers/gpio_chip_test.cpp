// How a line is named in a configuration, on folders that stand for /dev.
#include "board/drivers/gpio_chip.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cerrno>
#include <fstream>
#include <stdexcept>

namespace plenum::board::drivers {
namespace {

namespace fs = std::filesystem;

class GpioChip : public ::testing::Test {
 protected:
  GpioChip() {
    std::string name = ::testing::TempDir() + "plenum-gpio-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder " + name);
    devices_ = name;
  }
  ~GpioChip() override { fs::remove_all(devices_); }

  /// A device whose label stands in it.
  void add(const std::string& name, const std::string& label) const {
    std::ofstream(devices_ / name) << label;
  }

  std::string find(const std::string& chip) const {
    const auto label_of = [](const fs::path& path) -> std::optional<std::string> {
      std::string label;
      std::ifstream(path) >> label;
      return label;
    };
    return find_gpio_chip({.chip = chip, .line = "STOP"}, label_of, devices_).filename().string();
  }

  std::string failure(const std::string& chip) const {
    try {
      return "found " + find(chip);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  }

  fs::path devices_;
};

TEST_F(GpioChip, IsFoundByPathByNameAndByLabel) {
  add("gpiochip0", "pl061");
  add("gpiochip1", "pinctrl-bcm2711");
  EXPECT_EQ(find_gpio_chip({.chip = "/dev/gpiochip7", .line = "3"}, nullptr, devices_), "/dev/gpiochip7");
  EXPECT_EQ(find("gpiochip1"), "gpiochip1");
  EXPECT_EQ(find("pl061"), "gpiochip0");
}

TEST_F(GpioChip, ItsNameGoesBeforeTheLabelOfAnother) {
  for (const char* const other : {"gpiochip0", "gpiochip2", "gpiochip3"}) add(other, "gpiochip1");
  add("gpiochip1", "pl061");
  EXPECT_EQ(find("gpiochip1"), "gpiochip1");
}

TEST_F(GpioChip, OnlyAGpioDeviceIsAskedForItsLabel) {
  add("ttyS0", "pl061");
  EXPECT_EQ(failure("pl061"),
            "gpio:pl061 STOP: no such chip, expected a name or label that `gpiodetect` lists");
}

TEST_F(GpioChip, TwoOfOneLabelAreRefusedByTheirNames) {
  add("gpiochip3", "pcf8574");
  add("gpiochip2", "pcf8574");
  EXPECT_EQ(failure("pcf8574"),
            "gpio:pcf8574 STOP: 2 chips have this label, expected the name of one (gpiochip2, gpiochip3)");
}

TEST_F(GpioChip, AMachineWithoutDevicesHasNoChip) {
  devices_ /= "none";
  EXPECT_EQ(failure("gpiochip0"),
            "gpio:gpiochip0 STOP: no such chip, expected a name or label that `gpiodetect` lists");
}

TEST(GpioLine, IsAnOffsetWhenItIsANumberAndANameOtherwise) {
  EXPECT_EQ(gpio_offset("0"), 0U);
  EXPECT_EQ(gpio_offset("31"), 31U);
  for (const char* const name : {"", "STOP", "3v3", "-1", " 3", "GPIO3", "99999999999"}) {
    EXPECT_EQ(gpio_offset(name), std::nullopt) << name;
  }
}

TEST(GpioLine, WhatIsForbiddenWhatIsNoChipAndWhatIsTakenAreToldApart) {
  const auto words = [](int cause) -> std::string {
    try {
      refuse_gpio({.chip = "gpiochip0", .line = "3"}, cause);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  };
  EXPECT_EQ(
      words(EACCES),
      "gpio:gpiochip0 3: Permission denied, expected a user who may read and write the chip's character "
      "device");
  EXPECT_EQ(
      words(EBUSY),
      "gpio:gpiochip0 3: Device or resource busy, expected a line that this chip has, can drive this way, "
      "and that no driver or program holds");
}

}  // namespace
}  // namespace plenum::board::drivers
