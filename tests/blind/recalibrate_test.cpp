#include "host-sim/blind/recalibrate.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host-sim/blind/blind_case.hpp"
#include "tests/blind/middling_scale.hpp"

namespace plenum::host::blind {
namespace {

struct Stage {
  Machine nominal;
  std::vector<double> command_V;
  Recalibration recalibration;

  std::vector<double> pressure_Pa(const Machine& machine) const {
    return simulate(machine, command_V.size(), replay(command_V)).pressure_Pa;
  }
  double gap_Pa(const Machine& machine) const {
    const auto a = pressure_Pa(nominal), b = pressure_Pa(machine);
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return std::sqrt(sum / static_cast<double>(a.size()));
  }
  double rest_Pa(const Machine& machine) const { return recalibration.rest_Pa(pressure_Pa(machine)); }
};

Stage stage(int tier) {
  const Case drawn = make_case({.effects = {}, .kind = "none", .tier = tier, .seconds = 10.0, .seed = 21});
  Machine nominal = drawn.machine;
  nominal.clutter = Clutter{};
  return {nominal, drawn.log.command_V, Recalibration(nominal, drawn.log.command_V)};
}

TEST(Recalibration, LeavesNothingOfAnotherValve) {
  const Stage on = stage(1);
  Machine other = on.nominal;
  auto& valve = other.rig.valve;
  valve.open_above_V += 0.03;
  valve.exhaust_below_V -= 0.02;
  valve.inlet_area_per_V_m2 *= 1.2;
  valve.exhaust_area_per_V_m2 *= 0.85;
  valve.inlet_leak_m2 *= 1.5;
  valve.exhaust_leak_m2 *= 0.6;
  valve.transition_m2 *= 1.3;
  ASSERT_GT(on.gap_Pa(other), 5e3) << "Pa";
  EXPECT_LT(on.rest_Pa(other), 30.0) << "Pa";
}

TEST(Recalibration, AbsorbsAVolumeErrorAtRest) {
  const Stage on = stage(2);
  Machine larger = on.nominal;
  larger.departures.volume_error = VolumeError{0.15 * on.nominal.motion.mean_m3};
  ASSERT_GT(on.gap_Pa(larger), 2e3) << "Pa";
  EXPECT_LT(on.rest_Pa(larger), 10.0) << "Pa";
}

TEST(Recalibration, AbsorbsAHoleToAmbient) {
  const Stage on = stage(1);
  Machine leaking = on.nominal;
  leaking.departures.chamber_leak = ChamberLeak{0.0, 0.05e-6};
  ASSERT_GT(on.gap_Pa(leaking), 500.0) << "Pa";
  EXPECT_LT(on.rest_Pa(leaking), 10.0) << "Pa";
}

TEST(Recalibration, CannotHideADelayOrAMovingVolumesError) {
  const Stage on = stage(1);
  Machine delayed = on.nominal, larger = on.nominal;
  delayed.departures.dead_time = DeadTime{0.01};
  larger.departures.volume_error = VolumeError{0.15 * on.nominal.motion.mean_m3};
  EXPECT_GT(on.rest_Pa(delayed), 0.5 * on.gap_Pa(delayed)) << "Pa";
  EXPECT_GT(on.rest_Pa(larger), 500.0) << "Pa";
}

TEST(Recalibration, NeverLeavesMoreThanThereWas) {
  const Stage on = stage(1);
  for (std::size_t i = 0; i < departure_kinds().size(); i += 3) {
    const DepartureKind& kind = departure_kinds()[i];
    Random random(9);
    Machine machine = on.nominal;
    kind.draw(random, kMiddlingScale, machine.departures);
    // A quarter of a pascal is what the coarser step costs.
    EXPECT_LE(on.rest_Pa(machine), on.gap_Pa(machine) + 0.25) << "Pa, " << kind.id;
  }
}

}  // namespace
}  // namespace plenum::host::blind
