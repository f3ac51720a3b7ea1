#include "firmware/config/model_image.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "firmware/config/crc32.hpp"
#include "tests/firmware/config/tassa9_sample.hpp"

namespace plenum::config {
namespace {

// The image of tassa9_sample() as Python's struct and zlib write it from the layout in model_image.hpp, with
// the schema hash computed by a separate FNV-1a over the names and ranges.
constexpr std::array<std::uint8_t, 84> kGolden = {
    0x50, 0x4C, 0x4D, 0x32, 0x14, 0x16, 0x6F, 0xB6, 0x01, 0x00, 0x0C, 0x00, 0x00, 0xF1, 0x53, 0x65, 0x00,
    0x00, 0xA0, 0x3F, 0x67, 0x12, 0x00, 0x00, 0x2F, 0x03, 0x00, 0x00, 0xA6, 0x9B, 0xC4, 0x3A, 0xD7, 0xA3,
    0xA0, 0x40, 0x00, 0x00, 0x20, 0x40, 0x00, 0x00, 0x80, 0x40, 0xCD, 0xCC, 0x4C, 0xBD, 0xA6, 0x9B, 0x44,
    0x3B, 0x0A, 0xD7, 0xA3, 0x3C, 0x00, 0x00, 0x20, 0x42, 0xCD, 0xCC, 0xCC, 0x3D, 0x0A, 0xD7, 0xA3, 0x3D,
    0xCD, 0xCC, 0xCC, 0x3D, 0x00, 0x00, 0x1B, 0x44, 0x66, 0xA6, 0xCA, 0x42, 0xD6, 0x70, 0x28, 0x87};

constexpr std::size_t kCountAt = 10, kKindAt = 8, kHashAt = 4;

void put_u32(std::vector<std::uint8_t>& image, std::size_t at, std::uint32_t x) {
  for (std::size_t i = 0; i < 4; ++i) image[at + i] = static_cast<std::uint8_t>(x >> (8 * i));
}

// Makes the CRC right again, so that a test meets the check that it names and not the CRC.
void seal(std::vector<std::uint8_t>& image) {
  put_u32(image, image.size() - 4, crc32(std::span(image).first(image.size() - 4)));
}

ImageVerdict verdict_on(const std::vector<std::uint8_t>& image) {
  ModelParameters ignored;
  return decode(image, ignored);
}

TEST(ModelImage, IsWrittenByteForByteAsItsLayoutSays) {
  const std::vector<std::uint8_t> image = image_of(tassa9_sample());
  EXPECT_EQ(image, std::vector<std::uint8_t>(kGolden.begin(), kGolden.end()));
}

TEST(ModelImage, IsReadBackAsItWasWritten) {
  ModelParameters read;
  ASSERT_TRUE(decode(kGolden, read));
  const ModelParameters sample = tassa9_sample();
  EXPECT_EQ(read.kind, sample.kind);
  EXPECT_EQ(read.fit_date_s, sample.fit_date_s);
  EXPECT_EQ(read.fit_error_kPa, sample.fit_error_kPa);
  EXPECT_EQ(read.valve_serial, sample.valve_serial);
  EXPECT_EQ(read.sensor_serial, sample.sensor_serial);
  EXPECT_EQ(read.fixed_error_kPa, sample.fixed_error_kPa);
  EXPECT_EQ(read.count, sample.count);
  EXPECT_EQ(read.value, sample.value);
}

TEST(ModelImage, IsRefusedWhenAnySingleBitIsFlipped) {
  const std::vector<std::uint8_t> image = image_of(tassa9_sample());
  for (std::size_t bit = 0; bit < 8 * image.size(); ++bit) {
    std::vector<std::uint8_t> flipped = image;
    flipped[bit / 8] = static_cast<std::uint8_t>(flipped[bit / 8] ^ (1U << (bit % 8)));
    EXPECT_FALSE(verdict_on(flipped)) << "bit " << bit;
  }
}

TEST(ModelImage, IsRefusedWhenCutShortOrLengthened) {
  const std::vector<std::uint8_t> image = image_of(tassa9_sample());
  for (std::size_t size = 0; size < image.size(); ++size) {
    const ImageVerdict verdict =
        verdict_on({image.begin(), image.begin() + static_cast<std::ptrdiff_t>(size)});
    EXPECT_EQ(verdict.error, size < 36 ? ImageError::too_short : ImageError::wrong_size) << size << " bytes";
    EXPECT_EQ(verdict.value, static_cast<float>(size));
  }
  std::vector<std::uint8_t> longer = image;
  longer.push_back(0);
  EXPECT_EQ(verdict_on(longer).error, ImageError::wrong_size);
}

TEST(ModelImage, OfForeignMagicKindSchemaOrCountIsNamedAsSuch) {
  std::vector<std::uint8_t> image = image_of(tassa9_sample());
  image[3] = '1';
  seal(image);
  EXPECT_EQ(verdict_on(image).error, ImageError::bad_magic);

  image = image_of(tassa9_sample());
  image[kKindAt] = 9;
  seal(image);
  EXPECT_EQ(verdict_on(image).error, ImageError::unknown_kind);

  image = image_of(tassa9_sample());
  put_u32(image, kHashAt, 0x12345678);
  seal(image);
  EXPECT_EQ(verdict_on(image).error, ImageError::schema_mismatch);

  image = image_of(tassa9_sample());
  image[kCountAt] = 11;
  seal(image);
  EXPECT_EQ(verdict_on(image).error, ImageError::wrong_count);
}

TEST(ModelImage, MayStateTheValvesDeadTimeOrLeaveItOut) {
  ModelParameters read;
  ASSERT_TRUE(decode(image_of(tassa9_sample()), read));
  EXPECT_EQ(read.count, 12U);
  EXPECT_EQ(dead_time_s(read), std::nullopt);

  ModelParameters late = tassa9_sample();
  late.count = 13;
  late.value[12] = 0.025F;
  const std::vector<std::uint8_t> image = image_of(late);
  ASSERT_EQ(image.size(), image_of(tassa9_sample()).size() + 4);
  ASSERT_TRUE(decode(image, read));
  EXPECT_EQ(read.count, 13U);
  EXPECT_EQ(dead_time_s(read), 0.025F);
  EXPECT_EQ(supply_of(read).supply_kPa, 620.0F);
  EXPECT_EQ(supply_of(read).ambient_kPa, 101.325F);

  late.value[12] = 0.121F;
  EXPECT_EQ(validate(late).error, ImageError::out_of_range);
  EXPECT_EQ(validate(late).parameter, 12U);
  late.count = 14;
  EXPECT_EQ(validate(late).error, ImageError::wrong_count);
  EXPECT_EQ(validate(late).low, 12.0F);
  EXPECT_EQ(validate(late).high, 13.0F);
}

TEST(ModelImage, WithAWrongCrcIsNamedAsSuch) {
  std::vector<std::uint8_t> image = image_of(tassa9_sample());
  image.back() = static_cast<std::uint8_t>(image.back() ^ 0x80U);
  EXPECT_EQ(verdict_on(image).error, ImageError::bad_crc);
}

TEST(ModelImage, TheFirstOfManyBytesIsAsLongAsItsCountSays) {
  const std::vector<std::uint8_t> image = image_of(tassa9_sample());
  std::vector<std::uint8_t> bytes = image;
  bytes.insert(bytes.end(), image.begin(), image.end());
  EXPECT_EQ(first_image(bytes).data(), bytes.data());
  EXPECT_EQ(first_image(bytes).size(), image.size());
  for (std::size_t size = 0; size < image.size(); ++size)
    EXPECT_TRUE(first_image(std::span(bytes).first(size)).empty()) << size << " bytes";
  std::vector<std::uint8_t> many(32 + 4 * 33 + 4);
  many[kCountAt] = 33;
  EXPECT_TRUE(first_image(many).empty()) << "more parameters than an image can have";
}

TEST(ModelImage, RefusedLeavesTheReadersParametersAlone) {
  ModelParameters kept = tassa9_sample();
  ModelParameters bad = tassa9_sample();
  bad.value[kC1] = 9.0F;
  EXPECT_FALSE(decode(image_of(bad), kept));
  EXPECT_EQ(kept.value, tassa9_sample().value);
}

TEST(ModelImage, IsNotWrittenIntoTooSmallAPlaceOrForAnUnknownKind) {
  std::array<std::uint8_t, 83> small{};
  EXPECT_EQ(encode(tassa9_sample(), small), 0U);
  EXPECT_EQ(small, (std::array<std::uint8_t, 83>{}));
  std::array<std::uint8_t, kMaxImageBytes> room{};
  EXPECT_EQ(encode(ModelParameters{}, room), 0U);
  ModelParameters miscounted = tassa9_sample();
  miscounted.count = 60000;
  EXPECT_EQ(encode(miscounted, room), 0U);
}

/// FNV-1a, written again: kind, then of each parameter its name with the zero at its end, low and high.
TEST(ModelImage, SchemaHashCoversEveryNameAndRangeThatItsKindRequires) {
  for (const ModelKind kind : {ModelKind::tassa9, ModelKind::greybox, ModelKind::tassa9r}) {
    std::uint32_t hash = 2166136261U;
    const auto take = [&hash](std::uint32_t value, int bytes) {
      for (int i = 0; i < bytes; ++i) hash = (hash ^ (value >> (8 * i) & 0xFFU)) * 16777619U;
    };
    take(static_cast<std::uint32_t>(kind), 2);
    ASSERT_GE(required_count(kind), 11U);
    for (const ParameterSpec& spec : parameter_schema(kind).first(required_count(kind))) {
      for (const char letter : std::string(spec.name) + '\0') take(static_cast<std::uint8_t>(letter), 1);
      take(std::bit_cast<std::uint32_t>(spec.low), 4);
      take(std::bit_cast<std::uint32_t>(spec.high), 4);
    }
    EXPECT_EQ(schema_hash(kind), hash) << "kind " << static_cast<int>(kind);
  }
}

TEST(ModelSchema, ListsTheParametersOfTassa9InOrderAndRequiresAllButTheDeadTime) {
  const std::vector<std::string> expected = {
      "c1_V", "c2_per_V", "c3_per_V3", "c4_kPa_s_per_mL", "c5_per_mL",   "c6_per_mL",  "c7_per_V_s",
      "c8",   "c9_V",     "c_gamma_V", "supply_kPa",      "ambient_kPa", "dead_time_s"};
  std::vector<std::string> names;
  for (const ParameterSpec& spec : parameter_schema(ModelKind::tassa9)) names.emplace_back(spec.name);
  EXPECT_EQ(names, expected);
  EXPECT_EQ(required_count(ModelKind::tassa9), 12U);
  EXPECT_TRUE(parameter_schema(ModelKind::none).empty());
  EXPECT_EQ(required_count(ModelKind::none), 0U);
  EXPECT_NE(schema_hash(ModelKind::tassa9), schema_hash(ModelKind::none));
}

/// With what may be left out.
ModelParameters whole_sample() {
  ModelParameters p = tassa9_sample();
  p.count = 13;
  return p;
}

TEST(ModelValidation, AcceptsEachBoundAndRefusesTheNextFloatBeyondIt) {
  const auto schema = parameter_schema(ModelKind::tassa9);
  const float infinity = std::numeric_limits<float>::infinity();
  for (std::size_t i = 0; i < schema.size(); ++i) {
    for (const float beyond :
         {std::nextafter(schema[i].low, -infinity), std::nextafter(schema[i].high, infinity)}) {
      ModelParameters p = whole_sample();
      p.value[i] = beyond;
      const ImageVerdict verdict = validate(p);
      EXPECT_EQ(verdict.error, ImageError::out_of_range) << schema[i].name << " = " << beyond;
      EXPECT_EQ(verdict.parameter, i);
      EXPECT_EQ(verdict.value, beyond);
      EXPECT_EQ(verdict.low, schema[i].low);
      EXPECT_EQ(verdict.high, schema[i].high);
    }
    for (const float bound : {schema[i].low, schema[i].high}) {
      ModelParameters p = whole_sample();
      p.value[i] = bound;
      EXPECT_NE(validate(p).error, ImageError::out_of_range) << schema[i].name << " = " << bound;
    }
  }
}

TEST(ModelValidation, NamesTheParameterThatIsNotFinite) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    for (std::size_t i = 0; i < 13; ++i) {
      ModelParameters p = whole_sample();
      p.value[i] = bad;
      EXPECT_EQ(validate(p).error, ImageError::not_finite);
      EXPECT_EQ(validate(p).parameter, i);
    }
    ModelParameters p = tassa9_sample();
    p.fit_error_kPa = bad;
    EXPECT_EQ(validate(p).error, ImageError::not_finite);
    EXPECT_EQ(validate(p).parameter, kFitErrorField);
    p = tassa9_sample();
    p.fixed_error_kPa = bad;
    EXPECT_EQ(validate(p).error, ImageError::not_finite);
    EXPECT_EQ(validate(p).parameter, kFixedErrorField);
  }
}

TEST(ModelValidation, BlamesTheSupplyThatIsNotAboveAmbient) {
  ModelParameters p = tassa9_sample();
  p.value[kSupply] = 100.0F;
  p.value[kAmbient] = 100.0F;
  const ImageVerdict verdict = validate(p);
  EXPECT_EQ(verdict.error, ImageError::not_admissible);
  EXPECT_EQ(verdict.parameter, kSupply);
  EXPECT_EQ(verdict.low, 100.0F);
}

// c8 = 0.6: sqrt(1 - c8^2) = 0.8, so that c9 must exceed 0.2 c_gamma.
TEST(ModelValidation, BlamesALeakTooSmallForItsRateAsymmetry) {
  ModelParameters p = tassa9_sample();
  p.value[kC8] = 0.6F;
  p.value[kCGamma] = 0.5F;
  p.value[kC9] = 0.0999F;
  const ImageVerdict verdict = validate(p);
  EXPECT_EQ(verdict.error, ImageError::not_admissible);
  EXPECT_EQ(verdict.parameter, kC9);
  EXPECT_NEAR(verdict.low, 0.1F + kRateMargin_V, 1e-7F);
  p.value[kC9] = 0.1002F;
  EXPECT_TRUE(validate(p));
}

// c1 = 4 V: the farthest command is 6 V away, where c2 = 1.08 allows c3 down to -1.08 / 108 = -0.01.
TEST(ModelValidation, BlamesAKinkThatFoldsTheSteadyStateWithinTheCommandRange) {
  ModelParameters p = tassa9_sample();
  p.value[kC1] = 4.0F;
  p.value[kC2] = 1.08F;
  p.value[kC3] = -0.0101F;
  const ImageVerdict verdict = validate(p);
  EXPECT_EQ(verdict.error, ImageError::not_admissible);
  EXPECT_EQ(verdict.parameter, kC3);
  EXPECT_NEAR(verdict.low, -0.01F, 1e-8F);
  p.value[kC3] = -0.0099F;
  EXPECT_TRUE(validate(p));
}

// The paper's own bound c3 > -1 lets this set through, yet its s(u) falls.
TEST(ModelValidation, RefusesAFoldThatTheBoundOfTableOneLetsThrough) {
  ModelParameters p = tassa9_sample();
  p.value[kC2] = 1.0F;
  p.value[kC3] = -0.1F;
  const auto argument = [](float x) { return x - 0.1F * x * x * x; };
  ASSERT_LT(argument(3.0F), argument(2.0F));
  EXPECT_EQ(validate(p).parameter, kC3);
  EXPECT_EQ(validate(p).error, ImageError::not_admissible);
}

// Random sets around the joint bounds, judged by a scan of (9) and (10b) over the command range. A set that
// is refused is moved to the bound that the verdict names, so that the bound itself is what is scanned.
RC_GTEST_PROP(ModelValidation, AcceptedSetsHaveAPositiveRateAndARisingSteadyState, ()) {
  const auto within = [](double low, double high) {
    return static_cast<float>(low + (high - low) * *rc::gen::inRange(0, 1000001) / 1e6);
  };
  ModelParameters p = tassa9_sample();
  p.value[kC1] = within(2, 8);
  p.value[kC2] = within(1e-4, 5);
  p.value[kC3] = within(-0.1, 0.05);
  p.value[kC8] = within(-0.999, 0.999);
  p.value[kC9] = within(1e-5, 1);
  p.value[kCGamma] = within(0.001, 2);
  for (ImageVerdict verdict = validate(p); !verdict; verdict = validate(p)) {
    RC_ASSERT(verdict.error == ImageError::not_admissible);
    RC_ASSERT(p.value[verdict.parameter] < verdict.low);  // so each round makes progress
    p.value[verdict.parameter] = verdict.low;
  }
  const auto value = [&](std::size_t i) { return static_cast<double>(p.value[i]); };
  const double c1 = value(kC1), c2 = value(kC2), c3 = value(kC3);
  const double c8 = value(kC8), c9 = value(kC9), c_gamma = value(kCGamma);
  double before = -std::numeric_limits<double>::infinity();
  for (int i = 0; i <= 2000; ++i) {
    const double x = i * 0.005 - c1;
    const double k = std::sqrt(x * x + c_gamma * c_gamma) - c_gamma + c9 + c8 * x;
    RC_ASSERT(k > 0.0);
    const float xf = static_cast<float>(x);
    const float kf = std::sqrt(xf * xf + p.value[kCGamma] * p.value[kCGamma]) - p.value[kCGamma] +
                     p.value[kC9] + p.value[kC8] * xf;
    RC_ASSERT(kf > 0.0F);
    const double argument = c2 * x + c3 * x * x * x;
    RC_ASSERT(argument > before);
    before = argument;
  }
}

TEST(ImageErrors, AreEachDescribedInTheirOwnWords) {
  std::vector<std::string> seen;
  for (int e = 0; e <= static_cast<int>(ImageError::no_such_chamber); ++e) {
    const std::string text = describe(static_cast<ImageError>(e));
    EXPECT_EQ(std::count(seen.begin(), seen.end(), text), 0) << text;
    EXPECT_EQ(text.find("unknown reason"), std::string::npos) << e;
    seen.push_back(text);
  }
}

}  // namespace
}  // namespace plenum::config
