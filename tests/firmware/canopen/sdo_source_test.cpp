// Where uploads come from: streams of known and of unknown size, read forward, and again where they are repeated.
#include <gtest/gtest.h>

#include "firmware/canopen/sdo_source.hpp"
#include "tests/firmware/canopen/bench.hpp"

namespace plenum::canopen {
namespace {

std::size_t stream_holds = 0;           ///< bytes 0, 1, 2, ... that the stream has
std::uint32_t stream_tells = 0;         ///< the size it tells
std::vector<std::uint32_t> asked_from;  ///< offsets at which it was read

std::size_t read(Device&, Place, std::uint32_t offset, std::span<std::uint8_t> bytes) noexcept {
  asked_from.push_back(offset);
  std::size_t count = 0;
  while (count < bytes.size() && offset + count < stream_holds) {
    bytes[count] = static_cast<std::uint8_t>(offset + count);
    ++count;
  }
  return count;
}

std::uint32_t tell(const Device&, Place) noexcept {
  return stream_tells;
}

struct SourceBench {
  Config config;
  ProcessImage image;
  FakeDesk desk;
  config::SettingsDesk settings;
  telemetry::Recorder recorder;
  DataSheet sheet{config.identity, {}, desk, recorder};
  Device device{config, image, desk, settings, recorder, sheet, {}, {}, {}, {}};
  Entry entry;
  std::array<std::uint8_t, 8> room{};
  SdoSource source;

  SourceBench() {
    entry.type = DataType::domain;
    entry.read_stream = read;
    entry.stream_size = tell;
  }
  Abort open(std::size_t holds, std::uint32_t tells) {
    stream_holds = holds;
    stream_tells = tells;
    asked_from.clear();
    return source.open(device, {.entry = &entry}, room);
  }
  /// Reads to the end; returns the lengths of the segments, and fails when a byte is wrong.
  std::vector<std::size_t> lengths() {
    std::vector<std::size_t> lengths;
    do {
      std::array<std::uint8_t, kSegmentBytes> segment{};
      const std::uint32_t from = source.position();
      lengths.push_back(source.next(device, segment));
      for (std::size_t i = 0; i < lengths.back(); ++i)
        EXPECT_EQ(segment[i], static_cast<std::uint8_t>(from + i));
    } while (!source.at_end() && lengths.size() < 100);
    return lengths;
  }
};

using Lengths = std::vector<std::size_t>;

TEST(SdoSource, FindsTheLastSegmentOfAStreamWhetherItsSizeIsKnownOrNot) {
  for (const bool known : {false, true}) {
    for (const auto& [size, lengths] : {std::pair<std::uint32_t, Lengths>{1, {1}},
                                        {7, {7}},
                                        {8, {7, 1}},
                                        {14, {7, 7}},
                                        {20, {7, 7, 6}},
                                        {21, {7, 7, 7}}}) {
      SourceBench bench;
      EXPECT_EQ(bench.open(size, known ? size : 0), Abort::none);
      EXPECT_EQ(bench.source.size(), known ? size : 0);
      EXPECT_EQ(bench.lengths(), lengths) << size;
      EXPECT_FALSE(bench.source.is_short());
    }
  }
}

TEST(SdoSource, ReadsAStreamForward) {
  SourceBench bench;
  bench.open(700, 0);
  bench.lengths();
  EXPECT_TRUE(std::is_sorted(asked_from.begin(), asked_from.end()));
}

TEST(SdoSource, ReadsAgainWhereItIsSetBack) {
  SourceBench bench;
  bench.open(20, 0);
  EXPECT_EQ(bench.lengths(), (Lengths{7, 7, 6}));
  bench.source.seek(7);
  EXPECT_EQ(bench.lengths(), (Lengths{7, 6}));
}

TEST(SdoSource, OfNothingHasNoData) {
  SourceBench bench;
  EXPECT_EQ(bench.open(0, 0), Abort::no_data);
}

TEST(SdoSource, SeesAStreamThatEndsBeforeItsSize) {
  SourceBench bench;
  bench.open(10, 14);
  EXPECT_EQ(bench.lengths(), (Lengths{7, 3}));
  EXPECT_TRUE(bench.source.is_short());
}

TEST(SdoSource, SendsNoMoreOfAStreamThanItsSize) {
  SourceBench bench;
  bench.open(100, 10);
  EXPECT_EQ(bench.lengths(), (Lengths{7, 3}));
  EXPECT_FALSE(bench.source.is_short());
}

}  // namespace
}  // namespace plenum::canopen
