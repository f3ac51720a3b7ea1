#include "host-sim/client/stream.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "host-sim/client/session.hpp"
#include "tests/client/board_on_bus.hpp"

namespace plenum::host::client {
namespace {

/// A float holds it in kPa as well, so that it crosses to the last bit.
double pressure_Pa(std::uint32_t tick, std::size_t chamber) {
  return 100000.0 + 1000.0 * static_cast<double>(tick) + 15.625 * static_cast<double>(chamber);
}
double command_V(std::uint32_t tick, std::size_t chamber) {
  return 3.0 + 0.01 * tick + 0.1 * static_cast<double>(chamber);
}
double volume_m3(std::uint32_t tick, std::size_t chamber) {
  return 1.0e-4 + 1.0e-6 * tick + 1.0e-7 * static_cast<double>(chamber);
}

/// A board whose values tell tick and chamber.
struct Streaming : BoardOnBus {
  Streaming() {
    each_tick = [this] {
      for (std::size_t c = 0; c < kChambers; ++c) {
        image.chamber[c].actual_Pa = static_cast<float>(pressure_Pa(image.tick_count, c));
        image.chamber[c].command_V = static_cast<float>(command_V(image.tick_count, c));
        image.chamber[c].volume_m3 = static_cast<float>(volume_m3(image.tick_count, c));
      }
    };
  }
};

TEST(Stream, GivesTheSupplyOfEachTickWhereItIsAskedFor) {
  Streaming world;
  const auto chambers_too = world.each_tick;
  world.each_tick = [&] {
    chambers_too();
    world.image.supply_Pa = 600e3F + 100.0F * static_cast<float>(world.image.tick_count);
  };
  Session session(world, 5);
  for (const bool asked : {true, false}) {
    Stream stream = session.configure_stream({.supply = asked});
    session.nmt(canopen::NmtCommand::start);
    std::vector<StreamRow> rows;
    const Subscription subscription(session, [&](const Arrival& arrival) {
      stream.accept(arrival.time_s, arrival.frame, [&](const StreamRow& row) { rows.push_back(row); });
    });
    ASSERT_TRUE(session.listen_until([&] { return rows.size() == 20; }, 0.5));
    for (const StreamRow& row : rows) {
      ASSERT_EQ(row.supply_Pa.has_value(), asked);
      if (!asked) continue;
      // pressure_Pa() tells the tick
      const double tick = (row.sample[0].actual_Pa - 100000.0) / 1000.0;
      EXPECT_EQ(row.supply_Pa, 600e3 + 100.0 * tick) << "tick " << tick;
    }
  }
}

TEST(Stream, GivesOneRowATickWithAllChambersOfThatTick) {
  Streaming world;
  Session session(world, 5);
  Stream stream = session.configure_stream({.largest_volume_m3 = 6.5535e-4});
  session.nmt(canopen::NmtCommand::start);
  std::vector<StreamRow> rows;
  session.subscribe([&](const Arrival& arrival) {
    stream.accept(arrival.time_s, arrival.frame, [&](const StreamRow& row) { rows.push_back(row); });
  });
  const std::uint32_t first_tick = world.image.tick_count + 1;
  const bool all = session.listen_until([&] { return rows.size() == 100; }, 1.011);
  ASSERT_TRUE(all) << rows.size() << " rows, without any SYNC";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].chambers, 0xFF);
    const auto tick = first_tick + static_cast<std::uint32_t>(i);
    for (std::size_t c = 0; c < kChambers; ++c) {
      const StreamSample& sample = rows[i].sample[c];
      EXPECT_EQ(sample.chamber, c);
      EXPECT_EQ(sample.actual_Pa, pressure_Pa(tick, c)) << "row " << i << " chamber " << c << " [Pa]";
      EXPECT_NEAR(sample.command_V, command_V(tick, c), 0.51 * 10.0 / 65535.0) << "half an LSB [V]";
      EXPECT_NEAR(sample.volume_m3, volume_m3(tick, c), 0.51e-8) << "half an LSB [m3]";
    }
    EXPECT_EQ(static_cast<std::uint32_t>(rows[i].time_s / 0.01), tick) << "a row arrives within its tick";
  }
  EXPECT_EQ(world.node.counters().pdo_overwritten, 0U);
}

TEST(Stream, OfABoardAtRestCarriesThePositionSensorToTheLastBit) {
  Streaming world;
  const auto position_V = [](std::uint32_t tick, std::size_t chamber) {
    return std::nextafter(static_cast<float>(chamber), 9.0F) + static_cast<float>(tick) / 1024.0F;
  };
  world.each_tick = [&] {
    for (std::size_t c = 0; c < kChambers; ++c)
      world.image.chamber[c].position_V = position_V(world.image.tick_count, c);
  };
  Session session(world, 5);
  Stream stream = session.configure_stream({.position = true});
  session.nmt(canopen::NmtCommand::start);
  std::vector<StreamRow> rows;
  session.subscribe([&](const Arrival& arrival) {
    stream.accept(arrival.time_s, arrival.frame, [&](const StreamRow& row) { rows.push_back(row); });
  });
  const std::uint32_t first_tick = world.image.tick_count + 1;
  ASSERT_TRUE(session.listen_until([&] { return rows.size() == 10; }, 0.111));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t c = 0; c < kChambers; ++c) {
      const float expected_V = position_V(first_tick + static_cast<std::uint32_t>(i), c);
      EXPECT_EQ(rows[i].sample[c].position_V, static_cast<double>(expected_V)) << "row " << i << " [V]";
    }
  }
}

TEST(Stream, CarriesOnlyTheChambersAskedFor) {
  Streaming world;
  Session session(world, 5);
  session.configure_stream({});
  Stream stream = session.configure_stream({.chambers = 0x84, .every_ticks = 2});
  session.nmt(canopen::NmtCommand::start);
  std::vector<StreamRow> rows;
  int others = 0;
  session.subscribe([&](const Arrival& arrival) {
    const bool mine =
        stream.accept(arrival.time_s, arrival.frame, [&](const StreamRow& row) { rows.push_back(row); });
    if (!mine && stream_block(arrival.frame)) ++others;
  });
  session.listen(0.109);
  EXPECT_EQ(rows.size(), 5U);
  EXPECT_EQ(rows.at(0).chambers, 0x84);
  EXPECT_EQ(others, 0);
  session.stop_stream();
  rows.clear();
  session.listen(0.02);
  EXPECT_TRUE(rows.empty());
}

TEST(Stream, SaysWhichChambersALostFrameLeftOut) {
  Streaming world;
  Session session(world, 5);
  Stream stream = session.configure_stream({.chambers = 0x07});
  session.nmt(canopen::NmtCommand::start);
  int count = 0;
  world.bus.drop_when([&](const CanFrame& frame, std::size_t) {
    return frame.id == stream.first_cob_id() + 1 && ++count == 2;
  });
  std::vector<std::uint8_t> chambers;
  session.subscribe([&](const Arrival& arrival) {
    stream.accept(arrival.time_s, arrival.frame,
                  [&](const StreamRow& row) { chambers.push_back(row.chambers); });
  });
  session.listen(0.049);
  EXPECT_EQ(chambers, (std::vector<std::uint8_t>{0x07, 0x05, 0x07, 0x07}));
}

/// Somebody else's stream on some of the blocks, a frame each tick.
struct Crowded : BoardOnBus {
  Crowded(std::uint8_t node_id, std::vector<std::uint32_t> blocks) : BoardOnBus(node_id) {
    each_tick = [this, blocks = std::move(blocks)] {
      for (const std::uint32_t block : blocks)
        other.send({.id = kStreamIds + kStreamBlock * block, .length = 8, .data = {}});
    };
  }
  ports::SimulatedCanPort& other = bus.attach("other");
};

TEST(Stream, OfEachOfTwelveNodesHasIdentifiersOfItsOwn) {
  std::vector<std::uint32_t> first;
  for (const std::uint8_t node : std::to_array<std::uint8_t>({1, 2, 11, 12, 13, 127})) {
    BoardOnBus world(node);
    Session session(world, node);
    first.push_back(session.configure_stream({}).first_cob_id());
  }
  EXPECT_EQ(first, (std::vector<std::uint32_t>{0x680, 0x688, 0x6D0, 0x6D8, 0x680, 0x6B0}));
}

TEST(Stream, PassesOverBlocksThatOthersStreamOn) {
  Crowded world(3, {2, 3, 5});
  Session session(world, 3);
  EXPECT_EQ(session.configure_stream({}).first_cob_id(), 0x6A0U);
  session.nmt(canopen::NmtCommand::start);
  EXPECT_EQ(session.configure_stream({}).first_cob_id(), 0x6A0U) << "its own is no reason to move on";
}

TEST(Stream, IsRefusedWhereOthersUseEveryBlock) {
  Crowded world(5, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
  Session session(world, 5);
  try {
    session.configure_stream({});
    FAIL() << "it was opened";
  } catch (const ChannelTaken& error) {
    EXPECT_STREQ(
        error.what(),
        "node 5: others stream on all 12 blocks of identifiers from 680h to 6DFh, expected one to be free");
  }
}

TEST(Stream, DecodesOnlyItsOwnFrames) {
  const Stream stream({.chambers = 0x01}, 0x6A0, 0x485, 1.0e-7);
  CanFrame frame{.id = 0x6A0, .length = 8, .data = {0x00, 0x50, 0xC3, 0x47, 0xFF, 0xFF, 0xE8, 0x03}};
  const auto sample = stream.decode(frame);
  ASSERT_TRUE(sample);
  EXPECT_DOUBLE_EQ(sample->actual_Pa, 100000.0);
  EXPECT_DOUBLE_EQ(sample->command_V, 10.0);
  EXPECT_DOUBLE_EQ(sample->volume_m3, 1000 * 1.0e-7);
  frame.id = 0x6A1;
  EXPECT_FALSE(stream.decode(frame)) << "a chamber not asked for";
  frame.id = 0x680;
  EXPECT_FALSE(stream.decode(frame)) << "of another board";
  frame.id = 0x6A0;
  frame.length = 7;
  EXPECT_FALSE(stream.decode(frame));
  frame.length = 8;
  frame.extended = true;
  EXPECT_FALSE(stream.decode(frame));
}

}  // namespace
}  // namespace plenum::host::client
