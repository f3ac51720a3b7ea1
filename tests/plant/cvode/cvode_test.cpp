// The plant against CVODE at tight tolerances where the time step matters: full strokes on a small volume
// that swings, so that within one tick the chamber fills, chokes, unchokes and comes to rest on a port.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "host-sim/plant/chamber.hpp"
#include "host-sim/plant/random.hpp"
#include "tests/plant/cvode/cvode_chamber.hpp"

namespace plenum::host::plant {
namespace {

constexpr double kTick_s = 0.01;

VolumeMotion swinging(double mean_m3) {
  return VolumeMotion(mean_m3, {VolumeSine{0.4 * mean_m3, 1.5, 0.3}, VolumeSine{0.06 * mean_m3, 3.4, 1.0}});
}

double stroke_V(int tick) {
  return (tick / 12) % 2 == 0 ? 10.0 : 0.0;
}

/// Largest distance of the ends and of the means of the ticks [Pa], both run from the same start without ever
/// being brought together again.
struct Apart {
  double end_Pa = 0.0;
  double mean_Pa = 0.0;
};

template <class AnyValve, class Command>
Apart apart(const AnyValve& valve, const ChamberConfig& config, const VolumeMotion& volume,
            const Command& command_V, int ticks) {
  oracle::CvodeChamber<AnyValve> reference(valve, config, volume, {});
  ChamberPlant plant(valve, config, volume);
  Apart most;
  for (int k = 0; k < ticks; ++k) {
    const Interval expected = reference.advance(command_V(k), kTick_s);
    const Interval got = plant.advance(command_V(k), kTick_s);
    most.end_Pa = std::max(most.end_Pa, std::abs(got.end_Pa - expected.end_Pa));
    most.mean_Pa = std::max(most.mean_Pa, std::abs(got.mean_Pa - expected.mean_Pa));
  }
  return most;
}

// 1e-5 of the span: what README.md of host-sim/plant promises at the default tolerance.
constexpr double kPromised_Pa = 1e-5 * (700000.0 - 101325.0);

TEST(ChamberAgainstCvode, FullStrokesOnASmallMovingVolumeThroughAThinPlate) {
  for (const double volume_m3 : {2e-6, 10e-6, 40e-6}) {
    const Apart most = apart(ThinPlateValve({}), ChamberConfig{}, swinging(volume_m3), stroke_V, 96);
    EXPECT_LT(most.end_Pa, kPromised_Pa) << 1e6 * volume_m3 << " mL, end of a tick [Pa]";
    EXPECT_LT(most.mean_Pa, kPromised_Pa) << 1e6 * volume_m3 << " mL, mean of a tick [Pa]";
  }
}

TEST(ChamberAgainstCvode, FullStrokesOnASmallMovingVolumeThroughTheMeasuredValve) {
  ChamberConfig config;
  config.gas = reference_atmosphere();
  for (const MpyeChannel channel : {MpyeChannel::a, MpyeChannel::b_mirrored}) {
    for (const double volume_m3 : {2e-6, 10e-6, 40e-6}) {
      const Apart most = apart(MpyeValve(channel), config, swinging(volume_m3), stroke_V, 96);
      EXPECT_LT(most.end_Pa, kPromised_Pa) << 1e6 * volume_m3 << " mL, end of a tick [Pa]";
      EXPECT_LT(most.mean_Pa, kPromised_Pa) << 1e6 * volume_m3 << " mL, mean of a tick [Pa]";
    }
  }
}

TEST(ChamberAgainstCvode, SpoolStrokesFromStopToStop) {
  ChamberConfig config;
  config.spool = SpoolConfig{};
  const Apart plate = apart(ThinPlateValve({}), config, swinging(10e-6), stroke_V, 72);
  EXPECT_LT(plate.end_Pa, kPromised_Pa) << "thin plate, end of a tick [Pa]";
  EXPECT_LT(plate.mean_Pa, kPromised_Pa) << "thin plate, mean of a tick [Pa]";
  config.gas = reference_atmosphere();
  const Apart measured = apart(MpyeValve(MpyeChannel::a), config, swinging(10e-6), stroke_V, 72);
  EXPECT_LT(measured.end_Pa, kPromised_Pa) << "measured valve, end of a tick [Pa]";
  EXPECT_LT(measured.mean_Pa, kPromised_Pa) << "measured valve, mean of a tick [Pa]";
}

TEST(ChamberAgainstCvode, RandomCommandsEachTickOnAFastMovingVolume) {
  Random random(7);
  std::vector<double> command_V(300);
  for (double& u : command_V) u = random.uniform(3.0, 7.0);
  const auto command = [&](int k) { return command_V[static_cast<std::size_t>(k)]; };
  const VolumeMotion fast(20e-6, {VolumeSine{8e-6, 5.0, 0.0}});
  const Apart most = apart(ThinPlateValve({}), ChamberConfig{}, fast, command, 300);
  EXPECT_LT(most.end_Pa, kPromised_Pa);
  EXPECT_LT(most.mean_Pa, kPromised_Pa);
}

TEST(ChamberAgainstCvode, TighterToleranceOfThePlantComesNearerToCvode) {
  const auto end_Pa = [](double tolerance_Pa) {
    ChamberConfig config;
    config.tolerance_Pa = tolerance_Pa;
    return apart(ThinPlateValve({}), config, swinging(10e-6), stroke_V, 48).end_Pa;
  };
  const double coarse_Pa = end_Pa(200.0);
  ASSERT_GT(coarse_Pa, 1.0) << "too easy to show anything";
  EXPECT_LT(end_Pa(1e-3), 1e-2);
}

}  // namespace
}  // namespace plenum::host::plant
