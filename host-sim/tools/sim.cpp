#include <algorithm>
#include <chrono>
#include <memory>

#include "host-sim/tools/command.hpp"
#include "host-sim/tools/inproc.hpp"
#include "host-sim/tools/kept_rig.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/recorded_log.hpp"
#include "host-sim/tools/rig_link.hpp"
#include "host-sim/tools/serve.hpp"
#include "host-sim/trace/log_csv.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  RigChoice rig;
  std::string bus;
  std::string store;
  std::optional<double> seconds;
  double speed = 1.0;
  std::string out = "sim";
  Output output;
};

std::string log_name(unsigned boards, unsigned board, unsigned chamber) {
  return boards == 1 ? fmt::format("chamber-{}.csv", chamber + 1)
                     : fmt::format("board-{}-chamber-{}.csv", board + 1, chamber + 1);
}

/// What does not go together. Throws std::invalid_argument.
void require_one_use(const Arguments& arguments, const Options& options) {
  for (const char* option : {"--store", "--speed"}) {
    if (!options.bus.empty() || !arguments.given(option)) continue;
    throw std::invalid_argument(
        fmt::format("{} without --bus, expected --bus socketcand:HOST:PORT/CHANNEL", option));
  }
  if (!options.bus.empty() && arguments.given("--out")) {
    throw std::invalid_argument(
        "--out with --bus, expected one of them: a rig that is served writes no logs");
  }
}

/// Of each board, that of node 1 first; none: the boards keep nothing.
std::vector<std::filesystem::path> stores_of(const Options& options) {
  if (options.store.empty()) return {};
  const std::filesystem::path store = options.store;
  if (options.rig.boards == 1) return {store};
  std::vector<std::filesystem::path> stores;
  for (unsigned b = 0; b < options.rig.boards; ++b) stores.push_back(store / fmt::format("node-{}", b + 1));
  return stores;
}

int serve_rig(const Options& options) {
  const auto address = client::parse_bus(options.bus);
  const auto* socketcand = std::get_if<client::SocketcandAddress>(&address);
  if (socketcand == nullptr) {
    throw std::invalid_argument(
        fmt::format("--bus {}: cannot be served, expected socketcand:HOST:PORT/CHANNEL", options.bus));
  }
  rig::RigConfig config = options.rig.config();
  const auto stores = stores_of(options);
  for (std::size_t b = 0; b < stores.size(); ++b) {
    require_folder(stores[b]);
    keep_rig(options.rig, stores[b]);
    config.board[b].store = stores[b];
  }
  const bool endless = !options.seconds || *options.seconds == 0.0;
  return serve(config, *socketcand,
               {.seconds = endless ? std::nullopt : options.seconds, .speed = options.speed}, options.output);
}

int write_logs(const Options& options) {
  const double seconds = options.seconds.value_or(60.0);
  if (seconds < 1.0)
    throw std::invalid_argument(
        fmt::format("--seconds {:g}: not in the range 1 to 36000 of a log, expected one in it", seconds));
  const trace::RigDescription description = options.rig.description();
  rig::Rig rig(options.rig.config());
  require_folder(options.out);
  RigLink link(rig);

  Json result{{"seconds", seconds}, {"seed", options.rig.seed}, {"chambers", Json::array()}};
  options.output.print("{:>5} {:>7}  {:>18}  {:>16}  {:>14}  file\n", "board", "chamber", "pressure [kPa]",
                       "command [V]", "volume [mL]");
  const auto begin = std::chrono::steady_clock::now();
  trace::write_rig(std::filesystem::path(options.out) / "rig.toml", description);
  for (unsigned b = 0; b < options.rig.boards; ++b) {
    client::Session session(link, static_cast<std::uint8_t>(b + 1));
    std::vector<client::CapturedRow> rows;
    {
      Progress progress(fmt::format("simulating board {} of {}", b + 1, options.rig.boards));
      rows = client::capture(session,
                             {.seconds = seconds,
                              .seed = static_cast<std::uint32_t>(options.rig.seed),
                              .chambers = options.rig.chambers},
                             std::ref(progress));
    }
    for (unsigned c = 0; c < options.rig.chambers; ++c) {
      const trace::Log log = log_of(rows, c, false);
      const auto file = std::filesystem::path(options.out) / log_name(options.rig.boards, b, c);
      trace::write_log(file, log);
      const auto [low_Pa, high_Pa] = std::minmax_element(log.pressure_Pa.begin(), log.pressure_Pa.end());
      const auto [low_V, high_V] = std::minmax_element(log.command_V.begin(), log.command_V.end());
      const auto [low_m3, high_m3] = std::minmax_element(log.volume_m3.begin(), log.volume_m3.end());
      options.output.print("{:5} {:7}  {:7.1f} to {:7.1f}  {:5.2f} to {:7.2f}  {:4.0f} to {:6.0f}  {}\n",
                           b + 1, c + 1, *low_Pa / 1e3, *high_Pa / 1e3, *low_V, *high_V, *low_m3 * 1e6,
                           *high_m3 * 1e6, file.string());
      result["chambers"].push_back({{"board", b + 1},
                                    {"chamber", c + 1},
                                    {"file", file.string()},
                                    {"rows", log.size()},
                                    {"pressure_low_Pa", *low_Pa},
                                    {"pressure_high_Pa", *high_Pa}});
    }
  }
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  result["simulated_s"] = rig.now_s();
  result["bus_load"] = rig.bus().busy_share();
  result["realtime_factor"] = rig.now_s() / wall_s;
  options.output.print(
      "bus load {:.1f} % of 1 Mbit/s; {:.1f} s simulated in {:.2f} s: {:.0f} times real time\n",
      100.0 * rig.bus().busy_share(), rig.now_s(), wall_s, rig.now_s() / wall_s);
  options.output.finish(result);
  return kDone;
}

}  // namespace

Command add_sim(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command(
      "sim", "Simulate a rig under excitation, and write a log a chamber; or serve it on a bus in real time");
  arguments
      .option("--bus", options->bus, "Serve the rig to other programs, in real time; port 0: any free one")
      .type_name("socketcand:HOST:PORT/CHANNEL");
  arguments.option("--store", options->store, "With --bus: folder that keeps what the boards store")
      .type_name("DIR");
  arguments.option("--speed", options->speed, "With --bus: seconds of the rig in one of the clock")
      .within(0.01, 100.0)
      .show_default();
  options->rig.add_to(arguments);
  arguments.option("--boards", options->rig.boards, "Boards on the bus; they are excited one after the other")
      .within(1, 16)
      .show_default();
  arguments
      .option(
          "--seconds", options->seconds,
          "Length of each log [s] (default: 60); with --bus how long to serve (default, and 0: until Ctrl-C)")
      .within(0.0, 36000.0);
  arguments.option("-o,--out", options->out, "Folder for the logs and for rig.toml")
      .type_name("DIR")
      .show_default();
  options->output.add_to(arguments);
  arguments.footer(example(
      "  plenum sim --chambers 2 --seconds 20 --out logs    # logs/chamber-1.csv, chamber-2.csv, rig.toml\n"
      "  plenum sim --plant thin-plate --effect spool_lag=10 --effect supply_droop=20,recovery_s:0.1\n"
      "  plenum sim --bus socketcand:127.0.0.1:29536/can0   # for plenum --bus, python-can and others"));
  return {arguments, [arguments, options] {
            require_one_use(arguments, *options);
            for (const auto& store : stores_of(*options)) take_rig(options->rig, arguments, store);
            return options->bus.empty() ? write_logs(*options) : serve_rig(*options);
          }};
}

}  // namespace plenum::host::tools
