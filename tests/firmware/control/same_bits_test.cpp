// The model gives the same bits on every architecture and with every compiler, so that what was tested on the PC is what
// the board computes. The presets aarch64, armhf and armel (which has no floating-point unit at all) run this test, too.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <random>
#include <type_traits>

#include "firmware/config/crc32.hpp"
#include "firmware/control/greybox.hpp"
#include "firmware/control/supply_line.hpp"
#include "firmware/control/tassa9.hpp"
#include "firmware/control/tassa9r.hpp"
#include "tests/firmware/scalars.hpp"

namespace plenum::control {
namespace {

// c1..c9, c_gamma, P_c, P_r: a wide valve, a steep one, a tilted one, one that closes tightly.
constexpr std::array<std::array<float, 12>, 4> kChambers = {{
    {5.0F, 0.5F, 0.02F, 0.05F, 0.001F, 0.01F, 20.0F, 0.1F, 0.05F, 0.1F, 700.0F, 100.0F},
    {4.2F, 20.0F, 50.0F, -0.1F, 0.0F, 0.001F, 3.0F, -0.4F, 0.2F, 0.1F, 600.0F, 95.0F},
    {6.1F, 1.3F, 0.001F, 0.0F, 0.01F, 0.1F, 400.0F, 0.9F, 0.5F, 0.5F, 900.0F, 101.0F},
    {5.5F, 2.0F, 0.5F, 0.02F, 0.0001F, 0.02F, 9.0F, 0.0F, 0.0003F, 0.1F, 500.0F, 90.0F},
}};

// In the order of Greybox::Parameter: a thin plate, a bent curve behind an ISO 6358 flow function.
constexpr std::array<std::array<float, Greybox::kParameters>, 2> kValves = {{
    {5.08F, 4.92F, 300.0F, 320.0F, 6.0F, 6.0F, 10.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F,   0.0F,  0.528F,
     0.5F,  1.0F,  0.0F,   5.0F,   1.4F, 0.0F, 0.0F,  0.0F, 0.8F, 0.0F, 0.0F, 700.0F, 101.0F},
    {5.5F, 4.6F,  60.0F, 70.0F, 0.1F, 0.2F, 1.0F, 1.0F, -0.5F, 0.1F, 0.6F, 0.2F,   -0.1F, 0.35F,
     0.6F, 0.95F, 0.1F,  20.0F, 1.2F, 0.0F, 0.0F, 0.0F, 0.8F,  0.0F, 0.0F, 600.0F, 95.0F},
}};

/// A multiple of 1/64 from low to high: exact in float, so that no compiler can round it differently.
float between(std::mt19937& random, int low, int high) {
  const auto steps = static_cast<unsigned>(high - low) * 64;
  return static_cast<float>(low) + static_cast<float>(static_cast<unsigned>(random()) % steps) * 0x1p-6F;
}

using Bits = std::conditional_t<sizeof(Scalar) == 4, std::uint32_t, std::uint64_t>;

std::uint32_t crc_with(std::uint32_t before, Scalar value) {
  const auto bits = std::bit_cast<Bits>(value);
  std::array<std::uint8_t, sizeof bits> bytes{};
  for (unsigned i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(bits >> (8 * i));
  return config::crc32(bytes, before);
}

ChamberMotion any_motion(std::mt19937& random) {
  return {.volume_mL = between(random, 1, 500), .volume_rate_mL_s = between(random, -300, 300)};
}

/// Of a model's step and inverse over many random states; `any_supply`: which is not always what it states.
std::uint32_t crc_of(const PressureModel& model, std::mt19937& random, std::uint32_t crc,
                     bool any_supply = false) {
  for (int i = 0; i < 5'000; ++i) {
    ChamberMotion motion = any_motion(random);
    if (any_supply && i % 2 != 0) motion.supply = 0.5F + 0.125F * between(random, 0, 6);
    const float pressure_kPa = between(random, 90, 900);
    const float target_kPa = between(random, 90, 900);
    const float command_V = between(random, 0, 10);
    const Prediction next = model.step(pressure_kPa, command_V, motion, 1.0F);
    const Inverse back = model.inverse(pressure_kPa, target_kPa, motion, command_V);
    for (const Scalar value :
         {next.end_kPa, next.mean_kPa, back.command_V, back.reached_kPa, back.by_command_kPa_V})
      crc = crc_with(crc, value);
  }
  return crc;
}

/// Of a digest for each scalar, that of the core's.
constexpr std::uint32_t of_scalar(std::uint32_t of_float, std::uint32_t of_fixed) {
  return std::is_same_v<Scalar, float> ? of_float : of_fixed;
}

// The numbers below are what gcc 12 gives on x86-64. Whoever changes the arithmetic writes the new value here, and sees it in
// all presets.

TEST(SameBits, OfTheNineParameterModelOnEveryArchitecture) {
  std::mt19937 random(6);
  std::uint32_t crc = 0;
  for (const auto& parameters : kChambers) {
    Tassa9 model;
    model.configure(scalars(parameters), 0.0F, 10.0F);
    crc = crc_of(model, random, crc);
  }
  EXPECT_EQ(crc, of_scalar(0xD40D4C83U, 0x9D924544U)) << std::hex << "found " << crc;
}

TEST(SameBits, OfTheRepairedFormOnEveryArchitecture) {
  std::mt19937 random(8);
  std::uint32_t crc = 0;
  for (const auto& parameters : kChambers) {
    std::array<float, Tassa9r::kParameters> without_c4{};
    std::copy_n(parameters.begin(), 3, without_c4.begin());
    std::copy(parameters.begin() + 4, parameters.end(), without_c4.begin() + 3);
    Tassa9r model;
    model.configure(scalars(without_c4), 0.0F, 10.0F);
    crc = crc_of(model, random, crc);
  }
  EXPECT_EQ(crc, of_scalar(0xF514640CU, 0xABE9B3A9U)) << std::hex << "found " << crc;
}

TEST(SameBits, OfTheGreyBoxModelOnEveryArchitecture) {
  std::mt19937 random(7);
  std::uint32_t crc = 0;
  for (const auto& parameters : kValves) {
    Greybox model;
    model.configure(scalars(parameters), 0.0F, 10.0F);
    crc = crc_of(model, random, crc, true);
  }
  EXPECT_EQ(crc, of_scalar(0xDA1A4365U, 0x01931EECU)) << std::hex << "found " << crc;
}

TEST(SameBits, OfASupplyThatDroopsOnEveryArchitecture) {
  std::mt19937 random(9);
  std::uint32_t crc = 0;
  Greybox model;
  model.configure(scalars(kValves.front()), 0.0F, 10.0F);
  for (const float recovery_ticks : {0.0F, 0.75F, 12.0F}) {
    SupplyLine line;
    line.configure({.supply_kPa = 700.0F,
                    .resistance_s_L = 1.5F,
                    .recovery_ticks = recovery_ticks,
                    .followed_share = 0.75F},
                   0.3125F);
    for (int i = 0; i < 2'000; ++i) {
      line.measured(between(random, 500, 800));
      ChamberMotion motion = any_motion(random);
      motion.supply = line.supply();
      const float command_V = between(random, 0, 10);
      const float pressure_kPa = between(random, 90, 700);
      const Prediction next = line.step(line.part(), 0.3125F, model, pressure_kPa, model.opening(command_V),
                                        motion, model.moving(motion));
      for (const Scalar value : {next.end_kPa, next.mean_kPa, line.supply()}) crc = crc_with(crc, value);
    }
  }
  EXPECT_EQ(crc, of_scalar(0xCD4FDA24U, 0x05C92F7BU)) << std::hex << "found " << crc;
}

}  // namespace
}  // namespace plenum::control
