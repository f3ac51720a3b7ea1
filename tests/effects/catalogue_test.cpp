#include "host-sim/effects/catalogue.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

namespace plenum::host::effects {
namespace {

TEST(Catalogue, HoldsTheClosedListOfTheContractWithTheEquationOfEach) {
  const std::map<std::string_view, std::string_view> contract{{"spool_lag", "command"},
                                                              {"dead_time", "command"},
                                                              {"valve_hysteresis", "command"},
                                                              {"null_drift", "command"},
                                                              {"area_shape", "valve_area"},
                                                              {"flow_function", "mass_flow"},
                                                              {"exhaust_backpressure", "mass_flow"},
                                                              {"chamber_leak", "mass_flow"},
                                                              {"tube_dynamics", "mass_flow"},
                                                              {"supply_droop", "supply"},
                                                              {"heat_transfer", "energy"},
                                                              {"volume_error", "energy"},
                                                              {"sensor_lag", "sensor"},
                                                              {"sensor_bias", "sensor"}};
  std::map<std::string_view, std::string_view> ours;
  for (const Effect* effect : catalogue()) ours[effect->id] = name_of(effect->equation);
  EXPECT_EQ(ours, contract);
  EXPECT_EQ(kEffects, contract.size());
}

TEST(Catalogue, PositionsAreThoseOfTheirNames) {
  const std::map<Id, std::string_view> names{{kIdSpoolLag, "spool_lag"},
                                             {kIdDeadTime, "dead_time"},
                                             {kIdValveHysteresis, "valve_hysteresis"},
                                             {kIdAreaShape, "area_shape"},
                                             {kIdNullDrift, "null_drift"},
                                             {kIdFlowFunction, "flow_function"},
                                             {kIdSupplyDroop, "supply_droop"},
                                             {kIdExhaustBackpressure, "exhaust_backpressure"},
                                             {kIdChamberLeak, "chamber_leak"},
                                             {kIdTubeDynamics, "tube_dynamics"},
                                             {kIdHeatTransfer, "heat_transfer"},
                                             {kIdVolumeError, "volume_error"},
                                             {kIdSensorLag, "sensor_lag"},
                                             {kIdSensorBias, "sensor_bias"}};
  for (const auto& [id, name] : names) {
    EXPECT_EQ(kCatalogue[id]->id, name);
    EXPECT_EQ(find(name), std::optional<std::size_t>(id));
  }
  EXPECT_EQ(find("spool"), std::nullopt);
}

TEST(Catalogue, FiguresOfTheEffectsFollowOneAnotherWithoutGap) {
  std::size_t at = kValveFigures;
  for (std::size_t i = 0; i < kEffects; ++i) {
    EXPECT_EQ(kFirstFigure[i], at) << kCatalogue[i]->id;
    at += kCatalogue[i]->parameters.size();
  }
  EXPECT_EQ(kStampedEarly, at) << "of the log, after all of them";
  EXPECT_EQ(kFigures, at + 1);
}

TEST(Catalogue, EveryParameterCanVanishWithinItsBounds) {
  const Figures neutral = neutral_figures();
  for (std::size_t i = 0; i < kEffects; ++i) {
    std::size_t at = kFirstFigure[i];
    for (const Parameter& p : kCatalogue[i]->parameters) {
      const std::string name = std::string(kCatalogue[i]->id) + "." + std::string(p.name);
      EXPECT_TRUE(std::isfinite(p.least()) && std::isfinite(p.greatest())) << name;
      EXPECT_LT(p.least(), p.greatest()) << name;
      EXPECT_LE(p.least(), p.neutral()) << name;
      EXPECT_GE(p.greatest(), p.neutral()) << name;
      EXPECT_EQ(neutral[at++], p.neutral()) << name;
      EXPECT_GT(p.typical_change, 0.0) << name;
      EXPECT_LT(p.typical_change, p.greatest() - p.least()) << name << ": one step of a search stays within";
    }
  }
}

TEST(Catalogue, WhatMattersToAValveAHundredthAsWideIsAHundredTimesTheResistance) {
  const Parameter& resistance = kCatalogue[kIdExhaustBackpressure]->parameters[0];
  const Parameter& manifold = kCatalogue[kIdExhaustBackpressure]->parameters[1];
  const Parameter& conductance = kCatalogue[kIdChamberLeak]->parameters[0];
  const Parameter& bore = kCatalogue[kIdTubeDynamics]->parameters[1];
  const Parameter& fittings = kCatalogue[kIdTubeDynamics]->parameters[2];
  const Size small{0.01, 0.1};
  EXPECT_DOUBLE_EQ(resistance.of(small).high, 100.0 * resistance.high);
  EXPECT_DOUBLE_EQ(resistance.of(small).typical_change, 100.0 * resistance.typical_change);
  EXPECT_DOUBLE_EQ(conductance.of(small).high, 0.01 * conductance.high);
  EXPECT_DOUBLE_EQ(bore.of(small).low, 0.1 * bore.low);
  EXPECT_DOUBLE_EQ(bore.of(small).vanishes_at, 0.1 * bore.vanishes_at);
  EXPECT_DOUBLE_EQ(manifold.of(small).typical_change, 0.1 * manifold.typical_change);
  EXPECT_DOUBLE_EQ(fittings.of(small).low, 0.01 * fittings.low);
  EXPECT_DOUBLE_EQ(fittings.of(small).typical_change, 1e4 * fittings.typical_change) << "of 1/a^2";
  EXPECT_EQ(manifold.of(small).high, manifold.high) << "a manifold of any size can stand behind a valve";
  EXPECT_DOUBLE_EQ(resistance.of({1e-9, 1.0}).high, resistance.of_any_size().high) << "and no further";
}

TEST(Catalogue, OfAnySizeLetsARigSayWhatAFitMayFind) {
  for (const Effect* effect : catalogue()) {
    for (const Parameter& p : effect->parameters) {
      for (const double valve : {0.01, 0.3, 1.0, 7.0, 100.0}) {
        EXPECT_LE(p.of_any_size().low, p.of({valve, 1.0}).low) << effect->id << "." << p.name;
        EXPECT_GE(p.of_any_size().high, p.of({valve, 1.0}).high) << effect->id << "." << p.name;
      }
    }
  }
}

TEST(Catalogue, ValueAndCoordinateOfAParameterTurnIntoEachOther) {
  for (const Effect* effect : catalogue()) {
    for (const Parameter& p : effect->parameters) {
      EXPECT_EQ(p.value_of(p.coordinate_of(p.low)), p.low) << effect->id << "." << p.name;
      EXPECT_EQ(p.value_of(p.neutral()), p.vanishes_at) << effect->id << "." << p.name;
    }
  }
}

TEST(Catalogue, NamesCarryTheirUnitUnlessTheyAreRatios) {
  const std::set<std::string_view> ratios{"damping",        "inlet_slope",     "inlet_curve",
                                          "inlet_bend",     "exhaust_bend",    "exhaust_slope",
                                          "exhaust_curve",  "critical_ratio",  "subsonic_index",
                                          "cracking_ratio", "discharge_slope", "exponent",
                                          "gain_error",     "pressure_power",  "orifice_share",
                                          "softness",       "spring",          "letting_go",
                                          "straight_share", "coil_rise",       "slew_sharpness",
                                          "outflow_share",  "relieving_share", "density_share",
                                          "volume_power",   "sensor_share",    "chamber_share",
                                          "non_linearity",  "coil_return",     "exhaust_ratio_more",
                                          "delay_rise",     "followed_share",  "bow",
                                          "s_shape"};
  const std::set<std::string_view> units{"_Hz",  "_s",   "_V",  "_kPa_s_per_g", "_g_s_MPa", "_m",    "_mm",
                                         "_mm2", "_W_K", "_mL", "_kPa",         "_V_s",     "_kPa_V"};
  for (const Effect* effect : catalogue()) {
    for (const Parameter& p : effect->parameters) {
      const bool has_unit = std::any_of(units.begin(), units.end(),
                                        [&](std::string_view unit) { return p.name.ends_with(unit); });
      EXPECT_TRUE(has_unit != ratios.contains(p.name)) << effect->id << "." << p.name;
    }
  }
}

TEST(Catalogue, EveryEntrySaysWhatItIsInOneLine) {
  for (const Effect* effect : catalogue()) {
    EXPECT_FALSE(effect->parameters.empty()) << effect->id;
    for (const std::string_view text : {effect->summary, effect->formula, effect->source}) {
      EXPECT_FALSE(text.empty()) << effect->id;
      EXPECT_EQ(text.find('\n'), std::string_view::npos) << effect->id;
    }
  }
}

}  // namespace
}  // namespace plenum::host::effects
