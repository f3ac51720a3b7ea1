// Random frames: whatever comes, the process image changes by good frames only and the node keeps speaking.
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "tests/firmware/canopen/bench.hpp"

namespace plenum::canopen {
namespace {

using ports::CanFrame;

CanFrame any_frame() {
  CanFrame frame;
  frame.extended = *rc::gen::weightedElement<bool>({{9, false}, {1, true}});
  frame.remote = *rc::gen::weightedElement<bool>({{9, false}, {1, true}});
  frame.id = *rc::gen::oneOf(
      rc::gen::element<std::uint32_t>(0x000, 0x080, 0x205, 0x305, 0x405, 0x505, 0x605, 0x585, 0x705),
      rc::gen::inRange<std::uint32_t>(0, 0x800));
  frame.length = *rc::gen::inRange<std::uint8_t>(0, 9);
  for (std::size_t i = 0; i < frame.length; ++i) frame.data[i] = *rc::gen::arbitrary<std::uint8_t>();
  return frame;
}

/// A frame that a node which is operational may act upon.
bool is_good(const CanFrame& frame) {
  if (frame.extended || frame.remote) return false;
  switch (frame.id) {
    case 0x000:
      return frame.length == 2;
    case 0x080:
      return frame.length <= 1;  // a SYNC, empty or with its counter
    case 0x205:
    case 0x305:
    case 0x605:
      return frame.length == 8;
    case 0x405:
      return frame.length >= 2;  // of a longer one the beginning
    default:
      return false;
  }
}

RC_GTEST_PROP(FrameStorm, OfBadFramesChangesNothing, ()) {
  Bench bench(true);
  bench.send("405 03 00");
  bench.image.chamber[3].setpoint_Pa = numeric::Scalar(123456);
  const ProcessImage before = bench.image;
  const int count = *rc::gen::inRange(1, 100);
  for (int i = 0; i < count; ++i) {
    CanFrame frame = any_frame();
    // too short by one, the control word to one byte, and a SYNC, which may be empty, too long
    if (is_good(frame)) {
      frame.length = frame.id == 0x080   ? 2
                     : frame.id == 0x405 ? 1
                                         : static_cast<std::uint8_t>(frame.length - 1);
    }
    bench.node.receive(frame);
    if (i % 7 == 0) bench.tick();
    bench.drain();
  }
  bench.image.pdo_short = bench.image.pdo_long = bench.image.sync_misfits = false;  // it may say so
  RC_ASSERT(bench.image == before);
  RC_ASSERT(bench.node.state() == NmtState::operational);
}

RC_GTEST_PROP(FrameStorm, OfAnyFramesLeavesEveryValueAdmissibleAndTheQueueAlive, ()) {
  Bench bench(*rc::gen::arbitrary<bool>());
  const int count = *rc::gen::inRange(1, 300);
  for (int i = 0; i < count; ++i) {
    CanFrame frame = any_frame();
    if (*rc::gen::arbitrary<bool>() && frame.id == 0x605) {  // requests that get further
      frame = frame_from("605 00 00 00 00 00 00 00 00");
      frame.data[0] = *rc::gen::element<std::uint8_t>(0x23, 0x2B, 0x2F, 0x22, 0x21, 0x20, 0x40, 0x00, 0x10,
                                                      0x01, 0x11, 0x60, 0x70, 0x80, 0xC0);
      const Entry& entry =
          *rc::gen::elementOf(std::vector<Entry>(object_dictionary().begin(), object_dictionary().end()));
      frame.data[1] = static_cast<std::uint8_t>(entry.index);
      frame.data[2] = static_cast<std::uint8_t>(entry.index >> 8);
      frame.data[3] = entry.sub;
      for (std::size_t b = 4; b < 8; ++b) frame.data[b] = *rc::gen::arbitrary<std::uint8_t>();
    }
    bench.node.receive(frame);
    if (i % 5 == 0) bench.tick();
  }
  for (const ChamberImage& chamber : bench.image.chamber) {
    RC_ASSERT(chamber.setpoint_Pa.value() >= kSetpointLow_Pa);
    RC_ASSERT(chamber.setpoint_Pa.value() <= kSetpointHigh_Pa);
    RC_ASSERT(chamber.hold_setpoint_Pa.value() >= kSetpointLow_Pa);
    RC_ASSERT(chamber.hold_setpoint_Pa.value() <= kSetpointHigh_Pa);
    RC_ASSERT(chamber.actual_Pa == 0.0F);
    RC_ASSERT(chamber.excitation.command_low_V >= 0.0F);
    RC_ASSERT(chamber.excitation.command_high_V <= 10.0F);
    RC_ASSERT(std::isfinite(chamber.excitation.pressure_low_Pa));
  }

  // it still takes a command, reports an error and answers
  bench.drain();
  bench.send("000 82 05");
  bench.tick();
  RC_ASSERT(bench.drain() == Frames{"705 00"});
  bench.image.error_code = 0x5000;
  bench.image.error_register = 0;
  bench.image.fault_chamber = 0;
  bench.tick();
  RC_ASSERT(bench.drain() == Frames{"085 00 50 01 00 00 00 00 00"});
  RC_ASSERT(bench.answer("605 40 00 10 00 00 00 00 00") == "585 43 00 10 00 98 01 FF FF");
}

}  // namespace
}  // namespace plenum::canopen
