#include <memory>

#include "host-sim/tools/acceptance_report.hpp"
#include "host-sim/tools/acceptance_run.hpp"
#include "host-sim/tools/arguments.hpp"
#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/board_json.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/report_file.hpp"
#include "host-sim/tools/stop_signal.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  BoardChoice board;
  double seconds = 30.0;
  std::uint32_t bit_rate = 1'000'000;
  bool move = false;
  double move_seconds = 30.0;
  double command_low_V = 4.0;
  double command_high_V = 6.0;
  double pressure_low_kPa = 150.0;
  double pressure_high_kPa = 400.0;
  std::vector<std::string> limits;
  std::string report;
  Output output;
};

void require_ranges(const Options& options) {
  require_order("--command-low", options.command_low_V, "--command-high", options.command_high_V, "V");
  require_order("--pressure-low", options.pressure_low_kPa, "--pressure-high", options.pressure_high_kPa,
                "kPa");
  client::judge({}, options.limits);
}

AcceptancePlan plan_of(const Options& options) {
  AcceptancePlan plan{.seconds = options.seconds,
                      .chambers = options.board.rig.chambers,
                      .bit_rate = options.bit_rate,
                      .motion = {},
                      .stopped = {}};
  if (!options.move) return plan;
  plan.motion = {.seconds = options.move_seconds,
                 .seed = static_cast<std::uint32_t>(options.board.rig.seed),
                 .command_low_V = static_cast<float>(options.command_low_V),
                 .command_high_V = static_cast<float>(options.command_high_V),
                 .pressure_low_Pa = 1e3 * options.pressure_low_kPa,
                 .pressure_high_Pa = 1e3 * options.pressure_high_kPa,
                 .chambers = options.board.rig.chambers};
  return plan;
}

void print(const Output& output, std::span<const client::Judged> judged) {
  output.print("{:<50}  {:>10}  {:>10}  {:<5}  {}\n", "item", "measured", "limit", "", "verdict");
  for (const client::Judged& one : judged) {
    const client::Criterion& criterion = one.criterion;
    output.print("{:<50}  {:>10}  {:>10}  {:<5}  {}{}\n", criterion.text,
                 one.value ? fmt::format("{:.4g}", *one.value) : "-", fmt::format("<= {:g}", criterion.limit),
                 criterion.unit, client::verdict_name(one.verdict),
                 one.remark.empty() ? "" : "  (" + one.remark + ")");
  }
}

void print_readings(const Output& output, const AcceptanceRun& run) {
  output.print("\n{:>7}  {:>10}  {:>10}  {:>8}  {:>9}  {:>17}  {}\n", "chamber", "mean [kPa]", "noise [Pa]",
               "std [Pa]", "step [Pa]", "volume noise [mL]", "answer to its valve");
  for (std::size_t c = 0; c < run.reading.size(); ++c) {
    const client::Reading& reading = run.reading[c];
    output.print("{:>7}  {:>10.2f}  {:>10.1f}  {:>8.1f}  {:>9}  {:>17.3g}  {}\n", c + 1, 1e-3 * reading.mean,
                 reading.noise, reading.std, reading.step ? fmt::format("{:.3g}", *reading.step) : "-",
                 volume_noise_mL(run, c),
                 run.answer.empty() ? "not run" : fmt::format("{:.2f}", run.answer[c].own));
  }
}

Json items_json(std::span<const client::Judged> judged) {
  Json items = Json::array();
  for (const client::Judged& one : judged) {
    items.push_back({{"id", one.criterion.id},
                     {"value", number(one.value)},
                     {"unit", one.criterion.unit},
                     {"at_most", one.criterion.limit},
                     {"verdict", client::verdict_name(one.verdict)},
                     {"remark", one.remark}});
  }
  return items;
}

Json chambers_json(const AcceptanceRun& run) {
  Json chambers = Json::array();
  for (std::size_t c = 0; c < run.reading.size(); ++c) {
    const client::Reading& reading = run.reading[c];
    Json one{{"chamber", c + 1},
             {"mean_kPa", number(1e-3 * reading.mean)},
             {"noise_Pa", number(reading.noise)},
             {"std_Pa", number(reading.std)},
             {"step_Pa", number(reading.step)},
             {"position_V", number(run.position[c].mean)},
             {"position_noise_V", number(run.position[c].noise)},
             {"volume_noise_mL", number(volume_noise_mL(run, c))},
             {"answer", nullptr}};
    if (!run.answer.empty()) {
      one["answer"] = {{"own_valve", number(run.answer[c].own)},
                       {"follows_valve", run.answer[c].best + 1},
                       {"correlation", number(run.answer[c].best_correlation)},
                       {"trouble", client::trouble_of(run.answer[c], c)}};
    }
    chambers.push_back(one);
  }
  return chambers;
}

Json latency_json(const client::LoopLatency& loop) {
  Json bins = Json::array();
  for (const client::LatencyBin& bin : loop.bin) {
    if (bin.ticks > 0) bins.push_back({{"lowest_us", bin.lowest_us}, {"ticks", bin.ticks}});
  }
  return bins;
}

int run(const Options& options) {
  require_ranges(options);
  BoardAccess access(options.board);
  MeteredLink link(access.link());
  client::Session session(link, static_cast<std::uint8_t>(options.board.node),
                          options.board.session_config());
  client::require_compatible(session);
  const client::Identity identity = client::read_identity(session);
  const client::Versions versions = client::read_versions(session);
  AcceptanceRun measured;
  {
    const StopSignal stop;  // the valves have to come to rest, and what is borrowed be given back
    AcceptancePlan plan = plan_of(options);
    plan.stopped = [&stop] { return stop.asked(); };
    Progress progress("measuring");
    measured = run_acceptance(link, session, plan, std::ref(progress));
  }
  const std::vector<client::Judged> judged = client::judge(measured_by(measured), options.limits);
  const bool accepted = client::accepted(judged);
  const std::string board =
      fmt::format("Node {}: {}, hardware {}, software {}, serial {}; {}, {:g} s at rest{}.",
                  session.node_id(), versions.device, versions.hardware, versions.software, identity.serial,
                  counted(options.board.rig.chambers, "chamber"), options.seconds,
                  options.move ? fmt::format(", {:g} s with its valves excited", options.move_seconds) : "");
  options.output.print("{}\n\n", board);
  print(options.output, judged);
  print_readings(options.output, measured);
  options.output.print("\nacceptance: {}\n", accepted ? "passed" : "failed");
  write_report(options.output, options.report, [&] { return acceptance_page(board, measured, judged); });
  options.output.finish({{"schema", "plenum-acceptance/1"},
                         {"node", session.node_id()},
                         {"identity", identity_json(identity)},
                         {"versions", versions_json(versions)},
                         {"seconds", options.seconds},
                         {"accepted", accepted},
                         {"items", items_json(judged)},
                         {"latency", latency_json(measured.loop)},
                         {"chambers", chambers_json(measured)}});
  return accepted ? kDone : kFailure;
}

void add_motion(Arguments& arguments, Options& options) {
  arguments.flag("--move", options.move,
                 "Read the outputs back by the sensors. THE VALVES MOVE and chambers fill: a chamber whose "
                 "sensor lies may reach the supply's pressure (default: off, no valve moves)");
  arguments.option("--move-seconds", options.move_seconds, "How long they are excited [s]")
      .within(10.0, 600.0)
      .show_default();
  arguments.option("--command-low", options.command_low_V, "Least command while moving [V]")
      .within(0.0, 10.0)
      .show_default();
  arguments.option("--command-high", options.command_high_V, "Greatest command while moving [V]")
      .within(0.0, 10.0)
      .show_default();
  arguments
      .option("--pressure-low", options.pressure_low_kPa,
              "While moving the board turns a valve before a pressure leaves this [kPa, absolute]")
      .not_negative()
      .show_default();
  arguments.option("--pressure-high", options.pressure_high_kPa, "Likewise [kPa, absolute]")
      .not_negative()
      .show_default();
}

}  // namespace

Command add_acceptance(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command(
      "acceptance",
      "Test a board on its own hardware: latency, jitter, SDO, CAN load, noise, and with --move its valves");
  options->board.add_to(arguments);
  arguments.option("--seconds", options->seconds, "How long to listen while nothing moves [s]")
      .within(1.0, 36000.0)
      .show_default();
  arguments.option("--bit-rate", options->bit_rate, "Of the bus, for its load [bit/s]")
      .within(10'000U, 1'000'000U)
      .show_default();
  add_motion(arguments, *options);
  arguments
      .option("--limit", options->limits,
              "A limit in the place of the default; repeatable: latency_p999_us=200 (default: those that the "
              "result shows)")
      .type_name("NAME=VALUE")
      .one_at_a_time();
  arguments.option("--report", options->report, "Page to write (default: none)").type_name("FILE.html");
  options->output.add_to(arguments);
  arguments.footer(
      example("  plenum acceptance --bus can:can0 --node 5 --report board-5.html          # no valve moves\n"
              "  plenum acceptance --bus can:can0 --node 5 --move --pressure-high 300"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
