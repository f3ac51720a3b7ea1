// The server by its bytes: clients are plain sockets, the bus runs in virtual time, one thread.
#include "host-sim/ports/socketcand_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <memory>

#include "host-sim/wire/tcp.hpp"

namespace plenum::host::ports {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

CanFrame frame_of(std::uint32_t id, std::vector<std::uint8_t> bytes, bool extended = false) {
  CanFrame frame{.id = id, .length = static_cast<std::uint8_t>(bytes.size()), .extended = extended};
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  return frame;
}

class SocketcandServerTest : public ::testing::Test {
 protected:
  class Client {
   public:
    explicit Client(SocketcandServerTest& test)
        : test_(test), socket_(wire::connect_tcp("127.0.0.1", test.server_.port(), 5.0)) {}

    void say(std::string_view bytes) {
      ASSERT_EQ(::send(socket_.number(), bytes.data(), bytes.size(), MSG_NOSIGNAL),
                static_cast<ssize_t>(bytes.size()));
    }
    /// Lets the server work until so many bytes came; what came, also beyond.
    std::string hear(std::size_t size) {
      std::string heard;
      for (int k = 0; k < 1000 && heard.size() < size; ++k) {
        test_.server_.exchange();
        std::array<char, 4096> bytes;
        pollfd waiting{socket_.number(), POLLIN, 0};
        ::poll(&waiting, 1, 5);
        const ssize_t count = ::recv(socket_.number(), bytes.data(), bytes.size(), MSG_DONTWAIT);
        if (count > 0) heard.append(bytes.data(), static_cast<std::size_t>(count));
        if (count == 0) break;
      }
      return heard;
    }
    void expect(const std::string& bytes) { EXPECT_EQ(hear(bytes.size()), bytes); }
    void ask(const std::string& question, const std::string& answer) {
      say(question);
      expect(answer);
    }
    void open_raw() {
      expect("< hi >");
      ask("< open can0 >", "< ok >");
      ask("< rawmode >", "< ok >");
      ask("< echo >", "< echo >");  // who speaks has read that, and need not be waited for
    }
    bool hung_up() {
      std::array<char, 64> bytes;
      for (int k = 0; k < 1000; ++k) {
        test_.server_.exchange();
        pollfd waiting{socket_.number(), POLLIN, 0};
        ::poll(&waiting, 1, 5);
        if (::recv(socket_.number(), bytes.data(), bytes.size(), MSG_DONTWAIT) == 0) return true;
      }
      return false;
    }
    void hang_up() { socket_ = wire::FileDescriptor(); }

   private:
    SocketcandServerTest& test_;
    wire::FileDescriptor socket_;
  };

  /// Until the server has seen what clients wrote.
  template <class Done>
  void exchange_until(Done&& done) {
    for (int k = 0; k < 1000 && !done(); ++k) {
      server_.wait(0.005);
      server_.exchange();
    }
  }
  void run(std::uint64_t for_ns) {
    const std::uint64_t until_ns = bus_.now_ns() + for_ns;
    while (bus_.run_to_next_delivery(until_ns)) server_.collect(bus_.now_ns() / 1000);
  }
  std::vector<CanFrame> board_heard() {
    std::vector<CanFrame> frames;
    for (CanFrame frame; board_.receive(frame);) frames.push_back(frame);
    return frames;
  }

  SimulatedBus bus_;
  SimulatedCanPort& board_ = bus_.attach("board");
  std::vector<std::string> told_;
  SocketcandServer server_{bus_, "127.0.0.1", 0, "can0",
                           [this](const std::string& line) { told_.push_back(line); }};
};

TEST_F(SocketcandServerTest, AClientIsGreetedAndSwitchedToRawMode) {
  Client client(*this);
  client.open_raw();
  client.ask("< echo >", "< echo >");
  EXPECT_EQ(server_.counters().clients, 1U);
  EXPECT_THAT(told_, Contains("client 1 has joined"));
}

TEST_F(SocketcandServerTest, NoFrameFollowsTheAnswerToAModeInOnePiece) {
  Client client(*this);
  client.expect("< hi >");
  client.ask("< open can0 >", "< ok >");
  client.say("< rawmode >");
  server_.wait(1.0);
  server_.exchange();  // it is answered, and a frame comes before the answer is read
  board_.send(frame_of(0x181, {1}));
  run(1'000'000);
  EXPECT_EQ(client.hear(1), "< ok >");
  server_.wait(0.02);  // now frames may follow, but none overtakes those that waited
  board_.send(frame_of(0x182, {2}));
  run(1'000'000);
  const std::string heard = client.hear(40);
  EXPECT_THAT(heard, HasSubstr("< frame 181 ")) << "none is lost";
  EXPECT_LT(heard.find("< frame 181 "), heard.find("< frame 182 "));
}

TEST_F(SocketcandServerTest, AFrameOfABoardReachesEveryClientWithTheTimeOfItsDelivery) {
  Client first(*this);
  Client second(*this);
  first.open_raw();
  second.open_raw();
  run(2'000'000'000);
  board_.send(frame_of(0x181, {0x01, 0xAB}));
  run(1'000'000);
  const std::string us = std::to_string((bus_.last_delivery().end_ns - 2'000'000'000) / 1000);
  const std::string expected = "\n< frame 181 2.0000" + us + " 01AB >";
  first.expect(expected);
  second.expect(expected);
}

TEST_F(SocketcandServerTest, AFrameOfAClientReachesTheBoardsAndTheOtherClientsAndNotItself) {
  Client first(*this);
  Client second(*this);
  first.open_raw();
  second.open_raw();
  first.say("< send 601 8 40 0 10 0 0 0 0 0 >");
  exchange_until([&] { return server_.counters().frames_taken == 1; });
  EXPECT_TRUE(board_heard().empty()) << "before its time on the wire";
  run(1'000'000);
  EXPECT_THAT(board_heard(), ::testing::ElementsAre(frame_of(0x601, {0x40, 0, 0x10, 0, 0, 0, 0, 0})));
  EXPECT_THAT(second.hear(1), HasSubstr("< frame 601 0.000"));
  first.ask("< echo >", "< echo >");
}

TEST_F(SocketcandServerTest, ExtendedIdentifiersKeepTheirKindBothWays) {
  Client client(*this);
  client.open_raw();
  client.say("< send 00000012 0 >");
  exchange_until([&] { return server_.counters().frames_taken == 1; });
  run(1'000'000);
  EXPECT_THAT(board_heard(), ::testing::ElementsAre(frame_of(0x12, {}, true)));
  board_.send(frame_of(0x12, {7}, true));
  run(1'000'000);
  EXPECT_THAT(client.hear(1), HasSubstr("< frame 00000012 0.0"));
}

TEST_F(SocketcandServerTest, RemoteFramesHaveNoMessageAndAreNotHandedOn) {
  Client client(*this);
  client.open_raw();
  board_.send({.id = 0x701, .remote = true});
  board_.send(frame_of(0x702, {}));
  run(1'000'000);
  EXPECT_THAT(client.hear(1), ::testing::StartsWith("\n< frame 702 "));
}

TEST_F(SocketcandServerTest, InBroadcastManagerModeOnlySubscribedFramesAreHandedOn) {
  Client client(*this);
  client.expect("< hi >");
  client.ask("< open can0 >", "< ok >");
  client.ask("< subscribe 0 0 182 >< echo >", "< echo >");
  for (const std::uint32_t id : {0x181U, 0x182U, 0x183U}) board_.send(frame_of(id, {1}));
  run(1'000'000);
  EXPECT_THAT(client.hear(1), ::testing::StartsWith("\n< frame 182 "));
  client.ask("< unsubscribe 182 >< echo >", "< echo >");
  board_.send(frame_of(0x182, {1}));
  run(1'000'000);
  client.ask("< echo >", "< echo >");
}

TEST_F(SocketcandServerTest, ASubscribedFrameIsHandedOnNoOftenerThanAskedForAndTheNewestIs) {
  Client client(*this);
  client.expect("< hi >");
  client.ask("< open can0 >", "< ok >");
  client.ask("< subscribe 0 5000 182 >< echo >", "< echo >");  // 5 ms
  for (const std::uint8_t content : std::initializer_list<std::uint8_t>{0x11, 0x22, 0x33}) {
    board_.send(frame_of(0x182, {content}));
    run(1'000'000);
  }
  EXPECT_THAT(client.hear(1), ::testing::EndsWith(" 11 >"));
  client.ask("< echo >", "< echo >");  // and no other yet
  run(5'000'000);
  EXPECT_THAT(client.hear(1), ::testing::EndsWith(" 33 >"));
}

TEST_F(SocketcandServerTest, AFilteredFrameIsHandedOnWhenItsMaskedBitsChange) {
  Client client(*this);
  client.expect("< hi >");
  client.ask("< open can0 >", "< ok >");
  client.ask("< filter 0 0 182 2 f0 0 >< echo >", "< echo >");
  for (const std::uint8_t first : std::initializer_list<std::uint8_t>{0x10, 0x11, 0x21, 0x21})
    board_.send(frame_of(0x182, {first, first}));
  run(2'000'000);
  const std::string heard = client.hear(2 * sizeof("\n< frame 182 0.000000 1010 >") - 2);
  EXPECT_THAT(heard, ::testing::AllOf(::testing::HasSubstr(" 1010 >"), ::testing::HasSubstr(" 2121 >")));
  EXPECT_EQ(std::count(heard.begin(), heard.end(), '<'), 2);
}

TEST_F(SocketcandServerTest, ACyclicJobSendsInItsRhythmUntilItIsDeleted) {
  Client client(*this);
  client.expect("< hi >");
  client.ask("< open can0 >", "< ok >");
  client.ask("< add 0 10000 123 2 1 f1 >< echo >", "< echo >");
  const auto pass_ms = [&](int ms) {
    for (int k = 0; k < ms; ++k) {
      run(1'000'000);
      server_.exchange();
    }
  };
  pass_ms(35);
  EXPECT_THAT(board_heard(), ::testing::ElementsAre(frame_of(0x123, {1, 0xF1}), frame_of(0x123, {1, 0xF1}),
                                                    frame_of(0x123, {1, 0xF1}), frame_of(0x123, {1, 0xF1})));
  client.ask("< update 123 1 2 >< echo >", "< echo >");
  pass_ms(10);
  EXPECT_THAT(board_heard(), ::testing::ElementsAre(frame_of(0x123, {2})));
  client.ask("< delete 123 >< echo >", "< echo >");
  pass_ms(30);
  EXPECT_TRUE(board_heard().empty());
}

TEST_F(SocketcandServerTest, InControlModeItCountsTheTrafficAndHandsNoFrameOn) {
  Client client(*this);
  client.open_raw();
  client.say("< send 100 1 7 >");
  exchange_until([&] { return server_.counters().frames_taken == 1; });
  client.ask("< controlmode >", "< ok >");
  client.ask("< statistics 20 >< echo >", "< echo >");
  board_.send(frame_of(0x181, {1, 2, 3}));
  board_.send(frame_of(0x182, {1}));
  run(19'000'000);
  client.ask("< echo >", "< echo >");
  run(1'000'000);
  client.expect("< stat 4 2 1 1 >");
}

TEST_F(SocketcandServerTest, AnotherChannelIsRefusedAndTheConnectionEnds) {
  Client client(*this);
  client.expect("< hi >");
  client.ask("< open can1 >", "< error could not open bus >");
  EXPECT_TRUE(client.hung_up());
  EXPECT_THAT(told_, Contains("client 1 asked for can1, expected can0"));
}

TEST_F(SocketcandServerTest, WhatIsNoCommandIsAnsweredAndChangesNothing) {
  Client client(*this);
  client.expect("< hi >");
  client.ask("< send 123 0 >", "< error unknown command >");
  client.ask("< open can0 >", "< ok >");
  for (const char* text :
       {"< send 123 2 1 >", "< send 20000000 0 >", "< add 0 0 123 0 >", "< add 1 0 123 1 >",
        "< update 123 0 >", "< statistics 10 >", "< >", "< send >", "< subscribe >"}) {
    client.ask(text, "< error unknown command >");
  }
  run(1'000'000);
  EXPECT_TRUE(board_heard().empty());
}

TEST_F(SocketcandServerTest, AClientThatOutrunsTheBusLosesNoFrame) {
  Client client(*this);
  client.open_raw();
  std::string flood;
  for (unsigned k = 0; k < 2000; ++k)
    flood += wire::send_message(
        frame_of(0x100, {static_cast<std::uint8_t>(k), static_cast<std::uint8_t>(k >> 8)}));
  client.say(flood);
  client.hang_up();  // what it has written still goes out
  std::vector<CanFrame> heard;
  exchange_until([&] {
    run(1'000'000);
    for (const CanFrame& frame : board_heard()) heard.push_back(frame);
    return heard.size() == 2000;
  });
  ASSERT_EQ(heard.size(), 2000U);
  for (unsigned k = 0; k < 2000; ++k)
    ASSERT_EQ(heard[k].data[0] | heard[k].data[1] << 8, static_cast<int>(k));
}

TEST_F(SocketcandServerTest, AClientThatDoesNotReadIsDroppedAndTheOthersMissNothing) {
  Client deaf(*this);
  Client reader(*this);
  deaf.open_raw();
  reader.open_raw();
  unsigned sent = 0;
  std::string heard;
  while (server_.counters().dropped == 0 && sent < 400'000) {
    for (int k = 0; k < 32; ++k, ++sent) board_.send(frame_of(0x181, {1, 2, 3, 4, 5, 6, 7, 8}));
    run(100'000'000);
    heard += reader.hear(1);
  }
  EXPECT_EQ(server_.counters().dropped, 1U);
  EXPECT_THAT(told_.back(), HasSubstr("client 1 dropped: it does not read"));
  while (static_cast<unsigned>(std::count(heard.begin(), heard.end(), '>')) < sent) {
    const std::string more = reader.hear(1);
    ASSERT_FALSE(more.empty());
    heard += more;
  }
}

TEST_F(SocketcandServerTest, AClientThatWritesAnythingElseIsDropped) {
  Client client(*this);
  client.say(std::string(3000, 'x'));
  exchange_until([&] { return server_.counters().dropped == 1; });
  EXPECT_THAT(told_, Contains(HasSubstr("bytes without a message")));
}

TEST_F(SocketcandServerTest, OneClientTooManyIsToldAndLetGoAndTheOthersStay) {
  std::vector<std::unique_ptr<Client>> clients;
  for (std::size_t k = 0; k < SocketcandServer::kClients; ++k) {
    clients.push_back(std::make_unique<Client>(*this));
    clients.back()->open_raw();
  }
  Client more(*this);
  EXPECT_THAT(more.hear(10), HasSubstr("< error no room for more than 32 clients >"));
  EXPECT_TRUE(more.hung_up());
  clients.front()->ask("< echo >", "< echo >");
  clients.pop_back();
  exchange_until([&] { return told_.back() == "client 32 has gone"; });
  Client another(*this);
  another.open_raw();
}

TEST_F(SocketcandServerTest, ANewClientHearsNothingOfTheTimeBeforeIt) {
  Client first(*this);
  first.open_raw();
  first.hang_up();
  exchange_until([&] { return told_.back() == "client 1 has gone"; });
  board_.send(frame_of(0x181, {1}));
  run(1'000'000);
  Client second(*this);
  second.open_raw();
  second.ask("< echo >", "< echo >");
}

TEST_F(SocketcandServerTest, APortThatIsTakenIsToldWithItsAddress) {
  try {
    SocketcandServer again(bus_, "127.0.0.1", server_.port(), "can0", [](const std::string&) {});
    FAIL() << "two servers on one port";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(error.what(), "127.0.0.1:" + std::to_string(server_.port()) +
                                ": Address already in use, expected a free port of this machine");
  }
}

}  // namespace
}  // namespace plenum::host::ports
