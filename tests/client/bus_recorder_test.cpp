// What is written of a bus, and what of frames that were lost on the way.
#include "host-sim/client/bus_recorder.hpp"

#include <gtest/gtest.h>

#include <array>
#include <deque>
#include <sstream>

#include "tests/firmware/canopen/bench.hpp"

namespace plenum::host::client {
namespace {

/// A frame each millisecond, before which some may have been lost.
class LosingLink final : public Link {
 public:
  explicit LosingLink(std::deque<std::uint64_t> lost_before) : lost_before_(std::move(lost_before)) {}
  void send(const CanFrame&) override {}
  std::optional<CanFrame> receive(double) override {
    if (lost_before_.empty()) return std::nullopt;
    lost_ += lost_before_.front();
    lost_before_.pop_front();
    now_s_ += 1e-3;
    return canopen::frame_from("705 7F");
  }
  double now_s() const override { return now_s_; }
  std::uint64_t lost() const override { return lost_; }

 private:
  std::deque<std::uint64_t> lost_before_;
  std::uint64_t lost_ = 0;
  double now_s_ = 100.0;
};

TEST(BusRecorder, WritesWhatComesAndMarksWhereFramesAreMissing) {
  LosingLink link({0, 3, 0, 2});
  std::ostringstream log;
  BusRecorder recorder(link, log, "can0", 1'700'000'000'000'000);
  while (recorder.take(0.0)) continue;
  EXPECT_EQ(log.str(),
            "(1700000000.001000) can0 705#7F\n"
            "(1700000000.002000) can0 20000004#0001000000000000\n"
            "(1700000000.002000) can0 705#7F\n"
            "(1700000000.003000) can0 705#7F\n"
            "(1700000000.004000) can0 20000004#0001000000000000\n"
            "(1700000000.004000) can0 705#7F\n");
  EXPECT_EQ(recorder.frames(), 4U);
  EXPECT_EQ(recorder.lost(), 5U);
  ASSERT_EQ(recorder.gaps().size(), 2U);
  EXPECT_EQ(recorder.gaps()[0].before_frame, 1U);
  EXPECT_NEAR(recorder.gaps()[0].time_s, 0.002, 1e-9);
  EXPECT_EQ(recorder.gaps()[0].lost, 3U);
  EXPECT_EQ(recorder.gaps()[1].before_frame, 3U);
  EXPECT_EQ(recorder.gaps()[1].lost, 2U);
}

/// Frames that lay where they wait for ten seconds, and one of which nobody knows when it came.
class StampingLink final : public Link {
 public:
  void send(const CanFrame&) override {}
  std::optional<CanFrame> receive(double) override {
    if (taken_ == stamps_us_.size()) return std::nullopt;
    stamp_us_ = stamps_us_[taken_++];
    return canopen::frame_from("705 7F");
  }
  double now_s() const override { return 10.0; }
  std::optional<std::uint64_t> stamp_us() const override { return stamp_us_; }

 private:
  std::array<std::optional<std::uint64_t>, 3> stamps_us_ = {1'600'000'000'000'250, 1'600'000'000'010'251,
                                                            std::nullopt};
  std::size_t taken_ = 0;
  std::optional<std::uint64_t> stamp_us_;
};

TEST(BusRecorder, AFrameHasTheTimeAtWhichItWasOnTheBusAndNotAtWhichItWasTaken) {
  StampingLink link;
  std::ostringstream log;
  BusRecorder recorder(link, log, "can0", 1'700'000'000'000'000);
  while (recorder.take(0.0)) continue;
  EXPECT_EQ(log.str(),
            "(1600000000.000250) can0 705#7F\n"
            "(1600000000.010251) can0 705#7F\n"
            "(1700000000.000000) can0 705#7F\n");
}

TEST(BusRecorder, HasNoGapWhereNothingIsLost) {
  LosingLink link({0, 0, 0});
  std::ostringstream log;
  BusRecorder recorder(link, log, "can0", 0);
  while (recorder.take(0.0)) continue;
  EXPECT_EQ(recorder.frames(), 3U);
  EXPECT_TRUE(recorder.gaps().empty());
  EXPECT_EQ(log.str().find("20000004"), std::string::npos);
}

}  // namespace
}  // namespace plenum::host::client
