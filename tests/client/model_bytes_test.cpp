// A model between its file and its image: both ends agree on every name and bound.
#include "host-sim/client/model_bytes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "firmware/config/greybox_parameters.hpp"
#include "firmware/config/model_image.hpp"
#include "host-sim/client/session.hpp"
#include "host-sim/client/shortest_decimal.hpp"
#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/model_json.hpp"

namespace plenum::host::client {
namespace {

using plenum::config::ModelKind;

trace::ModelFile thin_plate() {
  trace::ModelFile model;
  model.kind = "greybox";
  model.parameters = {5.08, 4.92, 60.0, 64.0, 1.0, 1.0,  2.0,  0.0, 0.0, 0.0,  0.0,   0.0,   0.0, 0.53, 0.5,
                      1.0,  0.0,  5.0,  1.4,  0.5, 0.01, 0.02, 0.8, 0.1, 0.03, 700.0, 101.3, 0.4, 0.1,  1.0};
  return model;
}

bool reads_back(const trace::ModelFile& model) {
  try {
    trace::parse_model(trace::format_model(model), "m.json");
    return true;
  } catch (const trace::InputError&) {
    return false;
  }
}

TEST(ModelBytes, FilesAndImagesNameTheSameParametersInTheSameOrder) {
  for (const auto& [name, kind] :
       {std::pair{"tassa9", ModelKind::tassa9}, std::pair{"tassa9r", ModelKind::tassa9r},
        std::pair{"greybox", ModelKind::greybox}}) {
    const auto in_file = trace::parameter_names(name);
    const auto in_image = plenum::config::parameter_schema(kind);
    ASSERT_EQ(in_file.size(), in_image.size()) << name;
    for (std::size_t i = 0; i < in_file.size(); ++i) EXPECT_EQ(in_file[i], in_image[i].name) << name;
  }
}

TEST(ModelBytes, AFileOfAGreyBoxModelIsHeldToTheBoardsRanges) {
  ASSERT_TRUE(reads_back(thin_plate()));
  const auto schema = plenum::config::parameter_schema(ModelKind::greybox);
  for (std::size_t i = 0; i < schema.size(); ++i) {
    // a condition between the two cuts their ranges
    if (i == plenum::config::kSupply || i == plenum::config::kAmbient) continue;
    trace::ModelFile model = thin_plate();
    for (const float bound : {schema[i].low, schema[i].high}) {
      const double decimal = shortest_decimal(bound);
      model.parameters[i] = decimal;
      EXPECT_TRUE(reads_back(model)) << schema[i].name << " = " << decimal;
      model.parameters[i] = std::nextafter(decimal, bound == schema[i].low ? -1e9 : 1e9);
      EXPECT_FALSE(reads_back(model)) << schema[i].name << " beyond " << decimal;
    }
  }
}

TEST(ModelBytes, KindAndParametersSurviveTheImage) {
  const trace::ModelFile model = thin_plate();
  const DecodedModel decoded = decode_model(encode_model(model.kind, model.parameters, {}));
  EXPECT_EQ(decoded.kind, "greybox");
  EXPECT_EQ(decoded.parameters, model.parameters);
}

TEST(ModelBytes, TheRepairedFormSurvivesTheImageWithoutItsC4) {
  const std::vector<double> values{5.02, 0.7, 1.3, 0.02, 0.03, 90.0, 0.1, 0.3, 0.1, 700.0, 101.325};
  const DecodedModel decoded = decode_model(encode_model("tassa9r", values, {}));
  EXPECT_EQ(decoded.kind, "tassa9r");
  EXPECT_EQ(decoded.parameters, values);
}

TEST(ModelBytes, ADeadTimeOfTheValveSurvivesTheImageAndIsNoneWhereItIsLeftOut) {
  std::vector<double> values{5.02, 0.7, 1.3, -0.05, 0.02, 0.03, 90.0, 0.1, 0.3, 0.1, 700.0, 101.325};
  const DecodedModel silent = decode_model(encode_model("tassa9", values, {}));
  EXPECT_EQ(silent.parameters, values);
  EXPECT_EQ(valve_delay_s(silent), 0.0);
  values.push_back(0.025);
  const DecodedModel late = decode_model(encode_model("tassa9", values, {}));
  EXPECT_EQ(late.parameters, values);
  EXPECT_EQ(valve_delay_s(late), 0.025);
  EXPECT_EQ(plenum::config::parameter_schema(ModelKind::tassa9).back().high,
            static_cast<float>(trace::kLongestDeadTime_s));
}

TEST(ModelBytes, AKindThatIsNoneAndAWrongCountAreTold) {
  EXPECT_THROW(encode_model("spline", {}, {}), std::invalid_argument);
  EXPECT_THROW(encode_model("greybox", std::vector<double>(12, 1.0), {}), std::invalid_argument);
  for (const std::size_t count : {11U, 14U})
    EXPECT_THROW(encode_model("tassa9", std::vector<double>(count, 1.0), {}), std::invalid_argument) << count;
}

}  // namespace
}  // namespace plenum::host::client
