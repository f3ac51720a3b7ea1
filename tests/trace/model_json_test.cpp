#include "host-sim/trace/model_json.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "host-sim/trace/input_error.hpp"

namespace plenum::host::trace {
namespace {

using testing::HasSubstr;

ModelFile example() {
  ModelFile model;
  model.chamber = 3;
  model.parameters = {5.02, 0.7, 1.3, -0.05, 0.3, 0.2, 90.0, 0.1, 1.0 / 3.0, 0.1, 700.0, 101.325};
  model.fit["rms_one_step_kPa"] = 0.5;
  return model;
}

/// The refusal of the example after `change` to its JSON.
template <typename Change>
std::string refusal_after(Change change) {
  auto document = nlohmann::ordered_json::parse(format_model(example()));
  change(document);
  try {
    parse_model(document.dump(), "m.json");
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

using Json = nlohmann::ordered_json;

TEST(ModelJson, ReadsBackToTheSameBits) {
  const ModelFile read = parse_model(format_model(example()), "m.json");
  EXPECT_EQ(read.kind, "tassa9");
  EXPECT_EQ(read.chamber, 3U);
  EXPECT_EQ(read.parameters, example().parameters);
  EXPECT_EQ(read.fit, example().fit);
}

TEST(ModelJson, HoldsTheFieldsOfTheContract) {
  const Json document = Json::parse(format_model(example()));
  EXPECT_EQ(document["schema"], "plenum-model/1");
  EXPECT_EQ(document["parameters"]["c4_kPa_s_per_mL"], -0.05);
  EXPECT_EQ(document["parameters"].size(), 12U);
}

TEST(ModelJson, AChamberMayBeLeftOut) {
  ModelFile model = example();
  model.chamber.reset();
  EXPECT_FALSE(parse_model(format_model(model), "m.json").chamber.has_value());
}

TEST(ModelJson, NamesTheFieldWhatWasFoundAndWhatWasExpected) {
  EXPECT_THAT(refusal_after([](Json& j) { j["schema"] = "plenum-model/2"; }),
              HasSubstr("m.json: field 'schema' is \"plenum-model/2\", expected \"plenum-model/1\""));
  EXPECT_THAT(refusal_after([](Json& j) { j.erase("schema"); }), HasSubstr("field 'schema' is missing"));
  EXPECT_THAT(refusal_after([](Json& j) { j["kind"] = 9; }),
              HasSubstr("field 'kind' is 9, expected \"tassa9\", \"tassa9r\" or \"greybox\""));
  EXPECT_THAT(refusal_after([](Json& j) { j["chamber"] = -1; }), HasSubstr("field 'chamber' is -1"));
  EXPECT_THAT(refusal_after([](Json& j) { j["fit"] = 1; }),
              HasSubstr("field 'fit' is 1, expected an object"));
  EXPECT_THAT(refusal_after([](Json& j) { j["parameters"] = 1; }), HasSubstr("field 'parameters' is 1"));
  EXPECT_THAT(refusal_after([](Json& j) { j["parameters"].erase("c8"); }),
              HasSubstr("'parameters.c8' is missing, expected a number"));
  EXPECT_THAT(refusal_after([](Json& j) { j["parameters"]["c8"] = "0"; }),
              HasSubstr("'parameters.c8' is \"0\", expected a number"));
  EXPECT_THAT(refusal_after([](Json& j) { j["parameters"]["c10"] = 0; }),
              HasSubstr("'parameters.c10' is unknown, expected c1_V"));
}

TEST(ModelJson, HoldsTheParametersToTableI) {
  const auto with = [](std::string_view name, double value) {
    return refusal_after([&](Json& j) { j["parameters"][name] = value; });
  };
  EXPECT_THAT(with("c1_V", 8.0), HasSubstr("'parameters.c1_V' is 8, expected a number above 2 and below 8"));
  EXPECT_THAT(with("c1_V", 2.0), HasSubstr("above 2"));
  EXPECT_THAT(with("c3_per_V3", -1.0), HasSubstr("'parameters.c3_per_V3' is -1"));
  EXPECT_THAT(with("c8", 1.0), HasSubstr("'parameters.c8' is 1"));
  EXPECT_THAT(with("c8", -1.0), HasSubstr("'parameters.c8' is -1"));
  EXPECT_THAT(with("c9_V", 0.0), HasSubstr("'parameters.c9_V' is 0"));
  EXPECT_THAT(with("supply_kPa", 100.0),
              HasSubstr("'parameters.supply_kPa' is 100, expected above ambient_kPa"));
  EXPECT_EQ(with("c1_V", 7.9), "accepted");
}

TEST(ModelJson, TheValvesDeadTimeMayBeStated) {
  ModelFile model = example();
  EXPECT_FALSE(Json::parse(format_model(model))["parameters"].contains("dead_time_s"));
  model.parameters.push_back(0.025);
  EXPECT_EQ(Json::parse(format_model(model))["parameters"]["dead_time_s"], 0.025);
  EXPECT_EQ(parse_model(format_model(model), "m.json").parameters, model.parameters);
  const auto with = [](double dead_time_s) {
    return refusal_after([&](Json& j) { j["parameters"]["dead_time_s"] = dead_time_s; });
  };
  EXPECT_EQ(with(0.0), "accepted");
  EXPECT_EQ(with(0.12), "accepted");
  EXPECT_THAT(with(-0.001),
              HasSubstr("'parameters.dead_time_s' is -0.001, expected a number from 0 to 0.12"));
  EXPECT_THAT(with(0.121), HasSubstr("'parameters.dead_time_s' is 0.121"));
}

TEST(ModelJson, AGreyBoxMayLeaveOutTheSuppliesLineFromTheLastOn) {
  ModelFile model;
  model.kind = "greybox";
  model.parameters = {5.08, 4.92, 60.0, 64.0, 1.0, 1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0,   0.0,  0.53,
                      0.5,  1.0,  0.0,  5.0,  1.4, 0.0, 0.0, 0.0, 0.8, 0.0, 0.0, 700.0, 101.3};
  for (const double more : {0.4, 0.1, 1.0}) {
    EXPECT_EQ(parse_model(format_model(model), "m.json").parameters, model.parameters);
    model.parameters.push_back(more);
  }
  EXPECT_EQ(parse_model(format_model(model), "m.json").parameters, model.parameters);
  auto document = Json::parse(format_model(model));
  document["parameters"].erase("supply_recovery_s");
  try {
    parse_model(document.dump(), "m.json");
    ADD_FAILURE() << "supply_followed_share would be lost";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("'parameters.supply_recovery_s' is missing"));
  }
}

TEST(ModelJson, ARepairedFormHasNoC4AndIsHeldToTableI) {
  ModelFile model;
  model.kind = "tassa9r";
  model.parameters = {5.02, 0.7, 1.3, 0.3, 0.2, 90.0, 0.1, 1.0 / 3.0, 0.1, 700.0, 101.325};
  const ModelFile read = parse_model(format_model(model), "m.json");
  EXPECT_EQ(read.kind, "tassa9r");
  EXPECT_EQ(read.parameters, model.parameters);
  const auto refusal = [&](std::string_view name, double value) -> std::string {
    auto document = Json::parse(format_model(model));
    document["parameters"][name] = value;
    try {
      parse_model(document.dump(), "m.json");
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(refusal("c4_kPa_s_per_mL", 0.0), HasSubstr("'parameters.c4_kPa_s_per_mL' is unknown"));
  EXPECT_THAT(refusal("c8", 1.0), HasSubstr("'parameters.c8' is 1, expected a number above -1 and below 1"));
  EXPECT_THAT(refusal("c9_V", 0.0), HasSubstr("'parameters.c9_V' is 0"));
  EXPECT_THAT(refusal("supply_kPa", 100.0), HasSubstr("expected above ambient_kPa"));
  EXPECT_EQ(refusal("c5_per_mL", -3.0), "accepted");
}

TEST(ModelJson, RefusesBytesThatAreNoModel) {
  for (const std::string text : {"", "{", "[1]", "{\"schema\":\"plenum-model/1\"", "[1e999]"}) {
    EXPECT_THROW(parse_model(text, "m.json"), InputError) << text;
  }
}

TEST(ModelJson, RefusesToWriteANumberThatIsNotFinite) {
  ModelFile model = example();
  model.parameters[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(write_model("never.json", model), InputError);
}

}  // namespace
}  // namespace plenum::host::trace
