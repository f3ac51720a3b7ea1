#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <thread>

#include "host-sim/client/borrowed_stream.hpp"
#include "host-sim/client/watch.hpp"
#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/monitor_views.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/stop_signal.hpp"

namespace plenum::host::tools {
namespace {

namespace object = canopen::object;

struct Options {
  BoardChoice board;
  double seconds = 0.0;
  double rate_Hz = 10.0;
  bool stream = false;
  double largest_volume_mL = 3000.0;
  int web_port = -1;
  std::string web_address = "127.0.0.1";
  std::string udp;
  std::optional<Option> web;
  Output output;
};

constexpr int kDefaultPort = 8408;

/// A simulated board has no other master: it is excited, and gets its SYNC, in real time.
class OwnMaster {
 public:
  explicit OwnMaster(client::Session& session) : session_(session) {
    session.write(object::kControlMode, 0, static_cast<std::int8_t>(canopen::ControlMode::excitation));
    session.learn_sync();
    session.nmt(canopen::NmtCommand::start);
    session.enable();
    next_s_ = session.link().now_s();
    begin_s_ = next_s_;
  }
  /// Up to 10 ms of the board's life, which take as long for who watches.
  void cycle() {
    constexpr double kCycle_s = 0.01;
    session_.send_sync();
    next_s_ += kCycle_s;
    session_.listen(next_s_ - session_.link().now_s());
    std::this_thread::sleep_until(begin_ + std::chrono::duration<double>(next_s_ - begin_s_));
  }

 private:
  client::Session& session_;
  double begin_s_ = 0.0;
  double next_s_ = 0.0;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// A board that gives no answer may still be worth to be listened to.
void learn_mapping(client::Watch& watch, client::Session& session) {
  try {
    watch.learn_mapping(session);
  } catch (const std::runtime_error& error) {
    fmt::print(stderr, "{}; its PDOs are taken for those of a board as delivered\n", error.what());
  }
}

int run(const Options& options) {
  const StopSignal stop;  // the stream has to be given back
  BoardAccess access(options.board);
  client::Session& session = access.session();
  client::Link& link = access.link();
  const std::uint8_t node = session.node_id();
  const unsigned chambers = options.board.rig.chambers;

  std::optional<UdpView> udp;
  if (!options.udp.empty()) udp.emplace(options.udp);
  std::optional<WebView> web;
  if (options.web->given()) {
    const int port = options.web_port < 0 ? kDefaultPort : options.web_port;
    web.emplace(options.web_address, static_cast<std::uint16_t>(port), monitor_page());
    fmt::print(stderr, "live page: {} (Ctrl-C ends)\n", web->url());
  }

  client::Watch watch(node);
  session.subscribe([&](const client::Arrival& arrival) { watch.take(arrival.time_s, arrival.frame); });
  learn_mapping(watch, session);
  std::optional<client::BorrowedStream> stream;
  if (options.stream) {
    client::require_compatible(session);
    client::require_no_stream(session);
    const client::FaultEntry fault = client::read_fault(session).value_or(client::FaultEntry{});
    watch.know({.node_id = node, .code = fault.code, .chamber = static_cast<std::uint8_t>(fault.chamber)});
    stream.emplace(session, client::StreamConfig{.chambers = static_cast<std::uint8_t>((1U << chambers) - 1U),
                                                 .largest_volume_m3 = 1e-6 * options.largest_volume_mL});
    watch.follow(stream->stream());
  }
  std::optional<OwnMaster> master;
  if (options.board.simulated()) master.emplace(session);

  const double begin_s = link.now_s();
  const double period_s = 1.0 / options.rate_Hz;
  constexpr double kSlice_s = 0.02;  // how long a browser waits at most before it is looked after
  TerminalView terminal(master || stream ? "" : "they come with SYNC, or by --stream");
  std::uint64_t shown = 0;
  Json newest;
  while (!stop.asked()) {
    const double elapsed_s = link.now_s() - begin_s;
    if (options.seconds > 0.0 && elapsed_s >= options.seconds) break;
    if (elapsed_s >= static_cast<double>(shown) * period_s) {
      const client::BoardView view = watch.view(link.now_s());
      newest = view_json(view, node, chambers, elapsed_s);
      options.output.print("{}", terminal.text(view, node, chambers, elapsed_s));
      std::fflush(stdout);
      if (udp) udp->show(newest);
      if (web) web->show(newest);
      shown = static_cast<std::uint64_t>(elapsed_s / period_s) + 1;
    }
    if (master) {
      master->cycle();
    } else {
      session.listen(std::min(kSlice_s, period_s));
    }
    if (web) web->serve(link.now_s());
  }
  if (stream) stream->give_back();
  options.output.finish({{"seconds", link.now_s() - begin_s}, {"frames", watch.frames()}, {"last", newest}});
  return watch.frames() > 0 ? kDone : kFailure;
}

}  // namespace

Command add_monitor(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command(
      "monitor",
      "Watch a board live, in the terminal, a browser or PlotJuggler. It asks how the board's PDOs are "
      "mapped, then listens, and changes nothing, unless --stream asks for more; exit code 1 when nothing "
      "was heard");
  options->board.add_to(arguments);
  arguments.option("--seconds", options->seconds, "How long; 0: until Ctrl-C [s]")
      .not_negative()
      .show_default();
  arguments.option("--rate", options->rate_Hz, "How often it is shown [Hz]")
      .within(0.1, 100.0)
      .show_default();
  arguments.flag(
      "--stream", options->stream,
      "Let the board send command and volume, too: borrows its TPDOs 5 to 12 and gives them back at the end");
  arguments.option("--largest-volume", options->largest_volume_mL, "What the stream's volume can show [mL]")
      .within(1.0, 6'500'000.0)
      .show_default();
  options->web = arguments
                     .option("--web", options->web_port,
                             fmt::format("Serve one live page on this port (default: {}; 0: any free one)",
                                         kDefaultPort))
                     .type_name("PORT")
                     .value_optional()
                     .within(0, 65535);
  arguments
      .option("--web-address", options->web_address, "Of this machine, for the page: others can read it then")
      .type_name("IPV4")
      .show_default();
  arguments
      .option("--udp", options->udp,
              "Send each view as a JSON datagram; PlotJuggler: UDP server, JSON, timestamp")
      .type_name("HOST:PORT");
  options->output.add_to(arguments);
  arguments.footer(example(
      "  plenum monitor --bus socketcand:127.0.0.1:29536/can0 --node 5\n"
      "  plenum monitor --bus socketcand:127.0.0.1:29536/can0 --node 5 --stream --web --udp 127.0.0.1:9870"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
