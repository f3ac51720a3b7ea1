// Two masters on the one SDO channel of a board: what each gets is right, or an error that names the other.
#include "tests/client/two_masters.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host-sim/client/scan.hpp"
#include "host-sim/client/session.hpp"
#include "tests/firmware/config/tassa9_sample.hpp"

namespace plenum::host::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

namespace object = canopen::object;

constexpr std::uint8_t kNode = 5;

std::vector<ModelUpload> set_of(std::uint32_t master) {
  std::vector<ModelUpload> set;
  for (std::uint8_t chamber = 0; chamber < config::kChambers; ++chamber) {
    config::ModelParameters parameters = config::tassa9_sample();
    parameters.valve_serial = 100 * master + chamber;
    set.push_back({chamber, config::image_of(parameters)});
  }
  return set;
}

/// Whose set is in force: 0 nobody's, -1 no whole one.
int in_force(const BoardOnBus& world) {
  for (const std::uint32_t master : {1U, 2U}) {
    const auto set = set_of(master);
    if (std::all_of(set.begin(), set.end(), [&](const ModelUpload& one) {
          const auto image = world.slots.active_image(one.chamber);
          return std::equal(image.begin(), image.end(), one.image.begin(), one.image.end());
        }))
      return static_cast<int>(master);
  }
  for (std::uint8_t chamber = 0; chamber < config::kChambers; ++chamber)
    if (!world.slots.active_image(chamber).empty()) return -1;
  return 0;
}

/// On the simulated bus the one that was attached first wins where both send the same identifier.
std::array<std::uint32_t, 2> in_order(int run) {
  return run % 2 == 0 ? std::array{1U, 2U} : std::array{2U, 1U};
}

/// Seeds, so that a failure comes again.
SessionConfig config_of(std::uint32_t master, int run) {
  return {.sdo = {.seed = master + 10U * static_cast<std::uint32_t>(run)}};
}

// A tool that does not listen reads the data sheet by segments, for longer than a scan listens and asks.
TEST(TwoMasters, AScanLeavesTheTransferOfAnotherAlone) {
  BoardOnBus world(kNode);
  Masters masters(world);
  int segments = 0;
  bool disturbed = false;
  masters.add(0.0, [&](Link& link) {
    const auto exchange = [&](const std::array<std::uint8_t, 8>& data) {
      link.send({.id = canopen::cob::kSdoRequest + kNode, .length = 8, .data = data});
      while (const auto frame = link.receive(0.1)) {
        if (frame->id == canopen::cob::kSdoResponse + kNode) return frame->data[0];
      }
      return std::uint8_t{0x80};
    };
    exchange({0x40, 0x21, 0x10});
    for (std::uint8_t toggle = 0; link.now_s() < 1.5 && !disturbed; toggle ^= 0x10U, ++segments)
      disturbed = exchange({static_cast<std::uint8_t>(0x60U | toggle)}) != toggle;
    link.send({.id = canopen::cob::kSdoRequest + kNode, .length = 8, .data = {0x80, 0x21, 0x10}});
  });
  std::vector<ScannedNode> found;
  masters.add(0.02,
              [&](Link& link) { found = scan(link, 1.2, {.sdo = {.listen_first_s = 0.05, .seed = 1}}); });
  ASSERT_NO_THROW(masters.run());
  EXPECT_FALSE(disturbed) << "after " << segments << " segments";
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].board);
}

// The second begins at every 0.31 ms of the first one's upload, which takes some 0.1 s; in run 0 with it.
TEST(TwoMasters, OfTwoUploadsAtOnceOneIsWholeAndTheOtherIsRefusedWithTheReason) {
  int refused = 0;
  for (int run = 0; run < 400; ++run) {
    BoardOnBus world(kNode);
    Masters masters(world);
    std::vector<std::uint32_t> done;
    std::vector<std::string> said;
    for (const std::uint32_t master : in_order(run)) {
      masters.add(master == 1 ? 0.05 : 0.05 + 0.00031 * run, [&, master](Link& link) {
        Session session(link, kNode, config_of(master, run));
        try {
          session.upload_models(set_of(master));
          done.push_back(master);
        } catch (const Refused& refusal) {
          said.emplace_back(refusal.what());
        }
      });
    }
    ASSERT_NO_THROW(masters.run()) << "run " << run;
    ASSERT_FALSE(done.empty()) << "run " << run << ": " << said.front();
    EXPECT_EQ(in_force(world), static_cast<int>(done.back())) << "run " << run;
    for (const std::string& one : said)
      EXPECT_THAT(one, HasSubstr("another master is uploading")) << "run " << run;
    EXPECT_EQ(world.slots.upload_session().owner(), 0U) << "run " << run;
    refused += static_cast<int>(said.size());
  }
  EXPECT_GT(refused, 100) << "runs that were none of two at once";
}

TEST(TwoMasters, ReadAndWriteAtOnceAsIfTheyWereAlone) {
  for (int run = 0; run < 100; ++run) {
    BoardOnBus world(kNode);
    Masters masters(world);
    Session(world, kNode).upload_models(set_of(1));
    const double begin_s = world.now_s() + 0.01;
    for (const std::uint32_t master : in_order(run)) {
      masters.add(master == 1 ? begin_s : begin_s + 0.00037 * run, [&, master](Link& link) {
        Session session(link, kNode, config_of(master, run));
        const auto chamber = static_cast<std::uint16_t>(object::kPascals + master);
        for (int i = 0; i < 10; ++i) {
          EXPECT_EQ(session.read<std::uint32_t>(object::kDeviceTypeIndex, 0), canopen::kDeviceType);
          EXPECT_EQ(session.read_text(object::kDeviceName), "Plenum valve board");
          const float setpoint_Pa = 1.0e5F + static_cast<float>(i);
          session.write(chamber, 1, setpoint_Pa);
          EXPECT_EQ(session.read<float>(chamber, 1), setpoint_Pa) << "run " << run;
        }
        EXPECT_EQ(session.download_model(3), set_of(1)[3].image) << "run " << run;
      });
    }
    ASSERT_NO_THROW(masters.run()) << "run " << run;
  }
}

/// A tool that listens to nobody: one request in the middle of our upload, after each of its frames in turn.
TEST(TwoMasters, AnUploadIsWholeThoughAToolThatDoesNotListenSpeaksInto) {
  const std::array<Bytes, 5> requests = {{
      {0x40, 0x00, 0x10, 0x00, 0, 0, 0, 0},              // read the device type
      {0x40, 0x08, 0x10, 0x00, 0, 0, 0, 0},              // read the name, in segments
      {0x2B, 0x17, 0x10, 0x00, 0xE8, 0x03, 0, 0},        // write the heartbeat time
      {0xC6, 0x22, 0x21, 0x01, 0x81, 0x02, 0x00, 0x00},  // begin a set of its own
      {0x80, 0x00, 0x10, 0x00, 0x00, 0x00, 0x04, 0x05},  // give up
  }};
  for (const Bytes& data : requests) {
    for (int after = 0; after < 130; ++after) {
      BoardOnBus world(kNode);
      ports::SimulatedCanPort& tool = world.bus.attach("tool");
      Masters masters(world);
      int frames = 0;
      world.bus.drop_when([&](const CanFrame& frame, std::size_t sender) {
        if (frame.id != canopen::cob::kSdoRequest + kNode || sender == tool.number()) return false;
        if (frames++ != after) return false;
        CanFrame spoken{.id = frame.id, .length = 8};
        std::copy(data.begin(), data.end(), spoken.data.begin());
        tool.send(spoken);
        return false;
      });
      masters.add(0.05,
                  [&](Link& link) { Session(link, kNode, config_of(1, after)).upload_models(set_of(1)); });
      ASSERT_NO_THROW(masters.run()) << fmt::format("{:02X}h after frame {}", data[0], after);
      EXPECT_EQ(in_force(world), 1) << fmt::format("{:02X}h after frame {}", data[0], after);
    }
  }
}

TEST(TwoMasters, WhoFindsTheChannelTakenWaitsThenSaysSoAndSendsNothing) {
  BoardOnBus world(kNode);
  Masters masters(world);
  bool ended = false;
  masters.add(0.0,
              [&](Link& link) {  // reads the name, a segment each 0.3 s; the same one, when it is through
                while (!ended) {
                  link.send({.id = 0x605, .length = 8, .data = {0x40, 0x08, 0x10, 0x00}});
                  while (link.receive(0.3)) continue;
                  link.send({.id = 0x605, .length = 8, .data = {0x60}});
                  while (const auto answer = link.receive(0.3))
                    EXPECT_NE(answer->id, 0x605U) << "nobody speaks into";
                }
              });
  masters.add(0.2, [&](Link& link) {
    Session session(link, kNode, config_of(1, 0));
    try {
      session.upload_models(set_of(1));
      ADD_FAILURE() << "nothing was thrown";
    } catch (const ChannelTaken& taken) {
      EXPECT_THAT(taken.what(),
                  AllOf(HasSubstr("node 5"), HasSubstr("2148h:1"), HasSubstr("another master talks"),
                        HasSubstr("605h"), HasSubstr("waited 10 s")));
      EXPECT_NEAR(link.now_s(), 10.2, 0.01);
    }
    ended = true;
  });
  masters.run();
  EXPECT_EQ(in_force(world), 0);
}

TEST(TwoMasters, WhoJoinsABusHearsATransferThatIsUnderWayBeforeItSpeaks) {
  BoardOnBus world(kNode);
  Masters masters(world);
  Session(world, kNode).upload_models(set_of(1));
  const Bytes sheet = Session(world, kNode).sdo_read_domain(0x1021, 0);
  double read_s = 0.0;
  const double begin_s = world.now_s() + 0.01;
  masters.add(begin_s, [&](Link& link) {
    EXPECT_EQ(Session(link, kNode, config_of(1, 0)).sdo_read_domain(0x1021, 0), sheet);
    read_s = link.now_s();
  });
  masters.add(begin_s + 0.1, [&](Link& link) {
    SessionConfig config = config_of(2, 0);
    config.sdo.listen_first_s = 0.05;
    EXPECT_EQ(Session(link, kNode, config).status_word(), canopen::word::kReady);
    EXPECT_GT(link.now_s(), read_s) << "after the data sheet";
    EXPECT_GT(read_s, begin_s + 0.2) << "which takes longer than that";
  });
  masters.run();
}

}  // namespace
}  // namespace plenum::host::client
