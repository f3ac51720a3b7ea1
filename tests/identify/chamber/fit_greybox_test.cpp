// The identified model against chambers of the plant, which shares no code with it.
#include "host-sim/identify/chamber/fit_greybox.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/reproduce/actuators/population.hpp"

namespace plenum::host::identify::chamber {
namespace {

using reproduce::actuators::chamber_of_seed;
using reproduce::actuators::Motion;
using reproduce::actuators::population_rig;
using reproduce::actuators::record_chamber;
using reproduce::actuators::record_under_pid;

constexpr std::size_t kRows = 2000;

/// Channel A of the measured valve on 700 mL that double at 0.9 Hz.
trace::Log measured_valve() {
  std::mt19937_64 random(3);
  plant::ChamberConfig config;
  config.gas = plant::reference_atmosphere();
  config.initial_pressure_Pa = 200e3;
  plant::ChamberPlant chamber(plant::MpyeValve(plant::MpyeChannel::a, config.gas), config,
                              plant::VolumeMotion(700e-6, {plant::VolumeSine{230e-6, 0.9, 0.0}}));
  return record_under_pid(random, chamber, 0.0, 10.0, kRows);
}

const FigureFit& figure_of(const GreyboxFit& fit, const std::string& name) {
  const auto at = std::find_if(fit.parameters.begin(), fit.parameters.end(),
                               [&](const FigureFit& one) { return one.name == name; });
  EXPECT_NE(at, fit.parameters.end()) << name;
  return *at;
}

TEST(FitGreybox, OfAThinPlateIsTheValveItselfToItsStandardErrorsAndTakesNoEffect) {
  const plant::ThinPlateValveConfig truth = chamber_of_seed(4, Motion::violent).valve;
  const GreyboxFit fit = fit_greybox({record_chamber(4, Motion::violent, kRows)}, population_rig());
  EXPECT_THAT(fit.kept, testing::IsEmpty());
  EXPECT_TRUE(fit.converged) << fit.stop;
  const auto expect_found = [&](const char* name, double value) {
    const FigureFit& found = figure_of(fit, name);
    EXPECT_NEAR(found.value, value, 5.0 * found.standard_error) << name;
    EXPECT_NEAR(found.value, value, 0.01 * value) << name;
  };
  expect_found("open_above_V", truth.open_above_V);
  expect_found("exhaust_below_V", truth.exhaust_below_V);
  expect_found("inlet_area_per_V_m2", truth.inlet_area_per_V_m2);
  expect_found("exhaust_area_per_V_m2", truth.exhaust_area_per_V_m2);
  const double noise_kPa = 1e-6 * (620e3 - 101325.0) / std::sqrt(200.0);
  EXPECT_NEAR(fit.rms_free_run_kPa, noise_kPa, 0.1 * noise_kPa);
  EXPECT_NEAR(fit.noise_kPa, noise_kPa, 0.15 * noise_kPa);
  EXPECT_LT(fit.rms_next_tick_kPa, 2.0 * noise_kPa);
}

TEST(FitGreybox, TellsWhichFiguresAreKnown) {
  trace::Log log = record_chamber(4, Motion::violent, kRows);
  for (const FigureFit& figure : fit_greybox({log}, population_rig()).parameters) {
    EXPECT_EQ(figure.identifiable, figure.at_bound == Bound::none) << figure.name;
  }
  std::mt19937_64 random(1);
  std::normal_distribution<double> noise_Pa(0.0, 1e5);
  for (double& p : log.pressure_Pa) p += noise_Pa(random);
  const GreyboxFit noisy = fit_greybox({log}, population_rig());
  EXPECT_TRUE(figure_of(noisy, "inlet_area_per_V_m2").identifiable);
  EXPECT_FALSE(figure_of(noisy, "open_above_V").identifiable);
  EXPECT_FALSE(figure_of(noisy, "transition_m2").identifiable);
  const trace::ModelFile file = to_model_file(noisy, 3);
  EXPECT_EQ(file.fit["parameters"]["open_above_V"]["identifiable"], false);
}

TEST(FitGreybox, IsTheSameFromAValveWhoseNullGainsAndDeadBandAreFarOff) {
  const trace::Log log = record_chamber(4, Motion::violent, kRows);
  trace::RigDescription far = population_rig();
  far.valve.open_above_V = 6.2;
  far.valve.exhaust_below_V = 5.2;
  far.valve.inlet_area_per_V_m2 *= 3.0;
  far.valve.exhaust_area_per_V_m2 /= 3.0;
  const GreyboxFit near = fit_greybox({log}, population_rig());
  const GreyboxFit from_far = fit_greybox({log}, far);
  EXPECT_NEAR(from_far.rig.valve.open_above_V, near.rig.valve.open_above_V, 1e-4);
  EXPECT_NEAR(from_far.rig.valve.inlet_area_per_V_m2 / near.rig.valve.inlet_area_per_V_m2, 1.0, 1e-4);
  EXPECT_NEAR(from_far.rms_free_run_kPa, near.rms_free_run_kPa, 1e-5);
}

TEST(FitGreybox, OfTheMeasuredValveTakesTheShapeOfItsAreasAndLowersTheHeldOutErrorFourfold) {
  std::vector<double> told;
  const GreyboxFit fit = fit_greybox({measured_valve()}, {}, [&](double done) { told.push_back(done); });
  EXPECT_EQ(told.size(), fit.tried.size());
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_THAT(told, testing::Each(testing::AllOf(testing::Gt(0.0), testing::Lt(1.0))));
  EXPECT_THAT(fit.kept, testing::Contains("area_shape"));
  EXPECT_THAT(fit.tried.front().effects, testing::IsEmpty());
  EXPECT_LT(fit.rms_heldout_kPa, 0.25 * fit.tried.front().heldout_kPa);
  EXPECT_LT(fit.rms_free_run_kPa, 6.0) << "1 % of the span";
  // the tables: supply opens at 5.8 V, exhaust at 4.4 V
  EXPECT_NEAR(fit.rig.valve.open_above_V, 5.8, 0.1);
  EXPECT_NEAR(fit.rig.valve.exhaust_below_V, 4.45, 0.1);
}

TEST(FitGreybox, KeepsTheRigsOwnEffectsAsConfigured) {
  trace::RigDescription rig = population_rig();
  rig.effects["sensor_bias"]["offset_kPa"] = 4.0;
  const trace::Log log = record_chamber(4, Motion::violent, kRows);
  trace::Log biased = log;
  for (double& p : biased.pressure_Pa) p += 4000.0;
  const GreyboxFit plain = fit_greybox({log}, population_rig());
  const GreyboxFit with = fit_greybox({biased}, rig);
  EXPECT_EQ(with.rig.effects, rig.effects);
  EXPECT_NEAR(with.rig.valve.inlet_area_per_V_m2 / plain.rig.valve.inlet_area_per_V_m2, 1.0, 1e-3);
}

TEST(FitGreybox, MakesAModelFileThatReadsBackAndSaysHowItWasFound) {
  const GreyboxFit fit = fit_greybox({record_chamber(4, Motion::violent, kRows)}, population_rig());
  const trace::ModelFile file = trace::parse_model(trace::format_model(to_model_file(fit, 3)), "model");
  EXPECT_EQ(file.kind, "greybox");
  EXPECT_EQ(file.chamber, 3U);
  EXPECT_EQ(file.parameters.front(), fit.rig.valve.open_above_V);
  EXPECT_EQ(file.fit["stop"], fit.stop);
  EXPECT_EQ(file.fit["parameters"]["open_above_V"]["standard_error"],
            figure_of(fit, "open_above_V").standard_error);
}

TEST(FitGreybox, RefusesLogsWithNothingToLearnFrom) {
  const auto says = [](const trace::Log& log, const char* text) {
    try {
      fit_greybox({log}, {});
      ADD_FAILURE() << "no refusal: " << text;
    } catch (const CannotIdentify& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(text));
    }
  };
  const trace::Log log = record_chamber(4, Motion::violent, 300);
  trace::Log still = log;
  std::fill(still.command_V.begin(), still.command_V.end(), 5.0);
  says(still, "the command is 5 V throughout");
  trace::Log flat = log;
  std::fill(flat.pressure_Pa.begin(), flat.pressure_Pa.end(), 3e5);
  says(flat, "the pressure is 300 kPa throughout");
  trace::Log noise = log;
  std::mt19937_64 random(1);
  std::normal_distribution<double> pressure_Pa(3e5, 100.0);
  for (double& p : noise.pressure_Pa) p = pressure_Pa(random);
  says(noise, "does not move with the command beyond its noise of 0.1");
  says(record_chamber(4, Motion::violent, 100), "100 rows, expected at least 200");
  EXPECT_THROW(fit_greybox({}, {}), CannotIdentify);
}

}  // namespace
}  // namespace plenum::host::identify::chamber
