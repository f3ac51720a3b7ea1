// Our end of socketcand against a peer that follows a script: the bytes that come, and those that are expected back.
#include "host-sim/client/socketcand_link.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <functional>
#include <thread>

#include "host-sim/wire/tcp.hpp"
#include "tests/client/link_frames.hpp"

namespace plenum::host::client {
namespace {

using ::testing::HasSubstr;

constexpr double kSoon_s = 5.0;  ///< a deadline that is not reached

/// A server on a free port that speaks to one client as `script` says, in a thread of its own.
class Peer {
 public:
  explicit Peer(std::function<void(Peer&)> script) : listening_(wire::listen_tcp("127.0.0.1", 0)) {
    thread_ = std::thread([this, script = std::move(script)] {
      wait(listening_, POLLIN);
      client_ = wire::accept_tcp(listening_);
      script(*this);
    });
  }
  ~Peer() { thread_.join(); }

  SocketcandAddress address() const { return {"127.0.0.1", wire::port_of(listening_), "can0"}; }

  void say(std::string_view bytes) {
    ASSERT_EQ(::send(client_.number(), bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  void hear(const std::string& expected) {
    std::string heard;
    while (heard.size() < expected.size()) {
      std::array<char, 256> bytes;
      wait(client_, POLLIN);
      const ssize_t count = ::recv(client_.number(), bytes.data(), bytes.size(), 0);
      if (count <= 0) break;
      heard.append(bytes.data(), static_cast<std::size_t>(count));
    }
    EXPECT_EQ(heard, expected);
  }
  void greet() {
    say("< hi >");
    hear("< open can0 >");
    say("< ok >");
    hear("< rawmode >");
    say("< ok >");
  }
  void hang_up() { client_ = wire::FileDescriptor(); }
  /// Until the client hangs up.
  void stay() {
    std::array<char, 4096> bytes;
    do {
      wait(client_, POLLIN);
    } while (::recv(client_.number(), bytes.data(), bytes.size(), 0) > 0);
  }

 private:
  static void wait(const wire::FileDescriptor& socket, short events) {
    pollfd waiting{socket.number(), events, 0};
    ::poll(&waiting, 1, 10'000);
  }
  wire::FileDescriptor listening_;
  wire::FileDescriptor client_;
  std::thread thread_;
};

TEST(SocketcandLink, OpensItsChannelInRawModeAndCarriesFramesBothWays) {
  Peer peer([](Peer& server) {
    server.greet();
    server.hear("< send 605 8 40 0 10 0 0 0 0 0 >");
    server.say("< frame 585 1.000000 4300100098010000 >");
    server.stay();
  });
  SocketcandLink link(peer.address());
  link.send(frame_of(0x605, {0x40, 0x00, 0x10, 0, 0, 0, 0, 0}));
  EXPECT_EQ(link.receive(kSoon_s), frame_of(0x585, {0x43, 0x00, 0x10, 0x00, 0x98, 0x01, 0x00, 0x00}));
  EXPECT_EQ(link.stamp_us(), 1'000'000U) << "the server's";
}

TEST(SocketcandLink, FramesMayComeInPiecesAndTogether) {
  Peer peer([](Peer& server) {
    server.greet();
    server.say("< frame 181 1.0 01 >< frame 182 1.0 02 >< fra");
    server.hear("< send 000 2 1 5 >");  // the client took what was whole before it wrote
    server.say("me 183 1.0 03 >");
    server.stay();
  });
  SocketcandLink link(peer.address());
  EXPECT_EQ(link.receive(kSoon_s), frame_of(0x181, {1}));
  EXPECT_EQ(link.receive(kSoon_s), frame_of(0x182, {2}));
  EXPECT_EQ(link.receive(0.0), std::nullopt);
  link.send(frame_of(0x000, {1, 5}));
  EXPECT_EQ(link.receive(kSoon_s), frame_of(0x183, {3}));
}

TEST(SocketcandLink, ErrorFramesAndOtherMessagesArePassedOver) {
  Peer peer([](Peer& server) {
    server.greet();
    server.say("< error 004 1.0 >< echo >< stat 1 2 3 4 >< frame 181 1.0 01 >");
    server.stay();
  });
  SocketcandLink link(peer.address());
  EXPECT_EQ(link.receive(kSoon_s), frame_of(0x181, {1}));
}

TEST(SocketcandLink, WhatTheServerDoesNotUnderstandIsTold) {
  Peer peer([](Peer& server) {
    server.greet();
    server.say("< error unknown command >");
    server.stay();
  });
  SocketcandLink link(peer.address());
  EXPECT_THAT(failure([&] { link.receive(kSoon_s); }), HasSubstr("< error unknown command >"));
}

TEST(SocketcandLink, AServerThatVanishesIsToldAfterTheFramesItSent) {
  Peer peer([](Peer& server) {
    server.greet();
    server.say("< frame 181 1.0 01 >< frame 18");
    server.hang_up();
  });
  SocketcandLink link(peer.address());
  EXPECT_EQ(link.receive(kSoon_s), frame_of(0x181, {1}));
  EXPECT_THAT(failure([&] { link.receive(kSoon_s); }), HasSubstr("closed the connection"));
}

TEST(SocketcandLink, AServerThatRefusesTheChannelIsQuoted) {
  Peer peer([](Peer& server) {
    server.say("< hi >");
    server.hear("< open can0 >");
    server.say("< error could not open bus >");
    server.stay();
  });
  const SocketcandAddress address = peer.address();
  EXPECT_EQ(failure([&] { SocketcandLink link(address); }),
            format_bus(address) + ": < error could not open bus > after < open can0 >, expected < ok >");
}

TEST(SocketcandLink, AServerOfAnotherKindIsToldApart) {
  Peer silent([](Peer& server) { server.stay(); });
  EXPECT_THAT(failure([&] { SocketcandLink link(silent.address(), 0.05); }),
              HasSubstr("no answer after connecting, expected < hi > of a socketcand server"));
  Peer other([](Peer& server) {
    server.say(std::string(2 * wire::MessageReader::kLongest, 'x'));
    server.stay();
  });
  EXPECT_THAT(failure([&] { SocketcandLink link(other.address()); }),
              HasSubstr("bytes without a message, expected a socketcand server"));
}

TEST(SocketcandLink, ARemoteFrameIsRefused) {
  Peer peer([](Peer& server) {
    server.greet();
    server.stay();
  });
  SocketcandLink link(peer.address());
  EXPECT_THAT(failure([&] { link.send({.id = 0x701, .remote = true}); }), HasSubstr("remote frame 701h"));
}

TEST(SocketcandLink, AServerThatTakesNothingEndsTheSendingWithAnError) {
  std::atomic<bool> done = false;
  Peer peer([&](Peer& server) {
    server.greet();
    done.wait(false);
  });
  SocketcandLink link(peer.address());
  std::string found;
  for (int k = 0; k < 2'000'000 && found.empty(); ++k) {
    const std::string what = failure([&] { link.send(frame_of(0x123, {1, 2, 3, 4, 5, 6, 7, 8})); });
    if (what != "no failure") found = what;
  }
  done = true;
  done.notify_one();
  EXPECT_THAT(found, HasSubstr("expected a peer that takes them"));
}

}  // namespace
}  // namespace plenum::host::client
