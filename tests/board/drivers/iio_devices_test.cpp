// Devices, channels and their attributes by the names that the kernel gives them, as files (iio_stand_in.hpp).
#include "board/drivers/iio_devices.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "tests/board/drivers/iio_stand_in.hpp"

namespace plenum::board::drivers {
namespace {

using ::testing::HasSubstr;

const std::string kDevice = "iio:device0";

class IioDevicesTest : public IioStandIn {
 protected:
  void SetUp() override {
    IioStandIn::SetUp();
    if (IsSkipped()) return;
    add_device(kDevice, "ad7124-8");
    put(kDevice, "in_voltage0-voltage1_raw", "0");
    put(kDevice, "in_voltage2_raw", "0");
    put(kDevice, "in_voltage8_supply_raw", "0");
    put(kDevice, "in_temp_raw", "0");
    put(kDevice, "out_voltage2_raw", "0");
  }

  /// The name of an attribute of the input that is called so.
  static std::string file_of(const std::string& channel, const std::string& attribute) {
    return IioDevices().input({kDevice, channel}).attribute(attribute).filename();
  }

  static std::string failure(const std::string& channel) {
    try {
      return file_of(channel, "raw");
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  }
};

TEST_F(IioDevicesTest, AChannelIsCalledByIdOrName) {
  EXPECT_EQ(file_of("voltage2", "raw"), "in_voltage2_raw");
  EXPECT_EQ(file_of("voltage0-voltage1", "raw"), "in_voltage0-voltage1_raw");
  EXPECT_EQ(file_of("voltage8", "raw"), "in_voltage8_supply_raw");
  EXPECT_EQ(file_of("supply", "raw"), "in_voltage8_supply_raw");
}

TEST_F(IioDevicesTest, AChannelIsCalledByItsLabel) {
  put(kDevice, "in_voltage2_label", "tank");
  put(kDevice, "in_voltage8_supply_label", "supply");  // newer kernels repeat the name so
  EXPECT_EQ(file_of("tank", "raw"), "in_voltage2_raw");
  EXPECT_EQ(file_of("supply", "raw"), "in_voltage8_supply_raw");
}

TEST_F(IioDevicesTest, AnOutputIsNoInput) {
  EXPECT_EQ(IioDevices().output({kDevice, "voltage2"}).attribute("raw").filename(), "out_voltage2_raw");
  EXPECT_THROW(IioDevices().output({kDevice, "voltage8"}), std::runtime_error);
}

TEST_F(IioDevicesTest, AnAttributeIsTheChannelsOwnOrTheOneThatItSharesMostNarrowly) {
  put(kDevice, "scale", "4");
  EXPECT_EQ(file_of("voltage2", "scale"), "scale");
  put(kDevice, "in_scale", "3");
  EXPECT_EQ(file_of("voltage2", "scale"), "in_scale");
  put(kDevice, "in_voltage_scale", "2");
  EXPECT_EQ(file_of("voltage2", "scale"), "in_voltage_scale");
  EXPECT_EQ(file_of("supply", "scale"), "in_voltage_scale");
  put(kDevice, "in_voltage2_scale", "1");
  EXPECT_EQ(file_of("voltage2", "scale"), "in_voltage2_scale");
  EXPECT_EQ(file_of("supply", "scale"), "in_voltage_scale");
}

TEST_F(IioDevicesTest, WhatDifferencesShareIsNotWhatSingleVoltagesDo) {
  put(kDevice, "in_voltage_scale", "2");
  put(kDevice, "in_voltage-voltage_scale", "3");
  EXPECT_EQ(file_of("voltage2", "scale"), "in_voltage_scale");
  EXPECT_EQ(file_of("voltage0-voltage1", "scale"), "in_voltage-voltage_scale");
}

TEST_F(IioDevicesTest, ScaleAndOffsetMayBeSharedEachInItsWay) {
  put(kDevice, "in_voltage8_supply_scale", "0.5");
  put(kDevice, "in_offset", "-8");
  const IioChannel named{kDevice, "supply"};
  const IioScale scale = iio_scale(named, IioDevices().input(named));
  EXPECT_EQ(scale.scale_mV, 0.5);
  EXPECT_EQ(scale.offset, -8.0);
}

TEST_F(IioDevicesTest, AnAttributeThatEndsInRawIsNoChannelOfItsOwn) {
  put(kDevice, "in_voltage2_mean_raw", "0");
  EXPECT_EQ(file_of("voltage2", "raw"), "in_voltage2_raw");
  EXPECT_THAT(failure("mean"), HasSubstr("no such input"));
}

TEST_F(IioDevicesTest, WhatIsMissingIsToldWithWhatThereIs) {
  put(kDevice, "in_voltage8_supply_label", "supply");
  EXPECT_EQ(failure("voltage9"),
            "iio:iio:device0 voltage9: no such input, expected one of voltage0-voltage1, voltage2, voltage8 "
            "(supply)");
  for (const char* const file : {"in_voltage0-voltage1_raw", "in_voltage2_raw", "in_voltage8_supply_raw"})
    remove(kDevice, file);
  EXPECT_EQ(failure("voltage2"), "iio:iio:device0 voltage2: no such input, expected one, but there is none");
}

TEST_F(IioDevicesTest, ANameThatSeveralHaveIsToldWithTheirOthers) {
  put(kDevice, "in_voltage2_label", "supply");
  EXPECT_EQ(failure("supply"),
            "iio:iio:device0 supply: 2 inputs have this name, expected the label or id of one (voltage2, "
            "voltage8)");
  put(kDevice, "in_voltage8_spare_raw", "0");
  EXPECT_EQ(
      failure("voltage8"),
      "iio:iio:device0 voltage8: 2 inputs have this name, expected the label or id of one (spare, supply)");
}

TEST_F(IioDevicesTest, ATriggerIsCalledByNameOrId) {
  add_device("trigger3", "ad7124-8-dev0");
  EXPECT_EQ(IioDevices().trigger("trigger3").filename(), "trigger3");
  EXPECT_EQ(IioDevices().trigger("ad7124-8-dev0").filename(), "trigger3");
  EXPECT_THROW(IioDevices().device("trigger3"), std::runtime_error);
}

}  // namespace
}  // namespace plenum::board::drivers
