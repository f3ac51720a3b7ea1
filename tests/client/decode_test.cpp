// Frames written by hand from CiA 301, and the words they must become.
#include "host-sim/client/decode.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware/safety/faults.hpp"
#include "host-sim/client/emergency_text.hpp"

namespace plenum::host::client {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

class Decode : public ::testing::Test {
 protected:
  Decoded decode(std::uint32_t id, std::vector<std::uint8_t> bytes) {
    CanFrame frame{.id = id, .length = static_cast<std::uint8_t>(bytes.size())};
    std::copy(bytes.begin(), bytes.end(), frame.data.begin());
    return decoder_.decode(frame);
  }
  std::string text(std::uint32_t id, std::vector<std::uint8_t> bytes) {
    return decode(id, std::move(bytes)).text;
  }

  Decoder decoder_;
};

TEST_F(Decode, NetworkManagementSyncAndHeartbeats) {
  EXPECT_EQ(text(0x000, {0x01, 0x00}), "start all nodes");
  EXPECT_EQ(text(0x000, {0x81, 0x05}), "reset node");
  EXPECT_EQ(decode(0x000, {0x80, 0x05}).node, 5U);
  EXPECT_EQ(decode(0x080, {}).kind, "SYNC");
  EXPECT_EQ(text(0x080, {0x07}), "counter 7");
  EXPECT_EQ(text(0x705, {0x00}), "boot-up");
  EXPECT_EQ(text(0x705, {0x05}), "operational");
  EXPECT_EQ(decode(0x705, {0x7F}).node, 5U);
}

// The numbers of CiA 305.
TEST_F(Decode, LayerSettingServicesHaveWords) {
  EXPECT_EQ(decode(0x7E5, {0x04, 1, 0, 0, 0, 0, 0, 0}).kind, "LSS");
  EXPECT_EQ(text(0x7E5, {0x04, 0, 0, 0, 0, 0, 0, 0}), "switch all to waiting");
  EXPECT_EQ(text(0x7E5, {0x04, 1, 0, 0, 0, 0, 0, 0}), "switch all to configuration");
  EXPECT_EQ(text(0x7E5, {0x43, 0x78, 0x56, 0x34, 0x12, 0, 0, 0}),
            "switch to configuration serial number 12345678h");
  EXPECT_EQ(text(0x7E4, {0x44, 0, 0, 0, 0, 0, 0, 0}), "switched to configuration");
  EXPECT_EQ(text(0x7E5, {0x11, 9, 0, 0, 0, 0, 0, 0}), "configure node id 9");
  EXPECT_EQ(text(0x7E4, {0x11, 0, 0, 0, 0, 0, 0, 0}), "configure node id: done");
  EXPECT_EQ(text(0x7E5, {0x13, 0, 2, 0, 0, 0, 0, 0}), "configure bit timing, table 0, row 2");
  EXPECT_EQ(text(0x7E4, {0x13, 1, 0, 0, 0, 0, 0, 0}), "configure bit timing: refused, error 1");
  EXPECT_EQ(text(0x7E5, {0x15, 0xE8, 0x03, 0, 0, 0, 0, 0}), "activate bit timing in 1000 ms");
  EXPECT_EQ(text(0x7E4, {0x17, 2, 0, 0, 0, 0, 0, 0}), "store configuration: refused, error 2");
  EXPECT_EQ(text(0x7E5, {0x4B, 1, 0, 0, 0, 0, 0, 0}), "identify serial number to 00000001h");
  EXPECT_EQ(text(0x7E5, {0x51, 1, 0, 0, 0, 31, 0, 0}), "fastscan 00000001h, bit 31, number 0, next 0");
  EXPECT_EQ(text(0x7E4, {0x5E, 5, 0, 0, 0, 0, 0, 0}), "node id 5");
  EXPECT_EQ(text(0x7E4, {0x61, 5, 0, 0, 0, 0, 0, 0}), "unknown service 61h");
  EXPECT_EQ(decode(0x7E5, {0x04}).kind, "other") << "LSS has eight bytes";
}

TEST_F(Decode, EmergenciesHaveTheWordsOfTheirCodeAndChamber) {
  const Decoded decoded = decode(0x085, {0x50, 0x82, 0x11, 0, 0, 0, 0, 0});
  EXPECT_EQ(decoded.kind, "EMCY");
  EXPECT_EQ(decoded.node, 5U);
  EXPECT_EQ(decoded.text, "8250h set-point timeout, error register 11h");
  EXPECT_EQ(text(0x085, {0x05, 0xFF, 0x81, 3, 0, 0, 0, 0}),
            "FF05h pressure sensor out of range, chamber 3, error register 81h");
  EXPECT_EQ(text(0x085, {0x30, 0x81, 0x11, 0, 11, 0, 0, 0}),
            "8130h heartbeat lost, of node 11, error register 11h");
  EXPECT_EQ(text(0x085, {0, 0, 0, 0, 0, 0, 0, 0}), "0000h no error, error register 00h");
  EXPECT_EQ(text(0x085, {0x10, 0x42, 0x09, 0, 0, 0, 0, 0}), "4210h temperature, error register 09h");
}

TEST_F(Decode, EveryFaultOfTheFirmwareHasWordsOfItsOwn) {
  for (const safety::FaultSpec& fault : safety::fault_table()) {
    EXPECT_THAT(emergency_text(fault.code), HasSubstr(fault.name));
  }
}

TEST_F(Decode, PdosHaveTheNamesOfTheDefaultMappingAndPascals) {
  // 1013 mbar, -1 mbar, 7000 mbar, 0
  const Decoded decoded = decode(0x181, {0xF5, 0x03, 0xFF, 0xFF, 0x58, 0x1B, 0, 0});
  EXPECT_EQ(decoded.kind, "TPDO1");
  EXPECT_EQ(decoded.node, 1U);
  ASSERT_EQ(decoded.values.size(), 4U);
  EXPECT_EQ(decoded.values[0].value, 101300.0);
  EXPECT_EQ(decoded.values[1].value, -100.0);
  EXPECT_EQ(decoded.values[2].value, 700000.0);
  EXPECT_EQ(decoded.values[0].unit, "Pa");
  EXPECT_THAT(decoded.values[3].name, HasSubstr("chamber 4"));
  EXPECT_THAT(text(0x301, {0xE8, 0x03, 0, 0, 0, 0, 0, 0}), HasSubstr("chamber 5 = 100000 Pa"));
  EXPECT_THAT(text(0x401, {0x07, 0x00}), HasSubstr("= 7"));
  EXPECT_THAT(text(0x381, {0x0F, 0x00}), HasSubstr("= 15"));
}

TEST_F(Decode, APdoThatIsNotAsMappedIsShownInBytes) {
  EXPECT_EQ(text(0x181, {0xF5, 0x03}), "F5 03 (not mapped so, as far as is known)");
  EXPECT_EQ(text(0x481, {1, 2}), "01 02 (not mapped so, as far as is known)");
}

// TPDO1 of node 1 becomes 2210h:3 (REAL32, V) and 6381h:1 of chamber 2, sent as 1C5h
TEST_F(Decode, FollowsTheSdoThatRemapsAPdo) {
  decode(0x601, {0x2F, 0x00, 0x1A, 0, 0, 0, 0, 0});
  decode(0x581, {0x60, 0x00, 0x1A, 0, 0, 0, 0, 0});
  decode(0x601, {0x23, 0x00, 0x1A, 1, 0x20, 0x03, 0x10, 0x22});
  decode(0x581, {0x60, 0x00, 0x1A, 1, 0, 0, 0, 0});
  decode(0x601, {0x23, 0x00, 0x1A, 2, 0x10, 0x01, 0x81, 0x6B});
  decode(0x581, {0x60, 0x00, 0x1A, 2, 0, 0, 0, 0});
  decode(0x601, {0x2F, 0x00, 0x1A, 0, 2, 0, 0, 0});
  decode(0x581, {0x60, 0x00, 0x1A, 0, 0, 0, 0, 0});
  decode(0x601, {0x23, 0x00, 0x18, 1, 0xC5, 0x01, 0, 0x40});
  decode(0x581, {0x60, 0x00, 0x18, 1, 0, 0, 0, 0});
  const Decoded decoded = decode(0x1C5, {0x00, 0x00, 0xA0, 0x40, 0xE8, 0x03});  // 5.0 V, 1000 mbar
  EXPECT_EQ(decoded.kind, "TPDO1");
  EXPECT_EQ(decoded.node, 1U) << "whatever the identifier says";
  ASSERT_EQ(decoded.values.size(), 2U);
  EXPECT_EQ(decoded.values[0].value, 5.0);
  EXPECT_EQ(decoded.values[0].unit, "V");
  EXPECT_THAT(decoded.values[0].name, HasSubstr("chamber 1"));
  EXPECT_EQ(decoded.values[1].value, 100'000.0);
  EXPECT_THAT(decoded.values[1].name, HasSubstr("chamber 2"));
  EXPECT_THAT(text(0x182, {0xE8, 0x03, 0, 0, 0, 0, 0, 0}), HasSubstr("chamber 1 = 100000 Pa"))
      << "another board has its own";
}

TEST_F(Decode, ARemappingThatTheBoardRefusesIsNone) {
  decode(0x601, {0x2F, 0x02, 0x1A, 0, 0, 0, 0, 0});
  decode(0x581, {0x80, 0x02, 0x1A, 0, 0x22, 0, 0, 0x08});
  EXPECT_THAT(text(0x381, {0x0F, 0x00}), HasSubstr("= 15"));
}

TEST_F(Decode, TheAnswersToAMasterThatReadsTellTheMapping) {
  decode(0x601, {0x40, 0x02, 0x1A, 1, 0, 0, 0, 0});
  decode(0x581, {0x43, 0x02, 0x1A, 1, 0x10, 0x00, 0x4E, 0x60});  // 604Eh, error code
  const Decoded decoded = decode(0x381, {0x50, 0x82});
  ASSERT_EQ(decoded.values.size(), 1U);
  EXPECT_EQ(decoded.values[0].value, 0x8250);
  EXPECT_THAT(decoded.values[0].name, HasSubstr("Error code"));
}

// A segment of a block that the board sends begins with its number: 43h is no answer to anything.
TEST_F(Decode, SegmentsOfABlockTellNoMapping) {
  decode(0x601, {0xA4, 0x18, 0x21, 0, 0x7F, 0, 0, 0});
  decode(0x581, {0xC6, 0x18, 0x21, 0, 0xFF, 1, 0, 0});
  decode(0x601, {0xA3, 0, 0, 0, 0, 0, 0, 0});
  decode(0x581, {0x43, 0x02, 0x1A, 1, 0x10, 0x00, 0x4E, 0x60});
  EXPECT_THAT(decode(0x381, {0x0F, 0x00}).values.at(0).name, HasSubstr("Status word"));
}

TEST_F(Decode, ABoardThatBootsIsMappedAsItHasStored) {
  const auto map_error_code = [this] {
    decode(0x601, {0x23, 0x02, 0x1A, 1, 0x10, 0x00, 0x4E, 0x60});
    decode(0x581, {0x60, 0x02, 0x1A, 1, 0, 0, 0, 0});
  };
  const auto order = [this](std::uint8_t index, std::uint8_t sub) {
    decode(0x601, {0x23, index, 0x10, sub, 's', 'a', 'v', 'e'});
    decode(0x581, {0x60, index, 0x10, sub, 0, 0, 0, 0});
  };
  const auto carries = [this] { return decode(0x381, {0x0F, 0x00}).values.at(0).name; };
  map_error_code();
  EXPECT_EQ(carries(), "Error code");
  decode(0x701, {0x00});
  EXPECT_EQ(carries(), "Status word") << "nothing was stored";
  map_error_code();
  order(0x10, 2);  // 1010h:2
  decode(0x701, {0x00});
  EXPECT_EQ(carries(), "Error code");
  order(0x11, 1);  // 1011h:1
  EXPECT_EQ(carries(), "Error code") << "until the reset";
  decode(0x701, {0x00});
  EXPECT_EQ(carries(), "Status word");
}

TEST_F(Decode, AnArrayWithAValueAChamberNamesTheChamber) {
  decode(0x601, {0x23, 0x02, 0x1A, 1, 0x08, 0x06, 0x30, 0x22});  // 2230h:6, UNSIGNED8
  decode(0x581, {0x60, 0x02, 0x1A, 1, 0, 0, 0, 0});
  EXPECT_THAT(decode(0x381, {0x04}).values.at(0).name, HasSubstr(", 6"));
}

TEST_F(Decode, TheCaptureStreamIsInSiUnits) {
  // 100000 Pa = 47C35000h; 7FFFh of 65535 is 4.99992 V
  const Decoded decoded = decode(0x682, {0x00, 0x50, 0xC3, 0x47, 0xFF, 0x7F, 0x10, 0x27});
  EXPECT_EQ(decoded.kind, "stream");
  EXPECT_EQ(decoded.values[0].value, 100000.0);
  EXPECT_DOUBLE_EQ(decoded.values[1].value, 10.0 / 65535.0 * 0x7FFF);
  EXPECT_EQ(decoded.values[2].value, 10000.0);
  EXPECT_THAT(decoded.text, HasSubstr("actual pressure, chamber 3 = 100000 Pa"));
  EXPECT_THAT(text(0x6DF, {0x00, 0x50, 0xC3, 0x47, 0xFF, 0x7F, 0x10, 0x27}),
              HasSubstr("actual pressure, chamber 8 = 100000 Pa"))
      << "of the last block";
  EXPECT_EQ(decode(0x6E0, {0x00, 0x50, 0xC3, 0x47, 0xFF, 0x7F, 0x10, 0x27}).kind, "other");
}

TEST_F(Decode, ExpeditedTransfersNameTheirObjectAndSayItsValue) {
  EXPECT_THAT(text(0x601, {0x40, 0x41, 0x60, 0, 0, 0, 0, 0}), StartsWith("read 6041h:0 "));
  EXPECT_THAT(text(0x581, {0x4B, 0x41, 0x60, 0, 0x09, 0x00, 0, 0}), ::testing::EndsWith(" = 9 (09 00)"));
  // 6394h of chamber 2 is 6B94h; FF 9C is -100 in 16 bits
  EXPECT_THAT(text(0x601, {0x2B, 0x94, 0x6B, 1, 0x9C, 0xFF, 0, 0}), HasSubstr("chamber 2 = -100 (9C FF)"));
  EXPECT_THAT(text(0x581, {0x60, 0x94, 0x6B, 1, 0, 0, 0, 0}), StartsWith("written 6B94h:1 "));
}

TEST_F(Decode, AbortsHaveTheirWords) {
  EXPECT_THAT(text(0x581, {0x80, 0xFF, 0x5F, 0, 0, 0, 0x02, 0x06}), StartsWith("abort 5FFFh:0: 06020000h, "));
}

TEST_F(Decode, SegmentsNameTheObjectOfTheirTransfer) {
  EXPECT_THAT(text(0x601, {0x40, 0x08, 0x10, 0, 0, 0, 0, 0}), StartsWith("read 1008h:0 "));
  EXPECT_THAT(text(0x581, {0x41, 0x08, 0x10, 0, 9, 0, 0, 0}), HasSubstr(", 9 bytes in segments"));
  EXPECT_THAT(text(0x601, {0x60, 0, 0, 0, 0, 0, 0, 0}), StartsWith("next segment of 1008h:0"));
  EXPECT_THAT(text(0x581, {0x00, 'P', 'l', 'e', 'n', 'u', 'm', ' '}), HasSubstr("1008h:0"));
  // the last segment: toggled, five bytes unused, no more
  EXPECT_THAT(text(0x581, {0x1B, 'x', 'y', 0, 0, 0, 0, 0}), ::testing::EndsWith(": 78 79"));
  // another node's transfer is not mixed with this one's
  EXPECT_THAT(text(0x602, {0x40, 0x09, 0x10, 0, 0, 0, 0, 0}), StartsWith("read 1009h:0 "));
  EXPECT_THAT(text(0x601, {0x70, 0, 0, 0, 0, 0, 0, 0}), StartsWith("next segment of 1008h:0"));
}

TEST_F(Decode, SegmentsOfABlockAreNoCommands) {
  EXPECT_THAT(text(0x601, {0xA4, 0x18, 0x21, 0, 0x7F, 0, 0, 0}), StartsWith("read in blocks 2118h:0 "));
  EXPECT_THAT(text(0x581, {0xC6, 0x18, 0x21, 0, 14, 0, 0, 0}), HasSubstr(", 14 bytes"));
  EXPECT_THAT(text(0x601, {0xA3, 0, 0, 0, 0, 0, 0, 0}), StartsWith("begin the blocks of 2118h:0"));
  EXPECT_THAT(text(0x581, {0x01, 1, 2, 3, 4, 5, 6, 7}), StartsWith("block segment of 2118h:0"));
  EXPECT_THAT(text(0x581, {0x82, 8, 9, 10, 11, 12, 13, 14}), StartsWith("block segment of 2118h:0"));
  EXPECT_THAT(text(0x601, {0xA2, 2, 0x7F, 0, 0, 0, 0, 0}), HasSubstr("taken up to segment 2"));
  EXPECT_THAT(text(0x581, {0xC1, 0x34, 0x12, 0, 0, 0, 0, 0}), StartsWith("end of the blocks of 2118h:0"));
  EXPECT_THAT(text(0x601, {0xA1, 0, 0, 0, 0, 0, 0, 0}), StartsWith("end of the blocks of 2118h:0"));
}

TEST_F(Decode, ABlockWhoseLastSegmentWasNotTakenGoesOn) {
  decode(0x601, {0xC6, 0x10, 0x21, 0, 20, 0, 0, 0});
  decode(0x581, {0xA4, 0x10, 0x21, 0, 127, 0, 0, 0});
  decode(0x601, {0x01, 1, 2, 3, 4, 5, 6, 7});
  decode(0x601, {0x83, 15, 16, 17, 18, 19, 20, 0});
  EXPECT_THAT(text(0x581, {0xA2, 1, 127, 0, 0, 0, 0, 0}), HasSubstr("taken up to segment 1"));
  EXPECT_THAT(text(0x601, {0x01, 8, 9, 10, 11, 12, 13, 14}), StartsWith("block segment of 2110h:0"));
  EXPECT_THAT(text(0x601, {0x82, 15, 16, 17, 18, 19, 20, 0}), StartsWith("block segment of 2110h:0"));
  EXPECT_THAT(text(0x581, {0xA2, 2, 127, 0, 0, 0, 0, 0}), HasSubstr("taken up to segment 2"));
  EXPECT_THAT(text(0x601, {0xC5, 0x34, 0x12, 0, 0, 0, 0, 0}), StartsWith("end of the blocks of 2110h:0"));
  EXPECT_THAT(text(0x581, {0xA1, 0, 0, 0, 0, 0, 0, 0}), StartsWith("blocks of 2110h:0 "));
}

TEST_F(Decode, ABlockThatIsAbortedIsOver) {
  decode(0x601, {0xC6, 0x10, 0x21, 0, 100, 0, 0, 0});
  EXPECT_THAT(text(0x581, {0xA4, 0x10, 0x21, 0, 127, 0, 0, 0}), StartsWith("ready for blocks of 2110h:0"));
  EXPECT_THAT(text(0x601, {0x01, 1, 2, 3, 4, 5, 6, 7}), StartsWith("block segment of 2110h:0"));
  EXPECT_THAT(text(0x601, {0x80, 0x10, 0x21, 0, 0, 0, 0x04, 0x05}), StartsWith("abort 2110h:0"));
  EXPECT_THAT(text(0x601, {0x40, 0x00, 0x10, 0, 0, 0, 0, 0}), StartsWith("read 1000h:0"));
}

TEST_F(Decode, WhatIsNoCanopenIsOther) {
  EXPECT_EQ(decode(0x7FF, {1}).kind, "other");
  EXPECT_EQ(decode(0x581, {0x40}).kind, "other");
  EXPECT_EQ(decoder_.decode({.id = 0x701, .remote = true}).kind, "other");
  EXPECT_EQ(decoder_.decode({.id = 0x181, .length = 8, .extended = true}).kind, "other");
}

}  // namespace
}  // namespace plenum::host::client
