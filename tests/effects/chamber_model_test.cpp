// The chamber as a whole: effects that are off, the accuracy of its steps, agreement with the plant.
#include "host-sim/effects/chamber_model.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "host-sim/plant/chamber.hpp"
#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

TEST(ChamberModel, EffectAtTheValueAtWhichItVanishesChangesNoReading) {
  const Drive drive = drive_of(jumping_command_V(1000), swinging_volume(), 4);
  const std::vector<double> plain = run(0, nominal(), drive, 3e5);
  for (std::size_t i = 0; i < kEffects; ++i) {
    if (i == kIdTubeDynamics) continue;  // a hose of a millimetre: VeryShortHoseIsAsNone
    const std::vector<double> off = run(EffectSet{1} << i, nominal(), drive, 3e5);
    // thirds of a step, and 1 + (r - b)/(1 - b) for r, are rounded
    const bool rounded = i == kIdSpoolLag || i == kIdFlowFunction || i == kIdHeatTransfer;
    for (std::size_t k = 0; k < plain.size(); ++k) {
      if (rounded) {
        ASSERT_NEAR(off[k], plain[k], 1e-6) << "Pa, " << kCatalogue[i]->id << " row " << k;
      } else {
        ASSERT_EQ(off[k], plain[k]) << "Pa, " << kCatalogue[i]->id << " row " << k;
      }
    }
  }
}

TEST(ChamberModel, EffectThatIsOffIgnoresItsFigures) {
  const Drive drive = drive_of(jumping_command_V(300), swinging_volume(), 4);
  Figures figures = nominal();
  const std::vector<double> plain = run(0, figures, drive, 3e5);
  for (std::size_t i = 0; i < kEffects; ++i) {
    std::size_t at = kFirstFigure[i];
    for (const Parameter& p : kCatalogue[i]->parameters)
      figures[at++] = p.least() + 0.3 * (p.greatest() - p.least());
  }
  EXPECT_EQ(run(0, figures, drive, 3e5), plain);
}

std::vector<double> plant_means_Pa(const std::vector<double>& command_V) {
  plant::ChamberConfig config;
  config.initial_pressure_Pa = 3e5;
  config.tolerance_Pa = 0.02;
  plant::ChamberPlant plant(plant::ThinPlateValve({}), config, swinging_volume());
  std::vector<double> means{3e5};
  for (std::size_t k = 0; k + 1 < command_V.size(); ++k)
    means.push_back(plant.advance(command_V[k], kTick_s).mean_Pa);
  return means;
}

TEST(ChamberModel, AgreesWithTheErrorControlledPlant) {
  const std::vector<double> command_V = jumping_command_V(3000);
  const std::vector<double> truth = plant_means_Pa(command_V);
  const auto error_Pa = [&](int steps) {
    return rms_difference(run(0, nominal(), drive_of(command_V, swinging_volume(), steps), 3e5), truth);
  };
  EXPECT_LT(error_Pa(4), 25.0) << "Pa RMS";
  EXPECT_LT(error_Pa(16), 2.0) << "Pa RMS";
  EXPECT_LT(error_Pa(64), 0.5) << "Pa RMS";
}

/// A command that sweeps smoothly through both ports, without a jump that would hide the order of the rule.
std::vector<double> smooth_command_V(std::size_t rows) {
  std::vector<double> command_V;
  for (std::size_t k = 0; k < rows; ++k) {
    command_V.push_back(5.0 + 0.8 * std::sin(6.0 * static_cast<double>(k) * kTick_s));
  }
  return command_V;
}

struct Case {
  Id id;
  std::vector<double> values;
};

TEST(ChamberModel, ErrorFallsWithTheSquareOfTheStepWhateverTheEffect) {
  const std::vector<double> command_V = smooth_command_V(400);
  const Case cases[] = {{kIdSpoolLag, {30.0, 0.8}},
                        {kIdSpoolLag, {30.0, 0.8, 8.0, 0.004}},
                        {kIdSpoolLag, {60.0, 0.8, kInfinity, 0.008, 0.2, 0.4}},
                        {kIdSpoolLag, {30.0, 0.8, 8.0, 0.0, 0.0, 0.0, 5.0}},
                        {kIdValveHysteresis, {0.2}},
                        {kIdValveHysteresis, {0.2, 0.3, 0.6}},
                        {kIdValveHysteresis, {0.2, 0.3, 0.6, 0.6}},
                        {kIdAreaShape, {1.0, 0.5, -0.5, 1.0}},
                        {kIdNullDrift, {0.5, 10.0}},
                        {kIdFlowFunction, {0.35, 0.6, 1.0, 0.2}},
                        {kIdSupplyDroop, {30.0, 0.02}},
                        {kIdSupplyDroop, {30.0, 0.02, 0.7}},
                        {kIdSupplyDroop, {30.0, 0.02, 0.7, 0.0}},
                        {kIdExhaustBackpressure, {60.0, 20.0}},
                        {kIdExhaustBackpressure, {60.0, 0.0}},
                        {kIdExhaustBackpressure, {60.0, 20.0, 0.5, 20.0}},
                        {kIdExhaustBackpressure, {60.0, 20.0, 0.0, 0.0, 0.5}},
                        {kIdChamberLeak, {1.0}},
                        {kIdChamberLeak, {1.0, 0.3, 2.0}},
                        {kIdChamberLeak, {1.0, 1.0, 0.0, 250.0}},
                        {kIdTubeDynamics, {2.0, 4.0}},
                        {kIdTubeDynamics, {1.0, 8.0, 4.0, 20.0, 1.0}},
                        {kIdHeatTransfer, {0.5, 1.4}},
                        {kIdHeatTransfer, {0.5, 1.3, 0.8, 30.0}},
                        {kIdHeatTransfer, {0.5, 1.3, 0.8, 30.0, 1.0}},
                        {kIdVolumeError, {30.0}},
                        {kIdVolumeError, {30.0, 0.3, -0.5, 0.02}},
                        {kIdSensorLag, {0.02}},
                        {kIdSensorLag, {0.02, 0.7}},
                        {kIdSensorBias, {5.0, 0.02}}};
  for (const Case& c : cases) {
    Figures figures = nominal();
    for (std::size_t k = 0; k < c.values.size(); ++k) {
      figures[kFirstFigure[c.id] + k] = kCatalogue[c.id]->parameters[k].coordinate_of(c.values[k]);
    }
    const auto at = [&](int steps) {
      return run(only(c.id), figures, drive_of(command_V, swinging_volume(), steps), 3e5);
    };
    const std::vector<double> fine = at(512);
    const double coarse_step_Pa = rms_difference(at(4), fine);
    const double fine_step_Pa = rms_difference(at(32), fine);
    // 8 of the first order, 64 of the second: nearer to the second
    EXPECT_GT(coarse_step_Pa / fine_step_Pa, std::sqrt(8.0 * 64.0))
        << kCatalogue[c.id]->id << ": " << coarse_step_Pa << " to " << fine_step_Pa << " Pa";
    EXPECT_LT(fine_step_Pa, 1.0) << "Pa, " << kCatalogue[c.id]->id;
  }
}

TEST(ChamberModel, DelayThatEndsWithinAStepIsReadFromWhereItEnds) {
  // a port that opens to choked flow d into a tick: the pressure then rises by F a second, its mean over the tick by
  // F (h - d)^2/(2 h)
  std::vector<double> command_V(20, 5.0);
  constexpr std::size_t kOpens = 3;
  for (std::size_t row = kOpens; row < command_V.size(); ++row) command_V[row] = 7.0;
  for (const Id with_spool : {kIdDeadTime, kIdSpoolLag}) {
    for (double delay_s = 0.0; delay_s < kTick_s; delay_s += 0.0007) {
      Figures figures = with(sharp_valve(1.5e-6), kIdDeadTime, {delay_s});
      const EffectSet on = only(kIdDeadTime) | only(with_spool);  // a spool that vanishes changes nothing
      const std::vector<double> reading_Pa = run(on, figures, drive_of(command_V, still_volume(), 4), 150e3);
      const double rise_Pa = reading_Pa[kOpens + 3] - reading_Pa[kOpens + 2];  // F h
      const double expected_Pa = rise_Pa * std::pow(1.0 - delay_s / kTick_s, 2) / 2.0;
      EXPECT_NEAR(reading_Pa[kOpens + 1] - 150e3, expected_Pa, 1e-3 * rise_Pa)
          << "Pa, delay " << delay_s << " s";
    }
  }
}

TEST(ChamberModel, DelayThatEndsWithinAStepCostsNoAccuracy) {
  // a small chamber before a large valve, and a command that jumps every tick
  std::mt19937 bits(5);
  std::vector<double> command_V;
  for (int row = 0; row < 1000; ++row)
    command_V.push_back(3.0 + 4.0 * static_cast<double>(bits()) / 4294967296.0);
  const plant::VolumeMotion small(50e-6, {{{}, {}, {}}});
  const auto error_Pa = [&](double delay_s) {
    const Figures figures = with(sharp_valve(2.2e-6), kIdDeadTime, {delay_s});
    const auto at = [&](int steps) {
      return run(only(kIdDeadTime), figures, drive_of(command_V, small, steps), 3e5);
    };
    return rms_difference(at(4), at(256));
  };
  const double prompt_Pa = error_Pa(0.0);
  EXPECT_GT(prompt_Pa, 1.0);
  for (const double delay_s : {0.0003, 0.0011, 0.0032, 0.0047, 0.0089, 0.0132})
    EXPECT_LT(error_Pa(delay_s), 1.2 * prompt_Pa)
        << "Pa RMS, delay " << delay_s << " s, " << prompt_Pa << " without";
}

TEST(ChamberModel, PortThatShutsWithinAStepLeavesThePressureThatItsMeanAreaMakes) {
  // with one port open p' = area g(p): where the pressure ends depends on the area's integral alone, near the supply, too
  std::vector<double> command_V(12, 7.0);
  for (std::size_t row = 4; row < command_V.size(); ++row) command_V[row] = 5.0;
  const plant::VolumeMotion small(100e-6, {{{}, {}, {}}});
  for (const double start_Pa : {150e3, 400e3, 600e3}) {
    for (const double delay_s : {0.0005, 0.00125, 0.0037, 0.00875}) {
      const Figures figures = with(sharp_valve(1.5e-6), kIdDeadTime, {delay_s});
      const auto at = [&](int steps) {
        return run(only(kIdDeadTime), figures, drive_of(command_V, small, steps), start_Pa).back();
      };
      EXPECT_NEAR(at(4), at(256), 30.0) << "Pa, from " << start_Pa << " Pa, delay " << delay_s << " s";
    }
  }
}

TEST(ChamberModel, StaysPositiveAndFiniteWithEveryEffectAtEitherBound) {
  const Drive drive = drive_of(jumping_command_V(400), swinging_volume(), 4);
  for (std::size_t i = 0; i < kEffects; ++i) {
    for (const bool high : {false, true}) {
      Figures figures = nominal();
      std::size_t at = kFirstFigure[i];
      for (const Parameter& p : kCatalogue[i]->parameters) figures[at++] = high ? p.greatest() : p.least();
      for (const double reading_Pa : run(EffectSet{1} << i, figures, drive, 3e5)) {
        ASSERT_TRUE(std::isfinite(reading_Pa)) << kCatalogue[i]->id << (high ? " high" : " low");
        if (i != kIdSensorBias) {
          ASSERT_GT(reading_Pa, 0.0) << "Pa, " << kCatalogue[i]->id;
        }
      }
    }
  }
}

TEST(ChamberModel, ClosedValveAndRestingVolumeHoldThePressure) {
  const Drive drive = drive_of(std::vector<double>(200, 5.0), plant::VolumeMotion(150e-6), 4);
  for (const double reading_Pa : run(0, sealed(), drive, 4.4e5)) ASSERT_NEAR(reading_Pa, 4.4e5, 1e-6) << "Pa";
}

TEST(SensorAverage, IsOverTheEndOfATickHoweverLong) {
  // a pressure that rises linearly: choked fill of a large chamber
  Figures figures = sharp_valve(1e-6);
  const std::vector<double> volume_m3(5, 1.0);
  const auto late_s = [&](double average_s) {
    ChamberModel<double> model({}, {.tick_s = kTick_s, .average_s = average_s, .steps = 4}, 0, figures.data(),
                               1.5e5, 7.0, 1.0);
    const double before = model.pressure_Pa();
    const double reading = model.tick(7.0, volume_m3);
    const double rate_Pa_s = (model.pressure_Pa() - before) / kTick_s;
    return (model.pressure_Pa() - reading) / rate_Pa_s;
  };
  EXPECT_NEAR(late_s(0.0), 0.0, 1e-12);
  for (const double average_s : {0.0004, 0.002, 0.0025, 0.004, 0.005, 0.0093, 0.01}) {
    EXPECT_NEAR(late_s(average_s), 0.5 * average_s, 1e-6) << average_s << " s";
  }
  figures[kStampedEarly] = 0.0007;
  for (const double average_s : {0.0, 0.0004, 0.002, 0.0025, 0.004, 0.0093, 0.01}) {
    EXPECT_NEAR(late_s(average_s), 0.5 * average_s - 0.0007, 1e-6) << average_s << " s, stamped early";
  }
}

}  // namespace
}  // namespace plenum::host::effects
