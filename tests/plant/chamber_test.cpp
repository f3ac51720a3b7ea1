#include "host-sim/plant/chamber.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "host-sim/plant/random.hpp"
#include "host-sim/plant/reach.hpp"
#include "tests/plant/plant_oracles.hpp"

namespace plenum::host::plant {
namespace {

constexpr double kTick_s = 0.01;
constexpr double kSpan_Pa = 600e3;

VolumeMotion swinging(double mean_m3) {
  return VolumeMotion(
      mean_m3, {VolumeSine{0.3 * mean_m3, 1.5, 0.3}, VolumeSine{0.06 * mean_m3, 3.4, 1.0}, VolumeSine{}});
}
Valve sealed() {
  ThinPlateValveConfig c;
  c.inlet_area_per_V_m2 = c.exhaust_area_per_V_m2 = c.inlet_leak_m2 = c.exhaust_leak_m2 = c.transition_m2 =
      0.0;
  return ThinPlateValve(c);
}

TEST(Chamber, IsolatedGasIsCompressedAdiabatically) {
  ChamberConfig config;
  config.initial_pressure_Pa = 3e5;
  config.tolerance_Pa = 1e-3;
  ChamberPlant plant(sealed(), config, swinging(100e-6));
  const double constant = 3e5 * std::pow(plant.volume_m3(), 1.4);
  for (int i = 0; i < 300; ++i) {
    plant.advance(5.0, kTick_s);
    EXPECT_NEAR(plant.pressure_Pa() * std::pow(plant.volume_m3(), 1.4) / constant, 1.0, 1e-6)
        << plant.time_s() << " s";
  }
}

TEST(Chamber, SealedAtRestKeepsItsPressureToTheBit) {
  ChamberConfig config;
  config.initial_pressure_Pa = 3e5;
  ChamberPlant plant(sealed(), config, VolumeMotion(100e-6));
  EXPECT_EQ(plant.advance(5.0, 1.0).end_Pa, 3e5);
}

TEST(Chamber, ChokedChargingOfAFixedVolumeIsLinearInTime) {
  ThinPlateValveConfig valve;
  valve.exhaust_area_per_V_m2 = valve.exhaust_leak_m2 = valve.transition_m2 = 0.0;
  const Gas gas;
  ChamberPlant plant(ThinPlateValve(valve, gas), ChamberConfig{}, VolumeMotion(400e-6));
  const double slope_Pa_s = 1.4 * gas.specific_gas_constant_J_kg_K() * gas.temperature_K / 400e-6 *
                            (1.5e-6 * (6.0 - 5.08)) * thin_plate_constants(gas).beta_s_m * 700e3;
  const Interval interval = plant.advance(6.0, 0.1);
  ASSERT_LT(interval.end_Pa, 700e3 / thin_plate_constants(gas).theta);
  EXPECT_NEAR(interval.end_Pa, 101325.0 + slope_Pa_s * 0.1, 1e-6);
  EXPECT_NEAR(interval.mean_Pa, 101325.0 + slope_Pa_s * 0.05, 1e-6);
}

TEST(Chamber, ChokedVentingOfAFixedVolumeIsExponential) {
  ThinPlateValveConfig valve;
  valve.inlet_area_per_V_m2 = valve.inlet_leak_m2 = valve.transition_m2 = 0.0;
  const Gas gas;
  ChamberConfig config;
  config.initial_pressure_Pa = 600e3;
  ChamberPlant plant(ThinPlateValve(valve, gas), config, VolumeMotion(400e-6));
  const double rate_1_s = 1.4 * gas.specific_gas_constant_J_kg_K() * gas.temperature_K / 400e-6 *
                          (1.6e-6 * (4.92 - 4.0)) * thin_plate_constants(gas).beta_s_m;
  EXPECT_NEAR(plant.advance(4.0, 0.2).end_Pa, 600e3 * std::exp(-0.2 * rate_1_s), 1e-5);
}

struct Violent {
  const char* name;
  Valve valve;
  Gas gas;
  double volume_m3;
};

// Full strokes with the volume swinging, against RK4 at a thousandth of a tick started anew from the same
// state each tick.
TEST(Chamber, EndAndMeanOfATickAgreeWithFineRungeKuttaWhenViolent) {
  const Violent cases[] = {
      {"thin plate", ThinPlateValve({}), Gas{}, 40e-6},
      {"measured, channel A", MpyeValve(MpyeChannel::a), reference_atmosphere(), 40e-6},
      {"measured, channel B", MpyeValve(MpyeChannel::b_mirrored), reference_atmosphere(), 40e-6}};
  for (const Violent& c : cases) {
    for (const bool lagging : {false, true}) {
      ChamberConfig config;
      if (lagging) config.spool = SpoolConfig{};
      Spool spool(SpoolConfig{}, config.initial_command_V);
      config.gas = c.gas;
      const VolumeMotion motion = swinging(c.volume_m3);
      ChamberPlant plant(c.valve, config, motion);
      for (int k = 0; k < 60; ++k) {
        const double u = (k / 12) % 2 == 0 ? 10.0 : 0.0;
        const double t0 = plant.time_s();
        const double p0 = plant.pressure_Pa();
        const auto [end, integral] = std::visit(
            [&](const auto& valve) {
              const auto held = valve.opening(u);
              const FlowExponents n = valve.exponents();
              const double RT = c.gas.specific_gas_constant_J_kg_K() * c.gas.temperature_K;
              return oracle::rk4(p0, kTick_s, 1500, [&](double t, double p) {
                Spool at_t = spool;
                if (lagging) at_t.advance(u, t);
                const auto opening = lagging ? valve.opening(at_t.effective_V()) : held;
                const VolumeState v = motion.at(t0 + t);
                const PortFlows m = valve.flows(opening, p, 700e3, 101325.0);
                const double in = (m.inlet_kg_s > 0 ? n.entering : n.leaving) * m.inlet_kg_s;
                const double out = (m.exhaust_kg_s > 0 ? n.leaving : n.entering) * m.exhaust_kg_s;
                return RT / v.volume_m3 * (in - out) - 1.4 * v.rate_m3_s / v.volume_m3 * p;
              });
            },
            c.valve);
        spool.advance(u, kTick_s);
        const Interval got = plant.advance(u, kTick_s);
        EXPECT_NEAR(got.end_Pa, end, 1e-5 * kSpan_Pa)
            << c.name << (lagging ? ", spool" : "") << ", end [Pa] at " << t0 << " s";
        EXPECT_NEAR(got.mean_Pa, integral / kTick_s, 1e-5 * kSpan_Pa)
            << c.name << (lagging ? ", spool" : "") << ", mean [Pa] at " << t0 << " s";
      }
    }
  }
}

TEST(Chamber, EndAndMeanOfATickAgreeWithFineRungeKuttaWhileTheSpoolChasesSmallSteps) {
  struct Gentle {
    const char* name;
    Valve valve;
    Gas gas;
    double volume_m3;
  };
  const Gentle cases[] = {
      {"thin plate, sharp", ThinPlateValve({.transition_m2 = 0.0}), Gas{}, 40e-6},
      {"measured, channel A", MpyeValve(MpyeChannel::a), reference_atmosphere(), 400e-6},
      {"measured, channel B", MpyeValve(MpyeChannel::b_mirrored), reference_atmosphere(), 400e-6}};
  for (const Gentle& c : cases) {
    ChamberConfig config;
    config.spool = SpoolConfig{};
    config.gas = c.gas;
    config.initial_pressure_Pa = 350e3;
    const VolumeMotion motion = swinging(c.volume_m3);
    ChamberPlant plant(c.valve, config, motion);
    Spool spool(SpoolConfig{}, config.initial_command_V);
    Random random(5);
    for (int k = 0; k < 200; ++k) {
      // across the null and its corners, by steps of a millivolt to half a volt, back when pressure strays
      const double step_V = 0.5 * std::pow(10.0, -2.7 * random.uniform());
      const double u = 5.0 + (plant.pressure_Pa() < 350e3 ? step_V : -step_V) + 0.1 * std::sin(0.3 * k);
      const double t0 = plant.time_s();
      const double p0 = plant.pressure_Pa();
      const auto [end, integral] = std::visit(
          [&](const auto& valve) {
            const FlowExponents n = valve.exponents();
            const double RT = c.gas.specific_gas_constant_J_kg_K() * c.gas.temperature_K;
            return oracle::rk4(p0, kTick_s, 500, [&](double t, double p) {
              Spool at_t = spool;
              at_t.advance(u, t);
              const VolumeState v = motion.at(t0 + t);
              const PortFlows m = valve.flows(valve.opening(at_t.effective_V()), p, 700e3, 101325.0);
              const double in = (m.inlet_kg_s > 0 ? n.entering : n.leaving) * m.inlet_kg_s;
              const double out = (m.exhaust_kg_s > 0 ? n.leaving : n.entering) * m.exhaust_kg_s;
              return RT / v.volume_m3 * (in - out) - 1.4 * v.rate_m3_s / v.volume_m3 * p;
            });
          },
          c.valve);
      spool.advance(u, kTick_s);
      const Interval got = plant.advance(u, kTick_s);
      EXPECT_NEAR(got.end_Pa, end, 1e-5 * kSpan_Pa) << c.name << ", end [Pa] at " << t0 << " s";
      EXPECT_NEAR(got.mean_Pa, integral / kTick_s, 1e-5 * kSpan_Pa)
          << c.name << ", mean [Pa] at " << t0 << " s";
    }
  }
}

TEST(Chamber, EndAndMeanConvergeWithTheThirdOrder) {
  // a tolerance that lets every step through: the steps are the calls
  const auto run = [](int steps, double tolerance_Pa) {
    ChamberConfig config;
    config.tolerance_Pa = tolerance_Pa;
    config.initial_pressure_Pa = 450e3;
    ChamberPlant plant(ThinPlateValve({}), config, swinging(100e-6));
    Interval whole;
    for (int i = 0; i < steps; ++i) {
      const Interval part = plant.advance(5.3, 0.08 / steps);
      whole = {part.end_Pa, whole.mean_Pa + part.mean_Pa / steps};
    }
    return whole;
  };
  const Interval exact = run(1, 1e-7);
  const Interval coarse = run(4, 1e9);
  const Interval fine = run(8, 1e9);
  ASSERT_GT(std::abs(coarse.end_Pa - exact.end_Pa), 1e-4) << "too easy to show an order";
  EXPECT_LT(std::abs(fine.end_Pa - exact.end_Pa), std::abs(coarse.end_Pa - exact.end_Pa) / 7.0);
  EXPECT_LT(std::abs(fine.mean_Pa - exact.mean_Pa), std::abs(coarse.mean_Pa - exact.mean_Pa) / 7.0);
}

TEST(Chamber, ErrorFallsWithTheTolerance) {
  const auto run = [](double tolerance_Pa) {
    ChamberConfig config;
    config.tolerance_Pa = tolerance_Pa;
    config.spool = SpoolConfig{};
    ChamberPlant plant(ThinPlateValve({}), config, swinging(100e-6));
    double end = 0.0;
    for (int k = 0; k < 40; ++k) end = plant.advance(5.3 + 0.05 * (k % 7), kTick_s).end_Pa;
    return end;
  };
  const double exact = run(1e-6);
  EXPECT_LT(std::abs(run(1.0) - exact), 4.0);
  EXPECT_LT(std::abs(run(1e-2) - exact), 4e-2);
  EXPECT_LT(std::abs(run(1e-4) - exact), 4e-4);
}

TEST(Chamber, MeanOfOneStepIsOfFourthOrder) {
  const auto mean_error_Pa = [](double duration_s) {
    ChamberConfig config;
    config.initial_pressure_Pa = 450e3;
    config.tolerance_Pa = 1e9;
    ChamberConfig tight = config;
    tight.tolerance_Pa = 1e-9;
    const double exact =
        ChamberPlant(ThinPlateValve({}), tight, swinging(100e-6)).advance(5.3, duration_s).mean_Pa;
    return ChamberPlant(ThinPlateValve({}), config, swinging(100e-6)).advance(5.3, duration_s).mean_Pa -
           exact;
  };
  const double coarse = mean_error_Pa(0.004);
  const double fine = mean_error_Pa(0.002);
  EXPECT_LT(std::abs(fine), std::abs(coarse) / 12.0) << coarse << " Pa, then " << fine << " Pa";
}

TEST(Chamber, ResultDoesNotDependOnHowTimeIsCut) {
  ChamberConfig config;
  config.tolerance_Pa = 1e-3;
  config.spool = SpoolConfig{};
  ChamberPlant whole(ThinPlateValve({}), config, swinging(100e-6));
  ChamberPlant cut = whole;
  double fine_mean = 0.0;
  const Interval interval = whole.advance(6.1, 0.05);
  for (int i = 0; i < 500; ++i) fine_mean += cut.advance(6.1, 1e-4).mean_Pa / 500.0;
  EXPECT_NEAR(interval.end_Pa, cut.pressure_Pa(), 0.05);
  EXPECT_NEAR(interval.mean_Pa, fine_mean, 0.05);
}

TEST(Chamber, TenthOfACubicCentimetreIsStableAndRestsAtTheSteadyState) {
  ChamberPlant plant(ThinPlateValve({}), ChamberConfig{}, VolumeMotion(0.1e-6));
  for (const double u : {10.0, 0.0, 5.0, 5.2, 4.9, 7.0}) {
    for (int i = 0; i < 50; ++i) {
      plant.advance(u, kTick_s);
      ASSERT_GT(plant.pressure_Pa(), 101325.0 - 20.0) << u << " V";
      ASSERT_LT(plant.pressure_Pa(), 700e3 + 20.0) << u << " V";
    }
    EXPECT_NEAR(plant.pressure_Pa(), steady_state_Pa(plant.valve(), u, 700e3, 101325.0), 1.0) << u << " V";
  }
  EXPECT_LT(plant.steps_tried(), 300U * 40U);
}

TEST(Chamber, SameCallsGiveTheSameBits) {
  ChamberConfig config;
  config.spool = SpoolConfig{};
  ChamberPlant a(MpyeValve(MpyeChannel::a), config, swinging(100e-6));
  ChamberPlant b = a;
  for (int k = 0; k < 100; ++k) {
    const double u = 5.0 + 2.0 * std::sin(0.3 * k);
    const Interval x = a.advance(u, kTick_s);
    const Interval y = b.advance(u, kTick_s);
    ASSERT_EQ(x.end_Pa, y.end_Pa);
    ASSERT_EQ(x.mean_Pa, y.mean_Pa);
  }
}

TEST(Chamber, RefusesWhatIsNotFinite) {
  ChamberPlant plant(ThinPlateValve({}), ChamberConfig{}, VolumeMotion(100e-6));
  EXPECT_THROW(plant.advance(std::numeric_limits<double>::quiet_NaN(), kTick_s), std::invalid_argument);
  EXPECT_THROW(plant.advance(5.0, 0.0), std::invalid_argument);
  EXPECT_THROW(plant.set_supply_Pa(-1.0), std::invalid_argument);
  EXPECT_THROW(VolumeMotion(1e-6, {VolumeSine{1e-6, 1.0, 0.0}}), std::invalid_argument);
}

TEST(VolumeMotion, IsItsClosedFormAndItsRateIsItsDerivative) {
  const VolumeMotion motion = swinging(100e-6);
  const double pi = std::numbers::pi;
  for (double t = 0.0; t < 3.0; t += 0.0713) {
    const double v = 1e-4 * (1.0 + 0.3 * std::sin(3.0 * pi * t + 0.3) + 0.06 * std::sin(6.8 * pi * t + 1.0));
    EXPECT_NEAR(motion.at(t).volume_m3, v, 1e-17) << t << " s";
    const VolumeMotion::Interval interval(motion, t);
    for (const double after : {0.003, 0.01, 0.2}) {
      EXPECT_NEAR(interval.at(after).volume_m3, motion.at(t + after).volume_m3, 1e-17);
      EXPECT_NEAR(interval.at(after).rate_m3_s, motion.at(t + after).rate_m3_s, 1e-15);
    }
    const double rate = (motion.at(t + 1e-5).volume_m3 - motion.at(t - 1e-5).volume_m3) / 2e-5;
    EXPECT_NEAR(motion.at(t).rate_m3_s, rate, 1e-11) << t << " s";
  }
}

TEST(Spool, StepResponseIsTheTextbookForm) {
  const double w = 2.0 * std::numbers::pi * 65.0;
  for (const double t : {0.001, 0.004, 0.02}) {
    Spool under({65.0, 0.5}, 0.0);
    under.advance(1.0, t);
    const double d = std::sqrt(0.75);
    EXPECT_NEAR(under.effective_V(), 1.0 - std::exp(-0.5 * w * t) / d * std::sin(d * w * t + std::acos(0.5)),
                1e-12);
    Spool critical({65.0, 1.0}, 0.0);
    critical.advance(1.0, t);
    EXPECT_NEAR(critical.effective_V(), 1.0 - std::exp(-w * t) * (1.0 + w * t), 1e-12);
    Spool over({65.0, 2.0}, 0.0);
    over.advance(1.0, t);
    const double s1 = w * (2.0 - std::sqrt(3.0));
    const double s2 = w * (2.0 + std::sqrt(3.0));
    EXPECT_NEAR(over.effective_V(), 1.0 + (s1 * std::exp(-s2 * t) - s2 * std::exp(-s1 * t)) / (s2 - s1),
                1e-12);
  }
}

TEST(Spool, ClosedFormHoldsThroughCriticalDamping) {
  const double w = 2.0 * std::numbers::pi * 65.0;
  for (const double short_of_critical : {1e-7, 1e-6, 1e-5}) {
    const double zeta = 1.0 - short_of_critical;
    const double d = std::sqrt(1.0 - zeta * zeta);
    for (const double t : {0.0005, 0.0025, 0.01}) {
      Spool spool({65.0, zeta}, 0.0);
      spool.advance(1.0, t);
      const double x = 1.0 - std::exp(-zeta * w * t) * (std::cos(d * w * t) + zeta / d * std::sin(d * w * t));
      EXPECT_NEAR(spool.effective_V(), x, 1e-12) << "zeta = 1 - " << short_of_critical << ", " << t << " s";
    }
  }
}

TEST(Spool, FastSpoolVanishes) {
  ChamberConfig with;
  with.spool = SpoolConfig{1e6, 1.0};
  ChamberPlant lagged(ThinPlateValve({}), with, VolumeMotion(100e-6));
  ChamberPlant direct(ThinPlateValve({}), ChamberConfig{}, VolumeMotion(100e-6));
  EXPECT_NEAR(lagged.advance(6.0, kTick_s).end_Pa, direct.advance(6.0, kTick_s).end_Pa, 5.0);
}

TEST(BangBang, TimeIsThatOfFineStepping) {
  ChamberConfig config;
  config.spool = SpoolConfig{};
  const ChamberPlant start(MpyeValve(MpyeChannel::a), config, VolumeMotion(400e-6));
  ChamberPlant fine = start;
  while (fine.pressure_Pa() < 500e3) fine.advance(10.0, 1e-5);
  EXPECT_NEAR(bang_bang_time_s(start, 500e3, 0.0, 10.0), fine.time_s(), 1.5e-5);
  EXPECT_EQ(bang_bang_time_s(start, 900e3, 0.0, 10.0), std::numeric_limits<double>::infinity());
}

TEST(BangBang, ChokedFillTakesItsClosedFormTime) {
  ThinPlateValveConfig valve;
  valve.exhaust_area_per_V_m2 = valve.exhaust_leak_m2 = valve.transition_m2 = 0.0;
  const Gas gas;
  const ChamberPlant start(ThinPlateValve(valve, gas), ChamberConfig{}, VolumeMotion(400e-6));
  const double slope_Pa_s = 1.4 * gas.specific_gas_constant_J_kg_K() * gas.temperature_K / 400e-6 *
                            (1.5e-6 * (7.0 - 5.08)) * thin_plate_constants(gas).beta_s_m * 700e3;
  EXPECT_NEAR(bang_bang_time_s(start, 300e3, 3.0, 7.0), (300e3 - 101325.0) / slope_Pa_s, 1e-8);
}

}  // namespace
}  // namespace plenum::host::plant
