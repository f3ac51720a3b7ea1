// Captured scans: bytes written by hand into a FIFO that stands for /dev/iio:deviceN (iio_stand_in.hpp).
#include "board/drivers/iio_input.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <limits>
#include <optional>
#include <stdexcept>

#include "tests/board/drivers/iio_stand_in.hpp"

namespace plenum::board::drivers {
namespace {

using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

const std::string kAdc = "iio:device0";
const std::string kSecond = "iio:device1";

class IioInputTest : public IioStandIn {
 protected:
  void SetUp() override {
    IioStandIn::SetUp();
    if (IsSkipped()) return;
    // A step is a volt, so that a reading in volts is the raw number.
    add_adc(kAdc, "ad7606-8", "be:s16/16>>0");
    put(kAdc, "sampling_frequency", "50");
  }

  void add_adc(const std::string& id, const std::string& name, const std::string& type) {
    add_device(id, name);
    put(id, "in_voltage_scale", "1000");
    add_capture(id, {"voltage0", "voltage1", "voltage2"}, type);
  }

  static void add_trigger() {
    add_device("trigger0", "plenum-adc");
    put("trigger0", "sampling_frequency", "100");
  }

  std::string failure() const {
    try {
      const IioInput input(config_);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "no failure";
  }

  IioInputConfig config_{.channels = {{"ad7606-8", "voltage0"}}, .trigger = "", .rate_Hz = 1000};
};

std::vector<ports::AnalogReading> read(IioInput& input, std::size_t channels) {
  std::vector<ports::AnalogReading> readings(channels, {.mean_V = 99.0F, .fresh = true});
  input.read(readings);
  return readings;
}

/// One channel's reading; NaN when it is not fresh.
float volts(IioInput& input) {
  const ports::AnalogReading one = read(input, 1).front();
  return one.fresh ? one.mean_V : std::numeric_limits<float>::quiet_NaN();
}

/// `count` scans of one 16-bit channel.
Bytes scans(unsigned count, std::uint8_t number) {
  Bytes bytes;
  for (unsigned i = 0; i < count; ++i) bytes.insert(bytes.end(), {0x00, number});
  return bytes;
}

struct Format {
  const char* type;
  Bytes bytes;
  float number;
};

TEST_F(IioInputTest, ASampleIsReadAsTheKernelStatesItsForm) {
  const std::vector<Format> formats{
      {"be:s16/16>>0", {0x12, 0x34}, 0x1234},
      {"be:s16/16>>0", {0xFF, 0xFE}, -2},
      {"le:s16/16>>0", {0x34, 0x12}, 0x1234},
      {"le:u16/16>>0", {0xFE, 0xFF}, 65534},
      {"be:u12/16>>4", {0xAB, 0xCF}, 0xABC},
      {"le:s12/16>>0", {0x01, 0x08}, -2047},  // 801h; the upper four bits are nobody's
      {"le:s12/16>>0", {0x01, 0xF7}, 0x701},  // 701h, with all of them set
      {"le:u12/16>>0", {0x01, 0xF8}, 0x801},
      {"be:s24/32>>8", {0x80, 0x00, 0x00, 0x55}, -8388608},
      {"le:s18/32>>2", {0x04, 0x00, 0x08, 0x00}, -131071},  // 20001h of 18 bits
      {"le:u32/32>>0", {0x00, 0x00, 0x00, 0x80}, 2147483648},
      {"le:s8/8>>0", {0x80}, -128},
      {"le:u8/8>>0", {0x80}, 128},
  };
  for (const Format& format : formats) {
    put(kAdc, "scan_elements/in_voltage0_type", format.type);
    IioInput input(config_);
    bring(kAdc, format.bytes);
    EXPECT_EQ(volts(input), format.number) << format.type << ", first byte " << +format.bytes[0];
  }
}

TEST_F(IioInputTest, AReadingIsTheMeanOfTheScansSinceTheLast) {
  IioInput input(config_);
  bring(kAdc, {0, 1, 0, 2, 0, 6});
  EXPECT_EQ(volts(input), 3.0F);
  bring(kAdc, {0, 8});
  EXPECT_EQ(volts(input), 8.0F);
}

TEST_F(IioInputTest, GatheringInPiecesChangesNothing) {
  IioInput input(config_);
  EXPECT_EQ(input.gathered(), 0U);
  bring(kAdc, {0, 1});
  input.gather();
  EXPECT_EQ(input.gathered(), 1U);
  input.gather();
  bring(kAdc, {0, 2, 0, 6});
  input.gather();
  EXPECT_EQ(input.gathered(), 3U);
  EXPECT_EQ(volts(input), 3.0F);
  EXPECT_EQ(input.gathered(), 0U);
}

TEST_F(IioInputTest, AMeanIsNotRoundedToSteps) {
  IioInput input(config_);
  bring(kAdc, {0, 1, 0, 2, 0xFF, 0xFE, 0, 0});
  EXPECT_EQ(volts(input), 0.25F);
}

TEST_F(IioInputTest, ScaleAndOffsetAreTheKernels) {
  put(kAdc, "in_voltage_scale", "0.305176");  // AD7606, +-10 V
  put(kAdc, "in_voltage_offset", "-32768");
  IioInput input(config_);
  bring(kAdc, {0x00, 0x00});
  EXPECT_FLOAT_EQ(volts(input), -32768 * 0.305176F / 1000.0F);
}

TEST_F(IioInputTest, ChannelsComeInTheOrderOfTheConfiguration) {
  config_.channels = {{"ad7606-8", "voltage2"}, {}, {"ad7606-8", "voltage0"}};
  IioInput input(config_);
  bring(kAdc, {0, 10, 0, 30});  // voltage0, voltage2: a scan is in the kernel's order, and without voltage1
  const auto readings = read(input, 4);
  EXPECT_EQ(readings[0].mean_V, 30.0F);
  EXPECT_TRUE(readings[0].fresh);
  EXPECT_FALSE(readings[1].fresh) << "not fitted";
  EXPECT_EQ(readings[2].mean_V, 10.0F);
  EXPECT_FALSE(readings[3].fresh) << "beyond the configuration";
  EXPECT_EQ(text(kAdc, "scan_elements/in_voltage0_en"), "1");
  EXPECT_EQ(text(kAdc, "scan_elements/in_voltage1_en"), "0");
  EXPECT_EQ(text(kAdc, "scan_elements/in_voltage2_en"), "1");
}

TEST_F(IioInputTest, SamplesOfSeveralSizesStandAtTheirOwnAlignment) {
  put(kAdc, "scan_elements/in_voltage0_type", "le:s8/8>>0");
  put(kAdc, "scan_elements/in_voltage1_type", "be:s16/16>>0");
  put(kAdc, "scan_elements/in_voltage2_type", "le:s32/32>>0");
  config_.channels = {{kAdc, "voltage0"}, {kAdc, "voltage1"}, {kAdc, "voltage2"}};
  IioInput input(config_);
  bring(kAdc, {7, 0xEE, 0, 8, 9, 0, 0, 0, 9, 0xEE, 0, 10, 11, 0, 0, 0});
  const auto readings = read(input, 3);
  EXPECT_EQ(readings[0].mean_V, 8.0F);
  EXPECT_EQ(readings[1].mean_V, 9.0F);
  EXPECT_EQ(readings[2].mean_V, 10.0F);
}

TEST_F(IioInputTest, AScanIsInTheOrderOfTheKernelsIndices) {
  put(kAdc, "scan_elements/in_voltage0_index", "9");
  put(kAdc, "scan_elements/in_voltage1_type", "le:s32/32>>0");
  config_.channels = {{kAdc, "voltage0"}, {kAdc, "voltage1"}, {kAdc, "voltage2"}};
  IioInput input(config_);
  // voltage1, voltage2, voltage0: of 32, 16 and 16 bits; then 1 instead of 0 in each
  bring(kAdc, {10, 0, 0, 0, 0, 20, 0, 30, 11, 0, 0, 0, 0, 21, 0, 31});
  const auto readings = read(input, 3);
  EXPECT_EQ(readings[0].mean_V, 30.5F);
  EXPECT_EQ(readings[1].mean_V, 10.5F);
  EXPECT_EQ(readings[2].mean_V, 20.5F);
}

TEST_F(IioInputTest, AHoleAtTheEndOfAScanIsPassedOver) {
  put(kAdc, "scan_elements/in_voltage0_type", "le:s32/32>>0");
  config_.channels = {{kAdc, "voltage0"}, {kAdc, "voltage1"}};
  IioInput input(config_);
  bring(kAdc, {10, 0, 0, 0, 0, 20, 0xEE, 0xEE, 12, 0, 0, 0, 0, 22, 0xEE, 0xEE});
  const auto readings = read(input, 2);
  EXPECT_EQ(readings[0].mean_V, 11.0F);
  EXPECT_EQ(readings[1].mean_V, 21.0F);
}

TEST_F(IioInputTest, WhatAnEarlierProgramHasLeftSwitchedOnIsNoPartOfTheScans) {
  for (const char* const file : {"in_voltage1_en", "in_timestamp_en"})
    put(kAdc, std::string("scan_elements/") + file, "1");
  put(kAdc, "buffer/enable", "1");
  IioInput input(config_);
  EXPECT_EQ(text(kAdc, "scan_elements/in_voltage0_en"), "1");
  EXPECT_EQ(text(kAdc, "scan_elements/in_voltage1_en"), "0");
  EXPECT_EQ(text(kAdc, "scan_elements/in_timestamp_en"), "0");
  bring(kAdc, {0, 1, 0, 3});
  EXPECT_EQ(volts(input), 2.0F) << "scans of one channel";
}

TEST_F(IioInputTest, WhatAnEarlierProgramHasLeftRunningIsEndedBeforeAnythingIsSet) {
  put(kAdc, "buffer/enable", "1");
  remove(kAdc, "trigger");
  add_trigger();
  config_.trigger = "plenum-adc";
  EXPECT_THAT(failure(), HasSubstr("trigger plenum-adc"));
  EXPECT_EQ(text(kAdc, "buffer/enable"), "0");
}

TEST_F(IioInputTest, NothingIsChangedBeforeEveryChannelIsFound) {
  put(kAdc, "buffer/enable", "1");
  config_.channels.push_back({"ad7606-8", "voltage9"});
  EXPECT_THAT(failure(), HasSubstr("no such input"));
  EXPECT_EQ(text(kAdc, "buffer/enable"), "1");
}

TEST_F(IioInputTest, AScanThatComesInPiecesIsOne) {
  put(kAdc, "scan_elements/in_voltage1_type", "le:s32/32>>0");
  config_.channels = {{kAdc, "voltage0"}, {kAdc, "voltage1"}};
  IioInput input(config_);
  const std::vector<Bytes> pieces{{0, 7, 0}, {0, 70, 0, 0, 0, 0, 9, 0, 0}, {90, 0, 0}, {0}};
  for (const Bytes& piece : pieces) {
    bring(kAdc, piece);
    input.gather();
  }
  EXPECT_EQ(input.gathered(), 2U);
  const auto readings = read(input, 2);
  EXPECT_EQ(readings[0].mean_V, 8.0F);
  EXPECT_EQ(readings[1].mean_V, 80.0F);
}

TEST_F(IioInputTest, TheKernelsFolderOfAllThatIsTheBuffersServesAlone) {
  for (const char* const file : {"enable", "length", "watermark"})
    put(kAdc, std::string("buffer0/") + file, "0");
  for (const char* const part : {"en", "index", "type"})
    put(kAdc, std::string("buffer0/in_voltage0_") + part,
        text(kAdc, std::string("scan_elements/in_voltage0_") + part));
  for (const char* const former : {"buffer", "scan_elements"}) remove(kAdc, former);
  IioInput input(config_);
  EXPECT_EQ(text(kAdc, "buffer0/in_voltage0_en"), "1");
  EXPECT_EQ(text(kAdc, "buffer0/watermark"), "10");
  EXPECT_EQ(text(kAdc, "buffer0/length"), "80");
  EXPECT_EQ(text(kAdc, "buffer0/enable"), "1");
  bring(kAdc, {0, 4});
  EXPECT_EQ(volts(input), 4.0F);
}

TEST_F(IioInputTest, WithoutAScanNothingIsFresh) {
  IioInput input(config_);
  EXPECT_FALSE(read(input, 1)[0].fresh);
  bring(kAdc, {0, 1});
  EXPECT_TRUE(read(input, 1)[0].fresh);
  EXPECT_FALSE(read(input, 1)[0].fresh);
  EXPECT_FALSE(input.gone());
}

TEST_F(IioInputTest, ADeviceThatStallsLeavesTheOthersFresh) {
  add_adc(kSecond, "supply", "le:u16/16>>0");
  put(kSecond, "sampling_frequency", "50");
  config_.channels.push_back({"supply", "voltage1"});
  IioInput input(config_);
  EXPECT_EQ(input.descriptors().size(), 2U);
  bring(kAdc, {0, 4});
  input.gather();
  EXPECT_EQ(input.gathered(), 0U) << "the least of the devices";
  auto readings = read(input, 2);
  EXPECT_EQ(readings[0].mean_V, 4.0F);
  EXPECT_TRUE(readings[0].fresh);
  EXPECT_FALSE(readings[1].fresh);
  bring(kSecond, {5, 0});
  readings = read(input, 2);
  EXPECT_FALSE(readings[0].fresh);
  EXPECT_EQ(readings[1].mean_V, 5.0F);
}

TEST_F(IioInputTest, ADeviceThatIsGoneIsToldAndNotWaitedFor) {
  IioInput input(config_);
  bring(kAdc, {0, 4});
  EXPECT_EQ(volts(input), 4.0F);
  EXPECT_FALSE(input.gone());
  EXPECT_GE(input.descriptors()[0], 0);
  break_open("/dev/" + kAdc);
  EXPECT_FALSE(read(input, 1)[0].fresh);
  EXPECT_TRUE(input.gone());
  EXPECT_EQ(input.descriptors()[0], -1) << "what poll() leaves out";
  EXPECT_FALSE(read(input, 1)[0].fresh);
}

TEST_F(IioInputTest, ADeviceThatBringsItsEndIsGone) {
  IioInput input(config_);
  bring(kAdc, {0, 4});
  end(kAdc);
  EXPECT_EQ(volts(input), 4.0F) << "what it brought before";
  EXPECT_FALSE(read(input, 1)[0].fresh);
  EXPECT_TRUE(input.gone());
  EXPECT_EQ(input.descriptors()[0], -1);
}

TEST_F(IioInputTest, TheEndLeavesAloneTheDeviceThatHasTheNumberOfOneThatIsGone) {
  std::optional<IioInput> input(config_);
  std::filesystem::remove_all(folder(kAdc));
  put(kAdc, "buffer/enable", "1");  // another's capture
  input.reset();
  EXPECT_EQ(text(kAdc, "buffer/enable"), "1");
}

TEST_F(IioInputTest, TheDescriptorsWakeUpForScans) {
  IioInput input(config_);
  pollfd waiting{input.descriptors()[0], POLLIN, 0};
  EXPECT_EQ(::poll(&waiting, 1, 0), 0);
  bring(kAdc, {0, 4});
  EXPECT_EQ(::poll(&waiting, 1, 0), 1);
  input.gather();
  EXPECT_EQ(::poll(&waiting, 1, 0), 0);
}

TEST_F(IioInputTest, TheKernelKeepsEightTicksAndWakesAfterOne) {
  const IioInput input(config_);
  EXPECT_EQ(input.scans_per_tick(), 10U);
  EXPECT_EQ(text(kAdc, "buffer/watermark"), "10");
  EXPECT_EQ(text(kAdc, "buffer/length"), "80");
  EXPECT_EQ(text(kAdc, "buffer/enable"), "1");
}

TEST_F(IioInputTest, TheCaptureEndsWithTheInput) {
  { const IioInput input(config_); }
  EXPECT_EQ(text(kAdc, "buffer/enable"), "0");
}

TEST_F(IioInputTest, AFullBufferIsCountedAndItsScansAreNotTakenForThePresent) {
  IioInput input(config_);
  bring(kAdc, scans(79, 1));
  input.gather();
  EXPECT_EQ(input.overflows(), 0U);
  bring(kAdc, scans(128, 1));  // what the kernel makes of 80
  input.gather();
  EXPECT_EQ(input.overflows(), 1U);
  EXPECT_EQ(input.gathered(), 0U);
  EXPECT_FALSE(read(input, 1)[0].fresh) << "the oldest, of which nobody knows how old they are";
  bring(kAdc, scans(2, 7));
  EXPECT_EQ(volts(input), 7.0F);
  EXPECT_EQ(input.overflows(), 1U);
}

TEST_F(IioInputTest, OfSeveralTicksThatHaveWaitedTheLastCounts) {
  IioInput input(config_);
  bring(kAdc, scans(10, 1));
  input.gather();
  bring(kAdc, scans(20, 2));
  bring(kAdc, scans(10, 3));
  EXPECT_EQ(volts(input), 3.0F);
  bring(kAdc, scans(10, 4));
  bring(kAdc, scans(5, 7));
  EXPECT_EQ(volts(input), 5.0F) << "a tick that is a little late has all of its scans";
}

TEST_F(IioInputTest, WhatIsForgottenIsOfNoReading) {
  IioInput input(config_);
  bring(kAdc, scans(3, 1));
  input.gather();
  bring(kAdc, scans(3, 1));
  input.forget();
  EXPECT_EQ(input.gathered(), 0U);
  bring(kAdc, scans(2, 7));
  EXPECT_EQ(volts(input), 7.0F);
}

TEST_F(IioInputTest, ADeviceFasterThanItsReaderKeepsNobodyAndIsNotFresh) {
  IioInput input(config_);
  bring(kAdc, scans(170, 1));
  input.gather();
  EXPECT_EQ(input.gathered(), 0U) << "twice the buffer, and all of it old";
  input.gather();
  EXPECT_EQ(input.gathered(), 10U) << "what was left for the next time";
}

TEST_F(IioInputTest, TheRateIsSetAtTheDevice) {
  const IioInput input(config_);
  EXPECT_EQ(text(kAdc, "sampling_frequency"), "1000");
  EXPECT_EQ(text(kAdc, "trigger/current_trigger"), "");
}

TEST_F(IioInputTest, TheRateIsSetAtTheChannelsWhereTheDeviceHasNone) {
  remove(kAdc, "sampling_frequency");
  put(kAdc, "in_voltage_sampling_frequency", "50");
  const IioInput input(config_);
  EXPECT_EQ(text(kAdc, "in_voltage_sampling_frequency"), "1000");
}

TEST_F(IioInputTest, ATriggerIsSetAndHasTheRate) {
  add_trigger();
  config_.trigger = "plenum-adc";
  const IioInput input(config_);
  EXPECT_EQ(text(kAdc, "trigger/current_trigger"), "plenum-adc");
  EXPECT_EQ(text("trigger0", "sampling_frequency"), "1000");
  EXPECT_EQ(text(kAdc, "sampling_frequency"), "50") << "the device's own is left alone";
}

TEST_F(IioInputTest, ATriggerThatTheDeviceHasAlreadyIsKeptAndHasTheRate) {
  add_trigger();
  put(kAdc, "trigger/current_trigger", "plenum-adc");
  const IioInput input(config_);
  EXPECT_EQ(text(kAdc, "trigger/current_trigger"), "plenum-adc");
  EXPECT_EQ(text("trigger0", "sampling_frequency"), "1000");
}

TEST_F(IioInputTest, ATriggerWithoutARateLeavesItToTheDevice) {
  add_trigger();
  remove("trigger0", "sampling_frequency");
  config_.trigger = "trigger0";
  const IioInput input(config_);
  EXPECT_EQ(text(kAdc, "sampling_frequency"), "1000");
}

TEST_F(IioInputTest, ADeviceThatRunsFreelyIsTakenAsItIs) {
  remove(kAdc, "sampling_frequency");
  EXPECT_EQ(
      failure(),
      "iio:iio:device0: no attribute sampling_frequency, expected one of the device, its channels or its "
      "trigger, or rate_Hz = 0 for a device that runs freely");
  config_.rate_Hz = 0;
  IioInput input(config_);
  EXPECT_EQ(input.scans_per_tick(), 0U);
  EXPECT_EQ(text(kAdc, "buffer/length"), "2048");
  bring(kAdc, scans(300, 1));
  EXPECT_EQ(volts(input), 1.0F);
  EXPECT_EQ(input.overflows(), 0U);
}

TEST_F(IioInputTest, ARateThatTheDeviceDoesNotHaveIsNamed) {
  config_.rate_Hz = 1050;
  EXPECT_EQ(failure(), "iio:rate_Hz: 1050, expected a multiple of 100");
  config_.rate_Hz = 1000;
  // An attribute of the real kernel that takes a number, and reads as another.
  remove(kAdc, "sampling_frequency");
  std::filesystem::create_symlink("/proc/self/coredump_filter", folder(kAdc) / "sampling_frequency");
  EXPECT_THAT(failure(), HasSubstr("iio:iio:device0: sampling_frequency: the device made "));
  EXPECT_THAT(failure(), HasSubstr(" of 1000, expected a rate that it has"));
}

TEST_F(IioInputTest, OversamplingIsSetWhereTheDeviceHasIt) {
  put(kAdc, "oversampling_ratio", "1");
  put(kAdc, "oversampling_ratio_available", "1 2 4 8 16 32 64");
  config_.oversampling = 16;
  { const IioInput input(config_); }
  EXPECT_EQ(text(kAdc, "oversampling_ratio"), "16");
  put(kAdc, "in_voltage_oversampling_ratio", "1");
  { const IioInput input(config_); }
  EXPECT_EQ(text(kAdc, "in_voltage_oversampling_ratio"), "16") << "its channels' own come first";
}

TEST_F(IioInputTest, OversamplingIsSetAtEveryDeviceAndEveryChannelInUse) {
  add_adc(kSecond, "ad7606-4", "be:s16/16>>0");
  put(kSecond, "sampling_frequency", "50");
  put(kAdc, "oversampling_ratio", "1");
  for (const char* const channel : {"0", "1", "2"})
    put(kSecond, std::string("in_voltage") + channel + "_oversampling_ratio", "1");
  config_.channels = {{"ad7606-8", "voltage0"}, {"ad7606-4", "voltage0"}, {"ad7606-4", "voltage2"}};
  config_.oversampling = 8;
  const IioInput input(config_);
  EXPECT_EQ(text(kAdc, "oversampling_ratio"), "8");
  EXPECT_EQ(text(kSecond, "in_voltage0_oversampling_ratio"), "8");
  EXPECT_EQ(text(kSecond, "in_voltage1_oversampling_ratio"), "1") << "nobody uses it";
  EXPECT_EQ(text(kSecond, "in_voltage2_oversampling_ratio"), "8");
}

TEST_F(IioInputTest, OversamplingThatNobodyAsksForIsLeftAsItIs) {
  put(kAdc, "oversampling_ratio", "4");
  const IioInput input(config_);
  EXPECT_EQ(text(kAdc, "oversampling_ratio"), "4");
}

TEST_F(IioInputTest, OversamplingThatTheDeviceDoesNotHaveIsNamedAndNothingIsSet) {
  config_.oversampling = 3;
  EXPECT_EQ(
      failure(),
      "iio:iio:device0: oversampling_ratio: no such attribute, expected a converter that averages, or no "
      "key analog_input.oversampling");
  put(kAdc, "oversampling_ratio", "1");
  for (const char* const available :
       {"1 2 4 8 16 32 64", "[2 2 64]", "[4 1 64]", "[1 1 2]", "[1 0 64]", "", "["}) {
    put(kAdc, "oversampling_ratio_available", available);
    EXPECT_EQ(failure(), std::string("iio:iio:device0: oversampling_ratio: 3, expected one of ") + available);
    EXPECT_EQ(text(kAdc, "oversampling_ratio"), "1");
    EXPECT_EQ(text(kAdc, "sampling_frequency"), "50");
  }
  put(kAdc, "oversampling_ratio_available", "[1 2 63]");
  EXPECT_EQ(failure(), "no failure");
  EXPECT_EQ(text(kAdc, "oversampling_ratio"), "3");
}

TEST_F(IioInputTest, OversamplingThatTheDeviceMakesAnotherOfIsNamed) {
  // An attribute of the real kernel that takes a number, and reads as another.
  std::filesystem::create_symlink("/proc/self/coredump_filter", folder(kAdc) / "oversampling_ratio");
  config_.oversampling = 64;
  EXPECT_EQ(failure(),
            "iio:iio:device0: oversampling_ratio: the device made 40 of 64, expected a ratio that it has")
      << "the kernel writes it in hexadecimal, without a sign of that";
}

TEST_F(IioInputTest, WhatIsMissingIsNamed) {
  config_.channels = {{"ad7606-4", "voltage0"}};
  EXPECT_EQ(failure(), "iio:ad7606-4: no such device, expected one of iio:device0 (ad7606-8)");
  config_.channels = {{"ad7606-8", "voltage9"}};
  EXPECT_EQ(failure(), "iio:ad7606-8 voltage9: no such input, expected one of voltage0, voltage1, voltage2");
  config_.channels = {{"ad7606-8", "voltage0"}, {kAdc, "voltage0"}};
  EXPECT_EQ(failure(), "iio:iio:device0 voltage0: given twice, expected one channel an input");
  config_.channels = {{"ad7606-8", "voltage0"}};
  config_.trigger = "plenum-adc";
  EXPECT_EQ(failure(), "iio:plenum-adc: no such trigger, expected one, but there is none");
  add_trigger();
  config_.trigger = kAdc;
  EXPECT_EQ(failure(), "iio:iio:device0: no such trigger, expected one of trigger0 (plenum-adc)");
}

TEST_F(IioInputTest, AChannelThatCannotBeCapturedIsNamed) {
  put(kAdc, "in_voltage5_raw", "0");
  config_.channels[0].channel = "voltage5";
  EXPECT_EQ(failure(),
            "iio:ad7606-8 voltage5: no part of the device's scans, expected a channel that can be captured");
}

TEST_F(IioInputTest, ASampleOfAnotherFormIsNamed) {
  put(kAdc, "scan_elements/in_voltage0_type", "le:s64/64>>0");
  EXPECT_EQ(failure(),
            "iio:ad7606-8 voltage0: samples of le:s64/64>>0, expected one number in 8, 16 or 32 bits");
  put(kAdc, "scan_elements/in_voltage0_type", "le:s16/16X4>>0");
  EXPECT_EQ(failure(),
            "iio:ad7606-8 voltage0: samples of le:s16/16X4>>0, expected one number in 8, 16 or 32 bits");
}

TEST_F(IioInputTest, ATriggerThatIsNotAdmittedIsNamed) {
  add_trigger();
  remove(kAdc, "trigger");
  config_.trigger = "plenum-adc";
  EXPECT_THAT(failure(), HasSubstr("iio:iio:device0: trigger plenum-adc: No such file or directory"));
}

TEST_F(IioInputTest, ADeviceThatCannotBeOpenedIsNamedAndLeftAsItIs) {
  std::filesystem::remove("/dev/" + kAdc);
  put(kAdc, "buffer/enable", "1");  // as another program's capture has it
  EXPECT_THAT(failure(), HasSubstr("iio:iio:device0: capture: No such file or directory"));
  EXPECT_EQ(text(kAdc, "buffer/enable"), "1");
  EXPECT_EQ(text(kAdc, "sampling_frequency"), "50");
}

TEST_F(IioInputTest, AReadingWhoseSamplesAllStandAtTheMostThatTheConverterCanTellIsAtItsEnd) {
  struct Form {
    const char* type;
    Bytes most, below;
  };
  const std::vector<Form> forms{{"be:s16/16>>0", {0x7F, 0xFF}, {0x7F, 0xFE}},
                                {"be:u16/16>>0", {0xFF, 0xFF}, {0xFF, 0xFE}},
                                {"be:s12/16>>4", {0x7F, 0xFF}, {0x7F, 0xEF}},
                                {"be:u32/32>>0", {0xFF, 0xFF, 0xFF, 0xFF}, {0xFF, 0xFF, 0xFF, 0xFE}}};
  for (const Form& form : forms) {
    put(kAdc, "scan_elements/in_voltage0_type", form.type);
    IioInput input(config_);
    const auto at_end = [&](std::vector<Bytes> samples) {
      for (const Bytes& one : samples) bring(kAdc, one);
      const ports::AnalogReading reading = read(input, 1).front();
      EXPECT_TRUE(reading.fresh);
      return reading.at_end;
    };
    EXPECT_TRUE(at_end({form.most, form.most, form.most})) << form.type;
    EXPECT_FALSE(at_end({form.most, form.below, form.most})) << form.type;
    EXPECT_FALSE(at_end({form.below})) << form.type;
  }
}

TEST_F(IioInputTest, TheEndOfARangeIsThatOfItsHighestNumber) {
  put(kAdc, "in_voltage_scale", "0.152588");  // 5 V, what an AD7606 begins with
  EXPECT_NEAR(IioInput(config_).end_V(0), 32767 * 0.152588e-3, 1e-9);
}

TEST_F(IioInputTest, AScaleIsSetAsTheKernelWritesItAndItsRangeIsThatOfTheReadings) {
  put(kAdc, "in_voltage_scale", "0.152588");
  put(kAdc, "in_voltage_scale_available", "0.152588 0.305176");
  config_.scale_mV = 0.30517578125;
  IioInput input(config_);
  EXPECT_EQ(text(kAdc, "in_voltage_scale"), "0.305176");
  bring(kAdc, {0x40, 0x00});
  EXPECT_FLOAT_EQ(volts(input), 16384 * 0.305176e-3F);
}

// as the kernel has an AD7606B in its software mode
TEST_F(IioInputTest, ChannelsOfTheirOwnScaleMayShareTheListOfThoseThatThereAre) {
  put(kAdc, "in_voltage0_scale", "0.152588");
  put(kAdc, "in_voltage_scale_available", "0.152588 0.305176");
  config_.scale_mV = 0.305176;
  EXPECT_EQ(failure(), "no failure");
  EXPECT_EQ(text(kAdc, "in_voltage0_scale"), "0.305176");
  EXPECT_EQ(text(kAdc, "in_voltage_scale"), "1000") << "no channel in use has that one";
}

TEST_F(IioInputTest, AScaleThatTheDeviceHasNotIsRefusedAndNothingIsCaptured) {
  config_.scale_mV = 0.2;
  EXPECT_THAT(failure(), HasSubstr("scale: no scale_available"));
  put(kAdc, "in_voltage_scale_available", "0.152588 0.305176");
  EXPECT_THAT(failure(), AllOf(HasSubstr("scale: 0.2"), HasSubstr("one of 0.152588 0.305176")));
  EXPECT_EQ(text(kAdc, "in_voltage_scale"), "1000");
}

}  // namespace
}  // namespace plenum::board::drivers
