#include <chrono>
#include <cmath>
#include <fstream>
#include <memory>

#include "host-sim/client/bus_address.hpp"
#include "host-sim/client/bus_recorder.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/stop_signal.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  std::string bus;
  double seconds = 0.0;
  std::string out;
  Output output;
};

constexpr double kLook_s = 0.1;  ///< between two looks at the time while nothing comes

std::uint64_t epoch_us() {
  using namespace std::chrono;
  return static_cast<std::uint64_t>(
      duration_cast<microseconds>(system_clock::now().time_since_epoch()).count());
}

/// The name that the frames' bus has in the log.
std::string channel_of(const client::BusAddress& address) {
  if (const auto* socketcand = std::get_if<client::SocketcandAddress>(&address)) return socketcand->channel;
  if (const auto* can = std::get_if<client::CanAddress>(&address)) return can->interface;
  return "can0";
}

int run(const Options& options) {
  const client::BusAddress address = client::parse_bus(options.bus);
  const std::unique_ptr<client::Link> link = client::open_link(address);
  std::ofstream log(options.out);
  const auto written = [&] {
    if (!log.flush())
      throw trace::InputError(fmt::format("{}: cannot be written, expected room for a log", options.out));
  };
  written();
  const StopSignal stop;
  const double begin_s = link->now_s();
  const double end_s = options.seconds > 0.0 ? begin_s + options.seconds : HUGE_VAL;
  options.output.announce(fmt::format("recording {} to {}", client::format_bus(address), options.out));
  client::BusRecorder recorder(*link, log, channel_of(address), epoch_us());
  constexpr double kFlush_s = 1.0;  // of a bus that is never quiet
  for (double flushed_s = begin_s; !stop.asked() && link->now_s() < end_s;) {
    const bool heard = recorder.take(std::min(kLook_s, std::max(end_s - link->now_s(), 0.0)));
    if (heard && link->now_s() < flushed_s + kFlush_s) continue;
    written();
    flushed_s = link->now_s();
  }
  written();
  const double seconds = link->now_s() - begin_s;
  options.output.print("{} frames in {:.1f} s: {}\n", recorder.frames(), seconds, options.out);
  Json gaps = Json::array();
  for (const client::BusRecorder::Gap& gap : recorder.gaps())
    gaps.push_back({{"before_frame", gap.before_frame}, {"time_s", gap.time_s}, {"lost", gap.lost}});
  if (!recorder.gaps().empty()) {
    options.output.print(
        "{} frames are missing from it, the first after {:.3f} s, in {}: this PC read too slowly. Error "
        "frames of a full receive buffer mark where\n",
        recorder.lost(), recorder.gaps().front().time_s, counted(recorder.gaps().size(), "gap"));
  }
  options.output.finish({{"frames", recorder.frames()},
                         {"seconds", seconds},
                         {"file", options.out},
                         {"lost", recorder.lost()},
                         {"gaps", gaps}});
  return recorder.gaps().empty() ? kDone : kFailure;
}

}  // namespace

Command add_record(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command(
      "record",
      "Record the frames of a bus, in the log format of can-utils; exit code 1 when some are missing");
  arguments.option("--bus", options->bus, fmt::format("The bus to listen to: {}", client::kOutsideForms))
      .type_name("BUS")
      .required();
  arguments.option("--seconds", options->seconds, "How long (default, and 0: until Ctrl-C)").within(0.0, 1e6);
  arguments.option("-o,--out", options->out, "The log").type_name("FILE.log").required();
  options->output.add_to(arguments);
  arguments.footer(example("  plenum record --bus socketcand:127.0.0.1:29536/can0 --seconds 10 -o bus.log"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
