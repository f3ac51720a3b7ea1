// What is on a bus is told by a board; what it means, by its objects.
#include "host-sim/client/pdo_directory.hpp"

#include <gtest/gtest.h>

#include "firmware/canopen/object_dictionary.hpp"
#include "host-sim/client/session.hpp"
#include "host-sim/client/watch.hpp"
#include "tests/client/board_on_bus.hpp"
#include "tests/firmware/canopen/bench.hpp"

namespace plenum::host::client {
namespace {

namespace object = canopen::object;

class ARemappedBoard : public ::testing::Test {
 protected:
  /// TPDO2 becomes 2210h:3 and 6381h:1 of chamber 4, on another identifier; RPDO3 the set point of chamber 2 in Pa.
  ARemappedBoard() {
    map(1, object::kTpdoCommunication, object::kTpdoMapping, 0x4000'01C5,
        {canopen::mapping_entry(object::kRegulator + 3U, 3, 32),
         canopen::mapping_entry(object::of_module(object::kActual, 3), 1, 16)});
    map(2, object::kRpdoCommunication, object::kRpdoMapping, 0x405,
        {canopen::mapping_entry(object::kPascals + 1U, 1, 32)});
    world.each_tick = [this] {
      world.image.chamber[3].actual_Pa = 250e3F;
      world.image.chamber[3].command_V = 6.25F;
    };
  }

  void map(std::uint32_t n, std::uint32_t communication, std::uint32_t mapping, std::uint32_t cob_id,
           const std::vector<std::uint32_t>& objects) {
    const auto at = [n](std::uint32_t base) { return static_cast<std::uint16_t>(base + n); };
    session.write(at(communication), 1, cob_id | 0x8000'0000U);
    session.write<std::uint8_t>(at(mapping), 0, 0);
    for (std::size_t i = 0; i < objects.size(); ++i)
      session.write(at(mapping), static_cast<std::uint8_t>(i + 1), objects[i]);
    session.write(at(mapping), 0, static_cast<std::uint8_t>(objects.size()));
    session.write(at(communication), 1, cob_id);
  }

  BoardOnBus world;
  Session session{world, 5};
};

TEST_F(ARemappedBoard, IsReadAsItSaysWhenAsked) {
  PdoDirectory directory;
  directory.learn(session);
  std::optional<Pdo> heard;
  const Subscription subscription(session, [&](const Arrival& arrival) {
    if (arrival.frame.id == 0x1C5) heard = directory.read(arrival.frame);
  });
  session.nmt(canopen::NmtCommand::start);
  session.send_sync();
  session.listen(0.03);
  ASSERT_TRUE(heard && heard->values);
  EXPECT_EQ(heard->node, 5U);
  EXPECT_FALSE(heard->receive);
  EXPECT_EQ(heard->number, 2U);
  const std::vector<PdoValue>& values = *heard->values;
  ASSERT_EQ(values.size(), 2U);
  EXPECT_EQ(values[0].value, 6.25);
  EXPECT_EQ(values[0].instance, 3U);
  EXPECT_EQ(values[1].value, 250e3);
  EXPECT_TRUE(values[1].is_pressure);
}

TEST_F(ARemappedBoard, IsWatchedByWhatItsPdosCarry) {
  Watch watch(5);
  watch.learn_mapping(session);
  const Subscription subscription(session,
                                  [&](const Arrival& arrival) { watch.take(arrival.time_s, arrival.frame); });
  session.nmt(canopen::NmtCommand::start);
  session.send_sync();
  session.listen(0.03);
  watch.take(world.now_s(), canopen::frame_from("405 00 7C 92 48"));  // the master's: 300 kPa
  const BoardView view = watch.view(world.now_s());
  EXPECT_EQ(view.chamber[3].actual_Pa, 250e3);
  EXPECT_EQ(view.chamber[3].command_V, 6.25);
  EXPECT_EQ(view.chamber[1].setpoint_Pa, 300e3);
  EXPECT_EQ(view.chamber[4].actual_Pa, std::nullopt) << "of the PDO that was mapped otherwise";
}

TEST(PdoDirectory, KnowsNothingOfABoardThatDoesNotAnswer) {
  BoardOnBus world;
  world.deaf = true;
  Session session(world, 5);
  PdoDirectory directory;
  EXPECT_THROW(directory.learn(session), Timeout);
  const auto pdo = directory.read(canopen::frame_from("185 E8 03 D0 07 B8 0B A0 0F"));
  ASSERT_TRUE(pdo && pdo->values);
  EXPECT_EQ(pdo->values->at(1).value, 200e3) << "but what one has that is delivered";
}

// Node 1 listens to what node 5 sends.
TEST(PdoDirectory, AFrameIsItsSendersPdoWhoeverElseTakesIt) {
  for (const bool spoken_to : {false, true}) {
    PdoDirectory directory;
    directory.hear(canopen::frame_from("601 23 00 14 01 85 01 00 00"));
    directory.hear(canopen::frame_from("581 60 00 14 01 00 00 00 00"));
    if (spoken_to) directory.hear(canopen::frame_from("605 40 00 10 00 00 00 00 00"));
    const auto pdo = directory.read(canopen::frame_from("185 E8 03 D0 07 B8 0B A0 0F"));
    ASSERT_TRUE(pdo);
    EXPECT_EQ(pdo->node, 5U);
    EXPECT_FALSE(pdo->receive);
  }
}

TEST(PdoDirectory, APressureThatIsNotKnownIsNoNumber) {
  const auto pdo = PdoDirectory().read(canopen::frame_from("185 E8 03 00 80 B8 0B A0 0F"));
  ASSERT_TRUE(pdo && pdo->values);
  EXPECT_TRUE(std::isnan(pdo->values->at(1).value));
}

// What a PDO carries in 16 bits with a sign is taken for a pressure in mbar: the unit and the prefix beside each say so.
TEST(PdoDirectory, EveryIntegerOf16BitsThatAPdoCarriesIsInMillibar) {
  constexpr std::uint8_t kBar = 0x4E;
  constexpr std::int8_t kMilli = -3;
  BoardOnBus world;
  Session session(world, 5);
  std::size_t pressures = 0;
  for (const canopen::Entry& entry : canopen::object_dictionary()) {
    if (entry.mappable == canopen::Mappable::no || entry.type != canopen::DataType::integer16) continue;
    ++pressures;
    EXPECT_EQ(session.read<std::uint8_t>(entry.index, 2), kBar) << entry.index;
    EXPECT_EQ(session.read<std::int8_t>(entry.index, 3), kMilli) << entry.index;
  }
  EXPECT_GE(pressures, 2U) << "set point and actual value at least";
}

}  // namespace
}  // namespace plenum::host::client
