// Instructions of one tick of the controller with 8 chambers regulating, counted by callgrind (tick.py runs
// it).
//
// One tick is Controller::step: monitors, volume and pressure observers, two model inversions a chamber, the
// supervisor and the node's tick with the TPDOs of the process data and of the capture stream due. The
// eight chambers are alike, drawn at random (tests/cost/chambers_alike.hpp).
//
// usage: plenum_tick_bench [KIND]    KIND: tassa9 (default), tassa9r or greybox: the kind of all eight models
//
// A second count takes in the frames of that tick: SYNC, two PDOs of set points received, and what is sent.
#include <valgrind/callgrind.h>

#include <cstdio>
#include <memory>
#include <random>
#include <string_view>

#include "tests/cost/chambers_alike.hpp"

namespace {

using namespace plenum;

constexpr int kEpisodes = 150;  ///< one model each
constexpr int kTicks = 20;      ///< of an episode

/// Ticks that did not regulate, and models that were refused.
struct Void {
  int ticks = 0;
  int models = 0;
};

void counted_tick(cost::ChambersAlike<std::mt19937>& chambers) {
  Controller& controller = chambers.controller();
  const std::array<ports::CanFrame, 3> setpoints = chambers.setpoints();
  const Inputs inputs = chambers.inputs();
  CALLGRIND_TOGGLE_COLLECT;
  for (const ports::CanFrame& frame : setpoints) controller.receive(frame);
  CALLGRIND_DUMP_STATS_AT("receive");
  controller.step(inputs);
  CALLGRIND_DUMP_STATS_AT("step");
  ports::CanFrame frame;
  while (controller.next_frame(frame)) {
  }
  CALLGRIND_TOGGLE_COLLECT;
  CALLGRIND_DUMP_STATS_AT("send");
}

void episode(std::mt19937& random, config::ModelKind kind, Void& missed) {
  const auto chambers =
      std::make_unique<cost::ChambersAlike<std::mt19937>>(random, cost::draw_subject(random, kind));
  chambers->go_active();
  for (int k = 0; k < kTicks; ++k) {
    chambers->next_scene();
    counted_tick(*chambers);
    if (!chambers->regulates()) ++missed.ticks;
  }
  missed.models += chambers->refused();
}

}  // namespace

int main(int count, char** words) {
  const std::string_view name = count > 1 ? words[1] : "tassa9";
  const config::ModelKind kind = control::testing::kind_named(name);
  if (kind == config::ModelKind::none) {
    std::fprintf(stderr, "%s: expected tassa9, tassa9r or greybox\n", words[1]);
    return 2;
  }
  std::mt19937 random(2024);
  Void missed;
  for (int i = 0; i < kEpisodes; ++i) episode(random, kind, missed);
  if (missed.ticks == 0 && missed.models == 0) return 0;
  std::fprintf(stderr, "%d of %d ticks did not regulate, %d models were refused; the count is void\n",
               missed.ticks, kEpisodes * kTicks, missed.models);
  return 1;
}
