// Whatever the bus and the sensors bring: a command is a number, and one that the installer allows.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <limits>
#include <random>
#include <set>

#include "tests/firmware/board/bench.hpp"

namespace plenum {
namespace {

class Storm {
 public:
  explicit Storm(unsigned seed) : random_(seed) {}

  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random_()) % n; }
  bool one_in(std::uint32_t n) { return below(n) == 0; }
  std::uint8_t byte() { return static_cast<std::uint8_t>(below(256)); }

  /// Numbers that programs trip over, and ordinary ones.
  float number() {
    constexpr float kBig = std::numeric_limits<float>::max();
    constexpr float kInf = std::numeric_limits<float>::infinity();
    constexpr std::array<float, 10> kAwkward = {
        std::numeric_limits<float>::quiet_NaN(), kInf, -kInf, kBig, -kBig, 1e-40F, 0.0F, -0.0F, 1e9F, -1.0F};
    if (one_in(4)) return std::bit_cast<float>(static_cast<std::uint32_t>(random_()));
    if (one_in(2)) return kAwkward[below(kAwkward.size())];
    return 0.001F * static_cast<float>(below(10'000));
  }

  std::vector<std::uint8_t> sdo_write() {
    constexpr std::array<std::uint16_t, 14> kIndices = {0x2310, 0x2160, 0x2120, 0x2228, 0x2150,
                                                        0x2110, 0x1400, 0x1600, 0x1800, 0x6040,
                                                        0x6043, 0x6380, 0x6394, 0x1017};
    std::uint16_t index = kIndices[below(kIndices.size())];
    if (index == 0x2150 || index == 0x2110 || index == 0x2310)
      index = static_cast<std::uint16_t>(index + below(8));
    if (index == 0x6380 || index == 0x6394) index = static_cast<std::uint16_t>(index + 0x800 * below(8));
    constexpr std::array<std::uint8_t, 4> kSizes = {0x2F, 0x2B, 0x23, 0x23};
    const std::uint32_t value = one_in(2) ? std::bit_cast<std::uint32_t>(number()) : below(8);
    std::vector<std::uint8_t> data = {kSizes[below(4)], static_cast<std::uint8_t>(index),
                                      static_cast<std::uint8_t>(index >> 8),
                                      static_cast<std::uint8_t>(below(6))};
    for (unsigned shift = 0; shift < 32; shift += 8)
      data.push_back(static_cast<std::uint8_t>(value >> shift));
    return data;
  }

  void strike(Bench& bench) {
    if (one_in(10)) bench.put(below(0x800), bytes(below(9)));
    if (one_in(5)) bench.put(0x600 + Bench::kNode, sdo_write());
    if (one_in(20)) bench.put(0x600 + Bench::kNode, bytes(8));
    if (one_in(10)) bench.put(0x200 + 0x100 * below(2) + Bench::kNode, bytes(8));
    if (one_in(200)) bench.put(0, {byte(), 0});
    if (one_in(3)) bench.put(0x80, {});
    if (one_in(2)) bench.put(0x80, {});
  }

  std::vector<std::uint8_t> bytes(std::uint32_t count) {
    std::vector<std::uint8_t> data;
    while (data.size() < count) data.push_back(byte());
    return data;
  }

 private:
  std::mt19937 random_;
};

class BoardInAStorm : public ::testing::TestWithParam<unsigned> {};

TEST_P(BoardInAStorm, NeverSendsACommandThatTheInstallerDoesNotAllow) {
  const unsigned seed = GetParam();
  Storm storm(seed);
  Bench bench;
  bench.store_models();
  bench.board.start();
  bench.put(0, {1, 0});
  int driven_ticks = 0;
  int faulty_ticks = 0;
  for (int tick = 0; tick < 5'000; ++tick) {
    // a master that wants to work, in a storm that breaks its sensors and its frames for a while
    const bool calm = tick / 100 % 2 == 0;
    constexpr std::array<std::uint16_t, 5> kWords = {0x1, 0x9, 0x1, 0x3, 0x7};
    if (tick % 4 == 0) bench.control(kWords[tick / 4 % 5 == 4 || calm ? 4 : storm.below(5)]);
    if (calm && tick % 100 < 20) bench.control(kWords[static_cast<std::size_t>(tick % 100 / 4)]);
    if (calm && tick % 100 == 0) {
      bench.put(0, {130, 0});  // the PDOs are where they belong again; what else was written stays
      bench.forced.fill(std::nullopt);
      bench.analog_in.reading[2 * kChambers] = {6.2F, true};
      // a wild valve has filled or emptied the chambers: let the air settle
      for (Chamber& chamber : bench.chamber) chamber.pressure_kPa = 200.0 + storm.below(300);
    }
    if (calm && tick % 100 == 1) bench.put(0, {1, 0});  // with the reset it would have found nobody
    bench.streaming = calm && !storm.one_in(50);
    if (calm) {
      bench.setpoint_kPa = 0.1 * storm.below(7'000);
    } else {
      storm.strike(bench);
      if (storm.one_in(8)) {
        bench.forced[storm.below(kAnalogInputs)] = ports::AnalogReading{storm.number(), !storm.one_in(4)};
      }
      if (storm.one_in(30)) bench.digital.inputs.emergency_stop = !bench.digital.inputs.emergency_stop;
      bench.late = storm.one_in(3);
      bench.analog_out.refuses = storm.one_in(10);
    }
    if (calm) {
      bench.digital.inputs.emergency_stop = false;
      bench.late = false;
      bench.analog_out.refuses = false;
    }
    bench.tick();
    for (std::size_t c = 0; c < kChambers; ++c) {
      const float command_V = bench.analog_out.asked_V[c];
      const bool allowed = (command_V >= 3.0F && command_V <= 7.0F) || command_V == 2.5F;
      ASSERT_TRUE(allowed) << "command " << command_V << " V of chamber " << c << ", tick " << tick
                           << ", seed " << seed;
    }
    const std::set<int> only_told{0, 0x8110, 0x8210, 0x8220, 0x8240};
    ASSERT_TRUE(only_told.contains(bench.image().error_code) || bench.state() != safety::State::active)
        << "tick " << tick << ", seed " << seed;
    driven_ticks += bench.state() == safety::State::active ? 1 : 0;
    faulty_ticks += bench.image().error_code != 0 ? 1 : 0;
    bench.can.from_board.clear();
  }
  // the storm has been through both
  EXPECT_GT(driven_ticks, 500) << "seed " << seed;
  EXPECT_GT(faulty_ticks, 500) << "seed " << seed;
}

INSTANTIATE_TEST_SUITE_P(Seeds, BoardInAStorm, ::testing::Values(1U, 2U, 3U));

}  // namespace
}  // namespace plenum
