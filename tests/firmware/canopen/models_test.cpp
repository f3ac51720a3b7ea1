// Objects 2121h and 2128h: who uploads, and what has become of what was handed in.
#include <gtest/gtest.h>

#include <utility>

#include "firmware/config/model_image.hpp"
#include "tests/firmware/canopen/bench.hpp"

namespace plenum::canopen {
namespace {

TEST(UploadSessionObject, BelongsToOneTokenAtATime) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 40 21 21 01 00 00 00 00"), "585 43 21 21 01 00 00 00 00") << "nobody's";
  EXPECT_EQ(bench.answer("605 23 21 21 01 0A 0B 0C 0D"), "585 60 21 21 01 00 00 00 00");
  EXPECT_EQ(bench.answer("605 40 21 21 01 00 00 00 00"), "585 43 21 21 01 0A 0B 0C 0D");
  EXPECT_EQ(bench.answer("605 40 21 21 03 00 00 00 00"), "585 4B 21 21 03 98 3A 00 00") << "15000 ms";
  EXPECT_EQ(bench.answer("605 23 21 21 01 01 00 00 00"), "585 80 21 21 01 22 00 00 08") << "another's";
  EXPECT_EQ(bench.answer("605 23 21 21 02 01 00 00 00"), "585 80 21 21 02 22 00 00 08") << "another's";
  EXPECT_EQ(bench.answer("605 23 21 21 02 0A 0B 0C 0D"), "585 60 21 21 02 00 00 00 00");
  EXPECT_EQ(bench.answer("605 23 21 21 01 01 00 00 00"), "585 60 21 21 01 00 00 00 00");
}

TEST(UploadSessionObject, KnowsNoToken0) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 23 21 21 01 00 00 00 00"), "585 80 21 21 01 30 00 09 06");
}

TEST(StagedSetObject, HandsInWhatItTakesAndTellsTheOutcome) {
  for (const auto& [result, answer] :
       {std::pair{config::SetHandIn::taken, "585 20 00 00 00 00 00 00 00"},
        std::pair{config::SetHandIn::malformed, "585 80 22 21 01 10 00 07 06"},
        std::pair{config::SetHandIn::not_now, "585 80 22 21 01 22 00 00 08"}}) {
    Bench bench;
    bench.desk.hand_in_result = result;
    ASSERT_EQ(bench.answer("605 21 22 21 01 05 00 00 00"), "585 60 22 21 01 00 00 00 00");
    EXPECT_EQ(bench.answer("605 05 01 02 03 04 05 00 00"), answer);
    EXPECT_EQ(bench.desk.handed_in, (std::vector<std::uint8_t>{1, 2, 3, 4, 5}));
  }
  Bench bench;
  EXPECT_EQ(bench.answer("605 40 22 21 02 00 00 00 00"), "585 4F 22 21 02 00 00 00 00");
  bench.desk.progress = {.staging = true, .refused = 0};
  EXPECT_EQ(bench.answer("605 40 22 21 02 00 00 00 00"), "585 4F 22 21 02 FF 00 00 00");
  bench.desk.progress = {.staging = false, .refused = 8};
  EXPECT_EQ(bench.answer("605 40 22 21 02 00 00 00 00"), "585 4F 22 21 02 08 00 00 00");
}

// 1313 bytes are 05 21h: eight of the largest images and the mask.
TEST(StagedSetObject, TakesEightOfTheLargestImagesAndNoByteMore) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 C2 22 21 01 22 05 00 00"), "585 80 22 21 01 12 00 07 06");
  EXPECT_EQ(bench.answer("605 C2 22 21 01 21 05 00 00"), "585 A4 22 21 01 7F 00 00 00");
}

TEST(ModelParameters, AreThoseOfTheImageInForce) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 40 43 21 01 00 00 00 00"), "585 80 43 21 01 24 00 00 08") << "no model";
  config::ModelParameters model{.kind = config::ModelKind::tassa9r, .fixed_error_kPa = 0.5F};
  model.count = static_cast<std::uint16_t>(config::parameter_schema(model.kind).size());
  for (std::size_t k = 0; k < model.count; ++k) model.value[k] = static_cast<float>(k + 1);
  std::vector<std::uint8_t> image(config::kMaxImageBytes);
  image.resize(config::encode(model, image));
  bench.desk.active[3] = image;
  EXPECT_EQ(bench.answer("605 40 43 21 00 00 00 00 00"), "585 4F 43 21 00 20 00 00 00");
  EXPECT_EQ(bench.answer("605 40 43 21 01 00 00 00 00"), "585 43 43 21 01 00 00 80 3F") << "1.0";
  EXPECT_EQ(bench.answer("605 40 43 21 02 00 00 00 00"), "585 43 43 21 02 00 00 00 40") << "2.0";
  ASSERT_EQ(model.count, 12U);
  EXPECT_EQ(bench.answer("605 40 43 21 0C 00 00 00 00"), "585 43 43 21 0C 00 00 40 41") << "12.0, the last";
  EXPECT_EQ(bench.answer("605 40 43 21 0D 00 00 00 00"), "585 80 43 21 0D 24 00 00 08")
      << "the CRC is no parameter";
  EXPECT_EQ(bench.answer("605 40 44 21 01 00 00 00 00"), "585 80 44 21 01 24 00 00 08")
      << "another chamber's";
}

TEST(SetState, ShowsTheShadowRunInPascal) {
  Bench bench;  // worse, 3.5 kPa and 1.25 kPa: 3500.0 = 455AC000h, 1250.0 = 449C4000h
  EXPECT_EQ(bench.answer("605 40 2A 21 09 00 00 00 00"), "585 4F 2A 21 09 04 00 00 00");
  EXPECT_EQ(bench.answer("605 40 2A 21 0A 00 00 00 00"), "585 43 2A 21 0A 00 C0 5A 45");
  EXPECT_EQ(bench.answer("605 40 2A 21 0B 00 00 00 00"), "585 43 2A 21 0B 00 40 9C 44");
}

TEST(SetState, ShowsTheStagedCrcAndTheSerialExpected) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 40 2A 21 0C 00 00 00 00"), "585 43 2A 21 0C 88 77 66 55");
  EXPECT_EQ(bench.answer("605 40 2A 21 0D 00 00 00 00"), "585 43 2A 21 0D 67 12 00 00") << "4711";
}

// 430 kPa, 120 mL, 5.5 V, asked for 450 kPa, came 437.5 kPa: 430000.0 = 48D1F600h, 120e-6 = 38FBA882h, 5.5 = 40B00000h,
// 450000.0 = 48DBBA00h, 437500.0 = 48D59F80h
TEST(SetState, ShowsThePointAtWhichAModelFailsInPascalAndCubicMetres) {
  Bench bench;
  EXPECT_EQ(bench.answer("605 40 2A 21 0E 00 00 00 00"), "585 43 2A 21 0E 00 F6 D1 48");
  EXPECT_EQ(bench.answer("605 40 2A 21 0F 00 00 00 00"), "585 43 2A 21 0F 82 A8 FB 38");
  EXPECT_EQ(bench.answer("605 40 2A 21 10 00 00 00 00"), "585 43 2A 21 10 00 00 B0 40");
  EXPECT_EQ(bench.answer("605 40 2A 21 11 00 00 00 00"), "585 43 2A 21 11 00 BA DB 48");
  EXPECT_EQ(bench.answer("605 40 2A 21 12 00 00 00 00"), "585 43 2A 21 12 80 9F D5 48");
}

struct Answer {
  config::CommitResult result;
  const char* expected;
};

TEST(CommitObject, TellsWhatHasToWaitFromWhatIsRefusedAndUsesUpMaskAndCrcOfTheLatterAlone) {
  constexpr const char* kNotYet = "585 80 20 21 03 22 00 00 08";
  constexpr const char* kRefused = "585 80 20 21 03 20 00 00 08";
  for (const Answer& answer :
       {Answer{config::CommitResult::checking, kNotYet}, Answer{config::CommitResult::not_now, kNotYet},
        Answer{config::CommitResult::doubted, kRefused},
        Answer{config::CommitResult::nothing_staged, kRefused}}) {
    Bench bench;
    bench.desk.held_back = answer.result;
    bench.answer("605 2F 20 21 01 01 00 00 00");
    EXPECT_EQ(bench.answer("605 23 20 21 03 63 6F 6D 74"), answer.expected);
    EXPECT_EQ(bench.answer("605 40 20 21 01 00 00 00 00"), std::string_view(answer.expected) == kNotYet
                                                               ? "585 4F 20 21 01 01 00 00 00"
                                                               : "585 4F 20 21 01 00 00 00 00");
  }
}

TEST(CommitObject, TakesTheKeyAloneOnceItMay) {
  Bench bench;
  bench.desk.staged[0] = {1, 2, 3, 4};
  const std::uint32_t crc = config::commit_crc(std::array{config::trailing_crc(bench.desk.staged[0])});
  bench.answer("605 2F 20 21 01 01 00 00 00");
  bench.answer(text_of(
      {.id = 0x605,
       .length = 8,
       .data = {0x23, 0x20, 0x21, 2, static_cast<std::uint8_t>(crc), static_cast<std::uint8_t>(crc >> 8),
                static_cast<std::uint8_t>(crc >> 16), static_cast<std::uint8_t>(crc >> 24)}}));
  bench.desk.held_back = config::CommitResult::checking;
  EXPECT_EQ(bench.answer("605 23 20 21 03 63 6F 6D 74"), "585 80 20 21 03 22 00 00 08");
  bench.desk.held_back = config::CommitResult::accepted;
  EXPECT_EQ(bench.answer("605 23 20 21 03 63 6F 6D 74"), "585 60 20 21 03 00 00 00 00");
  EXPECT_EQ(bench.desk.commits, 1);
}

}  // namespace
}  // namespace plenum::canopen
