#include "host-sim/tools/serve.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <vector>

#include "host-sim/ports/socketcand_server.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/stop_signal.hpp"

namespace plenum::host::tools {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint64_t kSlice_ns =
    rig::kTick_ns;                  ///< of rig time between two looks at the clients when it is behind
constexpr double kBusy_s = 100e-6;  ///< the same while frames are on the bus: about one frame

/// Moves the rig along the clock, and frames between it and the clients.
class Server {
 public:
  Server(const rig::RigConfig& config, const client::SocketcandAddress& address, double speed)
      : speed_(speed),
        rig_(config),
        clients_(rig_.bus(), address.host, address.port, address.channel,
                 [](const std::string& line) { fmt::print(stderr, "{}\n", line); }) {}

  /// Where the rig should be by now.
  std::uint64_t due_ns() const {
    return static_cast<std::uint64_t>(
        std::chrono::duration<double, std::nano>(Clock::now() - begin_).count() * speed_);
  }

  /// Brings the rig to `until_ns`, or to where the clock is.
  void step(std::uint64_t until_ns) {
    wait();
    const std::uint64_t goal_ns = std::min({due_ns(), until_ns, rig_.now_ns() + kSlice_ns});
    while (rig_.now_ns() < goal_ns || rig_.ticks() * rig::kTick_ns <= goal_ns) {
      const std::uint64_t ticks = rig_.ticks();
      rig_.advance(goal_ns);
      clients_.collect(epoch_us_ + rig_.now_ns() / 1000);
      if (rig_.ticks() != ticks) worst_late_ns_ = std::max(worst_late_ns_, late_ns(ticks));
    }
    clients_.exchange();
  }

  rig::Rig& rig() { return rig_; }
  const ports::SocketcandServer& clients() const { return clients_; }
  double worst_late_ms() const { return worst_late_ns_ * 1e-6; }

 private:
  /// Until a client wants something, or the rig's next event is due.
  void wait() {
    const double next_tick_s =
        1e-9 * (static_cast<double>(rig_.ticks() * rig::kTick_ns) - static_cast<double>(due_ns()));
    clients_.wait((rig_.bus().idle() ? next_tick_s : std::min(next_tick_s, kBusy_s)) / speed_);
  }

  /// How long after its deadline tick number `tick` was done [ns of the clock].
  double late_ns(std::uint64_t tick) const {
    return (static_cast<double>(due_ns()) - static_cast<double>(tick * rig::kTick_ns)) / speed_;
  }

  double speed_;
  rig::Rig rig_;
  ports::SocketcandServer clients_;
  Clock::time_point begin_ = Clock::now();
  std::uint64_t epoch_us_ =
      static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(
                                     std::chrono::system_clock::now().time_since_epoch())
                                     .count());
  double worst_late_ns_ = 0.0;
};

}  // namespace

int serve(const rig::RigConfig& config, const client::SocketcandAddress& address, const ServeOptions& options,
          const Output& output) {
  Server server(config, address, options.speed);
  const StopSignal stop;
  client::SocketcandAddress served = address;
  served.port = server.clients().port();
  std::vector<int> nodes;
  for (const rig::BoardConfig& board : config.board) nodes.push_back(board.settings.node.node_id);
  output.announce(fmt::format("serving {}: {} {}; {} each, {} bit/s", client::format_bus(served),
                              nodes.size() == 1 ? "node" : "nodes", fmt::join(nodes, ", "),
                              counted(config.board.front().chamber.size(), "chamber"), config.bus.bit_rate));

  const std::uint64_t until_ns =
      options.seconds ? static_cast<std::uint64_t>(std::llround(*options.seconds * 1e9)) : UINT64_MAX;
  while (!stop.asked() && server.rig().now_ns() < until_ns) server.step(until_ns);

  rig::Rig& rig = server.rig();
  const auto& counters = server.clients().counters();
  output.print(
      "{:.1f} s served to {} ({} dropped); {} frames, bus load {:.1f} %; worst tick {:.1f} ms late\n",
      rig.now_s(), counted(counters.clients, "client"), counters.dropped, rig.bus().counters().frames,
      100.0 * rig.bus().busy_share(), server.worst_late_ms());
  output.finish({{"bus", client::format_bus(served)},
                 {"nodes", nodes},
                 {"seconds", rig.now_s()},
                 {"clients", counters.clients},
                 {"dropped", counters.dropped},
                 {"frames", rig.bus().counters().frames},
                 {"frames_taken", counters.frames_taken},
                 {"frames_handed", counters.frames_handed},
                 {"bus_load", rig.bus().busy_share()},
                 {"worst_late_ms", server.worst_late_ms()}});
  return kDone;
}

}  // namespace plenum::host::tools
