// capture() and follow() against the world that the rig simulates.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "host-sim/client/capture.hpp"
#include "host-sim/client/session.hpp"
#include "tests/rig/followed_rig.hpp"
#include "tests/rig/watched_rig.hpp"

namespace plenum::host::rig {
namespace {

using client::CapturedRow;
using client::Session;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;

constexpr double kStream_V = 10.0 / 65535.0;

/// The tick of the first row: the one whose pressures are bit for bit those of the row.
std::size_t tick_of(const CapturedRow& row, const WatchedRig& watched) {
  for (std::size_t k = 0; k < watched.moments.size(); ++k) {
    bool same = true;
    for (std::size_t c = 0; c < watched.moments[k][0].size(); ++c)
      same = same && static_cast<double>(watched.moments[k][0][c].image.actual_Pa) == row.sample[c].actual_Pa;
    if (same) return k;
  }
  throw std::logic_error("no tick has the pressures of this row");
}

TEST(Capture, HasOneRowForEachTickWhateverThePhaseOfTheMaster) {
  for (int start_us = 0; start_us < 10'000; start_us += 23) {
    WatchedRig watched(mpye_rig({.chambers = 8}));
    watched.wait(1e-6 * start_us);
    Session session(watched, 1);
    const auto rows = client::capture(session, {.seconds = 0.2});
    ASSERT_EQ(rows.size(), 20U);
    const std::size_t first = tick_of(rows[0], watched);
    for (std::size_t k = 0; k < rows.size(); ++k) {
      ASSERT_NEAR(rows[k].time_s, 0.01 * static_cast<double>(k), 1e-12);
      for (std::size_t c = 0; c < 8; ++c) {
        ASSERT_EQ(rows[k].sample[c].actual_Pa,
                  static_cast<double>(watched.moments[first + k][0][c].image.actual_Pa))
            << "Pa, row " << k << " chamber " << c << ", master starts at " << start_us << " us";
      }
    }
  }
}

TEST(Capture, RowsHoldWhatTheValveGotAndTheSensorsSaw) {
  const RigConfig config = mpye_rig({.chambers = 8});
  WatchedRig watched(config);
  Session session(watched, 1);
  const auto rows = client::capture(session, {.seconds = 10.0});
  const std::size_t first = tick_of(rows[0], watched);
  auto plants = fresh_plants(config);
  std::vector<double> mean_Pa(plants.size());
  double volume_squares = 0.0;
  for (std::size_t tick = 1; tick < first + rows.size(); ++tick) {
    for (std::size_t c = 0; c < plants.size(); ++c)
      mean_Pa[c] = plants[c].advance(watched.moments[tick - 1][0][c].command_V, kTick_s).mean_Pa;
    if (tick < first) continue;
    const std::size_t k = tick - first;
    for (std::size_t c = 0; c < plants.size(); ++c) {
      const client::StreamSample& sample = rows[k].sample[c];
      const ChamberConfig& chamber = config.board[0].chamber[c];
      // both converters round the same command
      ASSERT_NEAR(sample.command_V, watched.moments[tick][0][c].command_V, 1.01 * kStream_V)
          << "V, row " << k;
      ASSERT_NEAR(sample.actual_Pa, mean_Pa[c], 6.0 * mean_noise(config.board[0], chamber.pressure_Pa))
          << "Pa, row " << k << " chamber " << c;
      const double error_m3 = sample.volume_m3 - watched.moments[tick][0][c].volume_m3;
      ASSERT_LT(std::abs(error_m3), 0.002 * chamber.volume.mean_m3()) << "m3, row " << k << " chamber " << c;
      volume_squares += std::pow(error_m3 / chamber.volume.mean_m3(), 2);
    }
  }
  EXPECT_LT(std::sqrt(volume_squares / static_cast<double>(rows.size() * plants.size())), 3e-4)
      << "RMS of the volume's error over the mean volume";
}

TEST(Capture, KeepsThePressuresInsideItsLimits) {
  WatchedRig watched(mpye_rig({.chambers = 8, .volume_swing = 0.0}));
  Session session(watched, 1);
  client::capture(session, {.seconds = 10.0, .pressure_low_Pa = 150e3, .pressure_high_Pa = 500e3});
  for (std::size_t k = 200; k < watched.moments.size(); ++k) {
    for (std::size_t c = 0; c < 8; ++c) {
      ASSERT_LT(watched.moments[k][0][c].pressure_Pa, 540e3) << "tick " << k << " chamber " << c;
    }
  }
}

TEST(Capture, SameSeedGivesTheSameCommandsAndAnotherSeedOthers) {
  const auto commands = [](std::uint32_t seed) {
    WatchedRig watched(mpye_rig({.chambers = 2}));
    Session session(watched, 1);
    std::vector<double> found;
    for (const CapturedRow& row : client::capture(session, {.seconds = 1.0, .seed = seed, .chambers = 2})) {
      for (std::size_t c = 0; c < 2; ++c) found.push_back(row.sample[c].command_V);
    }
    return found;
  };
  EXPECT_EQ(commands(1), commands(1));
  EXPECT_NE(commands(1), commands(2));
}

TEST(Capture, OfTwoBoardsAtOnceHoldsTheChambersOfEach) {
  constexpr unsigned kEach = 2;
  WatchedRig watched(mpye_rig({.boards = 2, .chambers = kEach}));
  Session session(watched, 1);
  Session other(watched, 2);
  std::array streams{session.configure_stream({.chambers = 0x03}),
                     other.configure_stream({.chambers = 0x03})};
  std::array<std::vector<client::StreamRow>, 2> rows;
  session.nmt(canopen::NmtCommand::start);
  other.nmt(canopen::NmtCommand::start);
  session.subscribe([&](const client::Arrival& arrival) {
    for (std::size_t b = 0; b < 2; ++b)
      streams[b].accept(arrival.time_s, arrival.frame,
                        [&](const client::StreamRow& row) { rows[b].push_back(row); });
  });
  session.listen(1.0);
  for (std::size_t b = 0; b < 2; ++b) {
    ASSERT_GE(rows[b].size(), 99U);
    for (std::size_t k = 0; k < rows[b].size(); ++k) {
      ASSERT_EQ(rows[b][k].chambers, 0x03);
      const auto tick = static_cast<std::size_t>(rows[b][k].time_s / 0.01);
      for (std::size_t c = 0; c < kEach; ++c) {
        ASSERT_EQ(rows[b][k].sample[c].actual_Pa,
                  static_cast<double>(watched.moments[tick][b][c].image.actual_Pa))
            << "Pa, board " << b << " row " << k << " chamber " << c;
      }
    }
  }
}

// ---- follow()

class FollowWithPreview : public ::testing::TestWithParam<int> {
 protected:
  FollowWithPreview() : watched(mpye_rig(followed_rig(0.0))), session(watched, 1) {
    session.upload_models(fitted_models(0.0));
  }
  client::FollowOptions options() const {
    return {.preview_ticks = static_cast<std::uint8_t>(GetParam()), .chambers = kFollowed};
  }
  WatchedRig watched;
  Session session;
};

TEST_P(FollowWithPreview, ReferenceOfARowIsTheBoardsReferenceAtThatTick) {
  std::vector<double> reference_Pa;
  for (int k = 0; k < 200; ++k) reference_Pa.push_back(300e3 + 100e3 * std::sin(0.05 * k + 0.002 * k * k));
  const auto rows = client::follow(session, same_for_both(reference_Pa), options());
  ASSERT_EQ(rows.size(), reference_Pa.size());
  const std::size_t first = tick_of(rows[0], watched);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    // what the tick before is to end at; the bus carries millibars
    ASSERT_NEAR(static_cast<double>(watched.moments[first + k - 1][0][0].image.demand_Pa),
                rows[k].reference_Pa[0], 51.0)
        << "Pa, row " << k << ", preview " << GetParam() << " ticks";
    ASSERT_EQ(rows[k].reference_Pa[0], reference_Pa[k]);
  }
}

TEST_P(FollowWithPreview, SlowRampIsMetOnTimeAndWithoutSteadyError) {
  std::vector<double> reference_Pa;
  for (int k = 0; k < 100; ++k) reference_Pa.push_back(250e3);
  for (int k = 0; k < 200; ++k) reference_Pa.push_back(250e3 + 1e3 * k);
  for (int k = 0; k < 700; ++k) reference_Pa.push_back(450e3);
  const auto rows = client::follow(session, same_for_both(reference_Pa), options());
  const auto mean_error_Pa = [&](std::size_t from, std::size_t to, std::size_t c) {
    double sum = 0.0;
    for (std::size_t k = from; k < to; ++k)
      sum += rows[k].sample[c].actual_Pa - 0.5 * (reference_Pa[k - 1] + reference_Pa[k]);
    return sum / static_cast<double>(to - from);
  };
  for (std::size_t c = 0; c < kFollowed; ++c) {
    // the ramp climbs 1000 Pa a tick: nearer to its own tick's reference than to a neighbour's
    EXPECT_NEAR(mean_error_Pa(150, 299, c), 0.0, 500.0) << "Pa on the ramp, chamber " << c;
    // a fiftieth of a percent of the span: the dead band of the valve leaves no less
    EXPECT_NEAR(mean_error_Pa(800, 1000, c), 0.0, 120.0) << "Pa at rest, chamber " << c;
  }
}

INSTANTIATE_TEST_SUITE_P(Ticks, FollowWithPreview, ::testing::Values(0, 1, 2, 4, 8));

TEST(Follow, HealthyMinuteOfTwoChambersHasNoFault) {
  WatchedRig watched(mpye_rig(followed_rig(0.2)));
  Session session(watched, 1);
  session.upload_models(fitted_models(0.2));
  std::vector<double> reference_Pa;
  for (int k = 0; k < 6000; ++k) reference_Pa.push_back(350e3 + 150e3 * std::sin(0.06 * k));
  EXPECT_EQ(client::follow(session, same_for_both(reference_Pa), {.chambers = kFollowed}).size(), 6000U);
}

TEST(Follow, AfterAFaultOnlyAResetLetsTheBoardGoOn) {
  WatchedRig watched(mpye_rig(followed_rig(0.2)));
  Session session(watched, 1);
  session.upload_models(fitted_models(0.2));
  const std::vector<double> reference_Pa(50, 300e3);
  client::follow(session, same_for_both(reference_Pa), {.chambers = kFollowed});

  watched.rig.board(0).analog_in().set_dead(1, true);
  EXPECT_THROW(client::follow(session, same_for_both(reference_Pa), {.chambers = kFollowed}),
               client::Refused);
  EXPECT_THROW(session.reset_fault(), client::Refused) << "the sensor is still dead";
  watched.rig.board(0).analog_in().set_dead(1, false);
  watched.wait(0.1);
  EXPECT_THROW(client::follow(session, same_for_both(reference_Pa), {.chambers = kFollowed}), client::Refused)
      << "nobody has reset the fault";
  session.reset_fault();
  EXPECT_EQ(watched.rig.board(0).controller().state(), safety::State::disabled);
  EXPECT_EQ(client::follow(session, same_for_both(reference_Pa), {.chambers = kFollowed}).size(), 50U);
}

/// A board of two chambers, and a master that writes its control word.
class Reset : public ::testing::Test {
 protected:
  void control(unsigned bits) {
    session.write(canopen::object::kControlWord, 0, static_cast<std::uint16_t>(bits));
  }
  /// Whether the pressure sensor of a chamber is silent, and the time in which the board sees it.
  void silence(bool dead) {
    watched.rig.board(0).analog_in().set_dead(1, dead);
    watched.wait(0.1);
  }
  safety::State state() { return watched.rig.board(0).controller().state(); }
  std::uint32_t tick() { return watched.rig.board(0).controller().image().tick_count; }

  WatchedRig watched{mpye_rig(followed_rig(0.2))};
  Session session{watched, 1};
};

TEST_F(Reset, CountsWhenItsBitFallsAndRisesWithinATick) {
  namespace word = canopen::word;
  silence(true);
  control(word::kDisabled | word::kResetFault);
  watched.wait(0.1);
  ASSERT_EQ(state(), safety::State::fault_disabled) << "its cause stands";
  silence(false);
  const std::uint32_t before = tick();
  control(word::kDisabled);
  control(word::kDisabled | word::kResetFault);
  ASSERT_LE(tick(), before + 1) << "the test is of one tick";
  watched.wait(0.05);
  EXPECT_EQ(state(), safety::State::disabled);
}

TEST(Capture, ThatIsStoppedGivesTheRowsSoFarAndEndsAsItsEndDoes) {
  WatchedRig watched(mpye_rig({.chambers = 2}));
  Session session(watched, 1);
  std::size_t asked = 0;
  const auto rows =
      client::capture(session, {.seconds = 10.0, .chambers = 2, .stopped = [&] { return ++asked > 30; }});
  EXPECT_EQ(rows.size(), 30U);
  EXPECT_EQ(watched.rig.board(0).controller().state(), safety::State::disabled);
}

TEST(Capture, OfABoardThatSomebodyRegulatesIsRefusedAndTouchesNothing) {
  WatchedRig watched(mpye_rig(followed_rig(0.2)));
  Session session(watched, 1);
  session.upload_models(fitted_models(0.2));
  session.nmt(canopen::NmtCommand::start);
  session.request_state(canopen::word::kDisabled);
  session.request_state(canopen::word::kHold);
  EXPECT_THROW(client::capture(session, {.chambers = kFollowed}), client::Refused);
  EXPECT_THROW(
      client::follow(session, same_for_both(std::vector<double>(50, 300e3)), {.chambers = kFollowed}),
      client::Refused);
  watched.wait(0.1);
  EXPECT_EQ(watched.rig.board(0).controller().state(), safety::State::hold);
  EXPECT_EQ(watched.rig.board(0).controller().node().state(), canopen::NmtState::operational);
}

TEST(Capture, WithinLimitsThatLeaveNothingIsRefusedBeforeAnythingMoves) {
  WatchedRig watched(mpye_rig({.chambers = 2}));
  Session session(watched, 1);
  for (const auto& [low_Pa, high_Pa] : {std::pair{1e3, 4e3}, {900e3, 950e3}}) {
    EXPECT_THROW(
        client::capture(session, {.pressure_low_Pa = low_Pa, .pressure_high_Pa = high_Pa, .chambers = 2}),
        std::invalid_argument)
        << low_Pa << " to " << high_Pa << " Pa";
  }
  for (const auto& [low_V, high_V] : {std::pair{4.5F, 4.9F}, {5.5F, 7.0F}, {1.0F, 2.0F}}) {
    EXPECT_THROW(client::capture(session, {.command_low_V = low_V, .command_high_V = high_V, .chambers = 2}),
                 std::invalid_argument)
        << low_V << " to " << high_V << " V";
  }
  EXPECT_EQ(watched.rig.board(0).controller().state(), safety::State::init);
}

TEST(Capture, ThatAFaultEndsLeavesTheRowsFromBeforeIt) {
  WatchedRig watched(mpye_rig({.chambers = 2}));
  Session session(watched, 1);
  std::vector<CapturedRow> so_far;
  std::size_t asked = 0;
  const auto dies = [&] {
    if (++asked == 30) watched.rig.board(0).analog_in().set_dead(1, true);
    return false;
  };
  EXPECT_THROW(client::capture(session, {.seconds = 10.0, .chambers = 2, .stopped = dies, .so_far = &so_far}),
               client::Refused);
  EXPECT_GE(so_far.size(), 30U);
  EXPECT_LE(so_far.size(), 35U) << "of 1000: a sensor is stale after three ticks";
}

/// What a capture is refused with while `now(row)` happens.
std::string refusal_of_capture(Session& session, const std::function<void(std::size_t)>& now) {
  std::size_t row = 0;
  const auto happens = [&] {
    now(++row);
    return false;
  };
  try {
    client::capture(session, {.seconds = 2.0, .chambers = 2, .stopped = happens});
  } catch (const client::Refused& refused) {
    return refused.what();
  }
  return "none";
}

/// A master beside the session, who asks for states.
class OtherMaster {
 public:
  explicit OtherMaster(WatchedRig& watched) : port_(watched.rig.attach("other")) {}
  void control(std::uint8_t word) {
    port_.send({.id = 0x601, .length = 8, .data = {0x2B, 0x40, 0x60, 0, word, 0, 0, 0}});
  }

 private:
  ports::SimulatedCanPort& port_;
};

TEST(Capture, ThatAnotherMasterTakesTheBoardFromEndsAndSaysSo) {
  WatchedRig watched(mpye_rig({.chambers = 2}));
  Session session(watched, 1);
  OtherMaster other(watched);
  const auto shown = refusal_of_capture(session, [&](std::size_t row) {
    if (row == 30) other.control(1);
  });
  EXPECT_THAT(shown, MatchesRegex("node 1: has left ACTIVE by row 3[0-9] and is DISABLED, .*"));
}

TEST(Capture, TellsThatAnotherMasterHadTheBoardForAWhile) {
  WatchedRig watched(mpye_rig({.chambers = 2}));
  Session session(watched, 1);
  OtherMaster other(watched);
  const auto back = refusal_of_capture(session, [&](std::size_t row) {
    if (row == 30) other.control(3);
    if (row == 31) other.control(7);
  });
  EXPECT_THAT(back, HasSubstr("and is HOLD"));
}

TEST(Capture, AsksTheBoardAtTheEndWhereItDoesNotTellItsState) {
  WatchedRig watched(mpye_rig({.chambers = 2}));
  Session session(watched, 1);
  const std::uint32_t tpdo3 = session.read<std::uint32_t>(0x1802, 1);
  session.write(0x1802, 1, tpdo3 | canopen::cob::kInvalid);
  OtherMaster other(watched);
  const auto at_the_end = refusal_of_capture(session, [&](std::size_t row) {
    if (row == 30) other.control(1);
  });
  EXPECT_THAT(at_the_end, HasSubstr("has left ACTIVE by row 200 and is DISABLED"));
}

TEST(Capture, TellsTheFaultThatStopsTheStream) {
  constexpr std::uint16_t kErrorBehaviour = 0x1029;
  constexpr std::uint8_t kPreOperational = 0;
  WatchedRig watched(mpye_rig({.chambers = 2}));
  Session session(watched, 1);
  session.write(kErrorBehaviour, 2, kPreOperational);
  const auto fault = refusal_of_capture(session, [&](std::size_t row) {
    if (row == 30) watched.rig.board(0).analog_in().set_dead(1, true);
  });
  EXPECT_THAT(fault, HasSubstr("fault FF03h pressure stale, chamber 2 stands after the run"));
}

TEST(Follow, ThatLeadsAPressureAboveItsLimitEndsThere) {
  WatchedRig watched(mpye_rig(followed_rig(0.2)));
  Session session(watched, 1);
  session.upload_models(fitted_models(0.2));
  std::vector<double> reference_Pa(300, 250e3);
  std::fill(reference_Pa.begin() + 100, reference_Pa.end(), 400e3);
  std::vector<CapturedRow> so_far;
  EXPECT_THROW(client::follow(session, same_for_both(reference_Pa),
                              {.highest_Pa = 300e3, .chambers = kFollowed, .so_far = &so_far}),
               client::Refused);
  EXPECT_EQ(watched.rig.board(0).controller().state(), safety::State::disabled);
  ASSERT_GT(so_far.size(), 100U);
  EXPECT_EQ(so_far[99].reference_Pa[0], 250e3);
  EXPECT_EQ(so_far[100].reference_Pa[0], 400e3);
  EXPECT_LT(so_far.size(), 110U);
}

TEST(Follow, ThatIsStoppedWhileItSettlesDrivesNothingAndHasNoRows) {
  WatchedRig watched(mpye_rig(followed_rig(0.2)));
  Session session(watched, 1);
  session.upload_models(fitted_models(0.2));
  std::size_t asked = 0;
  bool active = false;
  const auto stopped = [&] {
    active = active || watched.rig.board(0).controller().state() == safety::State::active;
    return ++asked > 10;
  };
  const auto rows = client::follow(session, same_for_both(std::vector<double>(1000, 300e3)),
                                   {.chambers = kFollowed, .stopped = stopped});
  EXPECT_TRUE(rows.empty());
  EXPECT_FALSE(active);
  EXPECT_EQ(watched.rig.board(0).controller().state(), safety::State::disabled);
  asked = 0;
  EXPECT_EQ(client::follow(session, same_for_both(std::vector<double>(1000, 300e3)),
                           {.chambers = kFollowed, .stopped = [&] { return ++asked > 150; }})
                .size(),
            48U)
      << "rows: 150 questions, of which 100 while it settles, one before it drives, and one for the row of "
         "lead";
}

TEST_F(Reset, CountsWhenItsBitRisesAndFallsWithinATick) {
  namespace word = canopen::word;
  control(word::kDisabled);
  silence(true);
  ASSERT_EQ(state(), safety::State::fault_disabled);
  silence(false);
  const std::uint32_t before = tick();
  control(word::kActive | word::kResetFault);
  control(word::kDisabled);
  ASSERT_LE(tick(), before + 1) << "the test is of one tick";
  watched.wait(0.05);
  ASSERT_EQ(state(), safety::State::fault_disabled) << "it asked for motion";
  control(word::kDisabled | word::kResetFault);
  control(word::kActive);
  watched.wait(0.05);
  ASSERT_EQ(state(), safety::State::fault_disabled) << "so did what came after it";
  control(word::kDisabled | word::kResetFault);
  control(word::kDisabled);
  watched.wait(0.05);
  EXPECT_EQ(state(), safety::State::disabled);
}

// ---- the board's own comparison of models, by what it captured

client::ModelUpload with_scaled(const client::ModelUpload& upload, std::size_t parameter, float factor) {
  plenum::config::ModelParameters parameters;
  if (!plenum::config::decode(upload.image, parameters)) throw std::logic_error("the fitted image is none");
  parameters.value.at(parameter) *= factor;
  client::ModelUpload scaled = upload;
  plenum::config::encode(parameters, scaled.image);
  return scaled;
}

TEST(Upload, RefusesAWorseModelAfterACaptureUnlessForced) {
  constexpr std::size_t kC1 = 0, kC7 = 6;
  WatchedRig watched(mpye_rig(followed_rig(0.2)));
  Session session(watched, 1);
  const std::vector<client::ModelUpload> fitted = fitted_models(0.2);
  session.upload_models(fitted);  // no log yet: taken as they are
  client::capture(session, {.seconds = 12.0, .seed = 7, .chambers = kFollowed});

  for (const auto& worse : {with_scaled(fitted[0], kC1, 1.02F), with_scaled(fitted[1], kC7, 1.4F),
                            with_scaled(fitted[0], kC7, 0.7F)}) {
    EXPECT_THROW(session.upload_models(std::array{worse}), client::Refused)
        << "chamber " << int{worse.chamber};
    EXPECT_EQ(session.download_model(worse.chamber), fitted[worse.chamber].image);
  }
  // the log of a capture does not speak against what was fitted to another one
  session.upload_models(fitted);
  const client::ModelUpload worse = with_scaled(fitted[1], kC7, 1.4F);
  session.upload_models(std::array{worse}, client::Doubted::force);
  EXPECT_EQ(session.download_model(1), worse.image);
  session.upload_models(fitted);
  EXPECT_EQ(session.download_model(1), fitted[1].image) << "and the better one after it without force";
}

}  // namespace
}  // namespace plenum::host::rig
