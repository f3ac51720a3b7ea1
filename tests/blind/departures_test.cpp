#include "host-sim/blind/departures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <string>

#include "host-sim/blind/blind_case.hpp"
#include "tests/blind/middling_scale.hpp"

namespace plenum::host::blind {
namespace {

/// A case of the population and its recorded commands, so that runs differ in what is asked alone.
struct Stage {
  Machine machine;
  std::vector<double> command_V;

  Rows run(const Departures& departures, double step_s = kStep_s) const {
    Machine m = machine;
    m.departures = departures;
    return simulate(m, command_V.size(), replay(command_V), step_s);
  }
};

const Stage& stage() {
  static const Stage made = [] {
    const Case drawn = make_case({.effects = {}, .kind = "none", .tier = 1, .seconds = 6.0, .seed = 11});
    Stage stage{drawn.machine, drawn.log.command_V};
    stage.machine.clutter = Clutter{};
    return stage;
  }();
  return made;
}

double largest_difference(const Rows& a, const Rows& b) {
  double most = 0.0;
  for (std::size_t k = 0; k < a.pressure_Pa.size(); ++k) {
    most = std::max(most, std::abs(a.pressure_Pa[k] - b.pressure_Pa[k]));
  }
  return most;
}

TEST(Departures, AtTheValueWhereTheyVanishNoBitChanges) {
  const Rows nominal = stage().run({});
  const std::vector<std::pair<std::string, std::function<void(Departures&)>>> vanished{
      {"dead_time", [](Departures& d) { d.dead_time = DeadTime{0.0}; }},
      {"bouc_wen", [](Departures& d) { d.bouc_wen = BoucWen{0.0}; }},
      {"lugre",
       [](Departures& d) {
         d.lugre = LuGre{0.0, 0.2};
       }},
      {"null_drift",
       [](Departures& d) {
         d.null_drift = NullDrift{NullDrift::Course::kWander, 0.0, 20.0, {1, 2, 3}};
       }},
      {"flow_function discharge",
       [](Departures& d) {
         d.flow_function = FlowFunction{FlowFunction::Law::kDischarge, 0.0, 0.0, 0.0, 0.0, 0.0};
       }},
      {"flow_function ellipse",
       [](Departures& d) {
         d.flow_function = FlowFunction{FlowFunction::Law::kEllipse, 0.0, 0.0, 0.3, 1.0, 0.5};
       }},
      {"chamber_leak",
       [](Departures& d) {
         d.chamber_leak = ChamberLeak{0.0, 0.0};
       }},
      {"regulator",
       [](Departures& d) {
         d.regulator = Regulator{0.0, 0.05};
       }},
      {"wall_heat",
       [](Departures& d) {
         d.wall_heat = WallHeat{0.0, 0.5};
       }},
      {"volume_error", [](Departures& d) { d.volume_error = VolumeError{0.0}; }},
      {"sensor_bias",
       [](Departures& d) {
         d.sensor_bias = SensorBias{0.0, 1.0};
       }},
      {"supply_pulsation",
       [](Departures& d) {
         d.supply_pulsation = SupplyPulsation{0.0, 3.0, 0.0};
       }},
      {"sticking_flapper",
       [](Departures& d) {
         d.sticking_flapper = StickingFlapper{-1e9, -1e9};
       }},
      {"neighbour",
       [](Departures& d) {
         d.neighbour = Neighbour{0.0, 1.0, 0.3, 0.0};
       }},
      {"volume_lag", [](Departures& d) { d.volume_lag = VolumeLag{0.0}; }},
      {"volume_tremor",
       [](Departures& d) {
         d.volume_tremor = VolumeTremor{0.0, 7.0, 1.0};
       }},
      {"lifting_seal",
       [](Departures& d) {
         d.lifting_seal = LiftingSeal{0.0, 0.5, 0.3, 1};
       }},
  };
  for (const auto& [name, set] : vanished) {
    Departures d;
    set(d);
    EXPECT_EQ(stage().run(d).pressure_Pa, nominal.pressure_Pa) << name;
  }
}

TEST(Departures, NearTheValueWhereTheyVanishLittleChanges) {
  const Rows nominal = stage().run({});
  std::array<double, 7> straight{};
  for (std::size_t i = 0; i < 7; ++i) straight[i] = static_cast<double>(i) / 6.0;
  const std::vector<std::pair<std::string, std::function<void(Departures&)>>> small{
      {"area_shape", [&](Departures& d) { d.area_shape = area_shape(3.0, straight); }},
      {"reservoir",
       [](Departures& d) {
         d.reservoir = Reservoir{1e3, 1e-3};
       }},
      {"silencer",
       [](Departures& d) {
         d.silencer = Silencer{1e-3, 0.0};
       }},
      {"sensor_lag",
       [](Departures& d) {
         d.sensor_lag = SensorLag{5e-5, 0.0};
       }},
  };
  for (const auto& [name, set] : small) {
    Departures d;
    set(d);
    EXPECT_LT(largest_difference(stage().run(d), nominal), name == "sensor_lag" ? 2000.0 : 5.0)
        << "Pa, " << name;
  }
}

TEST(Departures, AVolumeIsDrawnLateOnlyWhereItMoves) {
  Scale scale = kMiddlingScale;
  for (const bool moves : {false, true}) {
    scale.moves = moves;
    int late = 0;
    for (std::uint64_t seed = 0; seed < 200; ++seed) {
      Random random(seed);
      Departures d;
      departure_kind("volume_error").draw(random, scale, d);
      ASSERT_NE(d.volume_lag.has_value(), d.volume_error.has_value());
      late += d.volume_lag ? 1 : 0;
    }
    EXPECT_EQ(late > 0, moves) << late;
  }
}

TEST(Departures, EachOneThatIsDrawnShows) {
  const Rows nominal = stage().run({});
  for (const DepartureKind& kind : departure_kinds()) {
    Random random(5);
    Departures d;
    const Drawn drawn = kind.draw(random, kMiddlingScale, d);
    EXPECT_EQ(drawn.id, kind.id);
    EXPECT_GT(largest_difference(stage().run(d), nominal), 1e-3) << "Pa, " << kind.id;
    kind.remove(d);
    EXPECT_EQ(stage().run(d).pressure_Pa, nominal.pressure_Pa) << kind.id << " taken away";
  }
}

TEST(Departures, HalvingTheStepMovesNoRowByMoreThanAFewPascals) {
  const auto check = [](const Departures& d, std::string_view name) {
    const double moved = largest_difference(stage().run(d), stage().run(d, 0.5 * kStep_s));
    EXPECT_LT(moved, 5.0) << "Pa, " << name;
  };
  check({}, "nominal");
  for (const DepartureKind& kind : departure_kinds()) {
    Random random(5);
    Departures d;
    kind.draw(random, kMiddlingScale, d);
    check(d, kind.id);
  }
}

// ---- each against a closed form

Machine plain() {
  Machine made;
  made.rig.supply.pressure_Pa = 700e3;
  made.motion.mean_m3 = 150e-6;
  made.initial_Pa = 150e3;
  made.rig.sampling.pressure_average_s = 0.0;
  return made;
}

/// Inflow alone, choked throughout: the pressure rises by a line.
Machine filling() {
  Machine made = plain();
  made.rig.supply.pressure_Pa = 2e6;
  made.rig.valve.exhaust_below_V = -1e6;
  made.rig.valve.exhaust_leak_m2 = 0.0;
  made.rig.valve.transition_m2 = 1e-12;
  return made;
}

Machine sealed() {
  Machine made = filling();
  made.rig.valve.open_above_V = 1e6;
  made.rig.valve.inlet_leak_m2 = 0.0;
  made.initial_Pa = 600e3;
  return made;
}

Driver constant(double command_V) {
  return [command_V](std::size_t, double) { return command_V; };
}

double slope_Pa_s(const Rows& rows) {
  return (rows.pressure_Pa[19] - rows.pressure_Pa[9]) / 0.1;
}

TEST(Departures, SensorLagsARampByItsTimeConstant) {
  for (const double damping : {0.0, 0.8}) {
    Machine late = filling();
    late.departures.sensor_lag = SensorLag{0.02, damping};
    const Rows a = simulate(filling(), 20, constant(5.3)), b = simulate(late, 20, constant(5.3));
    const double lag_s = damping == 0.0 ? 0.02 : 2.0 * damping * 0.02;
    EXPECT_NEAR((a.pressure_Pa[19] - b.pressure_Pa[19]) / slope_Pa_s(a), lag_s, 1e-6)
        << "s, damping " << damping;
  }
}

TEST(Departures, SensorBiasIsALineOfThePressure) {
  Machine off = plain();
  off.departures.sensor_bias = SensorBias{1500.0, 1.02};
  const Rows a = simulate(plain(), 20, constant(5.5)), b = simulate(off, 20, constant(5.5));
  for (std::size_t k = 0; k < 20; ++k) EXPECT_NEAR(b.pressure_Pa[k], 1500.0 + 1.02 * a.pressure_Pa[k], 1e-6);
}

TEST(Departures, RegulatorLosesItsDroopTimesTheFlow) {
  Machine drooping = filling();
  const double share = 0.25;  // m' = m'_0 (1 - droop m'/P): droop = share P/m'_0 gives m' = m'_0/(1 + share)
  const double area = port_area(5.3 - 5.08, 1.5e-6, 3e-8, 1e-12);
  const double flow = 0.72 * area * thin_plate_flux(2e6, 0.0, 293.15);
  drooping.departures.regulator = Regulator{share * 2e6 / flow, 0.01};
  const double ratio =
      slope_Pa_s(simulate(drooping, 20, constant(5.3))) / slope_Pa_s(simulate(filling(), 20, constant(5.3)));
  EXPECT_NEAR(ratio, 1.0 / (1.0 + share), 1e-6);
}

TEST(Departures, LineAddsItsVolume) {
  // A puff of the same mass into chamber and line: once at rest, the rise goes as one over the volume.
  Machine near = filling();
  near.rig.valve.inlet_leak_m2 = 0.0;
  Machine far = near;
  far.departures.tube = Tube{1.5, 4e-3, 0.03, 12};
  const auto puff = [](std::size_t row, double) { return row >= 10 && row < 30 ? 5.3 : 4.9; };
  const auto rise = [&](const Machine& m) {
    const Rows rows = simulate(m, 300, puff);
    return rows.pressure_Pa[299] - rows.pressure_Pa[0];
  };
  const double line_m3 = 1.5 * 0.25 * std::numbers::pi * 16e-6;
  EXPECT_NEAR(rise(far) / rise(near), 150e-6 / (150e-6 + line_m3), 1e-5);
}

TEST(Departures, LineDropsThePressureOfAThroughFlowAsIsothermalFrictionDoes) {
  // What the hole lets out has come through valve and line: d(p^2)/dx = -2 R T (32 mu/D^2 + f w/(2 A D)) w/A.
  const double length_m = 2.5, bore_m = 0.8e-3, friction = 0.03, hole_m2 = 0.1e-6;
  Machine m = filling();
  m.motion.mean_m3 = 5e-6;
  m.departures.tube = Tube{length_m, bore_m, friction, 12};
  m.departures.chamber_leak = ChamberLeak{0.0, hole_m2};
  const Rows rows = simulate(m, 1000, constant(5.2));
  const double p = rows.pressure_Pa.back();
  ASSERT_NEAR(p, rows.pressure_Pa[900], 1e-3) << "Pa: it has come to rest";
  const auto& v = m.rig.valve;
  const double temperature_K = m.rig.gas.temperature_K;
  const double w =
      v.discharge_coefficient * hole_m2 * thin_plate_flux(p, m.rig.ambient.pressure_Pa, temperature_K);
  const double inlet_m2 = v.discharge_coefficient * port_area(5.2 - v.open_above_V, v.inlet_area_per_V_m2,
                                                              v.inlet_leak_m2, v.transition_m2);
  double at_valve_Pa = m.rig.supply.pressure_Pa, below_Pa = p;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (at_valve_Pa + below_Pa);
    (inlet_m2 * thin_plate_flux(m.rig.supply.pressure_Pa, middle, temperature_K) < w ? at_valve_Pa
                                                                                     : below_Pa) = middle;
  }
  const double area_m2 = 0.25 * std::numbers::pi * bore_m * bore_m;
  const double per_m = 2.0 * kGasConstant_J_kg_K * temperature_K / area_m2 * w *
                       (32.0 * 1.82e-5 / (bore_m * bore_m) + friction * w / (2.0 * area_m2 * bore_m));
  EXPECT_GT(at_valve_Pa / p, 1.2) << "the line throttles";
  EXPECT_NEAR((at_valve_Pa * at_valve_Pa - p * p) / (per_m * length_m), 1.0, 1e-4);
}

TEST(Departures, DeadVolumeSlowsAFill) {
  Machine larger = filling();
  larger.departures.volume_error = VolumeError{30e-6};
  const double ratio =
      slope_Pa_s(simulate(larger, 20, constant(5.3))) / slope_Pa_s(simulate(filling(), 20, constant(5.3)));
  EXPECT_NEAR(ratio, 150.0 / 180.0, 1e-9);
}

TEST(Departures, CapillaryEmptiesASealedChamberByItsLaw) {
  // p' = -c (p^2 - a^2), c = kappa R T K/(2 a v): ln((p - a)/(p + a)) falls by 2 a c a second.
  Machine leaking = sealed();
  leaking.departures.chamber_leak = ChamberLeak{1e-10, 0.0};
  const Rows rows = simulate(leaking, 200, constant(5.0));
  const double a = 101325.0, rt = kGasConstant_J_kg_K * 293.15;
  const auto fallen = [&](double p) { return std::log((p - a) / (p + a)); };
  EXPECT_NEAR((fallen(rows.pressure_Pa[199]) - fallen(rows.pressure_Pa[0])) / 1.99,
              -kKappa * rt * 1e-10 / 150e-6, 1e-7)
      << "1/s";
}

TEST(Departures, SilencerAloneEmptiesAChamberByItsLaw) {
  // A port much wider than the silencer: p' = -c sqrt(p^2 - a^2): arcosh(p/a) falls by c a second.
  for (const double manifold_m3 : {0.0, 1e-6}) {
    Machine muffled = sealed();
    muffled.rig.valve.exhaust_below_V = 1000.0;
    muffled.rig.valve.exhaust_area_per_V_m2 = 5e-8;  // 50 mm2
    const double g = 1e-9;
    muffled.departures.silencer = Silencer{g, manifold_m3};
    const Rows rows = simulate(muffled, 60, constant(5.0));
    const double rt = kGasConstant_J_kg_K * 293.15;
    const double fallen =
        std::acosh(rows.pressure_Pa[0] / 101325.0) - std::acosh(rows.pressure_Pa[59] / 101325.0);
    EXPECT_NEAR(fallen / 0.59 / (kKappa * rt * g / (150e-6 + manifold_m3)), 1.0, 0.02)
        << "manifold " << manifold_m3;
  }
}

TEST(Departures, TremorSqueezesASealedChamberAdiabaticallyAndTheColumnMissesIt) {
  Machine shaken = sealed();
  constexpr double kShare = 0.03, kFrequency_Hz = 7.0;
  shaken.departures.volume_tremor = VolumeTremor{kShare * shaken.motion.mean_m3, kFrequency_Hz, 0.0};
  const Rows rows = simulate(shaken, 100, constant(5.0));
  const auto volume_share = [&](std::size_t k) {
    return 1.0 + kShare * std::sin(2.0 * std::numbers::pi * kFrequency_Hz * 0.01 * static_cast<double>(k));
  };
  for (std::size_t k = 0; k < rows.pressure_Pa.size(); ++k) {
    EXPECT_NEAR(rows.pressure_Pa[k] * std::pow(volume_share(k), 1.4) / rows.pressure_Pa[0], 1.0, 1e-4)
        << "row " << k;
    EXPECT_EQ(rows.volume_m3[k], shaken.motion.mean_m3);
  }
}

TEST(Departures, AWallOfAnyConductanceMakesCompressionIsothermal) {
  Machine cooled = sealed();
  cooled.motion.tones[0] = {0.3, 0.2, 0.0};
  cooled.departures.wall_heat = WallHeat{100.0, 0.5};
  const Rows rows = simulate(cooled, 300, constant(5.0));
  const double constant0 = rows.pressure_Pa[0] * rows.volume_m3[0];
  for (std::size_t k = 0; k < 300; ++k) {
    EXPECT_NEAR(rows.pressure_Pa[k] * rows.volume_m3[k] / constant0, 1.0, 0.005) << "row " << k;
  }
}

TEST(Departures, HotGasCoolsAtTheRateOfItsHeatCapacity) {
  // After a puff, at rest: m c_v dT/dt = H (T_w - T), so that p falls to m R T_w/v with tau = p_end v/(T_w (kappa - 1) H).
  Machine cooling = filling();
  cooling.rig.valve.inlet_leak_m2 = 0.0;
  cooling.departures.wall_heat = WallHeat{0.8, 0.0};
  const auto puff = [](std::size_t row, double) { return row >= 10 && row < 30 ? 5.3 : 4.9; };
  const Rows rows = simulate(cooling, 1500, puff);
  const double end_Pa = rows.pressure_Pa.back();
  const double tau_s = end_Pa * 150e-6 / (293.15 * (kKappa - 1.0) * 0.8);
  ASSERT_GT(rows.pressure_Pa[40] - end_Pa, 10e3) << "Pa: the puff is hot";
  EXPECT_NEAR(std::log((rows.pressure_Pa[40] - end_Pa) / (rows.pressure_Pa[80] - end_Pa)), 0.4 / tau_s, 1e-4);
}

/// Down well below, then up to `to_V`: the spool comes from below.
Driver from_below(double to_V) {
  return [to_V](std::size_t row, double) {
    return row < 50 ? 4.0 : row < 60 ? 4.0 + 0.1 * (to_V - 4.0) * double(row - 49) : to_V;
  };
}

TEST(Departures, HysteresisComesToHalfItsWidthBehindTheCommand) {
  Machine shifted = plain();
  shifted.rig.valve.open_above_V += 0.03;
  shifted.rig.valve.exhaust_below_V += 0.03;
  const Rows expected = simulate(shifted, 100, from_below(5.5));
  for (const bool bristles : {false, true}) {
    Machine m = plain();
    if (bristles) {
      m.departures.lugre = LuGre{0.03, 0.2};
    } else {
      m.departures.bouc_wen = BoucWen{0.03};
    }
    const Rows rows = simulate(m, 100, from_below(5.5));
    const double rise = rows.pressure_Pa[75] - rows.pressure_Pa[65];
    EXPECT_NEAR(rise / (expected.pressure_Pa[75] - expected.pressure_Pa[65]), 1.0, 0.01)
        << (bristles ? "LuGre" : "Bouc-Wen");
  }
}

TEST(Departures, DriftEndsAsAShiftOfBothThresholds) {
  Machine drifted = filling(), shifted = filling();
  drifted.departures.null_drift = NullDrift{NullDrift::Course::kRamp, 0.1, 0.05, {}};
  shifted.rig.valve.open_above_V -= 0.1;
  EXPECT_NEAR(
      slope_Pa_s(simulate(drifted, 20, constant(5.3))) / slope_Pa_s(simulate(shifted, 20, constant(5.3))),
      1.0, 1e-9);
}

TEST(Departures, SlowSpoolFollowsAtLast) {
  Machine slow = filling();
  slow.departures.spool_lag = SpoolLag{20.0, 0.7, 300.0};
  const auto jump = [](std::size_t row, double) { return row < 2 ? 5.2 : 5.3; };
  const Rows a = simulate(filling(), 40, jump), b = simulate(slow, 40, jump);
  const double w = 2.0 * std::numbers::pi * 20.0;
  // The area of the step response above it: coil 0.1/w and spool 2 zeta/w; the gain from 5.2 to 5.3 V counts.
  const double added =
      (a.pressure_Pa[39] - a.pressure_Pa[29] - 10.0 * (a.pressure_Pa[1] - a.pressure_Pa[0])) / 0.1;
  EXPECT_NEAR((a.pressure_Pa[39] - b.pressure_Pa[39]) / added, (0.1 + 1.4) / w, 1e-4) << "s";
}

}  // namespace
}  // namespace plenum::host::blind
