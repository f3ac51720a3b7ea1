// Staged models on the grid of their chamber, on a whole board: what is refused at upload, in which words, and how long it takes.
#include "firmware/inverse_run.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "firmware/canopen/objects.hpp"
#include "firmware/config/greybox_parameters.hpp"
#include "tests/firmware/board/bench.hpp"
#include "tests/firmware/board/greybox_image.hpp"

namespace plenum {
namespace {

using host::client::Refused;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
namespace object = canopen::object;

constexpr float kLowSupply_kPa = 50.0F, kLowAmbient_kPa = 12.6F;

/// An admissible set whose supply lies below all that the chamber regulates. Air that flows back through an inlet that opens meets an
/// exhaust that hardly closes: two commands have one end, and an inverse has one answer.
std::vector<std::uint8_t> with_a_wrong_inverse() {
  return greybox_with({{config::kOpenAbove, 1.36F},
                       {config::kExhaustBelow, 0.047F},
                       {config::kInletConductance, 4588.0F},
                       {config::kExhaustConductance, 0.149F},
                       {config::kInletLeak, 49.2F},
                       {config::kExhaustLeak, 21722.0F},
                       {config::kTransition, 4.65e-4F},
                       {config::kInletSlope, 1.4e-4F},
                       {config::kInletCurve, -0.325F},
                       {config::kExhaustSlope, 13.6F},
                       {config::kExhaustCurve, -15.8F},
                       {config::kSubsonicIndex, 0.26F},
                       {config::kCrackingRatio, 0.85F},
                       {config::kDischargeSlope, 0.8F},
                       {config::kVolumeExponent, 1.04F},
                       {config::kSupply, kLowSupply_kPa},
                       {config::kAmbient, kLowAmbient_kPa}});
}

TEST(InverseRunOnABoard, RefusesAModelWhoseInverseFailsWithThePoint) {
  Bench bench;
  bench.session.upload_model(2, image_of(kValve));
  EXPECT_THAT([&] { bench.session.upload_model(2, with_a_wrong_inverse(), host::client::Doubted::force); },
              ThrowsMessage<Refused>(AllOf(HasSubstr("chamber 3: model refused: its inverse fails at "),
                                           HasSubstr(" kPa, 93 mL, "), HasSubstr(" kPa off"))));
  const auto state = static_cast<std::uint16_t>(object::kSetState + 2);
  EXPECT_EQ(bench.session.read<std::uint8_t>(state, 1), 4) << "refused";
  EXPECT_EQ(bench.session.read<std::uint8_t>(state, 2), 16) << "its inverse fails";
  const double off_Pa =
      static_cast<double>(bench.session.read<float>(state, 18) - bench.session.read<float>(state, 17));
  EXPECT_GT(std::abs(off_Pa), 0.03e3 * static_cast<double>(kLowSupply_kPa - kLowAmbient_kPa));
  EXPECT_EQ(bench.session.download_model(2), image_of(kValve)) << "what was in force stays";
}

struct Unfit {
  Edits edits;
  const char* words;
};

TEST(InverseRunOnABoard, RefusesAValveThatDoesNotActAndADeadVolumeThatLeavesNone) {
  for (const Unfit& unfit : {
           Unfit{{{config::kOpenAbove, 15.0F}, {config::kExhaustBelow, -5.0F}},
                 "its valve does not act: at 351 kPa"},
           Unfit{{{config::kInletLeak, 100000.0F}}, "3.00 V lowers the pressure by "},
           Unfit{{{config::kInletConductance, 0.001F}}, "7.00 V raises the pressure by "},
           Unfit{{{config::kDeadVolume, -5000.0F}}, "dead_volume_mL is -5000, expected -93.5..5000"},
           Unfit{{{config::kInletSlope, -2.0F}}, "inlet_slope is -2, expected -1.85106..20"},
       }) {
    Bench bench;
    EXPECT_THAT([&] { bench.session.upload_model(0, greybox_with(unfit.edits)); },
                ThrowsMessage<Refused>(HasSubstr(unfit.words)))
        << unfit.words;
    EXPECT_TRUE(bench.session.download_model(0).empty());
  }
}

TEST(InverseRunOnABoard, ChecksOverTheLimitsOfTheChamber) {
  Settings settings = bench_settings();
  settings.chamber[1].command_high_V = 5.05F;  // below what opens the inlet
  settings.chamber[1].null_V = 5.0F;
  Bench bench(settings);
  bench.session.upload_model(0, greybox_with({}));
  EXPECT_THAT(
      [&] {
        bench.session.upload_model(1, greybox_with({{config::kTransition, 0.01F}}));
      },
      ThrowsMessage<Refused>(HasSubstr("5.05 V raises the pressure by ")));
}

// 2410h:1 may take the chamber into use later, and nobody would check the model then.
TEST(InverseRunOnABoard, ChecksAChamberThatIsNotInUseAsAnyOther) {
  Settings settings = bench_settings();
  settings.chamber[0].in_use = false;
  Bench bench(settings);
  const auto idle = greybox_with({{config::kOpenAbove, 15.0F}, {config::kExhaustBelow, -5.0F}});
  EXPECT_THAT([&] { bench.session.upload_model(0, idle, host::client::Doubted::force); },
              ThrowsMessage<Refused>(HasSubstr("its valve does not act")));
  EXPECT_TRUE(bench.session.download_model(0).empty());
}

TEST(InverseRunOnABoard, LetsAModelOfTheStoredSetBeThatWasInForce) {
  Bench bench;
  const auto stored = greybox_with({{config::kOpenAbove, 15.0F}});
  bench.store_models({stored});
  bench.board.start();
  bench.tick();
  EXPECT_EQ(bench.session.download_model(0), stored);
}

TEST(InverseRunOnABoard, TakesThreeTicksAChamberOneAfterTheOther) {
  Bench bench;
  const int begin = bench.ticks;
  for (std::uint16_t c = 0; c < kChambers; ++c)
    bench.session.sdo_write(static_cast<std::uint16_t>(object::kStagedModel + c), 0, greybox_with({}));
  const auto phase = [&](std::uint16_t c) {
    return bench.session.read<std::uint8_t>(static_cast<std::uint16_t>(object::kSetState + c), 1);
  };
  const int handed_in = bench.ticks - begin;
  ASSERT_EQ(handed_in, kChambers) << "each is answered in the tick that judges it, in which its check begins";
  for (int ticks = handed_in; ticks <= 3 * int{kChambers}; ++ticks, bench.run(1)) {
    for (std::uint16_t c = 0; c < kChambers; ++c)
      EXPECT_EQ(phase(c), ticks < 3 * (c + 1) ? 5 : 2) << "chamber " << c << " after " << ticks << " ticks";
  }
}

TEST(InverseRunOnABoard, BeginsAnewWithANewImage) {
  Bench bench;
  bench.session.sdo_write(object::kStagedModel, 0, greybox_with({{config::kOpenAbove, 15.0F}}));
  bench.run(1);
  bench.session.sdo_write(object::kStagedModel, 0, greybox_with({}));  // a tick
  bench.run(1);
  EXPECT_EQ(bench.session.read<std::uint8_t>(object::kSetState, 1), 5) << "checking";
  bench.run(1);
  EXPECT_EQ(bench.session.read<std::uint8_t>(object::kSetState, 1), 2) << "staged";
}

}  // namespace
}  // namespace plenum
