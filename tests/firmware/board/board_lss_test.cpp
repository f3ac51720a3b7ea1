// LSS (CiA 305) of a whole board: what is stored, and that no board that regulates loses its name.
#include <gtest/gtest.h>

#include "tests/firmware/board/bench.hpp"

namespace plenum {
namespace {

using config::LssSettings;

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
  /// Returns the error of the answer to "store configuration".
  int store_configuration() {
    take();
    ask({0x17});
    for (int i = 0; i < 100; ++i) {
      for (const ports::CanFrame& frame : take()) {
        if (frame.id == 0x7E4 && frame.data[0] == 0x17) return frame.data[1];
      }
      tick();
    }
    return -1;
  }
};

config::Slots with_models() {
  Bench bench;
  bench.store_models();
  return bench.store.durable;
}

TEST(BoardLss, WhatWasNotConfiguredKeepsItsStoredValue) {
  Named both;
  both.ask({0x04, 1});
  both.ask({0x11, 5});
  both.ask({0x13, 0, 3});
  ASSERT_EQ(both.store_configuration(), 0);

  Named id(both.store.durable);
  ASSERT_EQ(id.board.lss(), (LssSettings{.node_id = 5, .bit_rate_kbit = 250}));
  id.ask({0x04, 1});
  id.ask({0x11, 9});
  ASSERT_EQ(id.store_configuration(), 0);

  Named rate(id.store.durable);
  ASSERT_EQ(rate.board.lss(), (LssSettings{.node_id = 9, .bit_rate_kbit = 250}));
  rate.ask({0x04, 1});
  rate.ask({0x13, 0, 2});
  ASSERT_EQ(rate.store_configuration(), 0);

  Named nothing(rate.store.durable);
  ASSERT_EQ(nothing.board.lss(), (LssSettings{.node_id = 9, .bit_rate_kbit = 500}));
  nothing.ask({0x04, 1});
  ASSERT_EQ(nothing.store_configuration(), 0);
  EXPECT_EQ(Named(nothing.store.durable).board.lss(), (LssSettings{.node_id = 9, .bit_rate_kbit = 500}));
}

TEST(BoardLss, NodeIdThatIsTakenAwayIsForgottenInTheStoreToo) {
  Named board;
  board.ask({0x04, 1});
  board.ask({0x11, 9});
  ASSERT_EQ(board.store_configuration(), 0);
  board.ask({0x11, 255});
  ASSERT_EQ(board.store_configuration(), 0);
  EXPECT_EQ(Named(board.store.durable).board.lss().node_id, 0) << "the installer's counts";
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
