// What a board remembers against the world that the rig simulates.
#include "host-sim/client/board_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/rig/watched_rig.hpp"

namespace plenum::host::rig {
namespace {

using client::Session;
using testing::HasSubstr;

namespace object = canopen::object;

/// The rows are those of `rows.size()` ticks on end, which end where the world's valves were driven last.
void expect_rows_of_the_world(const std::vector<client::CapturedRow>& rows, const WatchedRig& watched) {
  const auto is_row = [&](std::size_t tick) {
    return static_cast<double>(watched.moments[tick][0][0].image.actual_Pa) == rows[0].sample[0].actual_Pa;
  };
  std::size_t first = 0;
  while (first < watched.moments.size() && !is_row(first)) ++first;
  ASSERT_LE(first + rows.size(), watched.moments.size()) << "no tick has the pressure of the first row";
  constexpr double kHalfCode_V = 0.5 * 10.0 / 65535.0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    ASSERT_NEAR(rows[k].time_s, 0.01 * static_cast<double>(k), 1e-12);
    for (std::size_t c = 0; c < watched.moments[first + k][0].size(); ++c) {
      const Moment& truth = watched.moments[first + k][0][c];
      const client::StreamSample& got = rows[k].sample[c];
      ASSERT_EQ(got.actual_Pa, static_cast<double>(truth.image.actual_Pa)) << "row " << k << " chamber " << c;
      ASSERT_NEAR(got.command_V, static_cast<double>(truth.image.command_V), 1.01 * kHalfCode_V)
          << "row " << k << " chamber " << c;
      ASSERT_EQ(got.volume_m3, static_cast<double>(truth.image.volume_m3)) << "row " << k << " chamber " << c;
    }
  }
}

TEST(BoardLog, HoldsTheTicksInWhichTheValvesWereDriven) {
  WatchedRig watched(mpye_rig({.chambers = 8}));
  Session session(watched, 1);
  client::capture(session, {.seconds = 3.0});
  const client::Remembered log = client::remembered(session, 8);
  EXPECT_GE(log.rows.size(), 300U);
  expect_rows_of_the_world(log.rows, watched);
  EXPECT_EQ(session.read<std::uint8_t>(object::kCapture, 4), 0) << "the log rolls again";
}

TEST(BoardLog, KeepsTheLastTenSecondsUpToAnEmergencyStop) {
  WatchedRig watched(mpye_rig({.chambers = 2}));
  Session session(watched, 1);
  watched.rig.board(0).digital().set_emergency_stop(false);
  try {
    client::capture(session, {.seconds = 15.0, .chambers = 2}, [&](double done) {
      if (done > 0.9) watched.rig.board(0).digital().set_emergency_stop(true);
    });
    FAIL() << "the stop went unnoticed";
  } catch (const std::runtime_error&) {
  }
  const client::Remembered log = client::remembered(session, 2);
  EXPECT_GT(log.rows.size(), 1000U);
  expect_rows_of_the_world(log.rows, watched);
}

TEST(BoardLog, IsNoneBeforeAnyValveWasDriven) {
  WatchedRig watched(mpye_rig({.chambers = 1}));
  Session session(watched, 1);
  watched.wait(0.1);
  EXPECT_THROW(client::remembered(session, 1), client::Refused);
  EXPECT_EQ(session.read<std::uint8_t>(object::kCapture, 4), 0) << "the log rolls again";
}

TEST(BoardLog, IsNotTakenFromAClientThatRecords) {
  WatchedRig watched(mpye_rig({.chambers = 1}));
  Session session(watched, 1);
  session.write<std::uint16_t>(object::kCapture, 3, 500);
  session.write<std::uint8_t>(object::kCapture, 1, 2);
  try {
    client::remembered(session, 1);
    FAIL() << "the recording was taken";
  } catch (const client::Refused& error) {
    EXPECT_THAT(error.what(), HasSubstr("0 of 500 rows"));
  }
  EXPECT_EQ(session.read<std::uint8_t>(object::kCapture, 4), 1) << "the recording goes on";
}

TEST(BoardLog, RefusesBytesThatAreNoLog) {
  WatchedRig watched(mpye_rig({.chambers = 1}));
  Session session(watched, 1);
  client::capture(session, {.seconds = 1.0, .chambers = 1});
  session.write<std::uint8_t>(object::kCapture, 1, 1);
  const std::vector<std::uint8_t> bytes = session.sdo_read_domain(object::kCaptureBuffer, 0);
  EXPECT_EQ(client::parse_board_log(bytes, 0).rows.size(), session.read<std::uint16_t>(object::kCapture, 5));
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::vector<std::uint8_t> damaged = bytes;
    damaged[i] ^= 0x10;
    EXPECT_THROW(client::parse_board_log(damaged, 0), client::ProtocolError) << "byte " << i;
  }
  for (const std::size_t size : {std::size_t{0}, std::size_t{23}, bytes.size() - 1}) {
    EXPECT_THROW(client::parse_board_log(std::span(bytes).first(size), 0), client::ProtocolError)
        << size << " bytes";
  }
  EXPECT_THROW(client::parse_board_log(bytes, 1), client::ProtocolError) << "of another chamber";
}

}  // namespace
}  // namespace plenum::host::rig
