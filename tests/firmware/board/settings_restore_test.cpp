// Settings over start and reset: what comes back, and that nothing moves by it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "firmware/canopen/objects.hpp"
#include "tests/firmware/board/bench.hpp"

namespace plenum {
namespace {

using canopen::NmtCommand;
namespace object = canopen::object;

constexpr std::uint8_t kPressureHigh = 10;  // sub-indices of 2400h
constexpr std::uint8_t kOverPressure = 11;
constexpr float kInstalledOver_kPa = 700.0F;  // of bench_settings()

/// A board in INIT that has time to store.
struct Storing : Bench {
  explicit Storing(const config::Slots& slots = config::PowerCutMedium::blank()) {
    store = config::PowerCutMedium(slots);
    board.start();
    storing = true;
    tick();
    take();
  }
  float field(std::uint8_t sub) { return session.read<float>(object::kChamberSettings, sub); }
  void set(std::uint8_t sub, float value) { session.write<float>(object::kChamberSettings, sub, value); }
  void save() { session.write(object::kStore, 3, canopen::kSaveSignature); }
  void load() { session.write(object::kRestore, 3, canopen::kLoadSignature); }
  void reset(NmtCommand command = NmtCommand::reset_node) { Bench::reset(command); }
};

// ---- a reset and the pressure ----

/// ACTIVE at a limit of 250 kPa that is not saved; 400 kPa are.
struct Tightened : Bench {
  Tightened() {
    storing = true;
    go_active(300.0);
    streaming = false;
    control(0);
    run(4);
    limit(400.0F);
    session.write(object::kStore, 3, canopen::kSaveSignature);
    limit(250.0F);
    setpoint_kPa = 350.0;
    climb();
    run(100);
  }
  void limit(float value_kPa) {
    for (std::uint16_t c = 0; c < kChambers; ++c)
      session.write<float>(static_cast<std::uint16_t>(object::kChamberSettings + c), kPressureHigh,
                           value_kPa);
  }
};

TEST(SettingsRestore, WaitsUntilAResetHasTakenTheBoardToInit) {
  Tightened bench;
  ASSERT_EQ(bench.state(), safety::State::active);
  ASSERT_NEAR(bench.chamber[0].pressure_kPa, 250.0, 0.5);
  bench.put(0, {0x81, Bench::kNode});
  bench.put(0, {0x01, Bench::kNode});
  bench.control(0x7);
  bench.tick();
  EXPECT_EQ(bench.state(), safety::State::init);
  EXPECT_EQ(bench.image().control_word, 0) << "what came behind the reset found nobody";
  for (int i = 0; i < 100; ++i) {
    bench.tick();
    ASSERT_EQ(bench.state(), safety::State::init);
    ASSERT_EQ(bench.analog_out.held_V[0], 5.0F) << "shut";
  }
  EXPECT_EQ(bench.session.read<float>(object::kChamberSettings, kPressureHigh), 400.0F);
}

TEST(SettingsRestore, EndsARegulationByAnyNumberOfResetsAtOnce) {
  Tightened bench;
  bench.streaming = false;
  bench.take();
  for (int i = 0; i < 30; ++i) {
    bench.put(0, {static_cast<std::uint8_t>(i % 2 == 0 ? 0x82 : 0x81), Bench::kNode});
  }
  bench.tick();
  EXPECT_EQ(bench.state(), safety::State::init);
  while (bench.board.controller().node().is_resetting()) bench.tick();
  const auto frames = bench.take();
  EXPECT_EQ(std::count_if(frames.begin(), frames.end(),
                          [](const ports::CanFrame& frame) {
                            return frame.id == 0x700 + Bench::kNode && frame.data[0] == 0;
                          }),
            1)
      << "boot-up messages";
  EXPECT_EQ(bench.session.read<float>(object::kChamberSettings, kPressureHigh), 400.0F)
      << "a reset of the node is more than one of the communication";
}

TEST(SettingsRestore, LeavesWhatIsInForceUntilAChambersSettingsAreBackAsAWhole) {
  Storing board;
  board.set(9, 110.0F);
  board.set(kPressureHigh, 680.0F);
  board.set(kOverPressure, 690.0F);
  board.save();
  board.set(kPressureHigh, 300.0F);
  board.set(kOverPressure, 310.0F);
  board.session.nmt(NmtCommand::reset_node);
  int ticks = 0;
  for (board.tick(); board.board.controller().node().is_resetting(); board.tick()) ++ticks;
  EXPECT_GT(ticks, 3) << "in pieces";
  EXPECT_EQ(board.field(kPressureHigh), 680.0F);
  EXPECT_EQ(board.field(kOverPressure), 690.0F);
  EXPECT_EQ(board.image().store.skipped_rows, 0);
}

/// The order has been given, and its set is not composed yet, when the reset comes.
TEST(SettingsRestore, SavesNoHalfOfASetWhenAResetFollowsASaveAtOnce) {
  Storing board;
  board.set(kPressureHigh, 680.0F);
  board.set(kOverPressure, 690.0F);
  board.save();
  board.set(kOverPressure, 685.0F);
  board.put(0x600 + Bench::kNode, {0x23, 0x10, 0x10, 1, 's', 'a', 'v', 'e'});
  board.put(0, {0x81, Bench::kNode});
  board.tick();
  EXPECT_TRUE(board.board.controller().node().is_resetting());
  while (board.board.controller().node().is_resetting()) board.tick();
  board.run(100);
  Storing restarted(board.store.durable);
  EXPECT_EQ(restarted.image().store.skipped_rows, 0);
  EXPECT_EQ(restarted.field(kPressureHigh), 680.0F);
  EXPECT_EQ(restarted.field(kOverPressure), 690.0F);
}

TEST(SettingsRestore, LetsARegulationGoOnWhenOnlyTheCommunicationIsReset) {
  Bench bench;
  bench.go_active(300.0);
  bench.streaming = false;
  bench.control(0x3);
  bench.run(3);
  bench.session.nmt(NmtCommand::reset_communication);
  bench.run(10);
  EXPECT_EQ(bench.state(), safety::State::hold);
}

// ---- what is in force after it ----

TEST(SettingsRestore, ResetDropsWhatWasNotSaved) {
  Storing board;
  board.set(kOverPressure, 650.0F);
  board.reset(NmtCommand::reset_communication);
  EXPECT_EQ(board.field(kOverPressure), 650.0F);
  board.reset();
  EXPECT_EQ(board.field(kOverPressure), kInstalledOver_kPa) << "nothing is stored";
  board.save();
  board.set(kOverPressure, 640.0F);
  board.reset();
  EXPECT_EQ(board.field(kOverPressure), kInstalledOver_kPa);
}

TEST(SettingsRestore, ResetHasTheSetPointsOfTheStartAndTheHoldSetPointThatWasSaved) {
  Storing board;
  const auto read = [&](std::uint16_t object) { return board.session.read<std::int16_t>(object, 1); };
  const std::int16_t at_start = read(object::kSetpoint);
  const std::int16_t hold_at_start = read(object::kHoldSetpoint);
  board.session.write(object::kSetpoint, 1, std::int16_t{2345});
  board.session.write(object::kHoldSetpoint, 1, std::int16_t{3456});
  board.reset();
  EXPECT_EQ(read(object::kSetpoint), at_start);
  EXPECT_EQ(read(object::kHoldSetpoint), hold_at_start);
  board.session.write(object::kHoldSetpoint, 1, std::int16_t{3456});
  board.save();
  board.reset();
  EXPECT_EQ(read(object::kHoldSetpoint), 3456);
}

TEST(SettingsRestore, LoadBringsBackTheInstallersSettingsWithTheNextReset) {
  Storing board;
  board.set(kOverPressure, 650.0F);
  board.save();
  board.load();
  EXPECT_EQ(board.field(kOverPressure), 650.0F) << "before the reset";
  board.reset();
  EXPECT_EQ(board.field(kOverPressure), kInstalledOver_kPa);
  Storing restarted(board.store.durable);
  EXPECT_EQ(restarted.field(kOverPressure), kInstalledOver_kPa);
}

/// 700, 750 and 780 kPa over the installer's 101, 600 and 700 kPa: most orders of writing pass through settings that are not
/// admissible.
TEST(SettingsRestore, KeepsLimitsThatAreJudgedTogetherInAnyOrderOfTheirRows) {
  const auto bytes_of = [](float value) {
    std::vector<std::uint8_t> bytes(4);
    canopen::store_le(std::bit_cast<std::uint32_t>(value), bytes);
    return bytes;
  };
  std::array<std::uint8_t, 3> subs{9, 10, 11};
  const std::array<std::vector<std::uint8_t>, 3> values{bytes_of(700.0F), bytes_of(750.0F), bytes_of(780.0F)};
  do {
    Bench writer;
    std::vector<config::RecordRow> rows;
    for (const std::uint8_t sub : subs) {
      rows.push_back({.index = object::kChamberSettings, .sub = sub, .value = values.at(sub - 9U)});
    }
    writer.store_models(Bench::images_of(1), rows);
    Storing board(writer.store.durable);
    EXPECT_EQ(board.image().store.skipped_rows, 0);
    const auto is_kept = [&] {
      return board.field(9) == 700.0F && board.field(10) == 750.0F && board.field(11) == 780.0F;
    };
    EXPECT_TRUE(is_kept()) << "start";
    board.set(9, 110.0F);
    board.set(10, 300.0F);
    board.set(11, 400.0F);
    board.reset();
    EXPECT_TRUE(is_kept()) << "reset";
  } while (std::next_permutation(subs.begin(), subs.end()));
}

TEST(SettingsRestore, FallsBackOnTheInstallersSettingsOfTheChamberThatContradictsItself) {
  const std::vector<std::uint8_t> high{0x00, 0x00, 0x39, 0x44};  // 740 kPa, beyond the trip of 700 kPa
  Bench writer;
  writer.store_models(Bench::images_of(1), {{.index = 0x2400, .sub = kPressureHigh, .value = high}});
  Storing board(writer.store.durable);
  EXPECT_EQ(board.field(kPressureHigh), 600.0F);
  EXPECT_EQ(board.image().store.skipped_rows, 1);
  EXPECT_EQ(board.image().store.first_skipped, 0x240000U);
  board.set(kPressureHigh, 500.0F);
  board.reset();
  EXPECT_EQ(board.field(kPressureHigh), 600.0F) << "not what was written since the start";
}

}  // namespace
}  // namespace plenum
