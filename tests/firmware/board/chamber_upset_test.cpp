// A bit that has flipped in a chamber's memory. Wherever a value stands in it, it stands spoilt.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <type_traits>

#include "tests/firmware/board/bench.hpp"

namespace plenum {
namespace {

using numeric::Scalar;
using ::testing::Each;

/// Overwrites each number of the loop that is exactly `was`. Returns how many there were.
template <class Number>
int spoil(ChamberLoop& loop, Number was, Number is) {
  auto* const bytes = reinterpret_cast<unsigned char*>(&loop);
  int count = 0;
  for (std::size_t at = 0; at + sizeof was <= sizeof loop; at += alignof(Number)) {
    if (std::memcmp(bytes + at, &was, sizeof was) != 0) continue;
    std::memcpy(bytes + at, &is, sizeof is);
    ++count;
  }
  return count;
}

config::ModelParameters model_of(const std::array<float, 12>& values) {
  config::ModelParameters parameters;
  EXPECT_TRUE(config::decode(image_of(values), parameters));
  return parameters;
}

constexpr float kStart_kPa = 301.25F;
constexpr float kVolume_mL = 140.0F;

/// One chamber of the bench with its loop, in closed loop or excited. A copy goes on by itself.
struct Rig {
  explicit Rig(canopen::ControlMode mode) {
    const Settings settings = bench_settings();
    loop.configure(settings.chamber[0], settings.regulator);
    chamber.pressure_kPa = static_cast<double>(kStart_kPa);
    chamber.volume_mL = static_cast<double>(kVolume_mL);
    image.setpoint_Pa = Scalar(1000.0F * kStart_kPa);
    order = {.drive = safety::Drive::active, .commanded = true, .mode = mode};
    image.excitation = {.command_low_V = 3.25F,
                        .command_high_V = 6.75F,
                        .pressure_low_Pa = 200e3F,
                        .pressure_high_Pa = 500e3F};
    measure(static_cast<double>(kStart_kPa));
    loop.take_over(model_of(kValve));
  }

  void measure(double mean_kPa) {
    const auto pressure_V = static_cast<float>(0.01 * mean_kPa);
    loop.measure({.pressure = {pressure_V, true}, .position = {(kVolume_mL - 20.0F) / 30.0F, true}}, true,
                 true);
  }
  float tick() {
    measure(chamber.advance(static_cast<double>(command_V)));
    return command_V = loop.command(order, image);
  }

  ChamberLoop loop;
  Chamber chamber;
  canopen::ChamberImage image;
  ChamberLoop::Order order;
  float command_V = 5.0F;
};

TEST(ChamberUpset, ExcitationStaysWithinTheInstallersRangeWhateverBecomesOfItsOwn) {
  for (const float bound_V : {3.25F, 6.75F}) {
    for (const float spoilt_V : {-bound_V, 200.0F}) {
      Rig rig(canopen::ControlMode::excitation);
      rig.tick();
      ASSERT_GT(spoil(rig.loop, Scalar(bound_V), Scalar(spoilt_V)), 0);
      for (int i = 0; i < 300; ++i) {
        const float command_V = rig.tick();
        EXPECT_TRUE(command_V >= 3.0F && command_V <= 7.0F)
            << command_V << " V, tick " << i << ", " << bound_V << " V has become " << spoilt_V;
      }
    }
  }
}

TEST(ChamberUpset, RestingCommandStaysWithinTheConvertersRangeWhateverBecomesOfASetting) {
  for (const float spoilt_V : {-2.5F, 2.5e30F, std::numeric_limits<float>::quiet_NaN()}) {
    Rig rig(canopen::ControlMode::pressure_closed_loop);
    rig.order.must_vent = true;
    ASSERT_EQ(rig.tick(), 2.5F);
    rig.order.commanded = false;  // and so the settings are taken over no more
    ASSERT_GT(spoil(rig.loop, 2.5F, spoilt_V), 0);
    const float command_V = rig.tick();
    EXPECT_TRUE(command_V >= 0.0F && command_V <= 10.0F) << command_V << " V of " << spoilt_V;
  }
}

void expect_back_on_its_set_point(Rig& rig, const char* what) {
  for (int i = 0; i < 100; ++i) rig.tick();
  EXPECT_NEAR(rig.chamber.pressure_kPa, 301.25, 0.5) << "kPa, " << what;
  EXPECT_LT(std::abs(rig.image.residual_Pa), 500.0F) << "Pa, " << what;
}

TEST(ChamberUpset, AnEstimateThatIsNoNumberOrAbsurdIsBegunAnew) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  for (const float estimate : {kStart_kPa, kVolume_mL}) {
    for (const float spoilt : {kNaN, std::numeric_limits<float>::infinity(), -estimate, 1e9F, -1e30F}) {
      Rig rig(canopen::ControlMode::pressure_closed_loop);
      ASSERT_GT(spoil(rig.loop, Scalar(estimate), Scalar(spoilt)), 0);
      expect_back_on_its_set_point(rig, ::testing::PrintToString(spoilt).c_str());
    }
  }
}

/// Bits of the loop that state_intact() tells of when they flip, but for those in its flags at the end, of which not every one is a
/// bool then. In place: a copy need not have the padding, which is in the sums.
std::size_t told_bits(ChamberLoop& loop) {
  static_assert(std::is_trivially_destructible_v<ChamberLoop>);
  std::array<unsigned char, sizeof loop> before;
  auto* const bytes = reinterpret_cast<unsigned char*>(&loop);
  std::memcpy(before.data(), bytes, before.size());
  std::size_t told = 0;
  for (std::size_t bit = 0; bit < 8 * (sizeof loop - 16); ++bit) {
    bytes[bit / 8] ^= static_cast<unsigned char>(1U << bit % 8);
    if (!loop.state_intact()) ++told;
    std::memcpy(bytes, before.data(), before.size());
  }
  return told;
}

TEST(ChamberUpset, EveryBitOfWhatRunsOnAndDoesNotComeBackIsToldAtTheNextTick) {
  constexpr std::size_t kSeal = sizeof(std::uint64_t);
  // volume, speed and acceleration; c(u); command, play and place of the spool; what the sensor shows; six of the regulator's
  constexpr std::size_t kEstimates = 3 + control::CommandTrim::kNodes + 3 + 1 + 6;
  // the set points that are latched, and the reference at the tick's end
  constexpr std::size_t kLatched = control::ReferenceShaper::kMaxPreview + 1 + 1;
  // of a valve without delay: two commands, the place of the newest, and the delay, which says how many
  constexpr std::size_t kSent = 2 * sizeof(control::SentCommands::Sent) + 2 * sizeof(std::size_t);
  for (const bool excited : {false, true}) {
    Rig rig(excited ? canopen::ControlMode::excitation : canopen::ControlMode::pressure_closed_loop);
    for (int i = 0; i < 5; ++i) rig.tick();
    const std::size_t driver =
        excited ? sizeof(control::Excitation) : kLatched * sizeof(Scalar) + sizeof(std::uint32_t);
    EXPECT_EQ(told_bits(rig.loop), 8 * (kEstimates * sizeof(Scalar) + kSent + driver + kSeal))
        << (excited ? "excited" : "regulated");
  }
  Rig rig(canopen::ControlMode::pressure_closed_loop);
  rig.order.drive = safety::Drive::hold;
  for (int i = 0; i < 5; ++i) rig.tick();
  const std::size_t driver = (kLatched + 1) * sizeof(Scalar) + sizeof(std::uint32_t);
  EXPECT_EQ(told_bits(rig.loop), 8 * (kEstimates * sizeof(Scalar) + kSent + driver + kSeal)) << "held";
}

TEST(ChamberUpset, WithoutAFlipTheStateIsIntactWhateverIsOrderedAndSet) {
  Rig rig(canopen::ControlMode::pressure_closed_loop);
  rig.tick();  // it has measured once, out of turn
  const Settings settings = bench_settings();
  for (int i = 0; i < 60; ++i) {
    ASSERT_TRUE(rig.loop.state_intact()) << "tick " << i;
    rig.order.drive = i % 5 == 0 ? safety::Drive::safe : safety::Drive::active;
    rig.order.mode =
        i % 3 == 0 ? canopen::ControlMode::excitation : canopen::ControlMode::pressure_closed_loop;
    if (i % 7 == 0) rig.loop.configure(settings.chamber[0], settings.regulator);
    if (i % 7 == 0 || i % 11 == 0) rig.loop.take_over(model_of(kValve));
    rig.tick();
  }
}

TEST(ChamberUpset, WhatHasFlippedIsBegunAnewAndTheChamberComesBackToItsSetPoint) {
  Rig rig(canopen::ControlMode::pressure_closed_loop);
  for (int i = 0; i < 20; ++i) rig.tick();
  ASSERT_GT(spoil(rig.loop, Scalar(kStart_kPa), Scalar(590.0F)), 0);  // the reference among them
  ASSERT_FALSE(rig.loop.state_intact());
  expect_back_on_its_set_point(rig, "after the reference had flipped");
  EXPECT_TRUE(rig.loop.state_intact());
}

/// Flips a bit wherever this number stands in the controller, whichever part holds it.
void flip_where(const Controller& controller, Scalar number, int bit) {
  auto* const bytes = reinterpret_cast<unsigned char*>(const_cast<Controller*>(&controller));
  for (std::size_t at = 0; at + sizeof number <= sizeof controller; at += alignof(Scalar)) {
    if (std::memcmp(bytes + at, &number, sizeof number) == 0)
      bytes[at] ^= static_cast<unsigned char>(1U << bit);
  }
}

TEST(ChamberUpset, IsAFaultOfTheVeryTickWithSafeOutputsUntilAResetAndThenTheBoardRegulatesAgain) {
  constexpr double kSetpoint_kPa = 287.5;
  Bench bench;
  bench.go_active(kSetpoint_kPa);
  ASSERT_EQ(bench.image().error_code, 0);
  flip_where(bench.board.controller(), Scalar(static_cast<float>(kSetpoint_kPa)), 4);
  bench.tick();
  EXPECT_EQ(bench.image().error_code, 0xFF09);
  EXPECT_THAT(bench.analog_out.held_V, Each(5.0F)) << "V, the null";
  bench.run(50);
  EXPECT_EQ(bench.image().error_code, 0xFF09) << "until somebody resets it";
  for (const std::uint16_t word : Words{0x1, 0x9, 0x1, 0x3, 0x7}) {
    bench.control(word);
    bench.run(2);
  }
  bench.run(200);
  EXPECT_EQ(bench.image().error_code, 0);
  EXPECT_EQ(bench.state(), safety::State::active);
  for (const Chamber& chamber : bench.chamber) EXPECT_NEAR(chamber.pressure_kPa, kSetpoint_kPa, 0.5) << "kPa";
}

TEST(ChamberUpset, ASetPointThatHasFlippedIsToldAndIsNoSetPointAnyMore) {
  for (const bool hold : {false, true}) {
    Bench bench;
    bench.store_models();
    bench.board.start();
    bench.put(0, {1, 0});
    bench.run(2);
    auto& image = const_cast<canopen::ProcessImage&>(bench.image());
    canopen::ChamberImage& of = image.chamber[2];
    of.setpoint_Pa = of.hold_setpoint_Pa = Scalar(300e3F);
    auto* const bytes = reinterpret_cast<unsigned char*>(hold ? &of.hold_setpoint_Pa : &of.setpoint_Pa);
    bytes[2] ^= 0x10;
    bench.tick();
    EXPECT_EQ(image.error_code, 0xFF09);
    EXPECT_EQ(of.setpoint_Pa.value(), 0.0F) << "Pa";
    EXPECT_EQ(of.hold_setpoint_Pa.value(), 0.0F) << "Pa";
    EXPECT_TRUE(of.setpoint_Pa.intact() && of.hold_setpoint_Pa.intact());
  }
}

TEST(ChamberUpset, ACopyOfAChamberHasItsModelInItselfAndNoAddressOfOne) {
  Rig rig(canopen::ControlMode::pressure_closed_loop);
  for (int i = 0; i < 20; ++i) rig.tick();
  Rig alone = rig;
  Rig beside = rig;
  for (int i = 0; i < 50; ++i) {
    alone.image.setpoint_Pa = beside.image.setpoint_Pa =
        Scalar(1000.0F * (kStart_kPa + static_cast<float>(i)));
    const float command_V = alone.tick();
    std::array<float, 12> another = kValve;
    another[0] = 4.0F;
    rig.loop.take_over(model_of(another));
    ASSERT_EQ(beside.tick(), command_V) << "V, tick " << i;
    rig.loop.take_over(model_of(kValve));
  }
}

}  // namespace
}  // namespace plenum
