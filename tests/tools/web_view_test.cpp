// The monitor's page over HTTP, by a clock of the test.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string>
#include <vector>

#include "host-sim/tools/monitor_views.hpp"
#include "host-sim/wire/tcp.hpp"

namespace plenum::host::tools {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr std::size_t kPlaces = 16;
constexpr const char* kNever = "a text that the view does not send";
constexpr const char* kHeadEnd = "\r\n\r\n";

/// A client that does not wait: the view lives in the same thread.
class Browser {
 public:
  explicit Browser(const WebView& view) : socket_(wire::connect_tcp("127.0.0.1", port_of(view), 5.0)) {}

  void say(const std::string& text) {
    ASSERT_EQ(::send(socket_.number(), text.data(), text.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(text.size()));
  }
  void ends_its_half() { ::shutdown(socket_.number(), SHUT_WR); }
  /// Sends until nothing more is taken; returns how many bytes were.
  std::size_t pour() {
    const std::vector<char> bytes(65536, 'x');
    std::size_t poured = 0;
    for (ssize_t count = 0; count >= 0; poured += static_cast<std::size_t>(std::max<ssize_t>(count, 0)))
      count = ::send(socket_.number(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    return poured;
  }
  /// What comes until it holds `last`, or the view hangs up; at `now_s` of the view's clock.
  std::string hear(WebView& view, double now_s = 0.0, const std::string& last = kNever) {
    std::string heard;
    constexpr int kChances = 1000;
    for (int i = 0; i < kChances && !hung_up_ && heard.find(last) == std::string::npos; ++i) {
      heard += hear_once(view, now_s);
    }
    return heard;
  }
  std::string hear_once(WebView& view, double now_s) {
    view.serve(now_s);
    pollfd waiting{socket_.number(), POLLIN, 0};
    ::poll(&waiting, 1, 10);
    std::array<char, 4096> bytes{};
    const ssize_t count = ::recv(socket_.number(), bytes.data(), bytes.size(), 0);
    hung_up_ = count == 0 || (count < 0 && errno != EAGAIN);
    return {bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0))};
  }
  bool hung_up() const { return hung_up_; }

 private:
  static std::uint16_t port_of(const WebView& view) {
    const std::string url = view.url();
    return static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
  }
  wire::FileDescriptor socket_;
  bool hung_up_ = false;
};

class WebViewTest : public ::testing::Test {
 protected:
  std::string answer_to(const std::string& request, double now_s = 0.0) {
    Browser browser(view_);
    browser.say(request);
    return browser.hear(view_, now_s);
  }
  WebView view_{"127.0.0.1", 0, "the page"};
};

TEST_F(WebViewTest, AnswersAllThatHttpAllowsToBeSaid) {
  for (const char* request :
       {"GET / HTTP/1.1\r\nHost: 127.0.0.1:8408\r\n\r\n", "GET / HTTP/1.1\r\nhost:127.0.0.1:8408\r\n\r\n",
        "GET / HTTP/1.1\r\nAccept: */*\r\nHOST: \t LocalHost \r\n\r\n",
        "GET / HTTP/1.0\nHost: [::1]:8408\n\n", "\r\nGET /?x=1 HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"}) {
    const std::string answer = answer_to(request);
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 200 OK\r\n")) << request;
    EXPECT_THAT(answer, EndsWith("\r\n\r\nthe page")) << request;
  }
}

TEST_F(WebViewTest, AnswersOnlyByTheNamesOfThisMachine) {
  for (const char* host :
       {"evil.example", "127.0.0.1.evil.example", "localhost:8408.evil.example", "", ":8408"}) {
    EXPECT_THAT(answer_to(std::string("GET / HTTP/1.1\r\nHost: ") + host + "\r\n\r\n"),
                StartsWith("HTTP/1.1 403 "))
        << host;
  }
}

TEST_F(WebViewTest, RefusesWhatIsNoRequest) {
  for (const char* request :
       {"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nhost: evil.example\r\n\r\n",
        "GET / HTTP/1.1\r\nAccept: */*\r\n\r\n", "GET / HTTP/1.1\r\nHost : 127.0.0.1\r\n\r\n",
        "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n folded\r\n\r\n", "GET /\r\nHost: 127.0.0.1\r\n\r\n",
        "GET\r\nHost: 127.0.0.1\r\n\r\n"}) {
    EXPECT_THAT(answer_to(request), StartsWith("HTTP/1.1 400 ")) << request;
  }
  EXPECT_THAT(answer_to("POST / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"),
              testing::AllOf(StartsWith("HTTP/1.1 405 "), HasSubstr("\r\nAllow: GET, HEAD\r\n")));
  EXPECT_THAT(answer_to("GET /other HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"), StartsWith("HTTP/1.1 404 "));
}

TEST_F(WebViewTest, AnswersHeadAsGetWithoutTheBody) {
  const std::string page = answer_to("HEAD / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  EXPECT_THAT(page, StartsWith("HTTP/1.1 200 OK\r\n"));
  EXPECT_THAT(page, HasSubstr("\r\nContent-Length: 8\r\n"));
  EXPECT_THAT(page, EndsWith("\r\n\r\n"));
  Browser events(view_);
  events.say("HEAD /events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  EXPECT_THAT(events.hear(view_), HasSubstr("text/event-stream"));
  EXPECT_TRUE(events.hung_up());
}

TEST_F(WebViewTest, AnswersAClientThatSaysNoMore) {
  Browser page(view_);
  page.say("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  page.ends_its_half();
  EXPECT_THAT(page.hear(view_), EndsWith("the page"));
  Browser events(view_);
  events.say("GET /events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  events.ends_its_half();
  EXPECT_THAT(events.hear(view_, 0.0, kHeadEnd), HasSubstr("text/event-stream"));
  view_.show({{"timestamp", 1}});
  EXPECT_EQ(events.hear(view_, 0.0, "\n\n"), "data: {\"timestamp\":1}\n\n");
}

TEST_F(WebViewTest, TakesLittleAtATimeOfAClientThatSendsWithoutEnd) {
  Browser flood(view_);
  flood.say("GET /events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  ASSERT_THAT(flood.hear(view_, 0.0, kHeadEnd), HasSubstr("text/event-stream"));
  const std::size_t first = flood.pour();
  view_.serve(0.0);
  EXPECT_LT(flood.pour(), first / 4);
}

TEST_F(WebViewTest, MakesRoomForAClientThatAsks) {
  std::vector<Browser> silent;
  for (std::size_t i = 0; i < kPlaces; ++i) {
    silent.emplace_back(view_);
    silent.back().say("GET / HT");
  }
  view_.serve(0.0);
  EXPECT_THAT(answer_to("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"), EndsWith("the page"));
  silent.back().say("TP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  EXPECT_THAT(silent.back().hear(view_), EndsWith("the page"));  // only the oldest had to go
}

TEST_F(WebViewTest, LetsAClientGoThatDoesNotAskWithinTenSeconds) {
  Browser silent(view_);
  silent.say("GET / HT");
  answer_to("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");  // by then the silent one has its place
  silent.hear_once(view_, 9.9);
  EXPECT_FALSE(silent.hung_up());
  silent.hear(view_, 10.1);
  EXPECT_TRUE(silent.hung_up());
}

TEST_F(WebViewTest, LetsAClientGoThatTakesNothingForTenSeconds) {
  Browser reader(view_);
  reader.say("GET /events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
  reader.hear(view_, 0.0, kHeadEnd);
  reader.hear_once(view_, 100.0);
  EXPECT_FALSE(reader.hung_up()) << "it had nothing to take";
  const Json large{{"large", std::string(std::size_t{1} << 22U, 'x')}};
  view_.show(large);  // more than the sockets hold
  view_.serve(100.0);
  view_.serve(109.9);
  view_.serve(110.1);
  EXPECT_LT(reader.hear(view_, 110.1).size(), large.dump().size());
  EXPECT_TRUE(reader.hung_up());
}

}  // namespace
}  // namespace plenum::host::tools
