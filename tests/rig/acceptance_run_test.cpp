// What an acceptance tells of a stream from which a bus loses frames.
#include "host-sim/tools/acceptance_run.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <utility>

#include "host-sim/client/session.hpp"
#include "host-sim/client/stream.hpp"
#include "host-sim/rig/standard_rigs.hpp"
#include "host-sim/tools/rig_link.hpp"

namespace plenum::host::rig {
namespace {

using client::CanFrame;

/// Loses frames of the stream.
class LossyLink final : public client::Link {
 public:
  using Lost = std::function<bool(const CanFrame&)>;

  LossyLink(client::Link& link, Lost lost) : link_(link), lost_(std::move(lost)) {}

  void send(const CanFrame& frame) override { link_.send(frame); }
  std::optional<CanFrame> receive(double timeout_s) override {
    for (const double end_s = now_s() + timeout_s;;) {
      const double left_s = end_s - now_s();
      const auto frame = link_.receive(left_s > 0.0 ? left_s : 0.0);
      if (!frame || !client::stream_block(*frame) || !lost_(*frame)) return frame;
    }
  }
  double now_s() const override { return link_.now_s(); }

 private:
  client::Link& link_;
  Lost lost_;
};

tools::AcceptanceRun run_with(unsigned chambers, LossyLink::Lost lost) {
  Rig rig(mpye_rig({.chambers = chambers}));
  tools::RigLink direct(rig);
  LossyLink lossy(direct, std::move(lost));
  tools::MeteredLink link(lossy);
  client::Session session(link, 1);
  return tools::run_acceptance(link, session, {.seconds = 2.0, .chambers = chambers, .motion = {}},
                               [](double) {});
}

/// Of two seconds at 100 Hz every second row; the stream may be cut anywhere.
constexpr double kHalf = 100.0;
constexpr double kCut = 3.0;

TEST(AcceptanceRun, NoRowIsLostOfAStreamThatComesWhole) {
  for (const unsigned chambers : {1U, 3U, 8U}) {
    const tools::AcceptanceRun run = run_with(chambers, [](const CanFrame&) { return false; });
    EXPECT_EQ(run.rows_lost, 0U) << chambers << " chambers";
    EXPECT_NEAR(static_cast<double>(run.rows), 2.0 * kHalf, kCut);
  }
}

TEST(AcceptanceRun, ATickOfWhichNothingCameIsARowLost) {
  for (const unsigned chambers : {1U, 3U}) {
    std::uint32_t frames = 0;
    const tools::AcceptanceRun run =
        run_with(chambers, [&](const CanFrame&) { return frames++ / chambers % 2 == 1; });
    EXPECT_NEAR(static_cast<double>(run.rows_lost), kHalf, kCut) << chambers << " chambers";
    EXPECT_NEAR(static_cast<double>(run.rows), kHalf, kCut);
  }
}

TEST(AcceptanceRun, TwoHalvesThatMakeARowOfTwoTicksAreARowLost) {
  std::uint32_t frames = 0;  // the second of a tick, and the first of the next
  const tools::AcceptanceRun run = run_with(2, [&](const CanFrame&) {
    const std::uint32_t at = frames++ % 4;
    return at == 1 || at == 2;
  });
  EXPECT_NEAR(static_cast<double>(run.rows_lost), kHalf, kCut);
}

TEST(AcceptanceRun, ATickOfWhichSomeCameIsOneRowLostAndNotTwo) {
  std::uint32_t frames = 0;
  const tools::AcceptanceRun run = run_with(2, [&](const CanFrame&) { return frames++ % 4 == 1; });
  EXPECT_NEAR(static_cast<double>(run.rows_lost), kHalf, kCut);
}

}  // namespace
}  // namespace plenum::host::rig
