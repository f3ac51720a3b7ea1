// The diagnosis on recordings whose truth is written by the blind generator, which shares no code with the catalogue.
#include "host-sim/diagnose/diagnose.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <utility>

#include "host-sim/blind/blind_case.hpp"
#include "host-sim/diagnose/found_rig.hpp"
#include "host-sim/effects/catalogue.hpp"
#include "host-sim/identify/chamber/noise.hpp"
#include "host-sim/plant/chamber.hpp"
#include "host-sim/reproduce/actuators/population.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/respiraworks.hpp"
#include "tests/diagnose/late_valve.hpp"

namespace plenum::host::diagnose {
namespace {

/// The first case of these effects whose gap is above five times the noise after recalibration, as its label says.
blind::Case clear_case(const std::vector<std::string>& effects, int tier, std::uint64_t seed,
                       double size = 1.0) {
  for (;; ++seed) {
    blind::Case made = blind::make_case({.effects = effects,
                                         .kind = effects.empty() ? "none" : "one",
                                         .tier = tier,
                                         .seconds = 15.0,
                                         .seed = seed,
                                         .size = size});
    if (effects.empty() || made.label.at("recalibrated_gap_Pa").get<double>() >
                               5.0 * made.label.at("noise_floor_Pa").get<double>()) {
      return made;
    }
  }
}

GapReport diagnosed(const blind::Case& made, const std::vector<std::string>& strike = {}) {
  DiagnoseOptions options;
  options.strike = strike;
  return diagnose({{"log", made.log}}, {{"heldout", made.heldout}}, made.rig, options);
}

std::set<std::string> named(const GapReport& report) {
  std::set<std::string> ids;
  for (const auto& effect : report.effects) ids.insert(effect.id);
  return ids;
}

TEST(Diagnose, NamesTheEffectThatTheLabelHolds) {
  for (const char* effect : {"supply_droop", "volume_error"}) {
    const GapReport report = diagnosed(clear_case({effect}, 1, 11));
    ASSERT_FALSE(report.effects.empty()) << effect << ": " << name_of(report.verdict);
    EXPECT_EQ(report.effects.front().id, effect);
    EXPECT_GT(report.effects.front().confidence, 0.8) << effect;
    EXPECT_GT(report.closed_fraction, 0.5) << effect;
    EXPECT_LT(report.with_effects_Pa, report.recalibrated_Pa) << effect;
  }
}

TEST(Diagnose, NamesTheEffectOfAMachineThatIsMuchSmaller) {
  // a silencer of some thousand kPa s/g, a hose of less than a millimetre, a vessel of a few cubic centimetres
  for (const char* effect : {"exhaust_backpressure", "tube_dynamics", "supply_droop"}) {
    const GapReport report = diagnosed(clear_case({effect}, 1, 11, 0.03));
    ASSERT_FALSE(report.effects.empty()) << effect << ": " << name_of(report.verdict);
    EXPECT_EQ(report.effects.front().id, effect);
    EXPECT_GT(report.closed_fraction, 0.8) << effect;
  }
}

TEST(Diagnose, TellsWhatWouldHaveShownBesideTheEffectFound) {
  const blind::Case made = clear_case({"supply_droop"}, 1, 11);
  const GapReport found = diagnosed(made);
  ASSERT_EQ(named(found), std::set<std::string>{"supply_droop"});
  // the same of a rig that knows of it, where nothing is left to find
  const GapReport known = diagnose({{"log", made.log}}, {{"heldout", made.heldout}}, found.found, {});
  ASSERT_EQ(known.verdict, Verdict::none);
  for (const Detectable& one : found.detectable) {
    if (std::isnan(one.smallest)) continue;
    const auto same = std::find_if(known.detectable.begin(), known.detectable.end(),
                                   [&](const Detectable& other) { return other.id == one.id; });
    ASSERT_NE(same, known.detectable.end()) << one.id;
    EXPECT_GT(one.smallest, 0.5 * same->smallest) << one.id;
    EXPECT_LT(one.smallest, 2.0 * same->smallest) << one.id;
  }
}

TEST(Diagnose, FollowsANullThatWandersIntoTheRowsThatItHoldsOut) {
  // the last two fifths of the log are held out: what the null did before says nothing of them
  const blind::Case made = blind::make_case({.effects = {"null_drift"},
                                             .kind = "one",
                                             .tier = 1,
                                             .seconds = 30.0,
                                             .seed = 10517097185913350119ULL});
  ASSERT_EQ(made.label.at("effects")[0].at("variant").get<std::string>(), "wander");
  const GapReport report = diagnose({{"log", made.log}}, {}, made.rig, {});
  ASSERT_EQ(report.effects.size(), 1U) << name_of(report.verdict);
  EXPECT_EQ(report.effects.front().id, "null_drift");
  EXPECT_GT(report.closed_fraction, 0.99);
}

TEST(Diagnose, FollowsANullThatWandersToTheEndOfALogOfMoreThanAMinute) {
  const blind::Case made = blind::make_case(
      {.effects = {"null_drift"}, .kind = "one", .tier = 1, .seconds = 90.0, .seed = 883683725814141656ULL});
  ASSERT_EQ(made.label.at("effects")[0].at("variant").get<std::string>(), "wander");
  const GapReport report = diagnose({{"log", made.log}}, {}, made.rig, {});
  ASSERT_EQ(report.effects.size(), 1U) << name_of(report.verdict);
  EXPECT_EQ(report.effects.front().id, "null_drift");
  EXPECT_GT(report.closed_fraction, 0.98);
  EXPECT_EQ(report.effects.front().parameters.back().name, "knot_s");
  EXPECT_NEAR(report.effects.front().parameters.back().value, 4.5, 0.01);
}

// No effect alone lowers the error, nor does the null, however it is followed: each hides the others.
TEST(Diagnose, FollowsANullThatWandersBesideTwoOthers) {
  const std::vector<std::string> effects{"null_drift", "sensor_bias", "sensor_lag"};
  const blind::Case made = blind::make_case(
      {.effects = effects, .kind = "many", .tier = 1, .seconds = 20.0, .seed = 9046427639451192554ULL});
  ASSERT_EQ(made.label.at("effects")[0].at("variant").get<std::string>(), "wander");
  const GapReport report = diagnosed(made);
  EXPECT_EQ(named(report), std::set<std::string>(effects.begin(), effects.end())) << name_of(report.verdict);
  EXPECT_GT(report.closed_fraction, 0.9);
  for (const NamedEffect& effect : report.effects) EXPECT_GT(effect.confidence, 0.8) << effect.id;
}

TEST(Diagnose, ClosesAGapOfHeatToTheNoiseThoughTheGasBeginsWarm) {
  const blind::Case made =
      clear_case({"heat_transfer"}, 1, 11);  // it was filled or vented before its first row
  const GapReport report = diagnosed(made);
  ASSERT_EQ(report.effects.size(), 1U) << name_of(report.verdict);
  EXPECT_EQ(report.effects.front().id, "heat_transfer");
  EXPECT_LT(report.with_effects_Pa, 1.12 * made.label.at("noise_floor_Pa").get<double>());
}

TEST(Diagnose, FindsASilencerThatShowsNothingUntilThePortBeforeItNoLongerChokes) {
  // the chamber stays above twice ambient: any wider silencer than the first one's changes no reading, and no fit leaves that plain;
  // before the second one's a wider one changes as little as fits that end early differ by
  for (const std::uint64_t seed : {4890565767844745853ULL, 8530831717539896880ULL}) {
    const blind::Case made =
        blind::make_case({.effects = {"exhaust_backpressure"}, .kind = "one", .tier = 3, .seed = seed});
    const GapReport report = diagnosed(made);
    ASSERT_EQ(report.effects.size(), 1U) << seed << ": " << name_of(report.verdict);
    EXPECT_EQ(report.effects.front().id, "exhaust_backpressure") << seed;
    EXPECT_LT(report.with_effects_Pa, 1.12 * made.label.at("noise_floor_Pa").get<double>()) << seed;
  }
}

constexpr double kStep_s = 0.001, kTick_s = 0.01, kNoise_Pa = 200.0;

/// Of what within each millisecond a tick's mean is taken.
enum class Averaged { all, ends };

/// A log of the plant with steps of mixed size; in place of the command its valve is given `at_spool(command, time)`, in the mean
/// over each millisecond; `at_row(chamber, log)` comes ahead of each tick.
template <class AtSpool, class AtRow>
trace::Log stepped_log(unsigned seed, std::size_t rows, AtSpool at_spool, AtRow at_row,
                       int longest_hold_ticks = 40, Averaged averaged = Averaged::all) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> level_V(3.5, 6.5);
  std::uniform_int_distribution<int> hold_ticks(3, longest_hold_ticks);
  std::normal_distribution<double> noise_Pa(0.0, kNoise_Pa);
  plant::ChamberConfig config;
  config.initial_pressure_Pa = 200e3;
  config.initial_command_V = 5.0;
  plant::ChamberPlant chamber(plant::ThinPlateValve({}), config,
                              plant::VolumeMotion(150e-6, {plant::VolumeSine{40e-6, 0.7, 0.3}}));
  trace::Log log;
  log.period_s = log.pressure_average_s = kTick_s;
  double u_V = 5.0, mean_Pa = config.initial_pressure_Pa;
  for (std::size_t row = 0, until = 0; row < rows; ++row) {
    if (row == until) {
      u_V = level_V(random);
      until += static_cast<std::size_t>(hold_ticks(random));
    }
    log.time_s.push_back(kTick_s * static_cast<double>(row));
    log.command_V.push_back(u_V);
    log.pressure_Pa.push_back(mean_Pa + noise_Pa(random));
    log.volume_m3.push_back(chamber.volume_m3());
    at_row(chamber, log);
    mean_Pa = 0.0;
    for (int step = 0; step < 10; ++step) {
      const double all_Pa =
          chamber.advance(at_spool(u_V, log.time_s.back() + step * kStep_s), kStep_s).mean_Pa;
      mean_Pa += 0.1 * (averaged == Averaged::all ? all_Pa : chamber.pressure_Pa());
    }
  }
  return log;
}

template <class AtSpool>
trace::Log stepped_log(unsigned seed, std::size_t rows, AtSpool at_spool) {
  return stepped_log(seed, rows, at_spool, [](const plant::ChamberPlant&, const trace::Log&) {});
}
double as_commanded(double u_V, double) {
  return u_V;
}

// A simulation that averages what it has after each of ten steps, say, or clocks that are half a millisecond apart.
TEST(Diagnose, CountsAStampThatIsEarlyByAPartOfATickAsCalibration) {
  const auto nothing = [](const plant::ChamberPlant&, const trace::Log&) {};
  const auto diagnosed_with = [&](Averaged averaged) {
    const trace::Log log = stepped_log(3, 3000, as_commanded, nothing, 40, averaged);
    return diagnose({{"log", log}}, {}, {}, {});
  };
  const GapReport early = diagnosed_with(Averaged::ends);
  EXPECT_EQ(early.verdict, Verdict::calibration) << name_of(early.verdict);
  EXPECT_TRUE(early.effects.empty());
  EXPECT_LT(early.recalibrated_Pa, 1.1 * kNoise_Pa);
  EXPECT_NEAR(early.stamped_early_s, 0.5 * kStep_s, 0.05 * kStep_s);
  EXPECT_EQ(diagnosed_with(Averaged::all).stamped_early_s, 0.0);
}

trace::Log in_gauge(trace::Log log) {
  for (double& p : log.pressure_Pa) p -= 101325.0;
  return log;
}

template <class Diagnosed>
std::string refusal_of(Diagnosed&& diagnosed) {
  try {
    diagnosed();
  } catch (const trace::InputError& error) {
    return error.what();
  }
  return "accepted";
}

// Its offset would be what has changed: sensor_bias, with confidence.
TEST(Diagnose, RefusesGaugePressureAfterABaselineInAbsolute) {
  DiagnoseOptions options;
  options.baseline = {{"before", stepped_log(5, 2000, as_commanded)}};
  const trace::Log after = stepped_log(6, 2000, as_commanded);
  const std::string told = refusal_of([&] { diagnose({{"after", in_gauge(after)}}, {}, {}, options); });
  EXPECT_EQ(told.substr(0, 52), "after: column pressure_Pa seems to be gauge pressure") << told;
}

TEST(Diagnose, RefusesAHeldOutLogThatIsNotAsTheFittedOnesAre) {
  const trace::Log log = stepped_log(5, 2000, as_commanded);
  const trace::Log held = stepped_log(6, 1000, as_commanded);
  trace::Log turned = held;
  for (double& u : turned.command_V) u = 10.0 - u;
  const auto told = [&](const trace::Log& other) {
    return refusal_of([&] { diagnose({{"log", log}}, {{"held", other}}, {}, {}); });
  };
  EXPECT_EQ(told(in_gauge(held)).substr(0, 51), "held: column pressure_Pa seems to be gauge pressure");
  EXPECT_EQ(told(turned).substr(0, 47), "held: column command_V seems to have the other ");
  EXPECT_EQ(told(held), "accepted");
  const auto null_moved = [](double u_V, double) { return u_V - 0.3; };
  EXPECT_EQ(told(stepped_log(6, 1000, null_moved)), "accepted") << "a machine that errs by its own";
}

// Both shift what the valve does, but only the stamp what the volume compresses.
TEST(Diagnose, NamesALateValveAloneThoughThePressuresAreStampedEarly) {
  const auto nothing = [](const plant::ChamberPlant&, const trace::Log&) {};
  const trace::Log log = stepped_log(
      4, 3000, [valve = LateValve(0.006)](double u_V, double) mutable { return valve(u_V); }, nothing, 40,
      Averaged::ends);
  const GapReport report = diagnose({{"log", log}}, {}, {}, {});
  EXPECT_EQ(named(report), std::set<std::string>{"dead_time"}) << name_of(report.verdict);
  ASSERT_FALSE(report.effects.empty());
  EXPECT_NEAR(report.effects.front().parameters.front().value, 0.006, 1e-4) << "s";
  EXPECT_NEAR(report.stamped_early_s, 0.5 * kStep_s, 0.1 * kStep_s);
  EXPECT_LT(report.with_effects_Pa, 1.1 * kNoise_Pa);
}

/// Whether one of the named effects lives in the equation that is blamed.
bool blames_what_is_named(const GapReport& report) {
  for (const NamedEffect& effect : report.effects) {
    const auto equation = effects::kCatalogue[*effects::find(effect.id)]->equation;
    if (report.equation && report.equation->equation == effects::name_of(equation)) return true;
  }
  return false;
}

TEST(Diagnose, BlamesAnEquationInWhichOneOfTheNamedLives) {
  // a late valve before a chamber that is larger than logged: alone, a hose looks most like both
  constexpr double kMore_m3 = 32e-6;
  trace::Log log =
      stepped_log(7, 3000, [valve = LateValve(0.029)](double u_V, double) mutable { return valve(u_V); });
  for (double& volume_m3 : log.volume_m3) volume_m3 -= kMore_m3;
  const GapReport report = diagnose({{"log", log}}, {}, {});
  EXPECT_EQ(named(report), (std::set<std::string>{"dead_time", "volume_error"}));
  EXPECT_TRUE(blames_what_is_named(report)) << report.equation->equation;
}

TEST(Diagnose, LetsNoWanderingNullTakeThePlaceOfAFormThatTheCatalogueLacks) {
  // ports that open as a notch does, with the square of the command up to 0.64 V, behind a late valve: of long holds twenty figures
  // follow each for itself
  constexpr double kNotch_V = 0.64;
  const auto notched = [valve = LateValve(0.012)](double u_V, double) mutable {
    const double late_V = valve(u_V);
    const double off_V = std::abs(late_V - 5.0);
    const double opened_V = off_V < kNotch_V ? 0.5 * off_V * off_V / kNotch_V : off_V - 0.5 * kNotch_V;
    return 5.0 + std::copysign(opened_V, late_V - 5.0);
  };
  const trace::Log log = stepped_log(
      2, 2600, notched, [](const plant::ChamberPlant&, const trace::Log&) {}, 250);
  const std::set<std::string> names = named(diagnose({{"log", log}}, {}, {}));
  EXPECT_FALSE(names.contains("null_drift"));
  EXPECT_TRUE(names.contains("dead_time"));
}

TEST(Diagnose, RefinesAnEffectBesideAnotherWhereItDidNotPayAlone) {
  // a loop whose corners matter only once the sensor's span is right, and whose form the catalogue has but nearly
  const blind::Case made = blind::make_case({.effects = {"sensor_bias", "valve_hysteresis"},
                                             .kind = "many",
                                             .tier = 1,
                                             .seed = 7244854910583403446});
  const GapReport report = diagnosed(made);
  EXPECT_EQ(named(report), (std::set<std::string>{"sensor_bias", "valve_hysteresis"}));
  EXPECT_GT(report.closed_fraction, 0.98);
}

TEST(Diagnose, PutsTheSimplerOfTwoEffectsInTheOthersPlaceWhileTheRestStands) {
  // a hose is found first, beside which heat comes right; without it, heat goes where no dead volume brings it back
  const blind::Case made = blind::make_case({.effects = {"chamber_leak", "volume_error", "heat_transfer"},
                                             .kind = "many",
                                             .tier = 1,
                                             .seed = 6707689927098443238});
  const GapReport report = diagnosed(made);
  EXPECT_EQ(named(report), (std::set<std::string>{"volume_error", "heat_transfer"}));
  EXPECT_LT(report.with_effects_Pa, 1.12 * made.label.at("noise_floor_Pa").get<double>());
}

TEST(Diagnose, TakesNoHoseWhoseAirStandsAllAlongItForADeadVolumeBesideOne) {
  // 2.7 m in twelve cells, behind a slow spool
  const blind::Case made = blind::make_case({.effects = {"tube_dynamics", "spool_lag"},
                                             .kind = "many",
                                             .tier = 1,
                                             .seconds = 20.0,
                                             .seed = 9654676697693921566ULL});
  const GapReport report = diagnosed(made);
  std::set<std::string> named;
  for (const NamedEffect& effect : report.effects) named.insert(effect.id);
  EXPECT_EQ(named, (std::set<std::string>{"tube_dynamics", "spool_lag"}));
}

TEST(Diagnose, NamesNoCauseWhereThereIsNone) {
  const GapReport report = diagnosed(clear_case({}, 1, 21));
  EXPECT_EQ(report.verdict, Verdict::calibration);
  EXPECT_TRUE(report.effects.empty());
  EXPECT_FALSE(report.equation.has_value());
}

TEST(Diagnose, TakesNoPressureThatNeverRestsForNoise) {
  // a new command each tick; 1 mL that the log does not tell of moves the pressure by less than the pressure's own third
  // differences come to
  std::mt19937_64 random(7);
  plant::ChamberConfig config;
  config.initial_pressure_Pa = 200e3;
  plant::ChamberPlant chamber(plant::ThinPlateValve({}), config,
                              plant::VolumeMotion(150e-6, {plant::VolumeSine{50e-6, 1.1, 0.3}}));
  trace::Log log = reproduce::actuators::record_under_pid(random, chamber, 2.0, 8.0, 3000);
  for (double& volume_m3 : log.volume_m3) volume_m3 -= 1e-6;
  const GapReport report = diagnose({{"log", log}}, {}, {});
  const double noise_Pa =
      1e-3 * (700e3 - 101325.0) / std::sqrt(200.0);  // of a tick's mean, as the log was made
  ASSERT_GT(identify::chamber::white_noise(log.pressure_Pa), 5.0 * noise_Pa);
  EXPECT_NEAR(report.noise_floor_Pa, noise_Pa, 0.15 * noise_Pa);
  EXPECT_EQ(report.verdict, Verdict::explained);
  ASSERT_EQ(report.effects.size(), 1U);
  EXPECT_EQ(report.effects.front().id, "volume_error");
  EXPECT_NEAR(report.effects.front().parameters.front().value, 1.0, 0.05);
}

TEST(Diagnose, ClosesTheGapOfAValveThatFollowsByASingleLag) {
  // no mass on a spring, as the catalogue has it: x' = (u - x)/tau
  constexpr double kLag_s = 0.02;
  const trace::Log log = stepped_log(3, 2500, [x_V = 5.0](double u_V, double) mutable {
    const double begin_V = std::exchange(x_V, u_V + (x_V - u_V) * std::exp(-kStep_s / kLag_s));
    return u_V - (x_V - begin_V) * kLag_s / kStep_s;
  });
  const GapReport report = diagnose({{"log", log}}, {}, {});
  EXPECT_EQ(report.verdict, Verdict::explained);
  EXPECT_EQ(named(report), std::set<std::string>{"spool_lag"});
  EXPECT_LT(report.with_effects_Pa, 1.12 * kNoise_Pa);
}

TEST(Diagnose, NamesTheValveThatASpringReturnsMoreSlowlyThanItsMagnetPulls) {
  const trace::Log log = stepped_log(5, 2500, [x_V = 5.0](double u_V, double) mutable {
    const double lag_s = std::abs(u_V - 5.0) < std::abs(x_V - 5.0) ? 0.016 : 0.009;
    const double begin_V = std::exchange(x_V, u_V + (x_V - u_V) * std::exp(-kStep_s / lag_s));
    return u_V - (x_V - begin_V) * lag_s / kStep_s;
  });
  const GapReport report = diagnose({{"log", log}}, {}, {});
  EXPECT_EQ(report.verdict, Verdict::explained);
  EXPECT_EQ(named(report), std::set<std::string>{"spool_lag"});
}

TEST(Diagnose, KnowsASupplyThatOthersDrawFromWhereTheLogTellsOfIt) {
  const auto drawn = [](unsigned seed, bool told) {
    std::mt19937_64 others(seed);
    std::uniform_real_distribution<double> droop_Pa(0.0, 60e3);
    double aim_Pa = 700e3, supply_Pa = 700e3;
    return stepped_log(seed, 2500, as_commanded, [&](plant::ChamberPlant& chamber, trace::Log& log) {
      if (log.size() % 70 == 1) aim_Pa = 700e3 - droop_Pa(others);
      if (told) log.supply_Pa.push_back(supply_Pa);
      supply_Pa += 0.1 * (aim_Pa - supply_Pa);  // others draw, whatever this valve does
      chamber.set_supply_Pa(supply_Pa);
    });
  };
  const GapReport told = diagnose({{"log", drawn(1, true)}}, {{"heldout", drawn(2, true)}}, {}, {});
  EXPECT_EQ(named(told), std::set<std::string>{"supply_droop"}) << name_of(told.verdict);
  EXPECT_GT(told.closed_fraction, 0.95);
  const auto followed = std::find_if(told.effects[0].parameters.begin(), told.effects[0].parameters.end(),
                                     [](const Estimate& of) { return of.name == "followed_share"; });
  ASSERT_NE(followed, told.effects[0].parameters.end());
  EXPECT_NEAR(followed->value, 1.0, 0.05);
  const GapReport untold = diagnose({{"log", drawn(1, false)}}, {{"heldout", drawn(2, false)}}, {}, {});
  EXPECT_NE(untold.verdict, Verdict::explained);
}

TEST(Diagnose, NamesASensorThatWarmsUpOrSharesTheValvesGround) {
  struct Shift {
    double drift_Pa, ground_Pa_V, even_Pa_V;
  };
  const auto read = [](unsigned seed, const Shift& by) {
    trace::Log log = stepped_log(seed, 2500, as_commanded);
    for (std::size_t row = 1; row < log.size(); ++row) {
      const double off_V = log.command_V[row - 1] - 5.0;
      log.pressure_Pa[row] += by.drift_Pa * (1.0 - std::exp(-log.time_s[row] / 8.0)) +
                              by.ground_Pa_V * off_V + by.even_Pa_V * std::abs(off_V);
    }
    return log;
  };
  for (const Shift& by : {Shift{12e3, 0.0, 0.0}, Shift{0.0, 5e3, 0.0}, Shift{0.0, 0.0, 5e3}}) {
    const GapReport report = diagnose({{"log", read(1, by)}}, {{"heldout", read(2, by)}}, {}, {});
    EXPECT_EQ(report.verdict, Verdict::explained);
    EXPECT_EQ(named(report), std::set<std::string>{"sensor_bias"})
        << by.drift_Pa << " Pa, " << by.ground_Pa_V << " and " << by.even_Pa_V << " Pa/V";
  }
}

TEST(Diagnose, FollowsANullThatWandersAnotherWayInEachLog) {
  const auto wandering = [](unsigned seed, double phase_rad) {
    return stepped_log(seed, 1500, [=](double u_V, double time_s) {
      return u_V - 0.2 * std::sin(0.4 * time_s + phase_rad);
    });
  };
  const GapReport report = diagnose({{"first", wandering(1, 0.0)}, {"second", wandering(2, 2.0)}},
                                    {{"heldout", wandering(3, 4.0)}}, {});
  EXPECT_EQ(named(report), std::set<std::string>{"null_drift"}) << name_of(report.verdict);
  EXPECT_GT(report.closed_fraction, 0.98);
}

TEST(Diagnose, AnEffectStruckFromTheCatalogueIsNeitherNamedNorExplainedAway) {
  const GapReport report = diagnosed(clear_case({"sensor_bias"}, 1, 31), {"sensor_bias"});
  EXPECT_NE(report.verdict, Verdict::explained);
  EXPECT_NE(report.verdict, Verdict::calibration);
  for (const NamedEffect& effect : report.effects) EXPECT_NE(effect.id, "sensor_bias");
}

TEST(Diagnose, TheSharesOfTheRegimesSumToOne) {
  const GapReport report = diagnosed(clear_case({"dead_time"}, 1, 41));
  ASSERT_FALSE(report.where.empty());
  double sum = 0.0;
  for (const RegimeShare& one : report.where) sum += one.share;
  EXPECT_NEAR(sum, 1.0, 0.02);
}

/// One half of a measured run of the ventilator, far outside what the nominal model holds.
trace::Log half_of_a_measured_run(bool second) {
  trace::Log log =
      trace::import_respiraworks(std::string(PLENUM_SOURCE_DIR) + "/tests/data/respiraworks/ctl_OXY_1.csv");
  const auto cut = [&](std::vector<double>& column) {
    const auto middle = column.begin() + static_cast<std::ptrdiff_t>(column.size() / 2);
    column = second ? std::vector<double>(middle, column.end()) : std::vector<double>(column.begin(), middle);
  };
  for (std::vector<double>* column : {&log.command_V, &log.pressure_Pa, &log.volume_m3}) cut(*column);
  log.time_s.resize(log.command_V.size());
  return log;
}

trace::RigDescription ventilator() {
  trace::RigDescription rig;
  rig.supply.pressure_Pa = 110e3;
  return rig;
}

TEST(Diagnose, SaysOfAMeasuredMachineThatNothingHasChanged) {
  DiagnoseOptions options;
  options.baseline = {{"before", half_of_a_measured_run(false)}};
  const GapReport report = diagnose({{"after", half_of_a_measured_run(true)}}, {}, ventilator(), options);
  EXPECT_EQ(report.verdict, Verdict::none);
  ASSERT_TRUE(report.baseline.has_value());
  EXPECT_NE(report.baseline->verdict, Verdict::none) << "the machine is not the nominal model";
  EXPECT_GE(report.noise_floor_Pa, report.baseline->with_effects_Pa);
}

TEST(Diagnose, NamesTheSensorErrorThatWasPutIntoAMeasuredRun) {
  constexpr double kOffset_Pa = 500.0;
  trace::Log changed = half_of_a_measured_run(true);
  for (double& p : changed.pressure_Pa) p += kOffset_Pa;
  DiagnoseOptions options;
  options.baseline = {{"before", half_of_a_measured_run(false)}};
  const GapReport report = diagnose({{"after", changed}}, {}, ventilator(), options);
  ASSERT_FALSE(report.effects.empty()) << name_of(report.verdict);
  EXPECT_EQ(report.effects.front().id, "sensor_bias");
  // an effect that the baseline has is named with its new figures, not with what they have changed by
  double offset_before_kPa = 0.0;
  for (const NamedEffect& effect : effects_in_model(diagnose(options.baseline, {}, ventilator()))) {
    if (effect.id == "sensor_bias") offset_before_kPa = effect.parameters.front().value;
  }
  EXPECT_EQ(report.effects.front().parameters.front().name, "offset_kPa");
  EXPECT_NEAR(report.effects.front().parameters.front().value - offset_before_kPa, 1e-3 * kOffset_Pa,
              0.1e-3 * kOffset_Pa);
}

/// Rows `from` to `to` - 1.
trace::Log part_of(trace::Log log, std::ptrdiff_t from, std::ptrdiff_t to) {
  for (std::vector<double>* column : {&log.time_s, &log.command_V, &log.pressure_Pa, &log.volume_m3}) {
    *column = {column->begin() + from, column->begin() + to};
  }
  return log;
}

// What 3.6 s leave unknown of the valve was made up for by a null that drifts, with 0.99.
TEST(Diagnose, NamesNothingOnAFewSecondsOfAMachineWithoutAnyEffect) {
  const blind::Case made = blind::make_case(
      {.effects = {}, .kind = "none", .tier = 1, .seconds = 40.0, .seed = 5170192192923322024});
  const trace::Log log = part_of(made.log, 679, 1279);
  const GapReport report = diagnose({{"log", log}}, {}, made.rig);
  EXPECT_EQ(report.verdict, Verdict::calibration);
  EXPECT_TRUE(report.effects.empty());
  EXPECT_EQ(report.traces.at(0).time_s.front(), log.time_s.front()) << "told where it was";
}

TEST(Diagnose, SaysThatTheValveItselfHasChangedSinceTheBaseline) {
  constexpr double kShift_V = 0.2;
  const blind::Case made = clear_case({}, 1, 21);
  trace::Log changed = made.heldout;
  for (double& u : changed.command_V) u += kShift_V;  // as if the null had moved by so much
  DiagnoseOptions options;
  options.baseline = {{"before", made.log}};
  const GapReport report = diagnose({{"after", changed}}, {}, made.rig, options);
  EXPECT_EQ(report.verdict, Verdict::calibration);
  EXPECT_TRUE(report.effects.empty());
  for (const std::size_t threshold : {effects::kOpenAbove, effects::kExhaustBelow}) {
    const CalibratedFigure& figure = report.calibration[threshold];
    EXPECT_NEAR(figure.fitted.value - figure.configured, kShift_V, 0.01) << figure.name;
  }
}

TEST(Diagnose, RefusesMoreLogsThanItsFitsHaveRoomFor) {
  const blind::Case made =
      blind::make_case({.effects = {}, .kind = "none", .tier = 1, .seconds = 10.0, .seed = 1});
  const std::vector<NamedLog> many(17, NamedLog{"log", made.log});
  const auto refusal = [&](const std::vector<NamedLog>& logs, const std::vector<NamedLog>& heldout) {
    try {
      diagnose(logs, heldout, made.rig);
      return std::string();
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
  };
  EXPECT_NE(refusal(many, {}).find("17 logs, expected at most 16"), std::string::npos);
  EXPECT_NE(refusal({many[0]}, many).find("17 held-out logs"), std::string::npos);
  DiagnoseOptions options;
  options.baseline.assign(16, many[0]);
  EXPECT_THROW(diagnose({many[0]}, {}, made.rig, options), std::invalid_argument);
}

TEST(Diagnose, RefusesToStrikeWhatTheCatalogueDoesNotHold) {
  const blind::Case made =
      blind::make_case({.effects = {}, .kind = "none", .tier = 1, .seconds = 10.0, .seed = 1});
  try {
    diagnosed(made, {"friction"});
    FAIL() << "an unknown effect was struck";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("friction"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("spool_lag"), std::string::npos);
  }
}

}  // namespace
}  // namespace plenum::host::diagnose
