// tube_dynamics against closed forms and balances.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <vector>

#include "tests/effects/chamber_under_effects.hpp"

namespace plenum::host::effects {
namespace {

struct Valve {
  double rate, slope;
};

struct Line {
  double fittings_mm2 = kInfinity, resistance_kPa_s_per_g = 0.0, sensor_share = 0.0, chamber_share = 0.0;
};
TubeDynamics<double> tube_of(double length_m, double bore_mm, double step_s, double start_Pa,
                             const Line& line = {}) {
  const double x[] = {length_m,
                      bore_mm,
                      1.0 / (line.fittings_mm2 * line.fittings_mm2),
                      line.resistance_kPa_s_per_g,
                      line.sensor_share,
                      line.chamber_share};
  TubeDynamics<double> tube;
  tube.prepare(x, RT(), 1.4, step_s, start_Pa);
  return tube;
}

double hose_volume_m3(double length_m, double bore_mm) {
  return std::numbers::pi / 4.0 * bore_mm * bore_mm * 1e-6 * length_m;
}

constexpr TubeDynamics<double>::Ends kEnds{1e5, 6e5};

TEST(TubeDynamics, WhatTheValvePassesIsFoundInHoseAndChamber) {
  const double flow = 2e-3;
  const double per_flow = 1.4 * RT() / 150e-6;
  for (const double length_m : {0.01, 1.0, 8.0}) {
    for (const double share : {0.0, 0.5}) {
      TubeDynamics<double> tube = tube_of(length_m, 4.0, 0.0025, 2e5, {.chamber_share = share});
      const double chamber_m3 = 150e-6 + tube.at_chamber_m3();
      double chamber_Pa = 2e5;
      for (int k = 0; k < 4000; ++k) {  // until it rests
        double passed = 0.0;
        const double rate = k < 100 ? flow : 0.0;
        const auto valve = [&](double, double part) {
          passed += part * rate;
          return Valve{rate, 0.0};
        };
        chamber_Pa =
            tube.advance(chamber_Pa, {per_flow * 150e-6 / chamber_m3, 0.0, 0.0}, kEnds, valve).end_Pa;
        ASSERT_NEAR(passed, rate, 1e-12 * flow) << "the shares of a step's mean";
      }
      EXPECT_NEAR(tube.at_valve_Pa() / chamber_Pa, 1.0, 1e-9);
      const double gained_kg = (chamber_Pa - 2e5) * (150e-6 + hose_volume_m3(length_m, 4.0)) / (1.4 * RT());
      EXPECT_NEAR(gained_kg / (flow * 0.25), 1.0, 1e-9) << length_m << " m, share " << share;
    }
  }
}

TEST(TubeDynamics, PartOfNoLengthChangesNothing) {
  TubeDynamics<double> tube = tube_of(1.0, 4.0, 0.0025, 2e5);
  const auto valve = [](double, double) { return Valve{2e-3, 0.0}; };
  const double chamber_Pa = tube.advance(2e5, {1.4 * RT() / 150e-6, 0.0, 0.0}, kEnds, valve).end_Pa;
  const double at_valve_Pa = tube.at_valve_Pa(), flow_kg_s = tube.flow_kg_s();
  EXPECT_GT(at_valve_Pa - chamber_Pa, 1e3);
  EXPECT_NEAR(tube.advance(chamber_Pa, {1.4 * RT() / 150e-6, 0.0, 0.0}, kEnds, valve, 0.0).end_Pa, chamber_Pa,
              1.0);
  EXPECT_NEAR(tube.at_valve_Pa(), at_valve_Pa, 10.0);
  EXPECT_NEAR(tube.flow_kg_s(), flow_kg_s, 1e-6);
}

TEST(TubeDynamics, SteadyDropIsThatOfIsothermalFlowWithLaminarPlusTurbulentFriction) {
  const double flow = 1e-3;
  const double length_m = 2.0;
  const double bore_m = 4e-3;
  TubeDynamics<double> tube = tube_of(length_m, 4.0, 0.0025, 3e5);
  // a chamber without end: its pressure stands still
  for (int k = 0; k < 4000; ++k) {
    tube.advance(3e5, {0.0, 0.0, 0.0}, kEnds, [&](double, double) { return Valve{flow, 0.0}; });
  }
  // p dp = -R T (128 mu w/(pi D^4) + f w^2/(2 D A^2)) dx, from one end to the other
  const double area = std::numbers::pi / 4.0 * bore_m * bore_m;
  const double per_m = 128.0 * 1.8e-5 * flow / (std::numbers::pi * std::pow(bore_m, 4)) +
                       0.03 * flow * flow / (2.0 * bore_m * area * area);
  const double expected_Pa = std::sqrt(3e5 * 3e5 + 2.0 * RT() * per_m * length_m);
  EXPECT_NEAR(tube.flow_kg_s() / flow, 1.0, 1e-9);
  EXPECT_NEAR(tube.at_valve_Pa() / expected_Pa, 1.0, 1e-9);
}

/// At the valve, a steady flow going through a wide hose into a chamber without end at 300 kPa.
double steady_Pa(const Line& line, double flow_kg_s) {
  TubeDynamics<double> tube = tube_of(1e-3, 12.0, 0.0025, 3e5, line);
  for (int k = 0; k < 4000; ++k) {
    tube.advance(3e5, {0.0, 0.0, 0.0}, kEnds, [&](double, double) { return Valve{flow_kg_s, 0.0}; });
  }
  return tube.at_valve_Pa();
}

TEST(TubeDynamics, FilterDropsItsResistanceTimesTheFlowAndFittingsAsAnOrificeDoes) {
  const double none_Pa = steady_Pa({}, 1e-3);
  EXPECT_NEAR(steady_Pa({.resistance_kPa_s_per_g = 40.0}, 1e-3) - none_Pa, 40e3, 1.0) << "Pa";
  EXPECT_NEAR(steady_Pa({.resistance_kPa_s_per_g = 40.0}, 2e-3) - steady_Pa({}, 2e-3), 80e3, 2.0) << "Pa";
  // p_t^2 - p^2 = R T (w/a)^2
  const double through_Pa = std::sqrt(RT()) * 1e-3 / 3e-6;
  EXPECT_NEAR(steady_Pa({.fittings_mm2 = 3.0}, 1e-3) / std::sqrt(none_Pa * none_Pa + through_Pa * through_Pa),
              1.0, 1e-6);
}

TEST(TubeDynamics, SensorAtTheValveReadsWhatStandsThereAndHalfwayTheMiddle) {
  const std::vector<double> command_V = jumping_command_V(300);
  const auto reading = [&](double share, int steps) {
    Figures figures = with(nominal(), kIdTubeDynamics, {1.5, 4.0, kInfinity, 0.0, share});
    return run(only(kIdTubeDynamics), figures, drive_of(command_V, swinging_volume(), steps), 3e5);
  };
  const std::vector<double> chamber = reading(0.0, 64), halfway = reading(0.5, 64), valve = reading(1.0, 64);
  EXPECT_GT(rms_difference(chamber, valve), 5e3) << "Pa";
  for (std::size_t k = 0; k < valve.size(); ++k) {
    ASSERT_NEAR(halfway[k], 0.5 * (chamber[k] + valve[k]), 1e-6) << "Pa, row " << k;
  }
  EXPECT_LT(rms_difference(reading(1.0, 4), reading(1.0, 256)), 250.0) << "Pa";

  // at the end of each step, too
  TubeDynamics<double> tube = tube_of(1.5, 4.0, 0.0025, 3e5, {.sensor_share = 1.0});
  for (int k = 0; k < 10; ++k) {
    const auto step = tube.advance(3e5, {0.0, 0.0, 0.0}, kEnds, [](double, double) {
      return Valve{1e-3, 0.0};
    });
    EXPECT_EQ(tube.read_Pa(step.end_Pa), tube.at_valve_Pa());
  }
}

// before a chamber so large that its pressure stands
double shut_hose_Hz(double length_m, const Line& line) {
  const double step_s = 2e-5;
  TubeDynamics<double> tube = tube_of(length_m, 12.0, step_s, 3e5, line);
  // pushed off by 100 Pa: friction is laminar, and little in so wide a hose
  double before = 0.0;
  std::vector<double> crossings_s;
  for (int k = 1; k < 20000 && crossings_s.size() < 9; ++k) {
    tube.advance(3e5 - 100.0, {0.0, 0.0, 0.0}, kEnds, [](double, double) { return Valve{0.0, 0.0}; });
    if (k > 1 && before * tube.flow_kg_s() < 0.0) crossings_s.push_back(k * step_s);
    before = tube.flow_kg_s();
  }
  return crossings_s.size() < 9 ? 0.0 : 4.0 / (crossings_s[8] - crossings_s[0]);
}

TEST(TubeDynamics, ShutHoseSwingsAtTheFirstFrequencyOfItsSections) {
  // n equal springs and masses in a row, one end shut and one open; shut with a half spring at c = 1/2
  const double length_m = 1.0;
  const auto n = static_cast<double>(TubeDynamics<double>::kSections);
  const double passes_Hz = std::sqrt(1.4 * RT()) / (2.0 * std::numbers::pi * length_m);
  EXPECT_NEAR(shut_hose_Hz(length_m, {}) / passes_Hz, 2.0 * n * std::sin(std::numbers::pi / (4.0 * n + 2.0)),
              0.01);
  const double halved = shut_hose_Hz(length_m, {.chamber_share = 0.5}) / passes_Hz;
  EXPECT_NEAR(halved, 2.0 * n * std::sin(std::numbers::pi / (4.0 * n)), 0.01);
  EXPECT_NEAR(halved / (std::numbers::pi / 2.0), 1.0, 0.02) << "of a line's first";
}

TEST(TubeDynamics, RestingHoseAddsItsAirToTheChamberWhereverItStands) {
  // slow changes: the chamber is larger by the hose
  const double length_m = 0.5, bore_mm = 8.0;
  const Drive drive = drive_of(std::vector<double>(400, 6.0), plant::VolumeMotion(100e-6), 4);
  const std::vector<double> without = run(0, sharp_valve(1e-12), drive, 1.2e5);
  EXPECT_GT(without.back() - 1.2e5, 1.0) << "Pa";
  for (const double share : {0.0, 0.2, 0.5}) {
    const Figures figures =
        with(sharp_valve(1e-12), kIdTubeDynamics, {length_m, bore_mm, kInfinity, 0.0, 0.0, share});
    const std::vector<double> with_hose = run(only(kIdTubeDynamics), figures, drive, 1.2e5);
    EXPECT_NEAR((without.back() - 1.2e5) / (with_hose.back() - 1.2e5),
                1.0 + hose_volume_m3(length_m, bore_mm) / 100e-6, 1e-2)
        << "share " << share;
  }
}

/// A chamber that is filled through a hose and then compressed.
struct Filled {
  double length_m, bore_mm, chamber_m3, flow_kg_s;

  double passed_kg_s(double t_s) const { return t_s < 0.2 ? flow_kg_s : 0.0; }
  static double swing(double t_s) { return 0.3 * std::sin(20.0 * t_s); }
  static double swing_1_s(double t_s) { return 0.3 * 20.0 * std::cos(20.0 * t_s); }
};
constexpr double kFine_s = 2e-5;

/// The chamber's pressure behind a line of 48 cells, half a cell at each end [Pa].
std::vector<double> behind_a_line_Pa(const Filled& of) {
  constexpr std::size_t kCells = 48;
  const double bore_m = 1e-3 * of.bore_mm;
  const double area_m2 = 0.25 * std::numbers::pi * bore_m * bore_m, cell_m = of.length_m / kCells;
  std::array<double, kCells + 1> p_Pa{};
  std::array<double, kCells> w_kg_s{};
  p_Pa.fill(2e5);
  std::vector<double> chamber_Pa;
  for (int k = 0; k < 40000; ++k) {
    const double t_s = k * kFine_s;
    const double volume_m3 = of.chamber_m3 * (1.0 + Filled::swing(t_s)) + 0.5 * area_m2 * cell_m;
    for (std::size_t i = 0; i < kCells; ++i) {
      const double density = 0.5 * (p_Pa[i] + p_Pa[i + 1]) / RT();
      const double drag = 32.0 * 1.8e-5 / (density * bore_m * bore_m) +
                          0.03 * std::abs(w_kg_s[i]) / (2.0 * density * area_m2 * bore_m);
      w_kg_s[i] = (w_kg_s[i] + kFine_s * area_m2 / cell_m * (p_Pa[i] - p_Pa[i + 1])) / (1.0 + kFine_s * drag);
    }
    p_Pa[0] += kFine_s * 1.4 * RT() / (0.5 * area_m2 * cell_m) * (of.passed_kg_s(t_s) - w_kg_s[0]);
    for (std::size_t i = 1; i < kCells; ++i) {
      p_Pa[i] += kFine_s * 1.4 * RT() / (area_m2 * cell_m) * (w_kg_s[i - 1] - w_kg_s[i]);
    }
    p_Pa.back() += kFine_s * 1.4 / volume_m3 *
                   (RT() * w_kg_s.back() - p_Pa.back() * of.chamber_m3 * Filled::swing_1_s(t_s));
    chamber_Pa.push_back(p_Pa.back());
  }
  return chamber_Pa;
}

TEST(TubeDynamics, WithHalfItsAirAtEachEndOfASectionItFollowsALineOfManyCells) {
  // wide and long; and as narrow as a small valve's, where friction is all
  for (const Filled& of : {Filled{4.0, 4.0, 150e-6, 1e-3}, Filled{2.5, 0.8, 10e-6, 1e-5}}) {
    const std::vector<double> line_Pa = behind_a_line_Pa(of);
    const auto error_Pa = [&](double share) {
      TubeDynamics<double> tube = tube_of(of.length_m, of.bore_mm, kFine_s, 2e5, {.chamber_share = share});
      double chamber_Pa = 2e5;
      std::vector<double> all_Pa;
      for (std::size_t k = 0; k < line_Pa.size(); ++k) {
        const double t_s = static_cast<double>(k) * kFine_s;
        const double volume_m3 = of.chamber_m3 * (1.0 + Filled::swing(t_s)) + tube.at_chamber_m3();
        const double squeeze_1_s = Filled::swing_1_s(t_s) * of.chamber_m3 / volume_m3;
        chamber_Pa = tube.advance(chamber_Pa, {1.4 * RT() / volume_m3, 0.0, 1.4 * squeeze_1_s}, {1e5, 2e6},
                                  [&](double, double) {
                                    return Valve{of.passed_kg_s(t_s), 0.0};
                                  })
                         .end_Pa;
        all_Pa.push_back(chamber_Pa);
      }
      return rms_difference(all_Pa, line_Pa);
    };
    const auto [least, most] = std::minmax_element(line_Pa.begin(), line_Pa.end());
    EXPECT_LT(error_Pa(0.5), 1e-3 * (*most - *least)) << "Pa, " << of.length_m << " m, " << error_Pa(0.5);
    EXPECT_LT(error_Pa(0.5), 0.2 * error_Pa(0.0)) << "Pa " << error_Pa(0.0);
  }
}

TEST(TubeDynamics, VeryShortHoseIsAsNone) {
  const std::vector<double> command_V = jumping_command_V(1000);
  const Drive drive = drive_of(command_V, swinging_volume(), 32);
  const std::vector<double> plain = run(0, nominal(), drive, 3e5);
  EXPECT_LT(rms_difference(
                run(only(kIdTubeDynamics), with(nominal(), kIdTubeDynamics, {0.0, 4.0}), drive, 3e5), plain),
            25.0)
      << "Pa: the friction of a millimetre, in swings of 600 kPa";
}

TEST(TubeDynamics, HoseOfAnyLengthAndBoreIsTheSameAtFourStepsAsAtManyMore) {
  const std::vector<double> command_V = jumping_command_V(300);
  struct Behind {
    plant::VolumeMotion chamber;
    double gain_m2_V;
  };
  const Behind usual{swinging_volume(), 1.5e-6};
  // the valve fills a hose of 2 mm to the supply within half a millisecond
  const Behind small{
      plant::VolumeMotion(45e-6, {{{.amplitude_m3 = 8e-6, .frequency_Hz = 0.9, .phase_rad = 0.3}, {}, {}}}),
      4e-6};
  for (const Behind& machine : {usual, small}) {
    for (const double length_m : {0.0, 0.03, 0.11, 0.3, 1.0, 5.0}) {
      for (const double bore_mm : {2.0, 4.0, 8.0}) {
        Figures figures = with(nominal(), kIdTubeDynamics, {length_m, bore_mm});
        figures[kInletGain] = figures[kExhaustGain] = machine.gain_m2_V;
        const auto at = [&](int steps) {
          return run(only(kIdTubeDynamics), figures, drive_of(command_V, machine.chamber, steps), 3e5);
        };
        const std::vector<double> fine = at(256);
        EXPECT_LT(rms_difference(at(4), fine), 250.0) << "Pa, " << length_m << " m of " << bore_mm << " mm";
        // each section of 3 cm of 2 mm is filled within 20 us
        const double bound_Pa =
            machine.gain_m2_V == small.gain_m2_V && length_m == 0.03 && bore_mm == 2.0 ? 100.0 : 50.0;
        EXPECT_LT(rms_difference(at(64), fine), bound_Pa)
            << "Pa, " << length_m << " m of " << bore_mm << " mm";
      }
    }
  }
}

}  // namespace
}  // namespace plenum::host::effects
