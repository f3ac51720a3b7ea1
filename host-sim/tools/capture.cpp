#include "host-sim/client/capture.hpp"

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <utility>

#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/board_log.hpp"
#include "host-sim/tools/arguments.hpp"
#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/stop_signal.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  BoardChoice board;
  double seconds = 60.0;
  bool closed_loop = false;
  bool last = false;
  double pressure_low_kPa = client::CaptureOptions{}.pressure_low_Pa / 1e3;
  double pressure_high_kPa = client::CaptureOptions{}.pressure_high_Pa / 1e3;
  double command_low_V = static_cast<double>(client::CaptureOptions{}.command_low_V);
  double command_high_V = static_cast<double>(client::CaptureOptions{}.command_high_V);
  double largest_volume_L = client::CaptureOptions{}.largest_volume_m3 * 1e3;
  std::string out = "capture";
  Output output;
};

/// Of random references: where a rig's valves can take them, and within what is asked for.
SetpointRange reference_range(const Options& options, const trace::RigDescription& description) {
  const SetpointRange able = setpoint_range(description);
  const SetpointRange range{std::max(able.low_Pa, options.pressure_low_kPa * 1e3),
                            std::min(able.high_Pa, options.pressure_high_kPa * 1e3)};
  if (range.low_Pa < range.high_Pa) return range;
  throw std::invalid_argument(fmt::format(
      "--pressure-low {:g} kPa, --pressure-high {:g} kPa: expected some of what the rig can be led to, {:g} "
      "to {:g} kPa",
      options.pressure_low_kPa, options.pressure_high_kPa, able.low_Pa / 1e3, able.high_Pa / 1e3));
}

/// What regulation may do beyond the references: a twentieth of their range. The board's own settings trip later.
double highest_Pa(const Options& options) {
  return 1e3 * (options.pressure_high_kPa + 0.05 * (options.pressure_high_kPa - options.pressure_low_kPa));
}

/// Of what is built into the board's chambers, as far as it states them.
void state_serials(trace::RigDescription& description, client::Session& session, unsigned chambers) {
  for (unsigned c = 0; c < chambers; ++c) {
    const client::Serials serials = client::read_serials(session, static_cast<std::uint8_t>(c));
    if (serials.valve == 0 && serials.sensor == 0) continue;
    description.chamber[c + 1] = {.valve_serial = serials.valve, .sensor_serial = serials.sensor};
  }
}

int run(const Options& options) {
  require_order("--pressure-low", options.pressure_low_kPa, "--pressure-high", options.pressure_high_kPa,
                "kPa");
  require_order("--command-low", options.command_low_V, "--command-high", options.command_high_V, "V");
  if (options.last && options.board.simulated()) {
    throw std::invalid_argument(
        "--last with --bus inproc: a simulated board forgets its ticks with each command, expected a board "
        "on a bus");
  }
  trace::RigDescription description = options.board.rig.description();
  if (options.closed_loop || !options.board.store.empty()) options.board.require_stored();
  BoardAccess board(options.board);
  client::require_compatible(board.session());
  const unsigned chambers = options.board.rig.chambers;
  if (options.closed_loop) require_models(board.session(), options.board);
  state_serials(description, board.session(), chambers);
  const StopSignal stop;  // what is driven has to come to rest, and what is borrowed be given back
  const auto stopped = [&stop] { return stop.asked(); };
  const OutputFolder folder(options.out);
  const auto seed = static_cast<std::uint32_t>(options.board.rig.seed);
  std::vector<client::CapturedRow> rows;
  RecordedSoFar so_far(options.out, chambers, options.closed_loop, description, options.output);
  std::string how = options.closed_loop ? "following random references" : "excited";
  if (options.last) {
    Progress progress("reading what the board remembers");
    client::Remembered log = client::remembered(board.session(), chambers, [&](double done) {
      progress(done);
      if (stopped()) throw std::runtime_error("stopped by hand before all was read that the board remembers");
    });
    how = log.before == 0
              ? "as the board remembers them"
              : fmt::format("as the board remembers them; {} from before a pause are left out", log.before);
    rows = std::move(log.rows);
  } else if (options.closed_loop) {
    const SetpointRange range = reference_range(options, description);
    Progress progress("recording in closed loop");
    rows = client::follow(
        board.session(),
        client::random_references(chambers, options.seconds, range.low_Pa, range.high_Pa, seed),
        {.largest_volume_m3 = options.largest_volume_L / 1e3,
         .highest_Pa = highest_Pa(options),
         .chambers = chambers,
         .stopped = stopped,
         .so_far = so_far.rows()},
        std::ref(progress));
  } else {
    Progress progress("recording");
    rows = client::capture(board.session(),
                           {.seconds = options.seconds,
                            .seed = seed,
                            .command_low_V = static_cast<float>(options.command_low_V),
                            .command_high_V = static_cast<float>(options.command_high_V),
                            .pressure_low_Pa = options.pressure_low_kPa * 1e3,
                            .pressure_high_Pa = options.pressure_high_kPa * 1e3,
                            .largest_volume_m3 = options.largest_volume_L / 1e3,
                            .chambers = chambers,
                            .stopped = stopped,
                            .so_far = so_far.rows()},
                           std::ref(progress));
  }
  if (stopped()) {
    if (rows.size() < kLeastLogRows) {
      throw std::runtime_error(fmt::format("stopped by hand after {} rows, expected at least {} for a log",
                                           rows.size(), kLeastLogRows));
    }
    how += ", stopped by hand";
  }
  write_recording(options.out, rows, chambers, options.closed_loop, description);
  options.output.print("{}, {} rows each, {}: {}\n", counted(chambers, "chamber"), rows.size(), how,
                       options.out);
  Json files = Json::array();
  for (unsigned c = 0; c < chambers; ++c)
    files.push_back((std::filesystem::path(options.out) / fmt::format("chamber-{}.csv", c + 1)).string());
  options.output.finish({{"rows", rows.size()},
                         {"closed_loop", options.closed_loop},
                         {"last", options.last},
                         {"stopped", stopped()},
                         {"seed", options.board.rig.seed},
                         {"bus_load", number(board.bus_load())},
                         {"files", files}});
  return kDone;
}

}  // namespace

Command add_capture(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command(
      "capture",
      "Record a board's chambers over CAN, for identification; Ctrl-C ends it early, with the rows so far. "
      "Refused by a board that somebody regulates");
  options->board.add_to(arguments);
  arguments.option("--seconds", options->seconds, "Length of the recording [s]")
      .within(1.0, 36000.0)
      .show_default();
  arguments.flag("--closed-loop", options->closed_loop,
                 "Follow random references with the models on the board (default: off, excite the valves). A "
                 "model fitted to such a recording regulates better. Ends where a pressure goes beyond "
                 "--pressure-high by a twentieth of the range");
  arguments
      .flag("--last", options->last,
            "Drive nothing: read what the board remembers of the last 10 s in which it drove its valves, "
            "after a fault, say (default: off)")
      .excludes("--closed-loop");
  arguments
      .option("--pressure-low", options->pressure_low_kPa,
              "The valve is turned before a pressure leaves these limits, or those of the board's settings "
              "where they are "
              "narrower [kPa, absolute]")
      .within(0.0, 2000.0)
      .show_default();
  arguments.option("--pressure-high", options->pressure_high_kPa, "Likewise [kPa, absolute]")
      .within(0.0, 2000.0)
      .show_default();
  arguments
      .option("--command-low", options->command_low_V,
              "Lowest command of the excitation, or that of the board's settings where it is higher; the "
              "pressure's limits are kept by "
              "these commands, too: they must open both ports [V]")
      .within(0.0, 10.0)
      .show_default();
  arguments.option("--command-high", options->command_high_V, "Highest, likewise [V]")
      .within(0.0, 10.0)
      .show_default();
  arguments
      .option("--largest-volume", options->largest_volume_L,
              "Of a chamber [L]: what the recording's volumes have room for, in steps of a 65535th of it")
      .within(0.01, 1000.0)
      .show_default();
  arguments
      .option("-o,--out", options->out,
              "Folder for chamber-N.csv and rig.toml, with the serial numbers that the board states")
      .type_name("DIR")
      .show_default();
  options->output.add_to(arguments);
  arguments.footer(example(
      "  plenum capture --seconds 60 -o first                            # valves excited at random\n"
      "  plenum capture --bus can:can0 --pressure-high 400 -o soft       # of an actuator good for 4 bar\n"
      "  plenum capture --store board --closed-loop --seed 2 -o second   # regulated to random references\n"
      "  plenum capture --bus can:can0 --last -o fault                   # what led to a fault"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
