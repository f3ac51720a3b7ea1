#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "tests/firmware/board/bench.hpp"

namespace plenum {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
namespace object = canopen::object;

TEST(Board, WakesUpInInitWithEveryValveAtItsSafeOutput) {
  for (const auto safe : {config::SafeOutput::null, config::SafeOutput::vent}) {
    Settings settings = bench_settings();
    for (auto& chamber : settings.chamber) chamber.safe_output = safe;
    Bench bench(settings);
    bench.board.start();
    EXPECT_EQ(bench.state(), safety::State::not_ready);
    bench.tick();
    EXPECT_EQ(bench.state(), safety::State::init);
    EXPECT_EQ(bench.image().status_word, 0x8);
    EXPECT_THAT(bench.analog_out.held_V, Each(safe == config::SafeOutput::null ? 5.0F : 2.5F));
    EXPECT_TRUE(bench.digital.outputs.valve_power);
    EXPECT_FALSE(bench.digital.outputs.fault_lamp);
  }
}

TEST(Board, NothingMovesHoweverLongNobodyAsks) {
  Bench bench;
  bench.store_models();
  bench.board.start();
  bench.streaming = true;
  bench.put(0, {1, 0});
  for (int i = 0; i < 500; ++i) {
    bench.tick();
    ASSERT_THAT(bench.analog_out.held_V, Each(5.0F)) << "tick " << i;
  }
  EXPECT_EQ(bench.state(), safety::State::init);
}

TEST(Board, TellsWhatIsAtItsPositionAndSupplySensors) {
  Bench bench;
  bench.board.start();
  bench.forced[kChambers + 2] = ports::AnalogReading{.mean_V = 3.25F, .fresh = true};
  bench.forced[2 * kChambers] = ports::AnalogReading{.mean_V = 6.5F, .fresh = true};
  bench.tick();
  EXPECT_EQ(bench.session.read<float>(object::kPascals + 2, 4), 3.25F);
  EXPECT_EQ(bench.session.read<float>(object::kSupply, 0), 650e3F) << "100 kPa/V, from 0";
  bench.forced[kChambers + 2] = ports::AnalogReading{};
  bench.tick();
  EXPECT_EQ(bench.session.read<float>(object::kPascals + 2, 4), 3.25F) << "the last that came";
}

TEST(Board, FullTransmitQueueLosesNoAnswerAndKeepsTheirOrder) {
  Bench bench;
  bench.board.start();
  bench.take();
  bench.can.room = 0;
  // reads of 1018h:1..4: as many answers as the node holds
  for (std::uint8_t sub = 1; sub <= 4; ++sub)
    bench.put(0x600 + Bench::kNode, {0x40, 0x18, 0x10, sub, 0, 0, 0, 0});
  bench.board.handle_frames();
  bench.run(20);
  ASSERT_THAT(bench.take(), IsEmpty());
  std::vector<std::uint8_t> order;
  for (bench.can.room = 1; order.size() < 4 && bench.ticks < 60; bench.tick()) {
    for (const ports::CanFrame& frame : bench.take()) {
      if (frame.id == 0x580 + Bench::kNode) order.push_back(frame.data[3]);
    }
  }
  EXPECT_THAT(order, ElementsAre(1, 2, 3, 4));
}

TEST(Board, FullTransmitQueueDelaysAnEmergencyButNeverLosesIt) {
  Bench bench;
  bench.go_active(300.0);
  bench.can.room = 0;
  bench.digital.inputs.emergency_stop = true;
  bench.run(50);
  bench.digital.inputs.emergency_stop = false;
  bench.run(5);
  bench.can.room = SIZE_MAX;
  bench.run(2);
  const auto emergencies = bench.take_emergencies();
  ASSERT_FALSE(emergencies.empty());
  EXPECT_EQ(emergencies.front().code, 0x9000);
}

TEST(Board, TellsOfEachFaultInTheTickInWhichItRises) {
  Bench bench;
  bench.go_active(300.0);
  bench.take();
  force(bench, 4, 0.0F);
  bench.tick();
  force(bench, 1, 7.5F);
  bench.digital.inputs.emergency_stop = true;
  bench.tick();
  bench.tick();
  using Code = std::pair<unsigned, unsigned>;
  std::vector<Code> told;
  for (const auto& emergency : bench.take_emergencies()) told.emplace_back(emergency.code, emergency.chamber);
  EXPECT_THAT(told, ElementsAre(Code{0xFF05, 5}, Code{0x9000, 0}, Code{0x8302, 2}, Code{0x9000, 0}));
  EXPECT_EQ(bench.image().error_code, 0x9000);
}

TEST(Board, RefusedUploadOrCommitNeverDisturbsTheActiveModel) {
  // The twin gets no upload: bit for bit the same commands are wanted.
  Bench bench, twin;
  for (Bench* one : {&bench, &twin}) one->go_active(300.0);
  const auto run_both = [&](const char* after) {
    while (twin.ticks < bench.ticks) twin.tick();  // an upload takes ticks
    bench.setpoint_kPa = twin.setpoint_kPa += 10.0;
    for (int i = 0; i < 5; ++i) {
      bench.tick();
      twin.tick();
      ASSERT_EQ(bench.analog_out.held_V, twin.analog_out.held_V) << "after " << after;
    }
    EXPECT_EQ(bench.session.download_model(0), image_of(kValve, 100)) << "after " << after;
  };
  std::vector<std::uint8_t> damaged = image_of(kValve, 1);
  damaged[30] ^= 4U;
  EXPECT_THROW(bench.session.upload_model(0, damaged), host::client::Refused);
  run_both("a damaged image");
  std::array<float, 12> inadmissible = kValve;
  inadmissible[8] = -1.0F;
  EXPECT_THROW(bench.session.upload_model(0, image_of(inadmissible)), host::client::Refused);
  run_both("a c9 below zero");
  // staged, but the commit's CRC is another's
  bench.session.sdo_write(object::kStagedModel, 0, image_of(kValve, 2));
  bench.session.write(object::kCommit, 1, std::uint8_t{1});
  bench.session.write(object::kCommit, 2, std::uint32_t{0x12345678});
  EXPECT_THROW(bench.session.write(object::kCommit, 3, config::kCommitKey), host::client::SdoAbort);
  run_both("a commit with a wrong CRC");
  // the mask names a chamber that has nothing staged
  const std::uint32_t crc = config::trailing_crc(image_of(kValve, 2));
  bench.session.write(object::kCommit, 1, std::uint8_t{3});
  bench.session.write(object::kCommit, 2, config::commit_crc({&crc, 1}));
  EXPECT_THROW(bench.session.write(object::kCommit, 3, config::kCommitKey), host::client::SdoAbort);
  run_both("a commit of a chamber without a staged image");
}

TEST(Board, CommitIsTakenOverAtOneTickForAllItsChambers) {
  Bench bench;
  bench.go_active(300.0);
  std::vector<std::uint32_t> crcs;
  for (std::uint16_t c = 0; c < kChambers; ++c) {
    const auto image = image_of(kValve, 20U + c);
    bench.session.sdo_write(static_cast<std::uint16_t>(object::kStagedModel + c), 0, image);
    crcs.push_back(config::trailing_crc(image));
  }
  bench.run(300);  // the shadow run
  bench.session.write(object::kCommit, 1, std::uint8_t{0xFF});
  bench.session.write(object::kCommit, 2, config::commit_crc(crcs));
  bench.session.write(object::kCommit, 3, config::kCommitKey);
  const auto in_force = [&] {
    std::vector<std::uint32_t> found;
    for (std::uint8_t c = 0; c < kChambers; ++c)
      found.push_back(config::trailing_crc(bench.board.controller().active_image(c)));
    return found;
  };
  const std::vector<std::uint32_t> before(kChambers, config::trailing_crc(image_of(kValve, 100)));
  EXPECT_EQ(in_force(), before) << "taken over between ticks";
  bench.tick();
  EXPECT_EQ(in_force(), crcs);
  EXPECT_EQ(bench.state(), safety::State::active);
}

/// The largest change of the command from one tick to the next around a commit, at a steady set point [V].
double bump_V(Bench& bench, const std::array<float, 12>& values) {
  std::vector<host::client::ModelUpload> uploads;
  for (std::uint8_t c = 0; c < kChambers; ++c) uploads.push_back({c, image_of(values, 9)});
  double bump = 0;
  float before_V = bench.analog_out.held_V[0];
  const auto watch = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) {
      bench.tick();
      bump = std::max(bump, std::abs(static_cast<double>(bench.analog_out.held_V[0] - before_V)));
      before_V = bench.analog_out.held_V[0];
    }
  };
  bench.session.upload_models(uploads);
  before_V = bench.analog_out.held_V[0];
  watch(100);
  return bump;
}

TEST(Board, TheSameModelCommittedAgainWhileActiveDoesNotMoveTheCommand) {
  Bench bench;
  bench.go_active(300.0);
  bench.run(400);
  EXPECT_LT(bump_V(bench, kValve), 0.002);
  EXPECT_NEAR(bench.chamber[0].pressure_kPa, 300.0, 0.05);
}

TEST(Board, TheSameModelCommittedOnARampLeavesTheCommandsAsTheyWere) {
  Bench bench, twin;
  for (Bench* one : {&bench, &twin}) {
    one->go_active(200.0);
    one->run(300);
  }
  const auto image = image_of(kValve, 2);
  bench.session.sdo_write(object::kStagedModel, 0, image);
  twin.run(bench.ticks - twin.ticks);               // until it was answered
  for (Bench* one : {&bench, &twin}) one->run(60);  // the shadow run
  double bump = 0.0;
  double residual_kPa = 0.0;
  for (int k = 0; k < 30; ++k) {
    if (k == 10) {
      const std::uint32_t crc = config::trailing_crc(image);
      bench.session.write(object::kCommit, 1, std::uint8_t{1});
      bench.session.write(object::kCommit, 2, config::commit_crc({&crc, 1}));
      bench.session.write(object::kCommit, 3, config::kCommitKey);
    }
    bench.setpoint_kPa = twin.setpoint_kPa += 10.0;
    bench.tick();
    twin.tick();
    ASSERT_EQ(bench.ticks, twin.ticks);
    bump =
        std::max(bump, std::abs(static_cast<double>(bench.analog_out.held_V[0] - twin.analog_out.held_V[0])));
    residual_kPa =
        std::max(residual_kPa, std::abs(static_cast<double>(bench.image().chamber[0].residual_Pa) / 1e3));
  }
  EXPECT_EQ(bench.session.download_model(0), image);
  EXPECT_LT(bump, 0.002) << "V";
  EXPECT_LT(residual_kPa, 0.1) << "kPa: the old estimate of the pressure is as good for the new model";
}

TEST(Board, StandingStillTheChamberIsHeldAtTheSetPointOfAPerfectModel) {
  Bench bench;
  bench.go_active(450.0);
  for (const Chamber& chamber : bench.chamber) EXPECT_NEAR(chamber.pressure_kPa, 450.0, 0.05);
  EXPECT_EQ(bench.image().error_code, 0);
  EXPECT_NEAR(static_cast<double>(bench.image().chamber[3].actual_Pa), 450e3, 50.0);
}

TEST(Board, HoldsThePressureAtWhichHoldingBeganUntilItIsToldAnother) {
  Bench bench;
  bench.go_active(450.0);
  bench.setpoint_kPa = 520.0;
  bench.run(100);
  bench.streaming = false;
  bench.control(0x3);
  bench.run(200);
  ASSERT_EQ(bench.state(), safety::State::hold);
  for (const Chamber& chamber : bench.chamber) EXPECT_NEAR(chamber.pressure_kPa, 520.0, 0.2);
  bench.session.write(canopen::object::of_module(canopen::object::kHoldSetpoint, 3), 1, std::int16_t{2000});
  bench.run(200);
  EXPECT_NEAR(bench.chamber[3].pressure_kPa, 200.0, 0.2);
  EXPECT_NEAR(bench.chamber[2].pressure_kPa, 520.0, 0.2);
  bench.control(0x7);
  bench.run(8);
  ASSERT_EQ(bench.state(), safety::State::active);
  EXPECT_NEAR(bench.chamber[2].pressure_kPa, 520.0, 0.2);
  EXPECT_NEAR(bench.chamber[3].pressure_kPa, 200.0, 0.2)
      << "and in ACTIVE until a set point comes: 6380h has 520 kPa";
}

// A chamber that has fallen to 320 kPa, as without supply, and whose reference falls by 10 kPa/s.
TEST(Board, LeadsNoRampToThePressureThatItHolds) {
  Settings settings = bench_settings();
  settings.chamber[2].ramp_type = config::RampType::two_rates;
  settings.chamber[2].reference_fall_kPa_per_s = 10.0F;
  Bench bench(settings);
  bench.go_active(450.0);
  bench.forced[2] = ports::AnalogReading{3.2F, true};
  bench.run(3);
  bench.control(0x3);
  bench.run(2);
  ASSERT_EQ(bench.state(), safety::State::hold);
  EXPECT_NEAR(bench.image().chamber[2].demand_Pa, 320e3F, 10.0F) << "Pa";
  EXPECT_NEAR(bench.image().chamber[1].demand_Pa, 450e3F, 100.0F) << "Pa";
}

TEST(Board, HealthyMinuteHasNoFaultAndNoEmergency) {
  Bench bench;
  bench.go_active(300.0);
  for (int second = 0; second < 60; ++second) {
    bench.setpoint_kPa = second % 2 == 0 ? 500.0 : 200.0;
    for (int i = 0; i < 100; ++i) {
      bench.tick();
      ASSERT_EQ(bench.image().error_code, 0) << "second " << second << " tick " << i;
      ASSERT_EQ(bench.state(), safety::State::active);
    }
    ASSERT_THAT(bench.take_emergencies(), IsEmpty());
  }
}

TEST(Board, ChamberNotInUseIsLeftAtNullWhateverItsInputsSay) {
  Settings settings = bench_settings();
  settings.chamber[7].in_use = false;
  Bench bench(settings);
  bench.forced[7] = ports::AnalogReading{};
  bench.forced[15] = ports::AnalogReading{};
  bench.go_active(300.0);
  EXPECT_EQ(bench.state(), safety::State::active);
  EXPECT_FLOAT_EQ(bench.analog_out.held_V[7], 5.0F);
  EXPECT_NEAR(bench.chamber[6].pressure_kPa, 300.0, 0.05);
}

// c4 v' of a volume that jumps by a hundred litres a tick, with the largest c4 there is: 1e10 kPa, which only float holds.
TEST(Board, TellsOnTheBusHowOftenFixedPointHadToCutANumberOff) {
  constexpr std::size_t kC4 = 3;
  constexpr std::uint8_t kSaturations = 12;
  Settings settings = bench_settings();
  settings.chamber[0].volume_gain_mL_per_V = 10000.0F;
  std::array<float, 12> model = kValve;
  model[kC4] = 1000.0F;
  Bench bench(settings);
  bench.store_models({image_of(model)});
  bench.board.start();
  bench.put(0, {1, 0});
  bench.run(20);
  const auto count = [&] { return bench.session.read<std::uint32_t>(object::kHealth, kSaturations); };
  EXPECT_EQ(count(), 0U) << "of volumes that stand still";
  for (const float position_V : {0.0F, 10.0F, 0.0F, 10.0F}) {
    bench.forced[kChambers] = ports::AnalogReading{position_V, true};
    bench.tick();
  }
  if constexpr (std::is_same_v<numeric::Scalar, numeric::Fixed>) {
    EXPECT_GT(count(), 0U);
  } else {
    EXPECT_EQ(count(), 0U);
  }
}

// The regulator squares the noise of its residuals: 1e10 kPa^2, which only float holds.
TEST(Board, CountsWhatItCutsOffBeforeItsFirstTickAndNotWhatAnotherBoardDoes) {
  Settings noisy = bench_settings();
  noisy.regulator.residual_noise_kPa = 1e5F;
  const Bench quiet, cut(noisy);
  EXPECT_EQ(quiet.image().saturation_count, 0U);
  EXPECT_EQ(cut.image().saturation_count > 0, (std::is_same_v<numeric::Scalar, numeric::Fixed>));
}

}  // namespace
}  // namespace plenum
