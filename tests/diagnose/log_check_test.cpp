#include "host-sim/diagnose/log_check.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/respiraworks.hpp"

namespace plenum::host::diagnose {
namespace {

using testing::HasSubstr;
using testing::Not;
using trace::Log;
using trace::RigDescription;

constexpr double kRate_Hz = 100.0;

/// A chamber by the textbook, in steps of 0.1 ms: an ideal nozzle from the supply and one to ambient.
struct Chamber {
  double volume_m3 = 200e-6;
  double swing = 0.0;  ///< of the volume, as a share
  double swing_Hz = 1.0;
  double start_Pa = 150e3;
  double supply_Pa = 700e3;
  double area_gain = 1.0;
  double noise_Pa = 100.0;
  double seconds = 20.0;
};

double nozzle_kg_s(double area_m2, double from_Pa, double to_Pa) {
  if (from_Pa < to_Pa) return -nozzle_kg_s(area_m2, to_Pa, from_Pa);
  const double ratio = std::max(to_Pa / from_Pa, 0.528);
  const double psi = std::sqrt(7.0 * (std::pow(ratio, 2.0 / 1.4) - std::pow(ratio, 2.4 / 1.4)));
  return 0.72 * area_m2 * from_Pa * psi / std::sqrt(287.0 * 293.15);
}

using Command = std::function<double(double time_s)>;

Log recorded(const Chamber& chamber, const Command& command_V) {
  const RigDescription::Valve valve;
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, chamber.noise_Pa);
  constexpr int kSteps = 100;
  const double step_s = 1.0 / (kRate_Hz * kSteps);
  const auto volume_m3 = [&](double time_s) {
    return chamber.volume_m3 *
           (1.0 + chamber.swing * std::sin(2.0 * std::numbers::pi * chamber.swing_Hz * time_s));
  };
  Log log;
  log.period_s = 1.0 / kRate_Hz;
  double p = chamber.start_Pa;
  for (int row = 0; row < static_cast<int>(chamber.seconds * kRate_Hz); ++row) {
    const double time_s = row / kRate_Hz;
    const double u = command_V(time_s);
    log.time_s.push_back(time_s);
    log.command_V.push_back(u);
    log.volume_m3.push_back(volume_m3(time_s));
    log.pressure_Pa.push_back(p + noise(random));
    const double inlet_m2 =
        chamber.area_gain *
        (valve.inlet_leak_m2 + valve.inlet_area_per_V_m2 * std::max(u - valve.open_above_V, 0.0));
    const double exhaust_m2 =
        chamber.area_gain *
        (valve.exhaust_leak_m2 + valve.exhaust_area_per_V_m2 * std::max(valve.exhaust_below_V - u, 0.0));
    for (int k = 0; k < kSteps; ++k) {
      const double now_s = time_s + k * step_s;
      const double v = volume_m3(now_s);
      const double flow_kg_s =
          nozzle_kg_s(inlet_m2, chamber.supply_Pa, p) - nozzle_kg_s(exhaust_m2, p, 101325.0);
      p += 1.4 * (287.0 * 293.15 * flow_kg_s * step_s - p * (volume_m3(now_s + step_s) - v)) / v;
    }
  }
  return log;
}

/// Random levels between 3 and 7 V, each held for 0.2 s.
Command random_steps() {
  std::mt19937 random(7);
  std::vector<double> levels(1000);
  for (double& level : levels) level = std::uniform_real_distribution<double>(3.0, 7.0)(random);
  return [levels](double time_s) { return levels[static_cast<std::size_t>(time_s / 0.2) % levels.size()]; };
}

/// Full fill, hold, full dump, hold: 2 s each.
double fill_and_dump(double time_s) {
  const int phase = static_cast<int>(time_s / 2.0) % 4;
  return phase == 0 ? 8.0 : phase == 2 ? 2.0 : 5.0;
}

Log excited(const Chamber& chamber = {}) {
  return recorded(chamber, random_steps());
}

/// "" where accepted; "2: message" for bad input; "3: message" where there is too little information.
std::string answer(const std::vector<NamedLog>& logs, const RigDescription& rig = {}) {
  try {
    require_diagnosable(logs, rig);
  } catch (const trace::InputError& error) {
    return std::string("2: ") + error.what();
  } catch (const CannotDiagnose& error) {
    return std::string("3: ") + error.what();
  }
  return "";
}

std::string answer(const Log& log, const RigDescription& rig = {}) {
  return answer(std::vector<NamedLog>{{"run.csv", log}}, rig);
}

void expect_refusal(int code, const Log& log, const std::vector<std::string>& says,
                    const RigDescription& rig = {}) {
  const std::string said = answer(log, rig);
  EXPECT_EQ(said.substr(0, 3), std::to_string(code) + ": ") << said;
  EXPECT_THAT(said, HasSubstr("run.csv"));
  EXPECT_THAT(said, HasSubstr("expected"));
  EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  for (const std::string& part : says) EXPECT_THAT(said, HasSubstr(part));
}

Log scaled_pressure(Log log, double gain, double offset_Pa) {
  for (double& p : log.pressure_Pa) p = gain * p + offset_Pa;
  return log;
}

Log scaled_volume(Log log, double gain) {
  for (double& v : log.volume_m3) v *= gain;
  return log;
}

Log scaled_command(Log log, double gain, double offset_V) {
  for (double& u : log.command_V) u = gain * u + offset_V;
  return log;
}

// ---- what must pass

TEST(LogCheck, AcceptsChambersFrom40To300MillilitresAtRestAndMoving) {
  for (const double volume_m3 : {40e-6, 100e-6, 300e-6}) {
    for (const double swing : {0.0, 0.2, 0.5}) {
      const Chamber chamber{.volume_m3 = volume_m3, .swing = swing};
      EXPECT_EQ(answer(excited(chamber)), "") << volume_m3 << " m3, swing " << swing;
      EXPECT_EQ(answer(recorded(chamber, fill_and_dump)), "") << volume_m3 << " m3, swing " << swing;
    }
  }
}

TEST(LogCheck, AcceptsWhatADiagnosisIsToFind) {
  EXPECT_EQ(answer(scaled_pressure(excited(), 1.0, -10e3)), "") << "a bias of -10 kPa";
  EXPECT_EQ(answer(scaled_pressure(excited(), 1.0, 10e3)), "") << "a bias of 10 kPa";
  EXPECT_EQ(answer(scaled_pressure(excited(), 0.95, -5e3)), "") << "gain and bias";
  EXPECT_EQ(answer(scaled_pressure(recorded({}, fill_and_dump), 0.95, -5e3)), "") << "the same, vented";
  EXPECT_EQ(answer(excited({.supply_Pa = 560e3})), "") << "a supply 20 % low";
  EXPECT_EQ(answer(excited({.supply_Pa = 840e3})), "") << "a supply 20 % high";
  EXPECT_EQ(answer(recorded({.supply_Pa = 560e3}, fill_and_dump)), "") << "rests at a low supply";
  EXPECT_EQ(answer(scaled_volume(excited(), 1.3)), "") << "a volume error of 30 %";
  EXPECT_EQ(answer(excited({.noise_Pa = 1000.0})), "") << "noise ten times what the sheet says";
  EXPECT_EQ(answer(excited({.noise_Pa = 0.0})), "") << "no noise";
  EXPECT_EQ(answer(recorded({.noise_Pa = 0.0}, fill_and_dump)), "") << "no noise, at rest to the last bit";
  EXPECT_EQ(answer(recorded({.volume_m3 = 40e-6, .supply_Pa = 560e3, .noise_Pa = 0.0}, fill_and_dump)), "")
      << "no noise, at rest to the last bit off the supply";
  for (const double gain : {0.2, 5.0}) EXPECT_EQ(answer(excited({.area_gain = gain})), "") << gain;
}

TEST(LogCheck, AcceptsASealedChamberThatDipsBelowAmbientAsItGrows) {
  const auto mostly_sealed = [](double time_s) { return time_s < 2.0 ? fill_and_dump(2.0 * time_s) : 5.0; };
  for (const double swing : {0.2, 0.5}) {
    const Log log =
        recorded({.swing = swing, .swing_Hz = 0.5, .start_Pa = 101325.0, .seconds = 30.0}, mostly_sealed);
    EXPECT_EQ(answer(log), "") << "least "
                               << *std::min_element(log.pressure_Pa.begin(), log.pressure_Pa.end())
                               << " Pa, swing " << swing;
  }
}

TEST(LogCheck, AcceptsAChamberThatTheLogFindsBeyondItsPressuresAsItHadMovedBefore) {
  const auto sealed_at_first = [steps = random_steps()](double time_s) mutable {
    return time_s < 2.0 ? 5.0 : steps(time_s);
  };
  const Log below = recorded({.swing = 0.4, .swing_Hz = 0.2, .start_Pa = 50e3}, sealed_at_first);
  EXPECT_EQ(answer(below), "");
  const Log above = recorded({.swing = 0.4, .swing_Hz = 0.2, .start_Pa = 1150e3}, sealed_at_first);
  EXPECT_EQ(answer(above), "");
  const Log gauge =
      scaled_pressure(recorded({.swing = 0.4, .swing_Hz = 0.2}, sealed_at_first), 1.0, -101325.0);
  EXPECT_THAT(answer(gauge), HasSubstr("looks like gauge pressure"));
}

TEST(LogCheck, AcceptsLongSealedHolds) {
  EXPECT_EQ(answer(recorded({.seconds = 60.0},
                            [](double time_s) { return std::fmod(time_s, 20.0) < 0.3 ? 5.8 : 5.0; })),
            "");
}

TEST(LogCheck, AcceptsABangBangCommandThatIsAlwaysAtItsEnds) {
  EXPECT_EQ(answer(recorded({}, [](double time_s) { return std::fmod(time_s, 0.5) < 0.22 ? 7.0 : 3.0; })),
            "");
}

TEST(LogCheck, AcceptsASensorThatRoundsToTwelveBits) {
  for (const Command& command : {random_steps(), Command(fill_and_dump)}) {
    Log log = recorded({.noise_Pa = 30.0}, command);
    for (double& p : log.pressure_Pa) p = std::round(p / 244.0) * 244.0;
    EXPECT_EQ(answer(log), "");
  }
}

TEST(LogCheck, AcceptsMeasuredVentilatorRuns) {
  RigDescription rig;
  rig.supply.pressure_Pa = 110e3;
  for (const char* run : {"1", "2", "3", "4", "5", "6"}) {
    const std::string file =
        std::string(PLENUM_SOURCE_DIR "/tests/data/respiraworks/ctl_OXY_") + run + ".csv";
    EXPECT_EQ(answer(trace::import_respiraworks(file), rig), "") << file;
  }
}

TEST(LogCheck, TakesAHoldAmongLogsThatExcite) {
  const Log hold = recorded({}, [](double) { return 5.0; });
  EXPECT_EQ(answer({{"hold.csv", hold}, {"run.csv", excited()}}), "");
  EXPECT_EQ(answer({{"a.csv", excited({.seconds = 2.0})}, {"b.csv", excited({.seconds = 2.0})}}), "");
}

TEST(LogCheck, TellsOfASupplyThatIsNotTheRigs) {
  Log log = excited();
  EXPECT_TRUE(notices({{"log.csv", log}}, {}).empty()) << "no column";
  log.supply_Pa.assign(log.size(), 700e3);
  for (std::size_t row = 0; row < log.size(); row += 2) log.supply_Pa[row] = 600e3;  // it droops
  EXPECT_TRUE(notices({{"log.csv", log}}, {}).empty());
  log.supply_Pa.assign(log.size(), 650e3);
  EXPECT_EQ(answer(log), "") << "one that is off is to be found";
  EXPECT_THAT(
      notices({{"log.csv", log}}, {}),
      ::testing::ElementsAre("log.csv: column supply_Pa comes to 650000, the rig's supply.pressure_Pa "
                             "is 700000: expected both alike"));
  log.supply_Pa.assign(log.size(), 500e3);
  expect_refusal(2, log, {"column supply_Pa comes to 500000", "correct the rig"});
  log.supply_Pa.assign(log.size(), 700e3);
  log.supply_Pa[41] = 0.0;
  expect_refusal(2, log, {"row 42", "column supply_Pa: 0"});
}

TEST(LogCheck, TellsOfPressuresAboveTheSupplyAndOfOneRowFarAboveIt) {
  Log log = excited();
  EXPECT_TRUE(notices({{"log.csv", log}}, {}).empty());
  trace::RigDescription low;
  low.supply.pressure_Pa = *std::max_element(log.pressure_Pa.begin(), log.pressure_Pa.end()) / 1.2;
  EXPECT_THAT(notices({{"log.csv", log}}, low),
              ::testing::ElementsAre(::testing::HasSubstr("above the rig's supply")));
  log.pressure_Pa[700] = 1.1e6;
  EXPECT_THAT(notices({{"log.csv", log}}, {}),
              ::testing::ElementsAre(::testing::HasSubstr("row 701 is 1.1e+06")));
}

TEST(LogCheck, TellsOfASensorThatStandsStillThoughAPortIsOpen) {
  Log log = excited();
  const std::size_t rows = static_cast<std::size_t>(5.0 / log.period_s);
  ASSERT_GT(log.size(), 2 * rows);
  std::fill_n(log.pressure_Pa.begin() + 100, rows, 321e3);
  EXPECT_THAT(
      notices({{"log.csv", log}}, {}),
      ::testing::ElementsAre(::testing::AllOf(::testing::HasSubstr("321000 to the last digit from row 101"),
                                              ::testing::HasSubstr("port is open"))));
}

TEST(LogCheck, TellsOfARestThatMovesFarLessThanWhatIsFitted) {
  Log log = excited();
  EXPECT_TRUE(notices_of_rests({{"log.csv", log}}, 0.6).empty());
  const auto rest = static_cast<std::size_t>(0.6 * static_cast<double>(log.size()));
  for (std::size_t row = rest; row < log.size(); ++row)
    log.pressure_Pa[row] = 120e3 + 0.05 * log.pressure_Pa[row];
  EXPECT_THAT(notices_of_rests({{"log.csv", log}}, 0.6),
              ::testing::ElementsAre(::testing::AllOf(
                  ::testing::HasSubstr(fmt::format("from row {} on, which is held out", rest + 1)),
                  ::testing::HasSubstr("--heldout"))));
  std::ranges::reverse(log.pressure_Pa);
  EXPECT_EQ(notices_of_rests({{"log.csv", log}}, 0.4).size(), 1U) << "nor far more";
}

TEST(LogCheck, AsksForUnitsAlsoWhereNothingMoves) {
  const Log hold = recorded({.seconds = 1.0}, [](double) { return 5.0; });
  EXPECT_NO_THROW(require_units({{"held.csv", hold}}, {}));
  EXPECT_THROW(require_units({{"held.csv", scaled_pressure(hold, 1e-3, 0.0)}}, {}), trace::InputError);
}

// ---- what must not

TEST(LogCheck, KnowsPressureInAnotherUnit) {
  const std::vector<std::pair<double, std::string>> units{
      {1e6, "MPa"}, {1e5, "bar"}, {6894.757, "psi"}, {1e3, "kPa"}, {100.0, "hPa"}};
  for (const Log& log : {excited(), recorded({.swing = 0.3}, fill_and_dump)}) {
    for (const auto& [unit_Pa, name] : units) {
      expect_refusal(2, scaled_pressure(log, 1.0 / unit_Pa, 0.0), {"pressure_Pa", "looks like " + name});
      if (name == "hPa") continue;  // 0 to 6000 could be Pa, too
      expect_refusal(2, scaled_pressure(log, 1.0 / unit_Pa, -101325.0 / unit_Pa),
                     {"pressure_Pa", "looks like gauge pressure in " + name});
    }
  }
}

TEST(LogCheck, KnowsGaugePressureAtRestAndMoving) {
  for (const double swing : {0.0, 0.2, 0.5}) {
    const Chamber chamber{.swing = swing};
    expect_refusal(2, scaled_pressure(excited(chamber), 1.0, -101325.0),
                   {"pressure_Pa", "looks like gauge pressure in Pa", "absolute"});
    expect_refusal(2, scaled_pressure(recorded(chamber, fill_and_dump), 1.0, -101325.0),
                   {"pressure_Pa", "looks like gauge pressure in Pa", "absolute"});
  }
}

TEST(LogCheck, CallsAVacuumNoGaugePressure) {
  const auto pumped_down = [](double rest_Pa, double deepest_Pa) {
    Log log = excited();
    for (std::size_t i = 0; i < log.size(); ++i) {
      log.pressure_Pa[i] = rest_Pa + (deepest_Pa - rest_Pa) * (1.0 - std::exp(-log.time_s[i] / 3.0));
    }
    return log;
  };
  for (const Log& log : {pumped_down(101e3, 36e3), pumped_down(63e3, 63e3)}) {
    expect_refusal(2, log, {"pressure_Pa", "a vacuum is not supported", "absolute"});
    EXPECT_THAT(answer(log), Not(HasSubstr("looks like gauge")));
  }
  expect_refusal(2, pumped_down(3e3, 60e3), {"looks like gauge pressure in Pa"});
  expect_refusal(2, pumped_down(300e3, 20e3), {"gauge pressure, or a vacuum, which is not supported"});
}

TEST(LogCheck, KnowsGaugePressureOfAVentilator) {
  RigDescription rig;
  rig.supply.pressure_Pa = 110e3;
  const Log log = trace::import_respiraworks(PLENUM_SOURCE_DIR "/tests/data/respiraworks/ctl_OXY_1.csv");
  expect_refusal(2, scaled_pressure(log, 1.0, -101325.0), {"gauge pressure in Pa"}, rig);
  expect_refusal(2, scaled_pressure(log, 1e-3, -101.325), {"looks like gauge pressure"}, rig);
}

TEST(LogCheck, RefusesPressureFarAboveTheSupplyAndASingleNegativeSample) {
  expect_refusal(2, scaled_pressure(excited(), 10.0, 0.0), {"far above the supply", "700000"});
  Log log = excited();
  log.pressure_Pa[41] = -5.0;
  expect_refusal(2, log, {"row 42", "pressure_Pa", "-5"});
}

TEST(LogCheck, KnowsVolumeInLitresAndMillilitres) {
  for (const double volume_m3 : {40e-6, 90e-6, 300e-6}) {
    for (const double swing : {0.0, 0.3}) {
      const Log log = excited({.volume_m3 = volume_m3, .swing = swing});
      expect_refusal(2, scaled_volume(log, 1e3), {"volume_m3", "looks like litres", "m3"});
      expect_refusal(2, scaled_volume(log, 1e6), {"volume_m3", "looks like millilitres", "m3"});
    }
  }
  RigDescription rig;
  rig.supply.pressure_Pa = 110e3;
  const Log log = trace::import_respiraworks(PLENUM_SOURCE_DIR "/tests/data/respiraworks/ctl_OXY_1.csv");
  expect_refusal(2, scaled_volume(log, 1e3), {"looks like litres"}, rig);
}

TEST(LogCheck, RefusesAVolumeThatIsNotPositiveOrTiny) {
  Log log = excited();
  log.volume_m3[7] = -1e-4;
  expect_refusal(2, log, {"row 8", "volume_m3", "-0.0001"});
  expect_refusal(2, scaled_volume(excited(), 1e-3), {"volume_m3", "1e-06 to 0.1"});
}

TEST(LogCheck, KnowsCommandsInPerCentNormalisedAndInMillivolts) {
  expect_refusal(2, scaled_command(excited(), 10.0, 0.0), {"command_V", "looks like per cent", "volts"});
  expect_refusal(2, scaled_command(excited(), 0.1, 0.0), {"command_V", "normalised", "5.08"});
  expect_refusal(2, scaled_command(excited(), 0.2, -1.0), {"command_V", "normalised"});
  expect_refusal(2, scaled_command(excited(), 1000.0, 0.0), {"command_V", "too large"});
}

TEST(LogCheck, TakesTheVoltsThatAValveOfTheRigsThresholdsIsGiven) {
  RigDescription rig;
  EXPECT_EQ(answer(scaled_command(excited(), 1.0, 5.0)), "") << "12 V";
  rig.valve = {.open_above_V = 12.1,
               .exhaust_below_V = 11.9,
               .inlet_area_per_V_m2 = 6e-7,
               .exhaust_area_per_V_m2 = 6e-7};
  const Log of_24_V = scaled_command(excited(), 2.4, 0.0);
  EXPECT_EQ(answer(of_24_V, rig), "");
  EXPECT_EQ(answer(scaled_command(excited(), 6.0, -18.0), rig), "") << "0 to 24 V";
  expect_refusal(2, scaled_command(excited(), 6.0, -18.0),
                 {"command_V", "or like a valve of more volts", "valve.open_above_V"});
  expect_refusal(2, scaled_command(excited(), 10.0, 0.0), {"looks like per cent, expected volts, up to 25.2"},
                 rig);
}

TEST(LogCheck, RefusesAnotherRateThanTheRigs) {
  Log log = excited();
  log.period_s = 0.02;
  expect_refusal(2, log, {"time_s", "50 Hz", "100"});
}

TEST(LogCheck, RefusesASupplyColumnFarFromTheRigs) {
  Log log = excited();
  log.supply_Pa.assign(log.size(), 650e3);
  EXPECT_EQ(answer(log), "");
  log.supply_Pa.assign(log.size(), 7.0);
  expect_refusal(2, log, {"supply_Pa", "700000"});
}

TEST(LogCheck, FindsTooLittleInAShortLog) {
  expect_refusal(3, excited({.seconds = 2.5}), {"too short", "250 rows", "2.5 s", "3 s"});
}

TEST(LogCheck, FindsTooLittleInACommandThatRestsOrOpensNoPort) {
  expect_refusal(3, recorded({}, [](double) { return 6.0; }), {"no excitation", "command_V", "6 V"});
  expect_refusal(3, recorded({}, [](double t) { return 6.0 + 0.005 * std::sin(t); }),
                 {"no excitation", "rests at 6 V"});
  expect_refusal(3, recorded({.swing = 0.2}, [](double t) { return 5.0 + 0.07 * std::sin(t); }),
                 {"no excitation", "opens no port", "5.08"});
}

TEST(LogCheck, FindsTooLittleInAPressureThatDoesNotMove) {
  Log log = excited();
  std::mt19937 random(3);
  for (const double noise_Pa : {0.0, 100.0, 600.0}) {
    for (double& p : log.pressure_Pa)
      p = 300e3 + std::normal_distribution<double>(0.0, 1.0)(random) * noise_Pa;
    expect_refusal(3, log, {"no excitation", "pressure_Pa", "noise"});
  }
  for (std::size_t i = 0; i < log.size(); ++i) log.pressure_Pa[i] = 300e3 + 200.0 * std::sin(log.time_s[i]);
  expect_refusal(3, log, {"no excitation", "pressure_Pa", "noise"});
}

TEST(LogCheck, FindsTooLittleInALogThatIsSaturatedNearlyAllTheTime) {
  const auto shut_off_late = [](double time_s) { return time_s < 19.9 ? 8.0 + 0.1 * std::sin(time_s) : 5.0; };
  const auto vented_late = [](double time_s) { return time_s < 0.3 ? 6.0 : 2.0; };
  expect_refusal(3, recorded({}, shut_off_late), {"saturated"});
  expect_refusal(3, recorded({}, vented_late), {"saturated"});
  expect_refusal(3, recorded({.supply_Pa = 560e3}, shut_off_late), {"saturated"});
}

TEST(LogCheck, FindsASensorThatClipsAtEitherEnd) {
  for (const double level_Pa : {350e3, 500e3}) {
    Log log = excited();
    for (double& p : log.pressure_Pa) p = std::min(p, level_Pa);
    expect_refusal(3, log, {"saturated", "cut off at"});
  }
  Log log = excited();
  for (double& p : log.pressure_Pa) p = std::max(p, 200e3);
  expect_refusal(3, log, {"saturated", "cut off at 200000"});
}

TEST(LogCheck, FindsASensorThatClipsJustBelowTheSupply) {
  Log log = recorded({.swing = 0.3}, [](double t) { return std::fmod(t, 1.0) < 0.4 ? 6.5 : 4.5; });
  for (double& p : log.pressure_Pa) p = std::min(p, 690e3);
  expect_refusal(3, log, {"saturated", "cut off at 690000"});
  for (double& p : log.pressure_Pa) p = 1e3 * std::round(1e-3 * p);
  EXPECT_EQ(answer(log), "") << "of so few digits a chamber at rest reads the same";
}

TEST(LogCheck, FindsASensorThatClipsBeforeItsNoise) {
  const auto cut_off = [](double least_Pa, double greatest_Pa) {
    std::mt19937 random(2);
    std::normal_distribution<double> noise(0.0, 50.0);
    Log log = excited();
    for (double& p : log.pressure_Pa) p = std::clamp(p, least_Pa, greatest_Pa) + noise(random);
    return log;
  };
  expect_refusal(3, cut_off(0.0, 350e3), {"saturated", "cut off at 350"});
  expect_refusal(3, cut_off(0.0, 500e3), {"saturated", "cut off at 500"});
  expect_refusal(3, cut_off(200e3, 1e6), {"saturated", "cut off at 199"});
}

TEST(LogCheck, TakesAChamberThatComesToRestAtASupplyBelowTheRigs) {
  const Command long_fills = [](double t) { return std::fmod(t, 4.0) < 3.0 ? 6.0 : 4.0; };
  Log log = recorded({.supply_Pa = 600e3}, long_fills);
  ASSERT_NEAR(*std::max_element(log.pressure_Pa.begin(), log.pressure_Pa.end()), 600e3, 1e3);
  EXPECT_EQ(answer(log), "");
}

}  // namespace
}  // namespace plenum::host::diagnose
