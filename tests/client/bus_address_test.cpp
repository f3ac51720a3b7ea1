#include "host-sim/client/bus_address.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace plenum::host::client {
namespace {

using ::testing::HasSubstr;

SocketcandAddress socketcand(const char* text) {
  return std::get<SocketcandAddress>(parse_bus(text));
}

std::string refusal(const char* text) {
  try {
    parse_bus(text);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "not refused";
}

TEST(BusAddress, NamesHostPortAndChannel) {
  const SocketcandAddress address = socketcand("socketcand:127.0.0.1:29537/can1");
  EXPECT_EQ(address.host, "127.0.0.1");
  EXPECT_EQ(address.port, 29537);
  EXPECT_EQ(address.channel, "can1");
}

TEST(BusAddress, ThePortIs29536WhereNoneIsNamed) {
  EXPECT_EQ(socketcand("socketcand:rig.local/can0").port, 29536);
  EXPECT_EQ(socketcand("socketcand:[::1]/can0").port, 29536);
}

TEST(BusAddress, ASerialAdapterHasTheRateOfABoardUnlessOneIsNamed) {
  EXPECT_EQ(std::get<SlcanAddress>(parse_bus("slcan:/dev/ttyUSB0")).bit_rate, 1'000'000U);
  EXPECT_EQ(std::get<SlcanAddress>(parse_bus("slcan:/dev/by@id@250000")).device, "/dev/by@id");
  EXPECT_EQ(std::get<CanAddress>(parse_bus("can:vcan1")).interface, "vcan1");
}

TEST(BusAddress, AnIpv6AddressStandsInBrackets) {
  const SocketcandAddress address = socketcand("socketcand:[fe80::1]:80/can0");
  EXPECT_EQ(address.host, "fe80::1");
  EXPECT_EQ(address.port, 80);
}

TEST(BusAddress, IsWrittenAsItIsRead) {
  EXPECT_TRUE(std::holds_alternative<InprocAddress>(parse_bus("inproc")));
  for (const char* text : {"inproc", "socketcand:127.0.0.1:29536/can0", "socketcand:[::1]:1/c", "can:can0",
                           "slcan:/dev/ttyACM0@500000"}) {
    EXPECT_EQ(format_bus(parse_bus(text)), text);
  }
}

TEST(BusAddress, ARefusalSaysWhatAndWhereAndWhatWasExpected) {
  EXPECT_EQ(refusal("vcan0"), "--bus vcan0: no such bus, expected inproc, " + std::string(kOutsideForms));
  EXPECT_EQ(refusal("socketcand:localhost:29536"),
            "--bus socketcand:localhost:29536: no channel, expected socketcand:HOST:PORT/CHANNEL, as in "
            "socketcand:127.0.0.1:29536/can0");
  EXPECT_THAT(refusal("can:"), HasSubstr("no interface, expected can:IFACE"));
  EXPECT_THAT(refusal("slcan:"), HasSubstr("no terminal, expected slcan:TTY"));
  EXPECT_THAT(refusal("slcan:/dev/ttyACM0@83333"), HasSubstr("'83333' is no bit rate"));
  EXPECT_THAT(refusal("slcan:/dev/ttyACM0@"), HasSubstr("'' is no bit rate"));
  EXPECT_THAT(refusal("socketcand:localhost:65536/can0"), HasSubstr("'65536' is no port"));
  EXPECT_THAT(refusal("socketcand:localhost:/can0"), HasSubstr("'' is no port"));
  EXPECT_THAT(refusal("socketcand:localhost:1x/can0"), HasSubstr("'1x' is no port"));
  EXPECT_THAT(refusal("socketcand::29536/can0"), HasSubstr("no host"));
  EXPECT_THAT(refusal("socketcand:[::1/can0"), HasSubstr("'[' without ']'"));
  EXPECT_THAT(refusal("socketcand:localhost/"), HasSubstr("'' is no channel"));
  EXPECT_THAT(refusal("socketcand:localhost/can 0"), HasSubstr("'can 0' is no channel"));
  EXPECT_THAT(refusal("socketcand:localhost/can0><"), HasSubstr("is no channel"));
  EXPECT_THAT(refusal("socketcand:localhost/12345678901234567"), HasSubstr("1 to 16 characters"));
}

TEST(BusAddress, ABusInsideAnotherProgramCannotBeOpened) {
  EXPECT_THROW(open_link(InprocAddress{}), std::invalid_argument);
}

}  // namespace
}  // namespace plenum::host::client
