// What is written of a bus, and what of frames that were lost on the way.
#include "host-sim/client/bus_recorder.hpp"

#include <gtest/gtest.h>

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
