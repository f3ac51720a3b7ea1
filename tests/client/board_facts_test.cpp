// What a board says of itself, who is on a bus, and settings read and written, against the real node on the simulated bus.
#include "host-sim/client/board_facts.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <limits>
#include <string>
#include <vector>

#include "host-sim/client/references.hpp"
#include "host-sim/client/scan.hpp"
#include "host-sim/client/settings.hpp"
#include "tests/client/board_on_bus.hpp"
#include "tests/client/scripted_link.hpp"
#include "tests/firmware/config/tassa9_sample.hpp"

namespace plenum::host::client {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
namespace object = canopen::object;

// ---- versions ----

/// Answers the reads that require_compatible() makes, with the given type, schema hash and count.
std::string refusal_of(std::uint32_t type, std::uint32_t hash, std::uint16_t count, std::uint8_t format) {
  const auto bytes = [](std::uint32_t value) {
    return fmt::format("{:02X} {:02X} {:02X} {:02X}", value & 0xFFU, value >> 8U & 0xFFU,
                       value >> 16U & 0xFFU, value >> 24U);
  };
  std::deque<std::string> script{"585 43 00 10 00 " + bytes(type)};
  for (int sub = 1; sub <= 4; ++sub) script.push_back(fmt::format("585 43 18 10 {:02X} 07 00 00 00", sub));
  for (const char* text :
       {"585 43 08 10 00 42 6F 61 72", "585 43 09 10 00 41 20 20 20", "585 43 0A 10 00 31 2E 30 20"})
    script.emplace_back(text);
  script.push_back("585 43 00 21 01 " + bytes(hash));
  script.push_back(fmt::format("585 4B 00 21 02 {:02X} {:02X} 00 00", count & 0xFFU, count >> 8U));
  script.push_back(fmt::format("585 4F 00 21 03 {:02X} 00 00 00", format));
  ScriptedLink link(script);
  Session session(link, 5);
  try {
    require_compatible(session);
  } catch (const Refused& refusal) {
    return refusal.what();
  }
  return "";
}

TEST(Compatible, IsAFirmwareWithTheSchemaOfThisProgram) {
  const std::uint32_t type = canopen::kDeviceType;
  EXPECT_EQ(refusal_of(type, own_schema_hash(), 12, 1), "");
  EXPECT_EQ(refusal_of(type, own_schema_hash(), 12, 2), "") << "fixed point takes the same images";
  EXPECT_THAT(refusal_of(0x00020192, own_schema_hash(), 12, 1),
              AllOf(HasSubstr("node 5"), HasSubstr("00020192h")));
  EXPECT_THAT(refusal_of(type, 0x12345678, 12, 1),
              AllOf(HasSubstr("firmware 1.0"), HasSubstr("12345678h"), HasSubstr("expected")));
  EXPECT_THAT(refusal_of(type, own_schema_hash(), 13, 1), HasSubstr("13 parameters"));
  EXPECT_THAT(refusal_of(type, own_schema_hash(), 12, 3), HasSubstr("format 3"));
  BoardOnBus world;
  Session session(world, 5);
  EXPECT_NO_THROW(require_compatible(session));
}

// ---- words ----

TEST(StateName, IsThatOfTheTableOfCia408) {
  EXPECT_STREQ(state_name(0x0, 0), "NOT_READY");
  EXPECT_STREQ(state_name(0x8, 0), "INIT");
  EXPECT_STREQ(state_name(0x9, 0), "DISABLED");
  EXPECT_STREQ(state_name(0xB, 0), "HOLD");
  EXPECT_STREQ(state_name(0xF, 0), "ACTIVE");
  EXPECT_STREQ(state_name(0x7, 0x8250), "FAULT_REACTION");
  EXPECT_STREQ(state_name(0x3, 0x8250), "FAULT_HOLD");
  EXPECT_STREQ(state_name(0x1, 0x8250), "FAULT_DISABLED");
  EXPECT_STREQ(state_name(0x0, 0x8250), "FAULT_INIT");
  for (const std::uint16_t at_rest : std::initializer_list<std::uint16_t>{0x0, 0x1, 0x8, 0x9})
    EXPECT_FALSE(is_regulating(at_rest)) << at_rest;
  for (const std::uint16_t at_work : std::initializer_list<std::uint16_t>{0x3, 0x7, 0xB, 0xF})
    EXPECT_TRUE(is_regulating(at_work)) << at_work;
}

TEST(Faults, AreReadWithTheirChamberAndNamedFromTheFirmwaresTable) {
  BoardOnBus world;
  Session session(world, 5);
  EXPECT_FALSE(read_fault(session));
  EXPECT_THAT(read_fault_history(session), IsEmpty());
  world.image.error_code = 0x8302;
  world.image.fault_chamber = 3;
  world.run_ticks(2);
  const auto fault = read_fault(session);
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->code, 0x8302);
  EXPECT_EQ(fault->chamber, 3U);
  EXPECT_EQ(read_fault_history(session).size(), 1U);
  EXPECT_EQ(fault_name({0x8250, 0}), "set-point timeout");
  EXPECT_EQ(fault_text({0x6300, 2}), "6300h no valid model, chamber 2");
  EXPECT_THAT(fault_name({0x1234, 0}), HasSubstr("does not know"));
  // one code for three: of a chamber it is another fault than of the board
  EXPECT_EQ(fault_name({0x6300, 2}), "no valid model");
  EXPECT_EQ(fault_name({0x6300, 0}), "stored set damaged or stored set cannot be written");
  session.write<std::uint8_t>(object::kErrorHistoryIndex, 0, 0);
  EXPECT_FALSE(read_fault(session)->placed) << "the history that said which chamber is gone";
}

TEST(Faults, ThatStandTogetherAreReadByUrgencyOfABoardFirst) {
  using plenum::safety::Fault;
  using plenum::safety::only;
  BoardOnBus world;
  Session session(world, 5);
  EXPECT_THAT(read_standing_faults(session), IsEmpty());
  world.image.standing_faults[3] = only(Fault::over_pressure) | only(Fault::no_model);
  world.image.standing_faults[8] = only(Fault::no_model);
  world.image.standing_faults.front() = only(Fault::stored_set_lost) | only(Fault::emergency_stop);
  std::vector<std::string> texts;
  for (const FaultEntry& fault : read_standing_faults(session)) texts.push_back(fault_text(fault));
  EXPECT_THAT(texts, ElementsAre("9000h emergency stop", "8302h over-pressure, chamber 3",
                                 "6300h no valid model, chamber 3", "6300h no valid model, chamber 8",
                                 "6300h stored set damaged or stored set cannot be written"));
}

TEST(Faults, OfOneCodeAtTwoChambersTheMostUrgentIsTheFirst) {
  using plenum::safety::Fault;
  using plenum::safety::only;
  BoardOnBus world;
  Session session(world, 5);
  world.image.standing_faults[6] = world.image.standing_faults[8] = only(Fault::no_model);
  world.image.error_code = 0x6300;
  world.image.fault_chamber = 6;
  world.run_ticks(2);
  EXPECT_EQ(read_fault(session)->chamber, 6U);
}

TEST(Faults, OfABoardThatDoesNotTellWhichStandAreNone) {
  ScriptedLink link({"585 80 31 28 09 00 00 02 06"});
  Session session(link, 5);
  EXPECT_THAT(read_standing_faults(session), IsEmpty());
}

// CiA 301 asks for the vendor's id alone.
TEST(Identity, OfANodeThatStatesItsVendorOnlyIsThat) {
  ScriptedLink link({"585 43 18 10 01 34 12 00 00", "585 80 18 10 02 11 00 09 06",
                     "585 80 18 10 03 11 00 09 06", "585 80 18 10 04 11 00 09 06"});
  Session session(link, 5);
  const Identity identity = read_identity(session);
  EXPECT_EQ(identity.vendor_id, 0x1234U);
  EXPECT_EQ(identity.product_code, 0U);
  EXPECT_EQ(identity.serial, 0U);
}

// ---- scan ----

TEST(Scan, FindsTheBoardWithIdentityStateAndFault) {
  BoardOnBus world(77);
  world.image.error_code = 0x3412;
  const auto nodes = scan(world, 1.2);
  ASSERT_EQ(nodes.size(), 1U);
  EXPECT_EQ(nodes[0].node_id, 77);
  EXPECT_EQ(nodes[0].nmt, canopen::NmtState::pre_operational);
  EXPECT_EQ(nodes[0].device_type, canopen::kDeviceType);
  EXPECT_EQ(nodes[0].identity.vendor_id, 1U);
  EXPECT_EQ(nodes[0].identity.product_code, 2U);
  EXPECT_EQ(nodes[0].name, "Plenum valve board");
  ASSERT_TRUE(nodes[0].board);
  EXPECT_TRUE(nodes[0].board->compatible);
  EXPECT_EQ(nodes[0].board->models, 0U);
  ASSERT_TRUE(nodes[0].board->fault);
  EXPECT_EQ(nodes[0].board->fault->code, 0x3412);
  EXPECT_LT(world.now_s(), 1.5) << "one time-out, not 127";
}

/// What somebody says on the way to a board, and when.
class OverheardLink final : public Link {
 public:
  explicit OverheardLink(Link& link) : link_(link) {}
  void send(const CanFrame& frame) override {
    said.push_back({link_.now_s(), frame});
    link_.send(frame);
  }
  std::optional<CanFrame> receive(double timeout_s) override { return link_.receive(timeout_s); }
  double now_s() const override { return link_.now_s(); }

  /// How many requests for 1000h went to a node within the first `duration_s`.
  std::ptrdiff_t asked(std::uint8_t node, double duration_s) const {
    return std::count_if(said.begin(), said.end(), [&](const Arrival& one) {
      return one.time_s < duration_s && one.frame.id == canopen::cob::kSdoRequest + node;
    });
  }

  std::vector<Arrival> said;

 private:
  Link& link_;
};

TEST(Scan, ListensFirstAndAsksOneByOneWhomItHasNotHeard) {
  BoardOnBus world;
  world.run_ticks(150);  // past the boot-up message, to the middle between two heartbeats
  const double begin_s = world.now_s();
  OverheardLink link(world);
  ASSERT_EQ(scan(link, 1.2).size(), 1U);
  EXPECT_EQ(link.asked(5, begin_s + 1.2), 0) << "its heartbeat was enough";
  EXPECT_EQ(link.asked(6, begin_s + 1.2), 1);
  ASSERT_GT(link.said.size(), 126U);
  EXPECT_GT(link.said[0].time_s, begin_s + 0.75);
  for (std::size_t i = 1; i < 126; ++i)
    EXPECT_GT(link.said[i].time_s - link.said[i - 1].time_s, 0.002) << "request " << i;
}

TEST(Scan, AsksABoardThatHasNoHeartbeat) {
  BoardOnBus world;
  Session(world, 5).write<std::uint16_t>(object::kHeartbeatTime, 0, 0);
  world.run_ticks(10);
  while (world.receive(0.0)) {  // nobody was there to hear its boot-up message
  }
  OverheardLink link(world);
  const auto nodes = scan(link, 1.2);
  ASSERT_EQ(nodes.size(), 1U);
  EXPECT_FALSE(nodes[0].nmt);
  EXPECT_TRUE(nodes[0].board);
}

TEST(Scan, ShowsAStoppedNodeByItsHeartbeatAlone) {
  BoardOnBus world;
  Session session(world, 5);
  session.nmt(canopen::NmtCommand::stop);
  const auto nodes = scan(world, 1.2);
  ASSERT_EQ(nodes.size(), 1U);
  EXPECT_EQ(nodes[0].nmt, canopen::NmtState::stopped);
  EXPECT_FALSE(nodes[0].device_type);
  EXPECT_THAT(nodes[0].trouble, HasSubstr("no answer"));
}

TEST(Scan, FindsNobodyOnAnEmptyBus) {
  BoardOnBus world;
  world.deaf = true;
  EXPECT_THAT(scan(world, 0.5), IsEmpty());
  EXPECT_LT(world.now_s(), 0.6);
}

/// Nodes up to 127 that have no heartbeat, and tell their device type by SDO, on a bus of some bit rate.
class CrowdedBus final : public Link {
 public:
  CrowdedBus(std::uint32_t bit_rate, std::uint32_t first_node)
      : bus_(ports::SimulatedBus::Config{.bit_rate = bit_rate}), rate_(bit_rate), first_(first_node) {}
  void send(const CanFrame& frame) override {
    while (!pc_.send(frame)) advance(bus_.now_ns() + 1'000'000);
  }
  std::optional<CanFrame> receive(double timeout_s) override {
    const auto until_ns = bus_.now_ns() + static_cast<std::uint64_t>(std::llround(timeout_s * 1e9));
    CanFrame frame;
    while (!pc_.receive(frame)) {
      if (bus_.now_ns() >= until_ns) return std::nullopt;
      advance(until_ns);
    }
    return frame;
  }
  double now_s() const override { return bus_.now_s(); }
  std::optional<std::uint32_t> bit_rate() const override {
    return knows_ ? std::optional(rate_) : std::nullopt;
  }
  void know_no_bit_rate() { knows_ = false; }

 private:
  void advance(std::uint64_t until_ns) {
    bus_.run_to_next_delivery(until_ns);
    for (CanFrame frame; nodes_.receive(frame);) {
      const std::uint32_t id = frame.id - canopen::cob::kSdoRequest;
      if (id < first_ || id > 127 || frame.data[0] != 0x40) continue;
      const bool is_type = frame.data[1] == 0x00 && frame.data[2] == 0x10;
      CanFrame answer{.id = canopen::cob::kSdoResponse + id, .length = 8, .data = frame.data};
      answer.data[0] = is_type ? 0x43 : 0x80;
      canopen::store_le(is_type ? 0x0003'0191U : 0x0602'0000U, std::span(answer.data).subspan<4, 4>());
      answers_.push_back(answer);
    }
    while (!answers_.empty() && nodes_.send(answers_.front())) answers_.pop_front();
  }

  ports::SimulatedBus bus_;
  ports::SimulatedCanPort& pc_ = bus_.attach("pc");
  ports::SimulatedCanPort& nodes_ = bus_.attach("nodes");
  std::uint32_t rate_;
  std::uint32_t first_;
  bool knows_ = true;
  std::deque<CanFrame> answers_;
};

TEST(Scan, FindsAllNodesAlsoOfASlowBus) {
  for (const std::uint32_t bit_rate : {10'000U, 20'000U, 50'000U, 125'000U, 1'000'000U}) {
    for (const std::uint32_t first : {1U, 120U}) {
      CrowdedBus world(bit_rate, first);
      EXPECT_EQ(scan(world, 1.2).size(), 128 - first) << bit_rate << " bit/s";
    }
  }
}

TEST(Scan, TakesTheBitRateFromWhoKnowsItWhereTheLinkDoesNot) {
  CrowdedBus world(10'000, 120);
  world.know_no_bit_rate();
  EXPECT_EQ(scan(world, 1.2, {}, {}, 10'000).size(), 8U);
}

// ---- settings ----

std::uint32_t value_in(const std::vector<Setting>& settings, std::uint16_t index, std::uint8_t sub) {
  for (const Setting& setting : settings) {
    if (setting.id == SettingId{index, sub}) return setting.bits;
  }
  ADD_FAILURE() << "no setting " << index << ':' << int{sub};
  return 0;
}

TEST(Settings, OfOneBoardMakeAnotherTheSame) {
  BoardOnBus first;
  Session from(first, 5);
  from.configure_setpoints(SetpointFormat::pascal);
  from.configure_stream({.largest_volume_m3 = 1e-3});
  from.write<std::uint16_t>(object::kHeartbeatTime, 0, 250);
  from.write<std::uint32_t>(object::kEmergencyCobId, 0, 0x8000'0000U);
  from.write<std::uint32_t>(object::kEmergencyCobId, 0, 0x0FEU);
  const std::vector<Setting> wanted = read_settings(from);
  EXPECT_EQ(value_in(wanted, object::kHeartbeatTime, 0), 250U);
  BoardOnBus second;
  Session to(second, 5);
  EXPECT_THAT(write_settings(to, wanted), IsEmpty());
  const std::vector<Setting> got = read_settings(to);
  ASSERT_EQ(got.size(), wanted.size());
  for (std::size_t i = 0; i < got.size(); ++i) {
    EXPECT_EQ(got[i].bits, wanted[i].bits) << std::hex << got[i].id.index << ':' << int{got[i].id.sub};
  }
  EXPECT_THAT(write_settings(to, wanted), IsEmpty()) << "once more changes nothing";
}

// A node in two entries of 1016h is refused (CiA 301), also on the way from one order to the other.
TEST(Settings, SwapTheNodesThatAreListenedFor) {
  constexpr std::uint16_t kConsumer = 0x1016;
  BoardOnBus world;
  Session session(world, 5);
  session.write<std::uint32_t>(kConsumer, 1, 10U << 16 | 500);
  session.write<std::uint32_t>(kConsumer, 2, 11U << 16 | 700);
  const std::vector<Setting> wanted = read_settings(session);
  session.write<std::uint32_t>(kConsumer, 1, 0);
  session.write<std::uint32_t>(kConsumer, 2, 10U << 16 | 500);
  session.write<std::uint32_t>(kConsumer, 1, 11U << 16 | 700);
  EXPECT_THAT(write_settings(session, wanted), IsEmpty());
  EXPECT_EQ(session.read<std::uint32_t>(kConsumer, 1), 10U << 16 | 500);
}

TEST(Settings, ThatABoardRefusesAreNamedAndTheRestIsWritten) {
  BoardOnBus world;
  Session session(world, 5);
  std::vector<Setting> settings = read_settings(session);
  for (Setting& setting : settings) {
    if (setting.id == SettingId{object::kHeartbeatTime, 0}) setting.bits = 123;
    if (setting.id == SettingId{object::kSyncCobId, 0}) setting.bits = 0x4000'0080U;  // no SYNC producer
  }
  settings.push_back({{0x5000, 1}, canopen::DataType::unsigned8, "of another firmware", 1});
  const auto troubles = write_settings(session, settings);
  ASSERT_EQ(troubles.size(), 2U);
  EXPECT_EQ(troubles[0].setting.id.index, object::kSyncCobId);
  EXPECT_THAT(troubles[0].reason, HasSubstr("06090030h"));
  EXPECT_EQ(troubles[1].setting.id.index, 0x5000);
  EXPECT_EQ(session.read<std::uint16_t>(object::kHeartbeatTime, 0), 123);
}

/// What write_settings() says of a board on which one setting is to be another.
std::string reason_to_refuse(std::uint16_t index, const std::string& name, const SettingNumber& value) {
  BoardOnBus world;
  Session session(world, 5);
  std::vector<Setting> settings = read_settings(session);
  for (Setting& setting : settings) {
    if (setting.id.index == index && setting.name == name) setting.bits = bits_of(setting.type, value);
  }
  const auto troubles = write_settings(session, settings);
  EXPECT_EQ(troubles.size(), 1U);
  if (troubles.empty()) return {};
  EXPECT_EQ(troubles[0].setting.name, name);
  return troubles[0].reason;
}

TEST(Settings, ThatAreBeyondTheirRangeAreRefusedWithValueAndRange) {
  EXPECT_THAT(reason_to_refuse(object::kChamberSettings + 1, "pressure_low_kPa", 5000.0),
              EndsWith(": is 5000, expected 0 to 2000"));
  EXPECT_THAT(reason_to_refuse(object::kChamberTicks, "stale_limit_ticks", std::int64_t{0}),
              EndsWith(": is 0, expected 1 to 100"));
  EXPECT_THAT(reason_to_refuse(object::kBoardSettings, "supply_gain_kPa_per_V", 0.01),
              EndsWith(": is 0.01, expected 0.1 to 10000"));
}

TEST(Settings, ThatContradictOthersAreRefusedWithTheRangeThatTheseLeave) {
  EXPECT_THAT(
      reason_to_refuse(object::kChamberSettings + 3, "pressure_high_kPa", 50.0),
      ContainsRegex(
          ": pressure_high_kPa = 50, expected 1[0-9.]+ to 2000 with the other settings as they are$"));
}

TEST(References, BeyondTheLimitsOfAChamberAreRefusedWithTheChamberAndItsLimits) {
  BoardOnBus world;
  Session session(world, 5);
  config::ChamberSettings narrow;
  narrow.pressure_low_kPa = 130.0F;
  narrow.pressure_high_kPa = 449.96F;  // 4500 mbar
  ASSERT_TRUE(world.settings.set(1, narrow));
  const auto refusal = [&](double low_Pa, double high_Pa) -> std::string {
    const std::vector<std::vector<double>> two = {{200e3, 300e3}, {low_Pa, 200e3, high_Pa}};
    try {
      require_within_limits(session, two);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return {};
  };
  EXPECT_EQ(refusal(130e3, 449.96e3), "");
  for (const std::string& text : {refusal(129e3, 400e3), refusal(150e3, 451e3)})
    EXPECT_THAT(text, AllOf(HasSubstr("chamber 2: reference from 1"), HasSubstr("within 130 to 450 kPa"),
                            HasSubstr("63A0h")));
}

TEST(Settings, AreNumbersOfTheirTypes) {
  using canopen::DataType;
  EXPECT_EQ(bits_of(DataType::integer8, std::int64_t{-1}), 0xFFU);
  EXPECT_EQ(bits_of(DataType::unsigned32, std::int64_t{4294967295}), 0xFFFFFFFFU);
  EXPECT_EQ(bits_of(DataType::real32, 0.5), 0x3F000000U);
  EXPECT_EQ(bits_of(DataType::real32, std::int64_t{2}), 0x40000000U) << "JSON writes 2.0 as 2";
  EXPECT_THROW(bits_of(DataType::unsigned8, std::int64_t{256}), std::invalid_argument);
  EXPECT_THROW(bits_of(DataType::unsigned16, std::int64_t{-1}), std::invalid_argument);
  EXPECT_THROW(bits_of(DataType::integer16, 0.5), std::invalid_argument);
  EXPECT_THROW(bits_of(DataType::real32, 1e39), std::invalid_argument);
  EXPECT_THROW(bits_of(DataType::real32, std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  EXPECT_EQ(std::get<std::int64_t>(number_of({{}, DataType::integer8, "", 0xFF})), -1);
  EXPECT_EQ(std::get<double>(number_of({{}, DataType::real32, "", 0x3DCCCCCD})), 0.1)
      << "as a person writes it";
  for (const Setting& setting : known_settings()) EXPECT_EQ(type_of(type_name(setting.type)), setting.type);
  EXPECT_THROW(type_of("DOMAIN"), std::invalid_argument);
}

TEST(Settings, AreStoredByTheSignatureAndABoardWithoutAStoreSaysSo) {
  ScriptedLink stores({"585 60 10 10 01 00 00 00 00"});
  Session one(stores, 5);
  EXPECT_TRUE(store_settings(one));
  EXPECT_EQ(stores.sent, std::vector<std::string>{"605 23 10 10 01 73 61 76 65"});
  ScriptedLink none({"585 80 10 10 01 00 00 02 06"});
  Session two(none, 5);
  EXPECT_FALSE(store_settings(two));
  ScriptedLink fails({"585 80 10 10 01 00 00 06 06"});
  Session three(fails, 5);
  EXPECT_THROW(store_settings(three), SdoAbort);
}

}  // namespace
}  // namespace plenum::host::client
