// What an acceptance tells of a stream from which a bus loses frames, and of boards with a defect.
#include "host-sim/tools/acceptance_run.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <utility>

#include "host-sim/client/session.hpp"
#include "host-sim/client/stream.hpp"
#include "host-sim/rig/standard_rigs.hpp"
#include "host-sim/tools/rig_link.hpp"

namespace plenum::host::rig {
namespace {

using client::CanFrame;

/// Loses frames of the stream.
class LossyLink final : public client::Link {
 public:
  using Lost = std::function<bool(const CanFrame&)>;

  LossyLink(client::Link& link, Lost lost) : link_(link), lost_(std::move(lost)) {}

  void send(const CanFrame& frame) override { link_.send(frame); }
  std::optional<CanFrame> receive(double timeout_s) override {
    for (const double end_s = now_s() + timeout_s;;) {
      const double left_s = end_s - now_s();
      const auto frame = link_.receive(left_s > 0.0 ? left_s : 0.0);
      if (!frame || !client::stream_block(*frame) || !lost_(*frame)) return frame;
    }
  }
  double now_s() const override { return link_.now_s(); }

 private:
  client::Link& link_;
  Lost lost_;
};

bool nothing(const CanFrame&) {
  return false;
}

tools::AcceptanceRun accept(Rig& rig, const tools::AcceptancePlan& plan, LossyLink::Lost lost = nothing) {
  tools::RigLink direct(rig);
  LossyLink lossy(direct, std::move(lost));
  tools::MeteredLink link(lossy);
  client::Session session(link, 1);
  return tools::run_acceptance(link, session, plan, [](double) {});
}

tools::AcceptanceRun run_with(unsigned chambers, LossyLink::Lost lost) {
  Rig rig(mpye_rig({.chambers = chambers}));
  return accept(rig, {.seconds = 2.0, .chambers = chambers, .motion = {}}, std::move(lost));
}

/// Of two seconds at 100 Hz every second row; the stream may be cut anywhere.
constexpr double kHalf = 100.0;
constexpr double kCut = 3.0;

TEST(AcceptanceRun, NoRowIsLostOfAStreamThatComesWhole) {
  for (const unsigned chambers : {1U, 3U, 8U}) {
    const tools::AcceptanceRun run = run_with(chambers, nothing);
    EXPECT_EQ(run.rows_lost, 0U) << chambers << " chambers";
    EXPECT_NEAR(static_cast<double>(run.rows), 2.0 * kHalf, kCut);
  }
}

TEST(AcceptanceRun, ATickOfWhichNothingCameIsARowLost) {
  for (const unsigned chambers : {1U, 3U}) {
    std::uint32_t frames = 0;
    const tools::AcceptanceRun run =
        run_with(chambers, [&](const CanFrame&) { return frames++ / chambers % 2 == 1; });
    EXPECT_NEAR(static_cast<double>(run.rows_lost), kHalf, kCut) << chambers << " chambers";
    EXPECT_NEAR(static_cast<double>(run.rows), kHalf, kCut);
  }
}

TEST(AcceptanceRun, TwoHalvesThatMakeARowOfTwoTicksAreARowLost) {
  std::uint32_t frames = 0;  // the second of a tick, and the first of the next
  const tools::AcceptanceRun run = run_with(2, [&](const CanFrame&) {
    const std::uint32_t at = frames++ % 4;
    return at == 1 || at == 2;
  });
  EXPECT_NEAR(static_cast<double>(run.rows_lost), kHalf, kCut);
}

TEST(AcceptanceRun, ATickOfWhichSomeCameIsOneRowLostAndNotTwo) {
  std::uint32_t frames = 0;
  const tools::AcceptanceRun run = run_with(2, [&](const CanFrame&) { return frames++ % 4 == 1; });
  EXPECT_NEAR(static_cast<double>(run.rows_lost), kHalf, kCut);
}

// ---- boards with a defect ----

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::size_t kFirstPosition = plenum::config::kChambers;
constexpr std::size_t kSupplyInput = 2 * plenum::config::kChambers;

/// Chambers at rest, the supply watched.
RigConfig still_rig(unsigned chambers) {
  RigConfig config = mpye_rig({.chambers = chambers, .volume_swing = 0.0});
  config.board.front().settings.board.supply_low_kPa = 300.0F;
  return config;
}

tools::AcceptancePlan plan_of(unsigned chambers, bool move) {
  tools::AcceptancePlan plan{.seconds = 10.0, .chambers = chambers, .motion = {}};
  if (move) {
    plan.motion = {.seconds = 30.0,
                   .command_low_V = 4.0F,
                   .command_high_V = 6.0F,
                   .pressure_low_Pa = 150e3,
                   .pressure_high_Pa = 400e3,
                   .chambers = chambers};
  }
  return plan;
}

/// The items that fail.
std::vector<std::string> failures(const tools::AcceptanceRun& run) {
  std::vector<std::string> ids;
  for (const client::Judged& one : client::judge(tools::measured_by(run), {}))
    if (one.verdict == client::Verdict::fail) ids.emplace_back(one.criterion.id);
  return ids;
}

std::string remark_on(const tools::AcceptanceRun& run, const std::string& id) {
  for (const client::Judged& one : client::judge(tools::measured_by(run), {}))
    if (one.criterion.id == id) return one.remark;
  return "no such item";
}

TEST(AcceptanceRun, AGoodBoardFailsInNothingAtRestAndMoving) {
  Rig rig(still_rig(2));
  const tools::AcceptanceRun run = accept(rig, plan_of(2, true));
  EXPECT_THAT(failures(run), IsEmpty());
  ASSERT_TRUE(run.moving);
  EXPECT_GE(run.moving->ticks, 3000U) << "of the 30 s of motion";
}

TEST(AcceptanceRun, TheNoiseOfPositionAndSupplyIsThatOfTheirConverter) {
  const RigConfig config = still_rig(2);
  Rig rig(config);
  const tools::AcceptanceRun run = accept(rig, plan_of(2, false));
  const plant::AdcConfig& adc = config.board.front().adc;
  const double step_V = (adc.high_V - adc.low_V) / std::pow(2.0, adc.bits);
  const double noise_V =
      std::sqrt((std::pow(adc.sample_noise_V, 2) + std::pow(step_V, 2) / 12.0) / adc.samples_per_tick);
  for (std::size_t c = 0; c < 2; ++c) {
    // The median of ten windows of 98 second differences: a standard error of 4 %.
    EXPECT_NEAR(run.position[c].noise, noise_V, 0.16 * noise_V) << "position " << c + 1 << " [V]";
    const double gain_mL_per_V =
        static_cast<double>(config.board.front().settings.chamber[c].volume_gain_mL_per_V);
    EXPECT_DOUBLE_EQ(tools::volume_noise_mL(run, c), gain_mL_per_V * run.position[c].noise);
  }
  ASSERT_TRUE(run.supply);
  const double noise_Pa = noise_V * config.board.front().supply_Pa.per_V;
  EXPECT_NEAR(run.supply->noise, noise_Pa, 0.4 * noise_Pa) << "a reading in ten ticks: one window, 10 %";
  EXPECT_NEAR(run.supply->mean, 700e3, noise_Pa);
}

TEST(AcceptanceRun, APressureThatIsStuckFailsByItsNameAndNoValveMoves) {
  Rig rig(still_rig(3));
  rig.board(0).analog_in().set_stuck(1, true);
  rig.run_until(kTick_ns);
  const double before_V = rig.board(0).analog_out().output_V(1);
  const tools::AcceptanceRun run = accept(rig, plan_of(3, true));
  EXPECT_THAT(run.stuck, ElementsAre("pressure 2"));
  EXPECT_THAT(failures(run), ElementsAre("stuck_channels"));
  EXPECT_THAT(remark_on(run, "stuck_channels"), HasSubstr("pressure 2: look at sensor"));
  EXPECT_THAT(run.moved, IsEmpty());
  EXPECT_THAT(remark_on(run, "chambers_amiss"), HasSubstr("a pressure is stuck"));
  EXPECT_EQ(rig.board(0).analog_out().output_V(1), before_V);
}

TEST(AcceptanceRun, APositionAndASupplyThatAreStuckFailByTheirNames) {
  Rig rig(still_rig(2));
  rig.board(0).analog_in().set_stuck(kFirstPosition, true);
  rig.board(0).analog_in().set_stuck(kSupplyInput, true);
  const tools::AcceptanceRun run = accept(rig, plan_of(2, false));
  EXPECT_THAT(run.stuck, ElementsAre("position 1", "supply"));
  EXPECT_THAT(failures(run), ElementsAre("stuck_channels"));
}

TEST(AcceptanceRun, OneBitInOneTickIsEnoughForAConverterThatIsQuiet) {
  Rig rig(still_rig(1));
  ports::SimulatedAnalogInput& inputs = rig.board(0).analog_in();
  inputs.set_stuck(0, true);
  std::uint32_t frames = 0;
  const tools::AcceptanceRun run = accept(rig, plan_of(1, false), [&](const CanFrame&) {
    if (++frames == 500) inputs.set_stuck(0, true);  // at another voltage from here on
    return false;
  });
  EXPECT_THAT(run.stuck, IsEmpty());
  EXPECT_EQ(run.reading[0].noise, 0.0) << "of the median window";
}

TEST(AcceptanceRun, AnInputThatNobodyUsesIsNotJudged) {
  RigConfig config = still_rig(2);
  config.board.front().settings.board.supply_low_kPa = 0.0F;
  Rig rig(config);
  {
    tools::RigLink link(rig);
    client::Session session(link, 1);
    session.write<std::uint8_t>(canopen::object::kChamberChoices + 1, 1, 0);  // not in use
  }
  for (const std::size_t input : {std::size_t{1}, kFirstPosition + 1, kSupplyInput})
    rig.board(0).analog_in().set_stuck(input, true);
  const tools::AcceptanceRun run = accept(rig, plan_of(2, false));
  EXPECT_THAT(run.stuck, IsEmpty());
  EXPECT_FALSE(run.supply);
}

TEST(AcceptanceRun, ValvesWhoseChannelsAreSwappedFailInBothChambers) {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    Rig rig(still_rig(3));
    rig.board(0).analog_out().wire(0, 1);
    rig.board(0).analog_out().wire(1, 0);
    tools::AcceptancePlan plan = plan_of(3, true);
    plan.motion->seed = seed;
    const tools::AcceptanceRun run = accept(rig, plan);
    EXPECT_THAT(failures(run), ElementsAre("chambers_amiss")) << "seed " << seed;
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_EQ(client::trouble_of(run.answer[c], c).empty(), c == 2)
          << "chamber " << c + 1 << ", seed " << seed;
  }
}

TEST(AcceptanceRun, AValveThatIsDeadFailsInItsChamberAlone) {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    Rig rig(still_rig(8));
    rig.board(0).analog_out().wire(1, std::nullopt);
    tools::AcceptancePlan plan = plan_of(8, true);
    plan.motion->seed = seed;
    const tools::AcceptanceRun run = accept(rig, plan);
    EXPECT_THAT(failures(run), ElementsAre("chambers_amiss")) << "seed " << seed;
    EXPECT_THAT(remark_on(run, "chambers_amiss"), testing::StartsWith("chamber 2 ")) << "seed " << seed;
    EXPECT_THAT(remark_on(run, "chambers_amiss"), testing::Not(HasSubstr(";"))) << "seed " << seed;
  }
}

TEST(AcceptanceRun, ATickThatIsLateWhileTheValvesMoveIsJudgedThere) {
  Rig rig(still_rig(1));
  bool once = false;
  const tools::AcceptanceRun run = accept(rig, plan_of(1, true), [&](const CanFrame&) {
    const bool moves = rig.board(0).controller().state() == safety::State::active;
    if (moves && !std::exchange(once, true)) rig.board(0).delay_next_tick();
    return false;
  });
  EXPECT_EQ(run.overruns, 0U);
  EXPECT_EQ(run.moving_overruns, 1U);
  ASSERT_TRUE(run.moving);
  EXPECT_EQ(run.moving->max_us, 10'000.0) << "a tick late";
  EXPECT_THAT(failures(run), Contains("moving_overruns"));
}

}  // namespace
}  // namespace plenum::host::rig
