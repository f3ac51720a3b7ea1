// What the logs of a machine with an effect tell of it, against machines of the blind generator and a gas integrated here: neither
// shares code with the catalogue.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "host-sim/blind/blind_case.hpp"
#include "host-sim/blind/excitation.hpp"
#include "host-sim/blind/truth.hpp"
#include "host-sim/identify/chamber/fit_greybox.hpp"

namespace plenum::host::identify::chamber {
namespace {

constexpr std::size_t kRows = 4000;
constexpr double kNoise_Pa = 100.0;

trace::Log log_of(const blind::Rows& rows, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise_Pa(0.0, kNoise_Pa);
  trace::Log log;
  for (std::size_t k = 0; k < rows.command_V.size(); ++k) log.time_s.push_back(0.01 * static_cast<double>(k));
  log.command_V = rows.command_V;
  log.volume_m3 = rows.volume_m3;
  for (const double p : rows.pressure_Pa) log.pressure_Pa.push_back(p + noise_Pa(random));
  return log;
}

template <class Departure>
blind::Departures only(std::optional<Departure> blind::Departures::*which, const Departure& departure) {
  blind::Departures departures;
  departures.*which = departure;
  return departures;
}

/// 40 s of a data sheet's machine with a departure; its volume swings by `swing`.
trace::Log log_of(const blind::Departures& departures, unsigned seed, double swing = 0.3) {
  blind::Machine machine;
  machine.motion = {.mean_m3 = 150e-6, .tones = {{{swing, 0.9, 0.4}, {}}}};
  machine.departures = departures;
  return log_of(blind::simulate(machine, kRows, blind::excite({.rows = kRows}, seed)), seed);
}

/// The same of a gas that is compressed with the exponent n: p' = n (R T m'/v - p v'/v), by Runge and Kutta in steps of 0.1 ms.
trace::Log polytropic_log(double n, double swing, unsigned seed) {
  constexpr double kStep_s = 1e-4;
  constexpr int kSteps = 100;
  const trace::RigDescription rig;
  const blind::Motion motion{.mean_m3 = 150e-6, .tones = {{{swing, 0.9, 0.4}, {}}}};
  const auto drive = blind::excite({.rows = kRows}, seed);
  const double T_K = rig.gas.temperature_K;
  const auto rate = [&](double t_s, double p_Pa, double command_V) {
    const auto& valve = rig.valve;
    const double in_m2 = blind::port_area(command_V - valve.open_above_V, valve.inlet_area_per_V_m2,
                                          valve.inlet_leak_m2, valve.transition_m2);
    const double out_m2 = blind::port_area(valve.exhaust_below_V - command_V, valve.exhaust_area_per_V_m2,
                                           valve.exhaust_leak_m2, valve.transition_m2);
    const double flow_kg_s =
        valve.discharge_coefficient * (in_m2 * blind::thin_plate_flux(rig.supply.pressure_Pa, p_Pa, T_K) -
                                       out_m2 * blind::thin_plate_flux(p_Pa, rig.ambient.pressure_Pa, T_K));
    const double v = motion.at(t_s);
    return n * (blind::kGasConstant_J_kg_K * T_K * flow_kg_s - p_Pa * motion.rate(t_s)) / v;
  };
  blind::Rows rows;
  double p = 200e3, mean = p;
  for (std::size_t k = 0; k < kRows; ++k) {
    const double t0 = 0.01 * static_cast<double>(k);
    const double u = drive(k, mean);
    rows.command_V.push_back(u);
    rows.pressure_Pa.push_back(mean);
    rows.volume_m3.push_back(motion.at(t0));
    mean = 0.0;
    for (int i = 0; i < kSteps; ++i) {
      const double t = t0 + kStep_s * i;
      const double k1 = rate(t, p, u);
      const double k2 = rate(t + 0.5 * kStep_s, p + 0.5 * kStep_s * k1, u);
      const double k3 = rate(t + 0.5 * kStep_s, p + 0.5 * kStep_s * k2, u);
      const double k4 = rate(t + kStep_s, p + kStep_s * k3, u);
      const double next = p + kStep_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
      mean += 0.5 * (p + next) / kSteps;
      p = next;
    }
  }
  return log_of(rows, seed);
}

/// The figure as found; without a standard error the fit did not look for it, or is at a bound.
FigureFit found(const GreyboxFit& fit, const std::string& name) {
  const auto at = std::find_if(fit.parameters.begin(), fit.parameters.end(),
                               [&](const FigureFit& one) { return one.name == name; });
  if (at != fit.parameters.end()) return *at;
  ADD_FAILURE() << name << " was not fitted; kept: " << testing::PrintToString(fit.kept);
  return {};
}

void expect_near(const FigureFit& of, double truth, double share) {
  EXPECT_NEAR(of.value, truth, share * truth) << of.name;
  EXPECT_NEAR(of.value, truth, 5.0 * of.standard_error) << of.name;
}

TEST(FitEffects, FindsALeakOfTheChamber) {
  for (const unsigned seed : {1U, 2U}) {
    const GreyboxFit fit =
        fit_greybox({log_of(only(&blind::Departures::chamber_leak, {0.5e-9, 0.0}), seed)}, {});
    EXPECT_THAT(fit.kept, testing::ElementsAre("chamber_leak")) << seed;
    expect_near(found(fit, "chamber_leak.conductance_g_s_MPa"), 0.5, 0.05);
  }
}

TEST(FitEffects, FindsTheLagOfASensor) {
  for (const unsigned seed : {1U, 2U}) {
    const GreyboxFit fit = fit_greybox({log_of(only(&blind::Departures::sensor_lag, {0.03, 0.0}), seed)}, {});
    EXPECT_THAT(fit.kept, testing::ElementsAre("sensor_lag")) << seed;
    expect_near(found(fit, "sensor_lag.time_constant_s"), 0.03, 0.03);
  }
}

/// Of a machine whose spool is dragged between two stops `width_V` apart.
trace::Log log_with_play(double width_V, unsigned seed) {
  blind::Machine machine;
  machine.motion = {.mean_m3 = 150e-6, .tones = {{{0.3, 0.9, 0.4}, {}}}};
  const blind::Driver drive = blind::excite({.rows = kRows}, seed);
  std::vector<double> command_V;
  double spool_V = 5.0;
  blind::Rows rows = blind::simulate(machine, kRows, [&](std::size_t row, double pressure_Pa) {
    const double u = drive(row, pressure_Pa);
    if (command_V.size() <= row) command_V.resize(row + 1);
    command_V[row] = u;
    if (row == 0) spool_V = u;
    return spool_V = std::clamp(spool_V, u - 0.5 * width_V, u + 0.5 * width_V);
  });
  rows.command_V = command_V;
  return log_of(rows, seed);
}

TEST(FitEffects, FindsTheWidthOfAPlay) {
  for (const unsigned seed : {1U, 2U}) {
    const GreyboxFit fit = fit_greybox({log_with_play(0.2, seed)}, {});
    EXPECT_THAT(fit.kept, testing::ElementsAre("valve_hysteresis")) << seed;
    expect_near(found(fit, "valve_hysteresis.width_V"), 0.2, 0.03);
  }
}

TEST(FitEffects, FindsTheDroopOfASupply) {
  for (const unsigned seed : {1U, 2U}) {
    const GreyboxFit fit = fit_greybox({log_of(only(&blind::Departures::regulator, {30e6, 0.1}), seed)}, {});
    EXPECT_THAT(fit.kept, testing::Contains("supply_droop")) << seed;
    EXPECT_LT(fit.rms_free_run_kPa, 2e-3 * kNoise_Pa) << seed << ": 18 kPa without it";
    expect_near(found(fit, "supply_droop.resistance_kPa_s_per_g"), 30.0, 0.03);
    EXPECT_NEAR(found(fit, "supply_droop.recovery_s").value, 0.1, 0.05 * 0.1) << seed;
  }
}

TEST(FitEffects, FollowsALoggedSupplyThatOthersDrawFrom) {
  const blind::Neighbour neighbour{.drop_Pa = 80e3, .period_s = 3.0, .duty = 0.4, .phase = 0.2};
  trace::Log log = log_of(only(&blind::Departures::neighbour, neighbour), 1);
  for (const double t_s : log.time_s) {
    const double turn = (t_s - 0.005) / neighbour.period_s + neighbour.phase;  // over the tick before the row
    const bool draws = turn - std::floor(turn) < neighbour.duty;
    log.supply_Pa.push_back(trace::RigDescription{}.supply.pressure_Pa - (draws ? neighbour.drop_Pa : 0.0));
  }
  const GreyboxFit fit = fit_greybox({log}, {});
  EXPECT_THAT(fit.kept, testing::ElementsAre("supply_droop"));
  EXPECT_NEAR(found(fit, "supply_droop.followed_share").value, 1.0, 0.05);
}

TEST(FitEffects, FindsTheExponentOfTheGasWhereTheVolumeMoves) {
  for (const double n : {1.1, 1.25}) {
    const GreyboxFit fit = fit_greybox({polytropic_log(n, 0.3, 3)}, {});
    EXPECT_THAT(fit.kept, testing::ElementsAre("heat_transfer")) << n;
    expect_near(found(fit, "heat_transfer.exponent"), n, 0.01);
    EXPECT_LT(fit.rms_free_run_kPa, 1.05e-3 * kNoise_Pa) << n;
  }
}

TEST(FitEffects, OfAChamberBehindWallsThatConductWithoutLimitTheExponentIsOne) {
  const GreyboxFit fit = fit_greybox({log_of(only(&blind::Departures::wall_heat, {300.0, 0.0}), 4)}, {});
  EXPECT_THAT(fit.kept, testing::Contains("heat_transfer"));
  EXPECT_NEAR(found(fit, "heat_transfer.exponent").value, 1.0, 0.01);
}

TEST(FitEffects, WhereTheVolumeRestsNothingTellsTheExponentAndItStays) {
  const GreyboxFit fit = fit_greybox({polytropic_log(1.1, 0.0, 5)}, {});
  EXPECT_THAT(fit.kept, testing::IsEmpty());
  EXPECT_THAT(fit.not_told,
              testing::Contains(testing::AllOf(testing::Field(&NotTold::name, "heat_transfer.exponent"),
                                               testing::Field(&NotTold::value, 1.4))));
}

TEST(FitEffects, AreNotInventedOnMachinesWithoutAny) {
  for (const int tier : {1, 2}) {
    for (const std::uint64_t seed : {11U, 12U, 13U, 14U}) {
      const blind::Case made = blind::make_case({.effects = {}, .kind = "none", .tier = tier, .seed = seed});
      const GreyboxFit fit = fit_greybox({made.log}, made.rig);
      EXPECT_THAT(fit.kept, testing::IsEmpty()) << "tier " << tier << ", seed " << seed;
      EXPECT_THAT(fit.not_told, testing::SizeIs(11)) << "tier " << tier << ", seed " << seed;
    }
  }
}

TEST(FitEffects, OfARigThatStatesOneAreAsConfiguredAndNotLookedFor) {
  trace::RigDescription rig;
  rig.effects["sensor_lag"]["time_constant_s"] = 0.03;
  const GreyboxFit fit = fit_greybox({log_of(only(&blind::Departures::sensor_lag, {0.03, 0.0}), 1)}, rig);
  EXPECT_EQ(fit.rig.effects, rig.effects);
  EXPECT_THAT(fit.not_told,
              testing::Each(testing::Field(&NotTold::name, testing::Not(testing::HasSubstr("sensor_lag")))));
}

}  // namespace
}  // namespace plenum::host::identify::chamber
