#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>

#include "host-sim/client/board_facts.hpp"
#include "host-sim/client/references.hpp"
#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/board_json.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/stop_signal.hpp"

namespace plenum::host::tools {
namespace {

struct Options {
  BoardChoice board;
  std::string kind = "sine";
  double mean_kPa = 350.0;
  double amplitude_kPa = 100.0;
  double frequency_Hz = 1.0;
  double seconds = 10.0;
  unsigned preview_ticks = client::FollowOptions{}.preview_ticks;
  std::string out = "regulate";
  Output output;
};

const std::map<std::string, client::ReferenceKind> kKinds{{"sine", client::ReferenceKind::sine},
                                                          {"steps", client::ReferenceKind::steps},
                                                          {"trapezoid", client::ReferenceKind::trapezoid},
                                                          {"random", client::ReferenceKind::random}};

std::string shown(double value, double scale) {
  return std::isfinite(value) ? fmt::format("{:.2f}", value * scale) : "-";
}

constexpr double kTick_s = 0.01;
constexpr unsigned kMostPreview_ticks = 8;

constexpr double kNone_ticks = 0.05;  ///< hardly seen, and printed as 0.0

/// A valve's delay and what a prompt one needs.
double ticks_over(double delay_s) {
  return delay_s / kTick_s + client::FollowOptions{}.preview_ticks;
}

/// Likewise, as far as a board can be told.
unsigned preview_over(double delay_s) {
  return std::min(static_cast<unsigned>(std::ceil(ticks_over(delay_s) - kNone_ticks)), kMostPreview_ticks);
}

int run(const Options& options) {
  const trace::RigDescription description = options.board.rig.description();
  const double span_Pa = description.supply.pressure_Pa - description.ambient.pressure_Pa;
  const unsigned chambers = options.board.rig.chambers;
  const auto references = client::references({.kind = kKinds.at(options.kind),
                                              .mean_Pa = options.mean_kPa * 1e3,
                                              .amplitude_Pa = options.amplitude_kPa * 1e3,
                                              .frequency_Hz = options.frequency_Hz,
                                              .seed = static_cast<std::uint32_t>(options.board.rig.seed)},
                                             chambers, options.seconds);
  options.board.require_stored();
  BoardAccess board(options.board);
  client::require_compatible(board.session());
  client::require_within_limits(board.session(), references);
  const auto models = require_models(board.session(), options.board);
  const StopSignal stop;  // the valves have to come to rest, and what is borrowed be given back
  const OutputFolder folder(options.out);
  std::vector<client::CapturedRow> rows;
  RecordedSoFar so_far(options.out, chambers, true, description, options.output);
  {
    Progress progress("regulating");
    rows = client::follow(board.session(), references,
                          {.preview_ticks = static_cast<std::uint8_t>(options.preview_ticks),
                           .chambers = chambers,
                           .stopped = [&stop] { return stop.asked(); },
                           .so_far = so_far.rows()},
                          std::ref(progress));
  }
  constexpr std::size_t kLeastRows = client::kOnsetRows + 2;
  if (rows.size() < kLeastRows) {
    throw std::runtime_error(fmt::format(
        "stopped by hand after {} rows, expected at least {} to tell errors from", rows.size(), kLeastRows));
  }
  write_recording(options.out, rows, chambers, true, description);

  Json list = Json::array();
  std::string lagging;
  double delay_s = 0.0;  // of the latest valve
  options.output.print("{:>7}  {:>10}  {:>12}  {:>21}  {:>12}  {:>24}\n", "chamber", "RMSE [kPa]",
                       "worst [kPa]", "overshoot [% of span]", "settling [s]", "model misses [kPa/tick]");
  for (unsigned c = 0; c < chambers; ++c) {
    const client::DecodedModel model = client::decode_model(models[c]);
    const double lag_s = client::sensor_lag_s(model);
    delay_s = std::max(delay_s, client::valve_delay_s(model));
    const client::Tracking tracking = client::tracking(rows, c, span_Pa, lag_s);
    const double drift_Pa = client::read_drift_Pa(board.session(), static_cast<std::uint8_t>(c));
    if (lag_s > 0.0)
      lagging += fmt::format("{}{} by {:.0f} ms", lagging.empty() ? "" : ", ", c + 1, 1e3 * lag_s);
    options.output.print("{:7}  {:10.2f}  {:12.2f}  {:>21}  {:>12}  {:24.2f}\n", c + 1,
                         tracking.rmse_Pa / 1e3, tracking.worst_Pa / 1e3,
                         shown(tracking.overshoot_Pa, 100.0 / span_Pa), shown(tracking.settling_s, 1.0),
                         drift_Pa / 1e3);
    list.push_back({{"chamber", c + 1},
                    {"rmse_kPa", tracking.rmse_Pa / 1e3},
                    {"worst_kPa", tracking.worst_Pa / 1e3},
                    {"overshoot_percent_of_span", number(100.0 * tracking.overshoot_Pa / span_Pa)},
                    {"settling_s", number(tracking.settling_s)},
                    {"sensor_lag_s", lag_s},
                    {"model_misses_kPa_per_tick", drift_Pa / 1e3}});
  }
  if (!lagging.empty()) {
    options.output.print(
        "readings that lag as the model says are held against what they would be of the reference: chamber "
        "{}\n",
        lagging);
  }
  const unsigned wanted_ticks = preview_over(delay_s);
  if (wanted_ticks > preview_over(0.0) && options.preview_ticks < wanted_ticks) {
    options.output.print(
        "the models have a valve late by {:.1f} ticks: --preview {} tells the board of the reference early "
        "enough\n",
        delay_s / kTick_s, wanted_ticks);
  }
  const double beyond_ticks = ticks_over(delay_s) - kMostPreview_ticks;
  if (beyond_ticks > kNone_ticks) {
    options.output.print(
        "the models have a valve late by {:.1f} ticks: {:.1f} more than any preview makes up for\n",
        delay_s / kTick_s, beyond_ticks);
  }
  const auto fault = client::read_fault(board.session());
  if (fault) {
    options.output.print("the board reports {}\n  {}\n", client::fault_text(*fault), fault_advice(*fault));
  }
  options.output.print("the first half second is left out; {}recorded in {}\n",
                       stop.asked() ? fmt::format("stopped by hand after {} rows, ", rows.size()) : "",
                       options.out);
  options.output.finish({{"rows", rows.size()},
                         {"stopped", stop.asked()},
                         {"bus_load", number(board.bus_load())},
                         {"fault", fault ? Json(client::fault_text(*fault)) : Json()},
                         {"chambers", list}});
  return fault && client::reacts(*fault) ? kFailure : kDone;
}

}  // namespace

Command add_regulate(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments =
      program.command("regulate",
                      "Let a board regulate its chambers to a reference at 100 Hz, and record how well it "
                      "does; Ctrl-C ends it early, with the rows so far");
  options->board.add_to(arguments);
  arguments.option("--reference", options->kind, "What to follow")
      .one_of({"sine", "steps", "trapezoid", "random"})
      .show_default();
  arguments.option("--mean", options->mean_kPa, "Middle of the reference [kPa, absolute]").show_default();
  arguments.option("--amplitude", options->amplitude_kPa, "From the middle to the farthest [kPa]")
      .not_negative()
      .show_default();
  arguments
      .option("--frequency", options->frequency_Hz, "Of the reference; of its fastest part if random [Hz]")
      .within(0.01, 49.0)
      .show_default();
  arguments.option("--seconds", options->seconds, "Length [s]").within(1.0, 36000.0).show_default();
  arguments
      .option("--preview", options->preview_ticks,
              "How many ticks ahead the board is told of the reference: at least a valve's delay and 2, to "
              "follow without lag")
      .within(0U, kMostPreview_ticks)
      .type_name("TICKS")
      .show_default();
  arguments.option("-o,--out", options->out, "Folder for chamber-N.csv and rig.toml")
      .type_name("DIR")
      .show_default();
  options->output.add_to(arguments);
  arguments.footer(
      example("  plenum regulate --store board --reference sine --frequency 2 --amplitude 80 -o tracked"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
