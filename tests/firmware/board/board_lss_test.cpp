// LSS (CiA 305) of a whole board: none that regulates loses its name.
#include <gtest/gtest.h>

#include "tests/firmware/board/bench.hpp"

namespace plenum {
namespace {

struct Named : Bench {
  explicit Named(const config::Slots& slots = config::PowerCutMedium::blank()) {
    store = config::PowerCutMedium(slots);
    board.start();
    storing = true;
    tick();
    take();
  }
  /// To HOLD, with models.
  void hold() {
    put(0, {1, 0});
    tick();
    climb();
    streaming = false;
    control(0x3);
    run(3);
  }
  void ask(std::initializer_list<std::uint8_t> head) {
    std::vector<std::uint8_t> data(head);
    data.resize(8);
    put(0x7E5, data);
    tick();
  }
};

config::Slots with_models() {
  Bench bench;
  bench.store_models();
  return bench.store.durable;
}

TEST(BoardLss, BoardThatHoldsItsPressureKeepsItsNameAndItsEars) {
  Named board(with_models());
  board.hold();
  board.put(0, {0x80, 0});
  board.run(2);
  ASSERT_EQ(board.state(), safety::State::hold) << "in PRE-OPERATIONAL";
  board.ask({0x04, 1});
  board.ask({0x11, 255});
  board.put(0, {0x82, 0});
  board.run(3);
  EXPECT_EQ(board.board.controller().node().node_id(), Bench::kNode);
  board.session.write<std::uint16_t>(canopen::object::kControlWord, 0, 0);
  board.run(2);
  EXPECT_EQ(board.state(), safety::State::init) << "it still hears";
}

TEST(BoardLss, IdThatWasGivenBeforeTheBoardRegulatesEndsTheRegulationWhenItComesIntoForce) {
  Named board(with_models());
  board.ask({0x04, 1});
  board.ask({0x11, 255});
  board.hold();
  ASSERT_EQ(board.state(), safety::State::hold);
  board.put(0, {0x82, 0});
  board.run(2);
  EXPECT_EQ(board.state(), safety::State::init);
  EXPECT_EQ(board.image().error_code, 0);
}

}  // namespace
}  // namespace plenum
