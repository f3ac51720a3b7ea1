#include "host-sim/trace/rig_toml.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "host-sim/trace/input_error.hpp"

namespace plenum::host::trace {
namespace {

using testing::HasSubstr;

std::string refusal(const std::string& text) {
  try {
    parse_rig(text, "rig.toml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(RigToml, NeedsNoMoreThanTheRate) {
  const RigDescription rig = parse_rig("[sampling]\nrate_Hz = 200\n", "rig.toml");
  EXPECT_EQ(rig.sampling.rate_Hz, 200.0);
  EXPECT_EQ(rig.sampling.pressure_average_s, 1.0 / 200.0) << "one tick";
  EXPECT_EQ(rig.supply.pressure_Pa, 700000.0);
  EXPECT_EQ(rig.ambient.pressure_Pa, 101325.0);
  EXPECT_EQ(rig.valve.inlet_area_per_V_m2, 1.5e-6);
}

TEST(RigToml, TellsWhatTheFileDoesNotState) {
  std::vector<std::string> assumed;
  parse_rig("[sampling]\nrate_Hz = 200\n[valve]\nopen_above_V = 5.1\n", "rig.toml", &assumed);
  EXPECT_EQ(assumed.size(), 12U) << "of 14 keys";
  EXPECT_THAT(assumed,
              testing::IsSupersetOf({"sampling.pressure_average_s = 0.005", "supply.pressure_Pa = 700000",
                                     "valve.exhaust_below_V = 4.92"}));
  std::vector<std::string> none;
  parse_rig(format_rig(RigDescription{}), "rig.toml", &none);
  EXPECT_TRUE(none.empty());
}

TEST(RigToml, TakesATickThatIsRoundedForOneTick) {
  const RigDescription rig =
      parse_rig("[sampling]\nrate_Hz = 60\npressure_average_s = 0.016667\n", "rig.toml");
  EXPECT_EQ(rig.sampling.pressure_average_s, 1.0 / 60.0);
}

TEST(RigToml, HoldsAValveOf24Volts) {
  EXPECT_EQ(refusal("[sampling]\nrate_Hz = 100\n[valve]\nopen_above_V = 12.2\nexhaust_below_V = 11.8\n"),
            "accepted");
}

TEST(RigToml, HoldsAValveWhoseNullIsAtZero) {
  const RigDescription rig = parse_rig(
      "[sampling]\nrate_Hz = 100\n[valve]\nopen_above_V = 0.08\nexhaust_below_V = -0.08\n", "rig.toml");
  EXPECT_EQ(rig.valve.open_above_V, 0.08);
  EXPECT_EQ(rig.valve.exhaust_below_V, -0.08);
}

TEST(RigToml, TakesLettersBeyondAsciiInCommentsOnly) {
  EXPECT_EQ(refusal("\xEF\xBB\xBF[sampling]\nrate_Hz = 100  # Prüfstand, 20 °C\n"), "accepted");
  EXPECT_THAT(refusal("[sampling]\nrate_Hz = 100\nµ = 1 # m\n"),
              HasSubstr("rig.toml: line 3: a character beyond ASCII"));
  EXPECT_THAT(refusal("a = \"\"\"\n# \\\n\xC2\xA7\"\"\"\n"),
              HasSubstr("rig.toml: line 3: a character beyond ASCII, expected none in a file with strings of "
                        "several lines"))
      << "what looks like a comment may be a string";
  for (const char* text :
       {"a = \"#\"\xC2\xA7\n", "a = '#'\xC2\xA7\n", "a = \"\\\"#\"\xC2\xA7\n", "\"#\"\xC2\xA7 = 1\n"}) {
    EXPECT_THAT(refusal(text), HasSubstr("rig.toml: line 1: a character beyond ASCII")) << text;
  }
}

TEST(RigToml, RefusesAKeyOfMorePartsThanAnyOfItsOwn) {
  const auto dotted = [](const std::string& part, std::size_t parts) {
    std::string key = part;
    for (std::size_t more = 1; more < parts; ++more) key += "." + part;
    return key;
  };
  for (const std::size_t parts : {9U, 5'000U, 200'000U}) {
    const std::string expected = fmt::format("a key of {} parts, expected 8 at most", parts);
    for (const std::string part : {"a", "'='", "\"]\\\"\""}) {
      EXPECT_EQ(refusal("\n" + dotted(part, parts) + " = 1\n"), "rig.toml: line 2: " + expected) << part;
      EXPECT_EQ(refusal("[" + dotted(part, parts) + "]"), "rig.toml: line 1: " + expected) << part;
    }
  }
  EXPECT_THAT(refusal(dotted("a", 8) + " = 1"), HasSubstr("unknown table or key 'a'"));
}

TEST(RigToml, ReadsTheExampleOfTheContract) {
  const RigDescription rig = parse_rig(R"(
[sampling]
rate_Hz = 100
pressure_average_s = 0.01
[gas]
temperature_K = 300
[supply]
pressure_Pa = 600000       # absolute
[ambient]
pressure_Pa = 100000
[valve]
open_above_V = 5.1
exhaust_below_V = 4.9
inlet_area_per_V_m2 = 1e-6
exhaust_area_per_V_m2 = 2e-6
inlet_leak_m2 = 3e-8
exhaust_leak_m2 = 4e-8
transition_m2 = 6e-8
discharge_coefficient = 0.7
[sensor]
pressure_noise_Pa = 50
)",
                                       "rig.toml");
  EXPECT_EQ(rig.gas.temperature_K, 300.0);
  EXPECT_EQ(rig.supply.pressure_Pa, 600000.0);
  EXPECT_EQ(rig.ambient.pressure_Pa, 100000.0);
  EXPECT_EQ(rig.valve.open_above_V, 5.1);
  EXPECT_EQ(rig.valve.exhaust_below_V, 4.9);
  EXPECT_EQ(rig.valve.inlet_area_per_V_m2, 1e-6);
  EXPECT_EQ(rig.valve.exhaust_area_per_V_m2, 2e-6);
  EXPECT_EQ(rig.valve.inlet_leak_m2, 3e-8);
  EXPECT_EQ(rig.valve.exhaust_leak_m2, 4e-8);
  EXPECT_EQ(rig.valve.transition_m2, 6e-8);
  EXPECT_EQ(rig.valve.discharge_coefficient, 0.7);
  EXPECT_EQ(rig.sensor.pressure_noise_Pa, 50.0);
}

TEST(RigToml, ThePrintedValuesAreARigThatReadsBackToTheSamePrint) {
  RigDescription rig;
  rig.sampling.rate_Hz = 1000.0 / 3.0;
  rig.sampling.pressure_average_s = 0.001;
  rig.valve.transition_m2 = 1.0 / 3.0 * 1e-7;
  rig.effects = {{"spool_lag", {{"natural_frequency_Hz", 9.8}, {"damping", 1.0 / 3.0}}},
                 {"dead_time", {{"delay_s", 1e-5}}}};
  const std::string text = format_rig(rig);
  EXPECT_EQ(format_rig(parse_rig(text, "rig.toml")), text);
}

TEST(RigToml, HoldsTheFiguresOfEffectsByIdAndName) {
  const RigDescription rig = parse_rig(
      "[sampling]\nrate_Hz = 100\n[effects.spool_lag]\nnatural_frequency_Hz = 9.8\n"
      "[effects.volume_error]\noffset_m3 = -1e-5\nscale = 2\n",
      "rig.toml");
  const std::map<std::string, std::map<std::string, double>> expected{
      {"spool_lag", {{"natural_frequency_Hz", 9.8}}},
      {"volume_error", {{"offset_m3", -1e-5}, {"scale", 2.0}}}};
  EXPECT_EQ(rig.effects, expected);
}

TEST(RigToml, MarksAValveThatNobodyStated) {
  RigDescription rig;
  EXPECT_THAT(format_rig(rig), HasSubstr("[valve]  # defaults"));
  rig.valve.open_above_V = 5.1;
  EXPECT_THAT(format_rig(rig), HasSubstr("[valve]\n"));
}

TEST(RigToml, OfANominalRigPrintsNeitherEffectsNorChambers) {
  EXPECT_EQ(format_rig(RigDescription{}).find("effects"), std::string::npos);
  EXPECT_EQ(format_rig(RigDescription{}).find("chamber."), std::string::npos);
}

TEST(RigToml, HoldsTheSerialNumbersOfAChambersValveAndSensor) {
  const RigDescription rig = parse_rig(
      "[sampling]\nrate_Hz = 100\n[chamber.3]\nvalve_serial = 4294967295\nsensor_serial = 815\n"
      "[chamber.8]\nsensor_serial = 7\n",
      "rig.toml");
  ASSERT_EQ(rig.chamber.size(), 2U);
  EXPECT_EQ(rig.chamber.at(3).valve_serial, 4294967295U);
  EXPECT_EQ(rig.chamber.at(3).sensor_serial, 815U);
  EXPECT_EQ(rig.chamber.at(8).valve_serial, 0U) << "not stated";
  EXPECT_EQ(rig.chamber.at(8).sensor_serial, 7U);
  const std::string text = format_rig(rig);
  EXPECT_EQ(format_rig(parse_rig(text, "rig.toml")), text);
  EXPECT_THAT(text, HasSubstr("[chamber.3]\nvalve_serial = 4294967295\nsensor_serial = 815\n"));
}

struct BadRig {
  const char* what;
  std::string text;
  std::vector<std::string> says;
};

class RigTomlRefuses : public testing::TestWithParam<BadRig> {};

TEST_P(RigTomlRefuses, WithLineKeyValueAndExpectation) {
  const std::string said = refusal(GetParam().text);
  EXPECT_THAT(said, HasSubstr("rig.toml"));
  EXPECT_THAT(said, HasSubstr("expected"));
  EXPECT_EQ(said.find('\n'), std::string::npos);
  for (const std::string& part : GetParam().says) EXPECT_THAT(said, HasSubstr(part));
}

const std::string kRate = "[sampling]\nrate_Hz = 100\n";

INSTANTIATE_TEST_SUITE_P(
    All, RigTomlRefuses,
    testing::Values(
        BadRig{"NoRate", "[gas]\ntemperature_K = 290\n", {"sampling.rate_Hz", "missing"}},
        BadRig{"Syntax", kRate + "[gas\n", {"line 3", "TOML"}},
        BadRig{"UnknownTable", kRate + "[valves]\n", {"line 3", "'valves'"}},
        BadRig{"UnknownKey", kRate + "[valve]\nopen_V = 5\n", {"line 4", "'open_V'", "open_above_V"}},
        BadRig{"ValueOutsideATable", "supply = 7\n" + kRate, {"line 1", "'supply'"}},
        BadRig{"AString",
               kRate + "[gas]\ntemperature_K = \"warm\"\n",
               {"line 4", "gas.temperature_K", "a string"}},
        BadRig{"OutOfRange",
               kRate + "[gas]\ntemperature_K = 20\n",
               {"line 4", "gas.temperature_K = 20", "200 to 400"}},
        BadRig{"NotFinite", kRate + "[gas]\ntemperature_K = nan\n", {"line 4", "gas.temperature_K = nan"}},
        BadRig{"AveragesMoreThanATick",
               kRate + "pressure_average_s = 0.02\n",
               {"sampling.pressure_average_s = 0.02"}},
        BadRig{"AnEffectThatIsANumber",
               kRate + "[effects]\nspool_lag = 9.8\n",
               {"line 4", "effects.spool_lag", "[effects.spool_lag]"}},
        BadRig{"AnEffectsFigureThatIsAString",
               kRate + "[effects.spool_lag]\nnatural_frequency_Hz = \"9.8\"\n",
               {"line 4", "effects.spool_lag.natural_frequency_Hz", "a string"}},
        BadRig{"AnEffectsFigureThatIsNotFinite",
               kRate + "[effects.spool_lag]\nnatural_frequency_Hz = inf\n",
               {"line 4", "effects.spool_lag.natural_frequency_Hz = inf", "finite"}},
        BadRig{"AnEffectWithABadName",
               kRate + "[effects.\"spool lag\"]\n",
               {"line 3", "'spool lag'", "letters"}},
        BadRig{"AFigureWithABadName", kRate + "[effects.spool_lag]\n9 = 1\n", {"line 4", "'9'", "letters"}},
        BadRig{"AChamberThatNoBoardHas", kRate + "[chamber.9]\n", {"line 3", "chamber.9", "1 to 8"}},
        BadRig{"AChamberThatIsANumber", kRate + "[chamber]\n3 = 1\n", {"line 4", "chamber.3", "[chamber.N]"}},
        BadRig{"AnUnknownKeyOfAChamber",
               kRate + "[chamber.3]\nserial = 1\n",
               {"line 4", "'serial'", "[chamber.3]", "valve_serial"}},
        BadRig{"ASerialThatIsNoWholeNumber",
               kRate + "[chamber.3]\nvalve_serial = 1.5\n",
               {"line 4", "chamber.3.valve_serial", "whole number", "4294967295"}},
        BadRig{"ASerialBeyond32Bits",
               kRate + "[chamber.3]\nsensor_serial = 4294967296\n",
               {"line 4", "chamber.3.sensor_serial", "4294967295"}},
        BadRig{"SupplyBelowAmbient",
               kRate + "[supply]\npressure_Pa = 100000\n",
               {"supply.pressure_Pa = 100000"}}),
    [](const testing::TestParamInfo<BadRig>& bad) { return bad.param.what; });

TEST(RigToml, RefusesToWriteWhatItWouldNotRead) {
  RigDescription rig;
  rig.valve.discharge_coefficient = 2.0;
  EXPECT_THROW(write_rig("never.toml", rig), InputError);
  RigDescription with_effect;
  with_effect.effects = {{"spool_lag", {{"natural_frequency_Hz", std::nan("")}}}};
  EXPECT_THROW(write_rig("never.toml", with_effect), InputError);
  with_effect.effects = {{"spool lag", {}}};
  EXPECT_THROW(write_rig("never.toml", with_effect), InputError);
  RigDescription with_chamber;
  with_chamber.chamber[9] = {.valve_serial = 1};
  EXPECT_THROW(write_rig("never.toml", with_chamber), InputError);
}

}  // namespace
}  // namespace plenum::host::trace
