// What a recording borrows of a board, and what it refuses to take from others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host-sim/client/capture.hpp"
#include "host-sim/client/session.hpp"
#include "host-sim/client/settings.hpp"
#include "tests/rig/followed_rig.hpp"
#include "tests/rig/watched_rig.hpp"

namespace plenum::host::rig {
namespace {

using client::Session;

/// A board whose owner has set all of it otherwise than it is delivered.
/// Among others TPDO 5 sends what its installer wants, and where.
void set_otherwise(Session& session) {
  session.configure_stream({.chambers = 0x01, .every_ticks = 7, .largest_volume_m3 = 2e-3});
  const std::uint16_t tpdo = canopen::object::nth(canopen::object::kTpdoCommunication, client::kStreamTpdo);
  for (const std::uint32_t off : {canopen::cob::kInvalid, 0U})
    session.write<std::uint32_t>(tpdo, 1, off | 0x4F1U);
  session.configure_setpoints(client::SetpointFormat::pascal);
  session.write<std::uint8_t>(canopen::object::kPreviewTicks, 0, 5);
}

void expect_same(const std::vector<client::Setting>& before, const std::vector<client::Setting>& after) {
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(before[i].bits, after[i].bits)
        << std::hex << before[i].id.index << "h:" << int{before[i].id.sub} << ' ' << before[i].name;
  }
}

TEST(Capture, LeavesTheSettingsAsTheyWere) {
  WatchedRig watched(mpye_rig({.chambers = 2}));
  Session session(watched, 1);
  set_otherwise(session);
  const auto before = client::read_settings(session);
  client::capture(session, {.seconds = 0.1, .chambers = 2});
  expect_same(before, client::read_settings(session));
}

TEST(Capture, LogsTheSupplyOfABoardThatWatchesIt) {
  for (const float supply_low_kPa : {0.0F, 300.0F}) {
    RigConfig config = mpye_rig({.chambers = 8});
    config.board[0].settings.board.supply_low_kPa = supply_low_kPa;
    WatchedRig watched(config);
    Session session(watched, 1);
    const auto before = client::read_settings(session);
    const auto rows = client::capture(session, {.seconds = 0.5});
    const trace::Log log = tools::log_of(rows, 2);
    ASSERT_EQ(log.supply_Pa.size(), supply_low_kPa > 0.0F ? rows.size() : 0U);
    for (const double supply_Pa : log.supply_Pa) EXPECT_NEAR(supply_Pa, 700e3, 2e3);
    expect_same(before, client::read_settings(session));
  }
}

TEST(Capture, OfABoardThatStreamsToSomebodyIsRefusedAndTakesNothingFromHim) {
  WatchedRig watched(mpye_rig({.chambers = 1}));
  Session other(watched, 1), session(watched, 1);
  session.upload_models(fitted_models(0.2));
  other.configure_stream({.chambers = 1});
  const auto before = client::read_settings(session);
  try {
    client::capture(session, {.seconds = 0.1, .chambers = 1});
    FAIL() << "not refused";
  } catch (const client::Refused& refused) {
    EXPECT_THAT(refused.what(), ::testing::HasSubstr("its TPDO 5 streams on 680h already, expected it off"));
  }
  expect_same(before, client::read_settings(session));
  // The remedy that it names.
  session.nmt(canopen::NmtCommand::reset_communication);
  session.wait_boot_up(1.0);
  EXPECT_EQ(client::capture(session, {.seconds = 0.1, .chambers = 1}).size(), 10U);
}

// They would be excited, or led to 0 Pa.
TEST(Capture, DrivesNothingWhereAChamberInUseIsLeftOut) {
  WatchedRig watched(mpye_rig({.chambers = 2}));
  Session session(watched, 1);
  session.upload_models(fitted_models(0.2));
  EXPECT_THROW(client::capture(session, {.seconds = 0.1, .chambers = 1}), std::invalid_argument);
  const std::vector<std::vector<double>> reference_Pa{std::vector<double>(10, 300e3)};
  EXPECT_THROW(client::follow(session, reference_Pa, {.chambers = 1}), std::invalid_argument);
  watched.wait(0.1);
  for (const auto& moment : watched.moments)
    for (const auto& chamber : moment[0]) EXPECT_EQ(chamber.command_V, watched.moments[0][0][0].command_V);
  session.write<std::uint8_t>(canopen::object::kChamberChoices + 1, 1, 0);
  EXPECT_EQ(client::capture(session, {.seconds = 0.1, .chambers = 1}).size(), 10U)
      << "it is not in use any more";
}

TEST(Follow, LeavesTheSettingsAsTheyWere) {
  WatchedRig watched(mpye_rig(followed_rig(0.2)));
  Session session(watched, 1);
  session.upload_models(fitted_models(0.2));
  set_otherwise(session);
  const auto before = client::read_settings(session);
  client::follow(session, same_for_both(std::vector<double>(10, 300e3)), {.chambers = kFollowed});
  expect_same(before, client::read_settings(session));
}

// What HOLD, and a fault, lead a chamber to is its owner's.
TEST(Follow, LeavesTheHoldSetPointsAndTheModeAsTheyWereAlsoWhenItFails) {
  WatchedRig watched(mpye_rig(followed_rig(0.2)));
  Session session(watched, 1);
  session.upload_models(fitted_models(0.2));
  constexpr auto kMode = static_cast<std::int8_t>(canopen::ControlMode::pressure_open_loop);
  session.write(canopen::object::kControlMode, 0, kMode);
  session.write<std::int16_t>(canopen::object::kHoldSetpoint, 1, 1200);
  const auto expect_as_before = [&] {
    EXPECT_EQ(session.read<std::int16_t>(canopen::object::kHoldSetpoint, 1), 1200) << "[mbar]";
    EXPECT_EQ(session.read<std::int8_t>(canopen::object::kControlMode, 0), kMode);
  };
  const auto reference = same_for_both(std::vector<double>(50, 300e3));
  client::follow(session, reference, {.chambers = kFollowed});
  expect_as_before();
  watched.rig.bus().drop_when([count = 0](const client::CanFrame& frame, std::size_t) mutable {
    return frame.id == client::kStreamIds + 1 && ++count == 5;
  });
  EXPECT_THROW(client::follow(session, reference, {.chambers = kFollowed}), client::ProtocolError);
  expect_as_before();
}

TEST(Follow, CountsItsSyncsForABoardThatExpectsIt) {
  WatchedRig watched(mpye_rig(followed_rig(0.2)));
  Session session(watched, 1);
  session.upload_models(fitted_models(0.2));
  session.write<std::uint8_t>(0x1019, 0, 10);
  EXPECT_EQ(
      client::follow(session, same_for_both(std::vector<double>(50, 300e3)), {.chambers = kFollowed}).size(),
      50U);
  EXPECT_EQ(client::capture(session, {.seconds = 0.5, .chambers = kFollowed}).size(), 50U);
}

TEST(Capture, BesideAnotherMasterThatCountsItsSyncsIsRefusedBeforeAnythingMoves) {
  WatchedRig watched(mpye_rig({.chambers = 1}));
  ports::SimulatedCanPort& other = watched.rig.attach("other master");
  Session session(watched, 1);
  session.write<std::uint8_t>(0x1019, 0, 10);
  const auto before = client::read_settings(session);
  // It sends one when the board has told 1019h.
  watched.rig.bus().drop_when([&other](const client::CanFrame& frame, std::size_t) {
    if (frame.id == 0x581 && frame.data[0] == 0x4F && frame.data[1] == 0x19 && frame.data[2] == 0x10)
      other.send({.id = 0x80, .length = 1, .data = {7}});
    return false;
  });
  try {
    client::capture(session, {.seconds = 0.1, .chambers = 1});
    FAIL() << "not refused";
  } catch (const client::Refused& refused) {
    EXPECT_THAT(refused.what(), ::testing::HasSubstr(
                                    "another master sends SYNC on 080h, and SYNCs are counted (1019h = 10)"));
  }
  watched.rig.bus().drop_when({});
  expect_same(before, client::read_settings(session));
  for (const auto& moment : watched.moments)
    EXPECT_EQ(moment[0][0].command_V, watched.moments[0][0][0].command_V);
}

TEST(Capture, ThatFailsLeavesTheBoardAtRestAndTheSettingsAsTheyWere) {
  WatchedRig watched(mpye_rig({.chambers = 2}));
  Session session(watched, 1);
  set_otherwise(session);
  const auto before = client::read_settings(session);
  watched.rig.bus().drop_when([count = 0](const client::CanFrame& frame, std::size_t) mutable {
    return frame.id == client::kStreamIds + 1 && ++count == 5;
  });
  EXPECT_THROW(client::capture(session, {.seconds = 1.0, .chambers = 2}), client::ProtocolError);
  EXPECT_EQ(watched.rig.board(0).controller().state(), safety::State::disabled);
  EXPECT_EQ(session.read<std::int8_t>(canopen::object::kControlMode, 0),
            static_cast<std::int8_t>(canopen::ControlMode::pressure_closed_loop));
  expect_same(before, client::read_settings(session));
}

}  // namespace
}  // namespace plenum::host::rig
