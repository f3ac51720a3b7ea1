#include "host-sim/tools/demo.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <thread>

#include "host-sim/identify/in_parallel.hpp"
#include "host-sim/identify/profile.hpp"
#include "host-sim/rig/rig.hpp"
#include "host-sim/tools/board_access.hpp"
#include "host-sim/tools/command.hpp"
#include "host-sim/tools/demo_report.hpp"
#include "host-sim/tools/fleet.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/tools/recorded_log.hpp"
#include "host-sim/tools/report_file.hpp"

namespace plenum::host::tools {
namespace {

constexpr double kStretch_s = 0.2;
constexpr double kTracked_s = 8.0;
constexpr double kHorizon_s = 2.0;
constexpr std::size_t kStarts = 48;

struct Options {
  double seconds = 60.0;
  RigChoice rig;
  std::string report = "plenum-demo.html";
  bool gaps = true;
  Output output;
};

using Rows = std::vector<client::CapturedRow>;

/// One line of the summary as soon as it is known, with the time it took.
class Stage {
 public:
  explicit Stage(const Output& output) : output_(output), begin_(std::chrono::steady_clock::now()) {}
  template <class... Args>
  void done(fmt::format_string<Args...> format, Args&&... args) {
    const auto now = std::chrono::steady_clock::now();
    output_.print("{:<86} {:5.1f} s\n", fmt::format(format, std::forward<Args>(args)...),
                  std::chrono::duration<double>(now - begin_).count());
    begin_ = now;
  }

 private:
  const Output& output_;
  std::chrono::steady_clock::time_point begin_;
};

/// Fits all chambers to a recording, and hands the models to the board, which answers with them.
std::vector<identify::Tassa9Fit> identify_and_upload(BoardAccess& board, const Rows& rows, unsigned chambers,
                                                     const trace::RigDescription& rig) {
  std::vector<identify::Tassa9Fit> fits(chambers);
  identify::FitOptions how;
  how.stretch_s = kStretch_s;
  {
    Progress progress("identifying");
    identify::in_parallel(
        chambers, std::thread::hardware_concurrency(),
        [&](std::size_t c) { fits[c] = identify::fit_tassa9_profiled({log_of(rows, c, false)}, rig, how); },
        std::ref(progress));
  }
  std::vector<client::ModelUpload> uploads;
  for (unsigned c = 0; c < chambers; ++c) {
    const trace::ModelFile model = identify::to_model_file(fits[c], c + 1);
    uploads.push_back(upload_of(model, c + 1, fixed_error_kPa(model)));
  }
  // models that regulate better may predict the ten seconds that the board remembers worse
  board.session().upload_models(uploads, client::Doubted::force);
  return fits;
}

Rows record_in_closed_loop(BoardAccess& board, const Options& options, const trace::RigDescription& rig,
                           double seconds, std::uint32_t seed) {
  const SetpointRange range = setpoint_range(rig);
  Progress progress("recording in closed loop");
  return client::follow(
      board.session(),
      client::random_references(options.rig.chambers, seconds, range.low_Pa, range.high_Pa, seed),
      {.chambers = options.rig.chambers}, std::ref(progress));
}

/// Sines up to what these valves can follow, ramps, a random reference, and steps, which nothing can follow.
std::vector<DemoTracked> references(const trace::RigDescription& rig, std::uint64_t seed) {
  using client::ReferenceKind;
  const double ambient_Pa = rig.ambient.pressure_Pa;
  const double span_Pa = rig.supply.pressure_Pa - ambient_Pa;
  const auto shaped = [&](const char* name, ReferenceKind kind, double amplitude, double frequency_Hz) {
    return DemoTracked{.name = name,
                       .shape = {.kind = kind,
                                 .mean_Pa = ambient_Pa + 0.42 * span_Pa,
                                 .amplitude_Pa = amplitude * span_Pa,
                                 .frequency_Hz = frequency_Hz,
                                 .seed = static_cast<std::uint32_t>(seed)},
                       .rows = {},
                       .chamber = {}};
  };
  return {shaped("sine 0.5 Hz", ReferenceKind::sine, 0.25, 0.5),
          shaped("sine 1 Hz", ReferenceKind::sine, 0.25, 1.0),
          shaped("sine 2 Hz", ReferenceKind::sine, 0.17, 2.0),
          shaped("sine 4 Hz", ReferenceKind::sine, 0.10, 4.0),
          shaped("trapezoid", ReferenceKind::trapezoid, 0.25, 0.5),
          shaped("random", ReferenceKind::random, 0.25, 2.5),
          shaped("steps", ReferenceKind::steps, 0.17, 0.5)};
}

void predict_held_out(DemoChamber& chamber) {
  chamber.drift = identify::drift(chamber.held_out, chamber.fit.model, kStarts, kHorizon_s);
  chamber.free_run_rms_kPa = identify::free_run_rms_kPa(chamber.fit.model, chamber.held_out, kHorizon_s);
}

void print_gaps(const Output& output, const std::vector<DemoGap>& gaps) {
  output.print("\n{:<36}{:>20}{:>25}\n", "", "model errs by [kPa]", "regulated to [kPa RMS]");
  output.print("{:<18}{:<18}{:>10}{:>10}{:>15}{:>10}\n", "machine has", "diagnosed", "sheet", "found",
               "with sheet", "found");
  for (const DemoGap& gap : gaps) {
    output.print("{:<18}{:<18}{:10.2f}{:10.2f}{:15.2f}{:10.2f}\n", gap.effect, named_by(gap),
                 gap.report.as_configured_Pa / 1e3, gap.report.with_effects_Pa / 1e3, gap.before.rms_Pa / 1e3,
                 gap.after.rms_Pa / 1e3);
  }
}

Json gaps_json(const std::vector<DemoGap>& gaps) {
  Json list = Json::array();
  for (const DemoGap& gap : gaps) {
    list.push_back({{"effect", gap.effect},
                    {"figures", gap.figures},
                    {"named", named_by(gap)},
                    {"verdict", diagnose::name_of(gap.report.verdict)},
                    {"as_configured_kPa", gap.report.as_configured_Pa / 1e3},
                    {"with_effects_kPa", gap.report.with_effects_Pa / 1e3},
                    {"uploaded", gap.uploaded},
                    {"tracking_rmse_before_kPa", gap.before.rms_Pa / 1e3},
                    {"tracking_rmse_after_kPa", gap.after.rms_Pa / 1e3}});
  }
  return list;
}

Json result_of(const Demo& demo, const std::string& report) {
  Json chambers = Json::array();
  for (std::size_t c = 0; c < demo.chamber.size(); ++c) {
    const DemoChamber& chamber = demo.chamber[c];
    Json one{{"chamber", c + 1},
             {"model", Json::parse(trace::format_model(identify::to_model_file(
                           chamber.fit, static_cast<unsigned>(c + 1))))["parameters"]},
             {"rms_one_step_kPa", chamber.fit.rms_one_step_kPa},
             {"heldout_rms_free_run_2_s_kPa", chamber.free_run_rms_kPa},
             {"drift_worst_std_percent_span", chamber.drift.worst_std_percent}};
    for (const DemoTracked& tracked : demo.tracked)
      one["tracking_rmse_kPa"][tracked.name] = tracked.chamber[c].rmse_Pa / 1e3;
    chambers.push_back(one);
  }
  return {{"seed", demo.seed},
          {"record_s", demo.record_s},
          {"bus_load", demo.bus_load},
          {"simulated_s", demo.simulated_s},
          {"tracking_rmse_kPa", smooth_rmse_kPa(demo)},
          {"drift_worst_std_percent_span", worst_drift_percent(demo)},
          {"chambers", chambers},
          {"gaps", gaps_json(demo.gaps)},
          {"report", report}};
}

int run(const Options& options) {
  const unsigned chambers = options.rig.chambers;
  const auto seed = static_cast<std::uint32_t>(options.rig.seed);
  const auto begin = std::chrono::steady_clock::now();
  Stage stage(options.output);
  Demo demo{.rig = options.rig.description(),
            .measured_valves = options.rig.plant == "mpye",
            .span_Pa = 0.0,
            .record_s = options.seconds,
            .volume_swing = options.rig.volume_swing,
            .seed = options.rig.seed,
            .chamber = std::vector<DemoChamber>(chambers),
            .tracked = {},
            .gaps = {}};
  demo.span_Pa = demo.rig.supply.pressure_Pa - demo.rig.ambient.pressure_Pa;
  BoardAccess board(options.rig.config());

  Rows excited;
  {
    Progress progress("recording");
    excited =
        client::capture(board.session(), {.seconds = options.seconds, .seed = seed, .chambers = chambers},
                        std::ref(progress));
  }
  stage.done("recorded {} for {:g} s over CAN, valves excited at random", counted(chambers, "chamber"),
             options.seconds);
  auto fits = identify_and_upload(board, excited, chambers, demo.rig);
  for (unsigned c = 0; c < chambers; ++c) {
    demo.chamber[c].excited = std::move(fits[c]);
    demo.chamber[c].excitation = log_of(excited, c, false);
  }
  stage.done("identified, uploaded over CAN, read back identical: {}", counted(chambers, "model"));
  const Rows followed = record_in_closed_loop(board, options, demo.rig, options.seconds, seed + 1);
  stage.done("recorded {:g} s more, regulated to random references", options.seconds);
  fits = identify_and_upload(board, followed, chambers, demo.rig);
  for (unsigned c = 0; c < chambers; ++c) demo.chamber[c].fit = std::move(fits[c]);
  stage.done("identified on these, uploaded, read back identical: {}", counted(chambers, "model"));

  const Rows held_out =
      record_in_closed_loop(board, options, demo.rig, std::max(20.0, 0.5 * options.seconds), seed + 2);
  for (unsigned c = 0; c < chambers; ++c) demo.chamber[c].held_out = log_of(held_out, c, true);
  identify::in_parallel(chambers, std::thread::hardware_concurrency(),
                        [&](std::size_t c) { predict_held_out(demo.chamber[c]); });
  stage.done("predicted a third recording in free runs of 2 s: drift up to {:.1f} % of span",
             worst_drift_percent(demo));
  demo.tracked = references(demo.rig, options.rig.seed);
  for (DemoTracked& tracked : demo.tracked) {
    Progress progress("regulating, " + tracked.name);
    tracked.rows = client::follow(board.session(), client::references(tracked.shape, chambers, kTracked_s),
                                  {.chambers = chambers}, std::ref(progress));
    for (unsigned c = 0; c < chambers; ++c)
      tracked.chamber.push_back(client::tracking(tracked.rows, c, demo.span_Pa));
  }
  stage.done("regulated {} references at 100 Hz, {:g} s each", demo.tracked.size(), kTracked_s);
  demo.bus_load = board.rig()->bus().busy_share();
  demo.bus_frames = board.rig()->bus().counters().frames;
  demo.simulated_s = board.rig()->now_s();
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (options.gaps) {
    {
      Progress progress("recording, diagnosing and regulating machines with an effect");
      demo.gaps = close_gaps({}, seed, std::ref(progress));
    }
    stage.done("diagnosed {} machines, each with an effect missing from its data sheet", demo.gaps.size());
  }

  options.output.print("\n{:<16}", "RMS error [kPa]");
  for (unsigned c = 0; c < chambers; ++c) options.output.print(" {:>8}", fmt::format("ch. {}", c + 1));
  options.output.print("\n");
  for (const DemoTracked& tracked : demo.tracked) {
    options.output.print("{:<16}", tracked.name);
    for (const client::Tracking& one : tracked.chamber) options.output.print(" {:8.2f}", one.rmse_Pa / 1e3);
    options.output.print("\n");
  }
  options.output.print(
      "all but steps: {:.2f} kPa, {:.2f} % of span; bus load {:.0f} %; {:.0f} s simulated in {:.1f} s\n",
      smooth_rmse_kPa(demo), 1e5 * smooth_rmse_kPa(demo) / demo.span_Pa, 100.0 * demo.bus_load,
      demo.simulated_s, took_s);
  if (options.gaps) print_gaps(options.output, demo.gaps);
  options.output.finish(result_of(demo, options.report));  // first: what follows may be refused
  write_report(options.output, options.report, [&] { return demo_page(demo); });
  return kDone;
}

}  // namespace

Command add_demo(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments =
      program.command("demo", "Simulate a rig; record, identify, upload, regulate over CAN; draw a report");
  arguments.option("--seconds", options->seconds, "Length of each recording to identify from [s]")
      .within(4.0, 3600.0)
      .show_default();
  arguments.flag(
      "!--no-gaps", options->gaps,
      "Leave out the second half: machines with an effect missing from their data sheet, diagnosed and "
      "regulated with the model found");
  options->rig.add_to(arguments);
  arguments.option("--report", options->report, "Page to write").type_name("FILE.html").show_default();
  options->output.add_to(arguments);
  arguments.footer(example("  plenum demo --seconds 30 --report demo.html"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
