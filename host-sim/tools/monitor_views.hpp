// Where the monitor shows a board: a terminal, a page in a browser, datagrams.
#pragma once

#include <netinet/in.h>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/client/watch.hpp"
#include "host-sim/tools/output.hpp"

namespace plenum::host::tools {

/// What the page and the datagrams carry: names nested, units in them, null where nothing was heard, or not lately
/// (client::kStale_s). "fault": null where there is none, else a sentence, also where it is not known; "silent_s": null while the board is heard.
///
///   {"timestamp": 12.34, "node5": {"nmt": "operational", "state": "ACTIVE", "fault": null, "silent_s": null, "frames": 4711,
///    "chamber1": {"setpoint_kPa": 350.0, "actual_kPa": 349.8, "command_V": 5.1, "volume_mL": 210.0}, ...}}
Json view_json(const client::BoardView& view, std::uint8_t node_id, unsigned chambers, double timestamp_s);

/// The board as a table that is drawn anew in its place on a terminal, and as a line a time anywhere else.
class TerminalView {
 public:
  /// `remedy`: said while no pressure is heard.
  explicit TerminalView(std::string remedy);
  /// The text that shows it, with what moves the cursor on a terminal.
  std::string text(const client::BoardView& view, std::uint8_t node_id, unsigned chambers, double time_s);

 private:
  std::string remedy_;
  bool terminal_;
  int lines_ = 0;  ///< drawn, to be drawn over
};

/// One JSON object a datagram, as PlotJuggler reads them.
class UdpView {
 public:
  /// HOST:PORT. Throws std::invalid_argument for another form, std::runtime_error for a host that is not found.
  explicit UdpView(const std::string& address);
  ~UdpView();
  UdpView(const UdpView&) = delete;
  UdpView& operator=(const UdpView&) = delete;
  /// A datagram that nobody takes is no error.
  void show(const Json& view);

 private:
  int socket_ = -1;
};

/// One page and its live data (server-sent events), over HTTP.
class WebView {
 public:
  /// Port 0: any free one. Throws std::runtime_error when it cannot listen there.
  WebView(const std::string& host, std::uint16_t port, std::string page);
  ~WebView();
  WebView(const WebView&) = delete;
  WebView& operator=(const WebView&) = delete;

  std::string url() const;
  /// Takes requests and sends what is due; never waits. A client that keeps it waiting for ten seconds is let go.
  void serve(double now_s);
  /// To be sent by the next serve().
  void show(const Json& view);

 private:
  struct Client {
    int socket;
    double due_s;  ///< its whole request, or that it takes some of what is sent
    std::string request;
    std::string waiting;  ///< to be sent
    bool answered = false;
    bool events = false;  ///< not closed once all is sent
  };
  void accept_clients(double now_s);
  bool read_from(Client& client);
  void answer(Client& client, std::span<const std::string_view> lines);
  static bool write_to(Client& client, double now_s);

  int listener_ = -1;
  std::string host_;
  std::uint16_t port_;
  std::string page_;
  std::vector<Client> clients_;  ///< in the order in which they came
};

/// The page, whole: it loads nothing from elsewhere.
std::string monitor_page();

}  // namespace plenum::host::tools
