// A bit that has flipped in a chamber's memory. Wherever a value stands in it, it stands spoilt.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>

#include "tests/firmware/board/bench.hpp"

namespace plenum {
namespace {

using numeric::Scalar;

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
    loop.configure(settings.chamber[0], settings.regulator, settings.volume);
    chamber.pressure_kPa = static_cast<double>(kStart_kPa);
    chamber.volume_mL = static_cast<double>(kVolume_mL);
    image.setpoint_Pa = 1000.0F * kStart_kPa;
    order = {.drive = safety::Drive::active, .commanded = true, .mode = mode, .excitation = {}};
    order.excitation = {.command_low_V = 3.25F,
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

TEST(ChamberUpset, ACopyOfAChamberHasItsModelInItselfAndNoAddressOfOne) {
  Rig rig(canopen::ControlMode::pressure_closed_loop);
  for (int i = 0; i < 20; ++i) rig.tick();
  Rig alone = rig;
  Rig beside = rig;
  for (int i = 0; i < 50; ++i) {
    alone.image.setpoint_Pa = beside.image.setpoint_Pa = 1000.0F * (kStart_kPa + static_cast<float>(i));
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
