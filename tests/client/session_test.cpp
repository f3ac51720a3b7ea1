// The client against the real node over the simulated bus, and against a scripted board for what a good node
// never does.
#include "host-sim/client/session.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "firmware/canopen/object_dictionary.hpp"
#include "host-sim/client/sdo_client.hpp"
#include "tests/client/board_on_bus.hpp"
#include "tests/client/scripted_link.hpp"
#include "tests/firmware/canopen/bench.hpp"
#include "tests/firmware/config/tassa9_sample.hpp"

namespace plenum::host::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

namespace object = canopen::object;

/// The message of the exception of type E that `action` throws.
template <class E, class Action>
std::string message_of(Action action) {
  try {
    action();
  } catch (const E& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << "one line";
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

std::vector<std::uint8_t> image_for(std::size_t chamber) {
  config::ModelParameters parameters = config::tassa9_sample();
  parameters.valve_serial = static_cast<std::uint32_t>(1000 + chamber);
  parameters.value[config::kC7] += static_cast<float>(chamber);
  return config::image_of(parameters);
}

TEST(Session, ReadsValuesTextsAndWrites) {
  BoardOnBus world;
  Session session(world, 5);
  EXPECT_EQ(session.read<std::uint32_t>(object::kDeviceTypeIndex, 0), 0xFFFF0198U);
  EXPECT_EQ(session.read_text(object::kDeviceName), "Plenum valve board");
  session.write(object::kPascals + 3, 1, 250000.0F);
  EXPECT_EQ(world.image.chamber[3].setpoint_Pa, 250000.0F);
  EXPECT_EQ(session.read<float>(object::kPascals + 3, 1), 250000.0F);
  session.write<std::int8_t>(object::kControlMode, 0, -1);
  EXPECT_EQ(session.read<std::int8_t>(object::kControlMode, 0), -1);
}

TEST(Session, NamesTheAbortInOneLine) {
  BoardOnBus world;
  Session session(world, 5);
  const auto write_status = [&] { session.write<std::uint16_t>(object::kStatusWord, 0, 1); };
  EXPECT_THAT(message_of<SdoAbort>(write_status), AllOf(HasSubstr("node 5"), HasSubstr("writing 6041h:0"),
                                                        HasSubstr("06010002h"), HasSubstr("read only")));
  try {
    session.sdo_read(0x5000, 7);
    FAIL();
  } catch (const SdoAbort& abort) {
    EXPECT_EQ(abort.index, 0x5000);
    EXPECT_EQ(abort.sub, 7);
    EXPECT_EQ(abort.code, 0x06020000U);
  }
  const auto read_wide = [&] { session.read<std::uint32_t>(object::kStatusWord, 0); };
  EXPECT_THAT(message_of<ProtocolError>(read_wide), HasSubstr("2 bytes, expected 4"));
}

TEST(Session, TimesOutOnABoardThatIsNotThere) {
  BoardOnBus world;
  Session session(world, 6);
  const auto read = [&] { session.status_word(); };
  EXPECT_THAT(message_of<Timeout>(read), AllOf(HasSubstr("node 6"), HasSubstr("6041h:0"), HasSubstr("586h")));
  EXPECT_DOUBLE_EQ(world.now_s(), 0.5);
  EXPECT_THROW(session.wait_heartbeat(3.0), Timeout);
  EXPECT_THROW(Session(world, 0), std::invalid_argument);
  EXPECT_THROW(Session(world, 128), std::invalid_argument);
}

TEST(Session, LeavesNothingBehindAfterATimeOutInTheMiddleOfATransfer) {
  BoardOnBus world;
  Session session(world, 5);
  bool confirmation_lost = false;
  world.bus.drop_when([&](const CanFrame& frame, std::size_t) {
    const bool drop = frame.id == 0x585 && frame.data[0] == 0xA1 && !confirmation_lost;  // of the whole block
    confirmation_lost = confirmation_lost || drop;
    return drop;
  });
  const std::vector<std::uint8_t> image = image_for(0);
  EXPECT_THROW(session.upload_model(0, image), Timeout);
  EXPECT_TRUE(world.slots.active_image(0).empty());
  session.upload_model(0, image);
  EXPECT_EQ(session.download_model(0), image);
}

TEST(Session, SendsNoModelOfAnotherValveOrSensorThanTheBoardHas) {
  for (const auto& [valve, sensor, says] :
       {std::tuple{4712U, 815U, "it is of valve 1002, the board has 4712"},
        std::tuple{1002U, 816U, "it is of sensor 815, the board has 816"}}) {
    BoardOnBus world;
    config::ChamberSettings settings;
    settings.valve_serial = valve;
    settings.sensor_serial = sensor;
    world.settings.set(2, settings);
    Session session(world, 5);
    bool has_written = false;
    world.bus.drop_when([&](const CanFrame& frame, std::size_t) {
      const unsigned command = frame.data[0] >> 5U;
      has_written =
          has_written || (frame.id == 0x605 && (command == 1 || (command == 6 && (frame.data[0] & 1U) == 0)));
      return false;
    });
    const auto upload = [&] { session.upload_model(2, image_for(2)); };
    EXPECT_THAT(message_of<Refused>(upload),
                AllOf(HasSubstr("node 5 chamber 3: model refused: "), HasSubstr(says), HasSubstr("force")));
    EXPECT_FALSE(has_written) << "not even the upload session is taken";
    session.upload_model(2, image_for(2), Doubted::force);
    EXPECT_EQ(session.download_model(2), image_for(2));
  }
}

TEST(Session, AsksNoBoardForSerialNumbersThatAModelDoesNotState) {
  BoardOnBus world;
  config::ChamberSettings settings;
  settings.valve_serial = 4712;
  world.settings.set(0, settings);
  config::ModelParameters unstated = config::tassa9_sample();
  unstated.valve_serial = unstated.sensor_serial = 0;
  Session session(world, 5);
  std::set<std::uint16_t> asked;
  session.watch_transfers([&](const Transfer& one) { asked.insert(one.index); });
  session.upload_model(0, config::image_of(unstated));
  EXPECT_FALSE(asked.contains(canopen::object::kSerials));
  EXPECT_TRUE(asked.contains(canopen::object::kSetState)) << "but for what it has to";
  EXPECT_EQ(session.download_model(0), config::image_of(unstated));
}

TEST(Session, TellsHowFarEachTransferIs) {
  BoardOnBus world;
  Session session(world, 5);
  session.upload_model(3, image_for(3));
  std::vector<Transfer> seen;
  session.watch_transfers([&](const Transfer& transfer) { seen.push_back(transfer); });
  const std::vector<std::uint8_t> image = session.download_model(3);
  ASSERT_GE(seen.size(), 2U);
  for (const Transfer& transfer : seen) EXPECT_EQ(transfer.index, object::kActiveModel + 3);
  EXPECT_EQ(seen.front().done, 0U);
  EXPECT_FALSE(seen.front().total);
  EXPECT_EQ(seen.back().done, image.size());
  EXPECT_EQ(seen.back().total, image.size());
  seen.clear();
  session.write(object::kPascals + 3, 1, 250000.0F);
  ASSERT_FALSE(seen.empty());
  EXPECT_EQ(seen.front().index, object::kPascals + 3);
  EXPECT_EQ(seen.front().sub, 1);
  session.watch_transfers({});
  const std::size_t before = seen.size();
  session.status_word();
  EXPECT_EQ(seen.size(), before);
}

TEST(Session, UploadsModelsOfEightChambersAtOnceAndReadsThemBack) {
  BoardOnBus world;
  Session session(world, 5);
  std::vector<ModelUpload> uploads;
  for (std::uint8_t chamber = 0; chamber < 8; ++chamber) uploads.push_back({chamber, image_for(chamber)});
  EXPECT_TRUE(session.download_model(0).empty());
  session.upload_models(uploads);
  for (std::uint8_t chamber = 0; chamber < 8; ++chamber) {
    EXPECT_EQ(session.download_model(chamber), image_for(chamber)) << "chamber " << int{chamber};
    EXPECT_EQ(world.slots.active(chamber).valve_serial, 1000U + chamber);
    EXPECT_EQ(world.slots.state(chamber).generation, 1U) << "all in one commit";
  }
  EXPECT_LT(world.now_s(), 0.5) << "8 x 80 bytes in segments, up and down";
}

TEST(Session, SaysWhichParameterTheBoardRefusedAndLeavesTheOldModelInForce) {
  BoardOnBus world;
  Session session(world, 5);
  session.upload_model(2, image_for(2));
  config::ModelParameters bad = config::tassa9_sample();
  const config::ParameterSpec& spec = config::parameter_schema(config::ModelKind::tassa9)[config::kC1];
  bad.value[config::kC1] = spec.high + 1.0F;
  EXPECT_THAT(message_of<Refused>([&] { session.upload_model(2, config::image_of(bad)); }),
              AllOf(HasSubstr("node 5 chamber 3"), HasSubstr(spec.name), HasSubstr("expected")));
  std::vector<std::uint8_t> torn = image_for(2);
  torn[40] = static_cast<std::uint8_t>(torn[40] ^ 1U);
  EXPECT_THAT(message_of<Refused>([&] { session.upload_model(2, torn); }),
              HasSubstr("does not match its CRC"));
  torn.resize(300);
  EXPECT_THAT(message_of<Refused>([&] { session.upload_model(2, torn); }),
              AllOf(HasSubstr("node 5"), HasSubstr("has not the size"), HasSubstr("06070010h")));
  EXPECT_EQ(session.download_model(2), image_for(2));
  EXPECT_EQ(world.slots.state(2).generation, 1U);
}

TEST(Session, StagesNoModelOfASetOfWhichOneIsRefused) {
  BoardOnBus world;
  Session session(world, 5);
  std::vector<ModelUpload> uploads;
  for (std::uint8_t chamber = 0; chamber < 8; ++chamber) uploads.push_back({chamber, image_for(chamber)});
  uploads[5].image[40] ^= 1U;
  EXPECT_THAT(message_of<Refused>([&] { session.upload_models(uploads); }),
              AllOf(HasSubstr("node 5 chamber 6"), HasSubstr("does not match its CRC")));
  for (std::uint8_t chamber = 0; chamber < 8; ++chamber) {
    EXPECT_EQ(world.slots.state(chamber).staged_crc, 0U) << "chamber " << int{chamber};
    EXPECT_TRUE(world.slots.active_image(chamber).empty()) << "chamber " << int{chamber};
  }
  EXPECT_EQ(world.slots.upload_session().owner(), 0U) << "released";
}

/// A board whose memory has flipped bit 0 of byte 17 of an image, and that sends what it has.
struct Forgetful : BoardOnBus {
  std::optional<CanFrame> receive(double timeout_s) override {
    std::optional<CanFrame> frame = BoardOnBus::receive(timeout_s);
    if (!frame || frame->id != 0x585) return frame;
    if (frame->data[0] == 3) frame->data[4] ^= 1U;  // of a block's third segment: bytes 14 to 20
    if ((frame->data[0] & 0xE3U) == 0xC1) {         // the CRC of a sum is the sum of the CRCs
      std::vector<std::uint8_t> flipped(image_for(1).size());
      flipped[17] = 1;
      frame->data[1] ^= static_cast<std::uint8_t>(crc16(flipped));
      frame->data[2] ^= static_cast<std::uint8_t>(crc16(flipped) >> 8);
    }
    return frame;
  }
};

TEST(Session, ComparesWhatItReadsBackWithWhatItSent) {
  Forgetful world;
  Session session(world, 5);
  EXPECT_THAT(message_of<ProtocolError>([&] { session.upload_model(1, image_for(1)); }),
              AllOf(HasSubstr("node 5 chamber 2"), HasSubstr("differs at byte 17")));
}

TEST(Session, UploadsWhileNoOtherMasterDoes) {
  BoardOnBus world;
  Session session(world, 5);
  session.write(object::kUploadSession, 1, std::uint32_t{0x1234});  // another master's token
  session.sdo_write(object::kStagedModel + 1, 0, image_for(1));
  EXPECT_THAT(message_of<Refused>([&] { session.upload_model(1, image_for(2)); }),
              AllOf(HasSubstr("another master is uploading"), HasSubstr("for another 15.0 s")));
  EXPECT_EQ(world.slots.state(1).staged_crc, config::trailing_crc(image_for(1))) << "what it staged stands";
  session.write(object::kUploadSession, 2, std::uint32_t{0x1234});
  session.upload_model(1, image_for(2));
  EXPECT_EQ(session.download_model(1), image_for(2));
  EXPECT_EQ(world.slots.upload_session().owner(), 0U) << "released when it is done";
}

TEST(Session, ReleasesTheUploadSessionWhenTheBoardRefuses) {
  BoardOnBus world;
  Session session(world, 5);
  std::vector<std::uint8_t> torn = image_for(2);
  torn[40] = static_cast<std::uint8_t>(torn[40] ^ 1U);
  EXPECT_THROW(session.upload_model(2, torn), Refused);
  EXPECT_EQ(world.slots.upload_session().owner(), 0U);
}

// A tool that knows no tokens: stage and commit are all it takes, but not into another master's session.
TEST(Session, BoardTakesModelsFromAMasterWithoutAToken) {
  BoardOnBus world;
  Session plain(world, 5);
  const auto upload = [&](std::uint16_t chamber) {
    const auto image = image_for(static_cast<std::uint8_t>(chamber));
    const std::uint32_t crc = config::trailing_crc(image);
    plain.sdo_write(static_cast<std::uint16_t>(object::kStagedModel + chamber), 0, image);
    plain.write(object::kCommit, 1, static_cast<std::uint8_t>(1U << chamber));
    plain.write(object::kCommit, 2, config::commit_crc({&crc, 1}));
    plain.write(object::kCommit, 3, config::kCommitKey);
    world.run_ticks(1);
  };
  upload(0);
  EXPECT_EQ(plain.download_model(0), image_for(0));
  upload(0);
  plain.write(object::kUploadSession, 1, std::uint32_t{0x1234});
  plain.sdo_write(object::kStagedModel + 1, 0, image_for(1));  // its owner's image
  EXPECT_THAT(message_of<SdoAbort>([&] { upload(2); }), HasSubstr("08000022h"));
  EXPECT_EQ(world.slots.state(2).refusal.error, config::ImageError::staged_by_another);
}

TEST(Session, RefusesToUploadForAChamberThatCannotBe) {
  BoardOnBus world;
  Session session(world, 5);
  EXPECT_THROW(session.upload_model(8, image_for(0)), std::invalid_argument);
  const std::vector<ModelUpload> twice = {{1, image_for(1)}, {1, image_for(1)}};
  EXPECT_THROW(session.upload_models(twice), std::invalid_argument);
}

TEST(Session, EnablesAndDisablesByControlAndStatusWord) {
  BoardOnBus world;
  Session session(world, 5);
  session.enable();
  EXPECT_EQ(world.image.control_word, 7);
  EXPECT_EQ(session.status_word(), 0xF);
  session.disable();
  EXPECT_EQ(session.status_word(), 0x9);
}

TEST(Session, TellsWhichFaultKeepsTheBoardFromStarting) {
  BoardOnBus world;
  Session session(world, 5);
  world.image.error_code = 0x8302;
  EXPECT_THAT(message_of<Refused>([&] { session.enable(); }),
              AllOf(HasSubstr("node 5"), HasSubstr("FAULT_DISABLED"), HasSubstr("expected DISABLED"),
                    HasSubstr("8302h"), HasSubstr("plenum faults")));
  world.clears = false;
  EXPECT_THROW(session.reset_fault(), Refused);
  world.clears = true;
  session.reset_fault();
  EXPECT_EQ(world.image.error_code, 0);
  session.enable();
}

TEST(Session, TellsABootUpThatStaysAwayFromABoardThatIsSilent) {
  BoardOnBus world;
  Session session(world, 5);
  session.wait_boot_up(0.1);
  EXPECT_THAT([&] { session.wait_boot_up(2.5); },
              ThrowsMessage<Timeout>(AllOf(HasSubstr("no boot-up message within 2.5 s"), HasSubstr("705h"),
                                           HasSubstr("goes on"))));
  world.deaf = true;
  EXPECT_THAT(
      [&] { session.wait_boot_up(2.5); },
      ThrowsMessage<Timeout>(AllOf(HasSubstr("no boot-up message within 2.5 s"), Not(HasSubstr("goes on")))));
  world.deaf = false;
  session.nmt(canopen::NmtCommand::reset_node);
  session.wait_boot_up(1.0);
}

// CiA 301, 7.2.5.2: from 1 to the overflow value, and again.
TEST(SessionProtocol, CountsItsSyncsAsTheBoardExpects) {
  ScriptedLink link({"585 43 05 10 00 85 00 00 40", "585 4F 19 10 00 03 00 00 00"});
  Session session(link, 5);
  session.learn_sync();
  link.sent.clear();
  for (int k = 0; k < 5; ++k) session.send_sync();
  EXPECT_EQ(link.sent, (std::vector<std::string>{"085 01", "085 02", "085 03", "085 01", "085 02"}));
}

TEST(Session, HearsHeartbeatsAndFollowsNmt) {
  BoardOnBus world;
  Session session(world, 5);
  EXPECT_EQ(session.wait_heartbeat(0.1), canopen::NmtState::initialising) << "the boot-up message";
  EXPECT_EQ(session.wait_heartbeat(1.1), canopen::NmtState::pre_operational);
  session.nmt(canopen::NmtCommand::start);
  EXPECT_EQ(session.wait_heartbeat(1.1), canopen::NmtState::operational);
  session.nmt(canopen::NmtCommand::reset_node);
  EXPECT_EQ(session.wait_heartbeat(1.1), canopen::NmtState::initialising);
}

TEST(Session, HandsOnWhatArrivesDuringATransfer) {
  BoardOnBus world;
  Session session(world, 5);
  session.nmt(canopen::NmtCommand::start);
  session.write<std::uint16_t>(object::kHeartbeatTime, 0, 10);
  std::map<std::uint32_t, int> seen;
  std::vector<Emergency> emergencies;
  double last_s = 0.0;
  session.subscribe([&](const Arrival& arrival) {
    EXPECT_GE(arrival.time_s, last_s);
    last_s = arrival.time_s;
    ++seen[arrival.frame.id];
    if (const auto emergency = decode_emergency(arrival.frame)) emergencies.push_back(*emergency);
  });
  world.each_tick = [&] {
    world.image.error_code = world.image.tick_count >= 3 ? 0x3412 : 0;
    world.image.fault_chamber = 2;
  };
  while (world.now_s() < 0.1) session.sdo_read(object::kDeviceName, 0);
  EXPECT_NEAR(seen[0x705], 9, 1);
  EXPECT_EQ(seen.count(0x585), 0U);
  ASSERT_EQ(emergencies.size(), 1U);
  EXPECT_EQ(emergencies[0].node_id, 5);
  EXPECT_EQ(emergencies[0].code, 0x3412);
  EXPECT_EQ(emergencies[0].chamber, 2);
}

TEST(Session, SendsSetPointsInMillibarAndInPascal) {
  for (const SetpointFormat format : {SetpointFormat::millibar, SetpointFormat::pascal}) {
    BoardOnBus world;
    Session session(world, 5);
    session.configure_setpoints(format);
    session.nmt(canopen::NmtCommand::start);
    std::array<double, kChambers> setpoints_Pa{};
    for (std::size_t c = 0; c < kChambers; ++c) setpoints_Pa[c] = 150012.5 + 50000.0 * static_cast<double>(c);
    session.send_setpoints(setpoints_Pa);
    session.send_sync();
    session.listen(0.005);
    for (std::size_t c = 0; c < kChambers; ++c) {
      const double tolerance_Pa = format == SetpointFormat::pascal ? 0.0 : 50.0;  // half a step
      EXPECT_NEAR(static_cast<double>(world.image.chamber[c].setpoint_Pa), setpoints_Pa[c], tolerance_Pa)
          << "chamber " << c;
    }
    EXPECT_EQ(world.image.setpoint_count, 1U);
  }
}

TEST(Session, RefusesToSendASetPointThatTheBoardWouldDrop) {
  BoardOnBus world;
  Session session(world, 5);
  std::array<double, kChambers> setpoints_Pa{};
  for (const double bad_Pa : {-1.0, 4.0e6, std::numeric_limits<double>::quiet_NaN()}) {
    setpoints_Pa[6] = bad_Pa;
    EXPECT_THAT(message_of<std::invalid_argument>([&] { session.send_setpoints(setpoints_Pa); }),
                AllOf(HasSubstr("chamber 7"), HasSubstr("expected 0..")));
  }
}

// ---- a board by script ----

TEST(SessionProtocol, ReadsExpeditedAsCia301Says) {
  ScriptedLink link({"585 43 00 10 00 92 01 02 00"});
  EXPECT_EQ(Session(link, 5).read<std::uint32_t>(0x1000, 0), 0x00020192U);
  EXPECT_EQ(link.sent, std::vector<std::string>{"605 40 00 10 00 00 00 00 00"});
}

TEST(SessionProtocol, WritesExpeditedAndInSegments) {
  ScriptedLink link({"585 60 17 10 00 00 00 00 00", "585 60 10 21 00 00 00 00 00",
                     "585 20 00 00 00 00 00 00 00", "585 30 00 00 00 00 00 00 00"});
  Session session(link, 5);
  session.write<std::uint16_t>(0x1017, 0, 1000);
  session.sdo_write(0x2110, 0, std::array<std::uint8_t, 9>{1, 2, 3, 4, 5, 6, 7, 8, 9});
  EXPECT_EQ(link.sent,
            (std::vector<std::string>{"605 2B 17 10 00 E8 03 00 00", "605 21 10 21 00 09 00 00 00",
                                      "605 00 01 02 03 04 05 06 07", "605 1B 08 09 00 00 00 00 00"}));
}

TEST(SessionProtocol, ReadsATextAsOneThatMovesNoTerminal) {
  ScriptedLink link({"585 43 08 10 00 1B 5B 32 4A"});
  EXPECT_EQ(Session(link, 5).read_text(0x1008), "\\x1B[2J");
}

TEST(SessionProtocol, GivesUpOnAToggleBitThatStandsStill) {
  ScriptedLink link(
      {"585 41 08 10 00 09 00 00 00", "585 00 41 42 43 44 45 46 47", "585 0B 48 49 00 00 00 00 00"});
  EXPECT_THROW(Session(link, 5).sdo_read(0x1008, 0), ProtocolError);
  EXPECT_EQ(link.sent.back(), "605 80 08 10 00 00 00 03 05");
}

TEST(SessionProtocol, GivesUpWhenTheSizeIsNotTheAnnouncedOne) {
  ScriptedLink more({"585 41 08 10 00 05 00 00 00", "585 00 41 42 43 44 45 46 47"});
  EXPECT_THROW(Session(more, 5).sdo_read(0x1008, 0), ProtocolError);
  EXPECT_EQ(more.sent.back(), "605 80 08 10 00 10 00 07 06");
  ScriptedLink fewer({"585 41 08 10 00 09 00 00 00", "585 01 41 42 43 44 45 46 47"});
  EXPECT_THROW(Session(fewer, 5).sdo_read(0x1008, 0), ProtocolError);
}

TEST(SessionProtocol, GivesUpOnAnAnswerOfTheWrongKind) {
  ScriptedLink link({"585 60 08 10 00 00 00 00 00"});
  EXPECT_THROW(Session(link, 5).sdo_read(0x1008, 0), ProtocolError);
  EXPECT_EQ(link.sent.back(), "605 80 08 10 00 01 00 04 05");
}

TEST(SessionProtocol, PassesOverTheLateAnswerToAnEarlierRequest) {
  ScriptedLink link({"585 4B 41 60 00 09 00 00 00"});  // the answer to a read of 6041h
  const auto read = [&] { Session(link, 5).read<std::uint16_t>(0x1017, 0); };
  EXPECT_THROW(read(), Timeout);
  EXPECT_EQ(link.sent.back(), "605 80 17 10 00 00 00 04 05") << "the server is told";
}

TEST(SessionProtocol, NamesAbortCodesItDoesNotKnow) {
  ScriptedLink link({"585 80 17 10 00 EF BE AD DE"});
  EXPECT_THAT(message_of<SdoAbort>([&] { Session(link, 5).sdo_read(0x1017, 0); }),
              AllOf(HasSubstr("DEADBEEFh"), HasSubstr("unknown abort code")));
}

// A master that has kept a data sheet finds by 1018h that it is of other objects.
TEST(Revision, IsThatOfTheObjectsWhereNobodyStatesOneAndTheSameInTheDataSheet) {
  BoardOnBus world;
  Session session(world, 5);
  EXPECT_EQ(session.read<std::uint32_t>(object::kIdentity, 3), canopen::dictionary_revision());
  const std::vector<std::uint8_t> sheet = session.sdo_read_domain(0x1021, 0);
  const std::string text(sheet.begin(), sheet.end());
  EXPECT_THAT(text, HasSubstr(fmt::format("RevisionNumber=0x{:08X}\n", canopen::dictionary_revision())));
}

}  // namespace
}  // namespace plenum::host::client
