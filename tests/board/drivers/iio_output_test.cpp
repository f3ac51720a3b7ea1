// Voltages out through the kernel's attributes, which are files here (iio_stand_in.hpp).
#include "board/drivers/iio_output.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "tests/board/drivers/iio_stand_in.hpp"

namespace plenum::board::drivers {
namespace {

using ::testing::_;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string kDac = "iio:device0";

/// Two channels of an AD5755: 0..10 V and -10..10 V in 65536 steps, as its kernel driver tells them.
class IioOutputTest : public IioStandIn {
 protected:
  void SetUp() override {
    IioStandIn::SetUp();
    if (IsSkipped()) return;
    add_device(kDac, "ad5755");
    add_channel("out_voltage0", "0.152587890", "0");
    add_channel("out_voltage1", "0.305175781", "-32768");
  }

  static void add_channel(const std::string& name, const std::string& scale, const std::string& offset) {
    put(kDac, name + "_raw", "777");
    put(kDac, name + "_scale", scale);
    put(kDac, name + "_offset", offset);
    put(kDac, name + "_powerdown", "1");
  }

  std::string raw(int channel) const { return text(kDac, "out_voltage" + std::to_string(channel) + "_raw"); }
  std::string powerdown(int channel) const {
    return text(kDac, "out_voltage" + std::to_string(channel) + "_powerdown");
  }

  std::string failure() const {
    try {
      const IioOutput output(config_);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "no failure";
  }

  IioOutputConfig config_{.channels = {{"ad5755", "voltage0"}, {"ad5755", "voltage1"}},
                          .safe_V = {5.0F, -2.5F}};
};

bool write(IioOutput& output, const std::vector<float>& command_V) {
  return output.write(command_V);
}

TEST_F(IioOutputTest, VoltsBecomeTheRawNumberByScaleAndOffset) {
  IioOutput output(config_);
  EXPECT_TRUE(write(output, {5.0F, 0.0F}));
  EXPECT_EQ(raw(0), "32768");  // 5 V / 10 V x 65536
  EXPECT_EQ(raw(1), "32768");  // 0 V / 20 V x 65536 + 32768
  EXPECT_TRUE(write(output, {0.0F, -10.0F}));
  EXPECT_EQ(raw(0), "0");
  EXPECT_EQ(raw(1), "0");
}

TEST_F(IioOutputTest, TheNearestStepIsTaken) {
  IioOutput output(config_);
  // Steps of 0.15259 mV: 1.4 and 1.6 of them.
  EXPECT_TRUE(write(output, {0.000214F, 0.0F}));
  EXPECT_EQ(raw(0), "1");
  EXPECT_TRUE(write(output, {0.000244F, 0.0F}));
  EXPECT_EQ(raw(0), "2");
}

TEST_F(IioOutputTest, NothingIsWrittenBeforeTheFirstCommand) {
  { const IioOutput output(config_); }
  EXPECT_EQ(raw(0), "777");
  EXPECT_EQ(powerdown(0), "1");
}

TEST_F(IioOutputTest, SafeIsEachOutputsOwnValue) {
  IioOutput output(config_);
  EXPECT_TRUE(output.make_safe());
  EXPECT_EQ(raw(0), "32768");
  EXPECT_EQ(raw(1), "24576");  // -2.5 V / 20 V x 65536 + 32768
}

TEST_F(IioOutputTest, SafeIsWhatIsSafeNowWhereThatMayChange) {
  std::array<std::atomic<float>, 2> now_V{5.0F, -2.5F};
  config_.safe_now_V = now_V;
  IioOutput output(config_);
  now_V[0] = 2.5F;
  EXPECT_TRUE(output.make_safe());
  EXPECT_EQ(raw(0), "16384");
  EXPECT_EQ(raw(1), "24576");
  now_V[1] = 0.0F;
  EXPECT_FALSE(write(output, {1.0F, std::nanf("")}));
  EXPECT_EQ(raw(1), "32768");
}

TEST_F(IioOutputTest, WhatWasDrivenEndsSafe) {
  {
    IioOutput output(config_);
    EXPECT_TRUE(write(output, {1.0F, 1.0F}));
    ASSERT_EQ(raw(1), "36045");
  }
  EXPECT_EQ(raw(0), "32768");
  EXPECT_EQ(raw(1), "24576");
}

TEST_F(IioOutputTest, AnOutputIsPoweredUpByItsFirstValue) {
  IioOutput output(config_);
  EXPECT_TRUE(output.make_safe());
  EXPECT_EQ(powerdown(0), "0");
  EXPECT_EQ(powerdown(1), "0");
}

TEST_F(IioOutputTest, AnOutputWithoutPowerDownAndOffsetNeedsNeither) {
  for (const char* const file : {"out_voltage0_powerdown", "out_voltage0_offset"}) remove(kDac, file);
  IioOutput output(config_);
  EXPECT_TRUE(write(output, {10.0F, 0.0F}));
  EXPECT_EQ(raw(0), "65536");
}

TEST_F(IioOutputTest, ACommandBeyondTheStatedRangeIsClippedAndReportedButForTheStepToFullScale) {
  put(kDac, "out_voltage0_raw_available", "[100 1 65535]");
  IioOutput output(config_);
  EXPECT_TRUE(write(output, {10.0F, 0.0F})) << "code 65536 and a fraction";
  EXPECT_EQ(raw(0), "65535");
  EXPECT_FALSE(write(output, {-1.0F, 0.0F}));
  EXPECT_EQ(raw(0), "100");
  EXPECT_FALSE(write(output, {std::numeric_limits<float>::max(), 0.0F}));
  EXPECT_EQ(raw(0), "65535");
}

TEST_F(IioOutputTest, FullScaleIsTheLastCodeAndBeyondItIsRefused) {
  // An attribute of the real kernel that takes numbers up to 1000, and answers EINVAL above.
  const std::filesystem::path limited = "/proc/self/oom_score_adj";
  std::filesystem::remove(folder(kDac) / "out_voltage0_raw");
  std::filesystem::create_symlink(limited, folder(kDac) / "out_voltage0_raw");
  put(kDac, "out_voltage0_scale", "10");
  IioOutput output(config_);
  EXPECT_TRUE(write(output, {10.01F, 0.0F})) << "code 1001";
  EXPECT_EQ(raw(0), "1000");
  EXPECT_FALSE(write(output, {10.02F, 0.0F})) << "code 1002";
}

TEST_F(IioOutputTest, ACommandThatIsNoNumberIsReportedAndBecomesTheSafeValue) {
  IioOutput output(config_);
  EXPECT_FALSE(write(output, {std::nanf(""), 0.0F}));
  EXPECT_EQ(raw(0), "32768");
  EXPECT_EQ(raw(1), "32768") << "the other is written all the same";
  EXPECT_FALSE(write(output, {0.0F, std::numeric_limits<float>::infinity()}));
  EXPECT_EQ(raw(1), "24576");
}

TEST_F(IioOutputTest, ADeviceThatRefusesOneOutputStillGetsTheOthers) {
  IioOutput output(config_);
  break_open(folder(kDac) / "out_voltage0_raw");
  EXPECT_FALSE(write(output, {1.0F, 0.0F}));
  EXPECT_EQ(raw(1), "32768");
  EXPECT_FALSE(output.make_safe());
  EXPECT_EQ(raw(1), "24576");
}

TEST_F(IioOutputTest, AnOutputThatCannotBePoweredUpIsReportedUntilItCan) {
  IioOutput output(config_);
  break_open(folder(kDac) / "out_voltage1_powerdown");
  EXPECT_FALSE(output.make_safe());
  EXPECT_FALSE(output.make_safe());
}

TEST_F(IioOutputTest, WhatIsNotFittedIsLeftOut) {
  config_.channels[0] = {};
  IioOutput output(config_);
  EXPECT_TRUE(write(output, {std::nanf(""), 0.0F}));
  EXPECT_EQ(raw(0), "777");
  EXPECT_EQ(raw(1), "32768");
}

TEST_F(IioOutputTest, ADeviceIsFoundByNameLabelAndId) {
  put(kDac, "label", "valves");
  for (const char* const name : {"ad5755", "valves", "iio:device0"}) {
    config_.channels = {{name, "voltage0"}};
    config_.safe_V = {1.0F};
    EXPECT_EQ(failure(), "no failure") << name;
  }
}

TEST_F(IioOutputTest, EqualDevicesMustBeToldApart) {
  add_device("iio:device1", "ad5755");
  EXPECT_EQ(
      failure(),
      "iio:ad5755: 2 devices have this name, expected the label or id of one (iio:device0, iio:device1)");
}

TEST_F(IioOutputTest, WhatIsMissingIsNamed) {
  config_.channels[1].device = "ad5766";
  EXPECT_EQ(failure(), "iio:ad5766: no such device, expected one of iio:device0 (ad5755)");
  config_.channels[1] = {"ad5755", "voltage2"};
  EXPECT_EQ(failure(), "iio:ad5755 voltage2: no such output, expected one of voltage0, voltage1");
  config_.channels[1] = {"ad5755", "voltage0"};
  EXPECT_EQ(failure(), "iio:ad5755 voltage0: given twice, expected one channel an output");
  config_.channels[1] = {"ad5755", "voltage1"};
  remove(kDac, "out_voltage1_scale");
  EXPECT_THAT(failure(), HasSubstr("iio:ad5755 voltage1: scale: "));
  put(kDac, "out_voltage1_scale", "0.3 V");
  EXPECT_EQ(failure(), "iio:ad5755 voltage1: scale: Invalid argument, expected a number to be read");
  put(kDac, "out_voltage1_scale", "0");
  EXPECT_EQ(failure(), "iio:ad5755 voltage1: scale: no step, expected a scale in mV");
  put(kDac, "out_voltage1_scale", "1");
  remove(kDac, "out_voltage1_raw");
  EXPECT_EQ(failure(), "iio:ad5755 voltage1: no such output, expected one of voltage0");
}

TEST_F(IioOutputTest, WhereOneIsMissingTheOthersAreOpenedAndKeptSafe) {
  config_.channels = {{"ad5755", "voltage0"}, {"ad5766", "voltage0"}, {"ad5755", "voltage1"}};
  config_.safe_V = {5.0F, 0.0F, -2.5F};
  std::vector<std::string> missing;
  {
    IioOutput output(config_, &missing);
    EXPECT_THAT(missing, ElementsAre(HasSubstr("iio:ad5766: no such device")));
    EXPECT_FALSE(write(output, {1.0F, 1.0F, 1.0F})) << "one was not written";
    EXPECT_EQ(raw(0), "6554");
    EXPECT_FALSE(output.make_safe());
    EXPECT_EQ(raw(0), "32768");
    EXPECT_EQ(raw(1), "24576");
  }
  std::filesystem::remove_all("/sys/bus/iio");
  IioOutput none(config_, &missing);
  EXPECT_THAT(missing, ElementsAre(_, HasSubstr("no Industrial I/O in this kernel")));
  EXPECT_FALSE(none.make_safe());
}

TEST_F(IioOutputTest, ASafeValueThatTheConverterCannotHoldIsNamed) {
  put(kDac, "out_voltage0_raw_available", "[0 1 16383]");  // 2.5 V
  EXPECT_EQ(
      failure(),
      "iio:ad5755 voltage0: safe_V lies beyond the converter's range, expected a value that it can hold");
}

TEST_F(IioOutputTest, ASourceOfCurrentIsNoVoltage) {
  put(kDac, "out_current2_raw", "0");
  config_.channels[1].channel = "current2";
  EXPECT_EQ(failure(), "iio:ad5755 current2: no such output, expected one of voltage0, voltage1");
}

TEST_F(IioOutputTest, EachOutputNeedsASafeValue) {
  config_.safe_V = {1.0F};
  EXPECT_EQ(failure(), "iio:outputs: 1 safe values, expected one for each of the 2 channels");
  config_.safe_V = {1.0F, std::nanf("")};
  EXPECT_EQ(failure(), "iio:ad5755 voltage1: safe_V is no number, expected volts");
}

TEST_F(IioOutputTest, ARangeThatIsNoneIsNamed) {
  put(kDac, "out_voltage0_raw_available", "0 1 2 3");
  EXPECT_EQ(failure(), "iio:ad5755 voltage0: raw_available: 0 1 2 3, expected [lowest step highest]");
}

TEST_F(IioOutputTest, AKernelWithoutIioIsToldAsThat) {
  std::filesystem::remove_all("/sys/bus/iio");
  EXPECT_EQ(
      failure(),
      "iio:/sys/bus/iio: no Industrial I/O in this kernel, expected the driver of a converter (modprobe "
      "industrialio, and the converter's module)");
}

}  // namespace
}  // namespace plenum::board::drivers
