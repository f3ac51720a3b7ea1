#include "host-sim/tools/acceptance_report.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace plenum::host::tools {
namespace {

constexpr double kTick_s = 0.01;
constexpr double kBelowOne = 0.5;  // tick: a bin that holds one has a bar on a logarithmic axis

std::vector<double> ticks_s(std::size_t rows) {
  std::vector<double> times_s(rows);
  for (std::size_t k = 0; k < rows; ++k) times_s[k] = static_cast<double>(k) * kTick_s;
  return times_s;
}

std::string limit_text(const client::Criterion& criterion) {
  return fmt::format("≤\u00a0{:g}", criterion.limit);
}

report::Table verdict_table(std::span<const client::Judged> judged) {
  report::Table table{.caption = "Every item",
                      .columns = {"Item", "Measured", "Unit", "Limit", "Verdict", "Remark"},
                      .rows = {}};
  for (const client::Judged& one : judged) {
    table.rows.push_back({std::string(one.criterion.text),
                          one.value ? report::Cell(*one.value) : report::Cell(std::string("-")),
                          std::string(one.criterion.unit), limit_text(one.criterion),
                          std::string(client::verdict_name(one.verdict)), one.remark});
  }
  return table;
}

/// The bins from the first that holds a tick to the last.
report::BarChart latency_chart(const client::LoopLatency& loop) {
  const auto holds = [](const client::LatencyBin& bin) { return bin.ticks > 0; };
  const auto first = std::find_if(loop.bin.begin(), loop.bin.end(), holds);
  const auto last = std::find_if(loop.bin.rbegin(), loop.bin.rend(), holds).base();
  report::BarChart chart{.title = "How late ticks began",
                         .caption = "Ticks by the board's own clock; each bar is a bin of object 2201h.",
                         .categories = {},
                         .value = {"Ticks", "", kBelowOne, {}, true},
                         .series = {{"ticks", {}}}};
  std::for_each(first, last, [&](const client::LatencyBin& bin) {
    chart.categories.push_back(fmt::format("{} us", bin.lowest_us));
    chart.series.front().values.push_back(bin.ticks);
  });
  return chart;
}

report::Table reading_table(const AcceptanceRun& run) {
  report::Table table{.caption = "Each chamber at rest",
                      .columns = {"Chamber", "Mean [kPa]", "Noise [Pa]", "Standard deviation [kPa]",
                                  "Step [Pa]", "Position [V]", "Position noise [mV]", "Volume noise [mL]"},
                      .rows = {}};
  for (std::size_t c = 0; c < run.reading.size(); ++c) {
    const client::Reading& reading = run.reading[c];
    table.rows.push_back(
        {fmt::format("{}", c + 1), report::Fixed{1e-3 * reading.mean, 1}, report::Fixed{reading.noise, 1},
         report::Fixed{1e-3 * reading.std, 2},
         reading.step ? report::Cell(*reading.step)
                      : report::Cell(std::string(reading.changed ? "not seen" : "never changed")),
         report::Fixed{run.position[c].mean, 3}, report::Fixed{1e3 * run.position[c].noise, 2},
         report::Fixed{volume_noise_mL(run, c), 3}});
  }
  return table;
}

report::LineChart rest_chart(const AcceptanceRun& run) {
  report::LineChart chart{.title = "Pressures at rest, from their means",
                          .caption =
                              "Where a chamber's volume moves, as those of a simulated board do, its "
                              "pressure moves with it, though the valve rests.",
                          .y = {"Pressure", "Pa"},
                          .curves = {}};
  const std::vector<double> times_s = ticks_s(run.rows);
  for (std::size_t c = 0; c < run.rest_Pa.size(); ++c) {
    std::vector<double> from_mean_Pa = run.rest_Pa[c];
    for (double& pressure_Pa : from_mean_Pa) pressure_Pa -= run.reading[c].mean;
    chart.curves.push_back({fmt::format("chamber {}", c + 1), times_s, std::move(from_mean_Pa)});
  }
  return chart;
}

report::Table answer_table(const AcceptanceRun& run) {
  report::Table table{
      .caption = "Which valve each pressure follows",
      .columns = {"Chamber", "Correlation with its own valve", "Follows most", "Correlation", "Finding"},
      .rows = {}};
  for (std::size_t c = 0; c < run.answer.size(); ++c) {
    const client::Answer& answer = run.answer[c];
    const std::string trouble = client::trouble_of(answer, c);
    table.rows.push_back({fmt::format("{}", c + 1), report::Fixed{answer.own, 2},
                          fmt::format("valve {}", answer.best + 1), report::Fixed{answer.best_correlation, 2},
                          trouble.empty() ? std::string("answers") : trouble});
  }
  return table;
}

void add_motion(report::Section& section, const AcceptanceRun& run) {
  section
      .paragraph(
          "The board excited its valves at random within the pressures it was given. A pressure's change in "
          "a "
          "tick is held against the command some ticks before: 1 is a rising command that feeds the chamber.")
      .table(answer_table(run));
  const std::vector<double> times_s = ticks_s(run.moved.size());
  for (std::size_t c = 0; c < run.answer.size(); ++c) {
    std::vector<double> pressure_kPa;
    std::vector<double> command_V;
    for (const client::CapturedRow& row : run.moved) {
      pressure_kPa.push_back(1e-3 * row.sample[c].actual_Pa);
      command_V.push_back(row.sample[c].command_V);
    }
    section.row(
        {report::LineChart{.title = fmt::format("Chamber {}, pressure", c + 1),
                           .y = {"Pressure", "kPa"},
                           .curves = {{"pressure", times_s, std::move(pressure_kPa)}},
                           .group = "moved"},
         report::LineChart{.title = fmt::format("Chamber {}, command", c + 1),
                           .y = {"Command", "V"},
                           .curves = {{"command", times_s, std::move(command_V), report::Stroke::kSteps}},
                           .group = "moved"}});
  }
}

}  // namespace

report::Page acceptance_page(const std::string& board, const AcceptanceRun& run,
                             std::span<const client::Judged> judged) {
  report::Page page(client::accepted(judged) ? "Acceptance: passed" : "Acceptance: failed");
  page.lead(board);
  std::vector<report::Tile> tiles;
  for (const client::Judged& one : judged) {
    if (!one.value) continue;
    const client::Criterion& criterion = one.criterion;
    tiles.push_back({std::string(criterion.text), *one.value, std::string(criterion.unit),
                     report::at_most(criterion.limit), one.remark});
  }
  page.tiles(std::move(tiles));
  page.section("Verdict").table(verdict_table(judged));
  page.section("Loop").chart(latency_chart(run.loop));
  page.section("Converters at rest")
      .paragraph(
          "Noise is estimated from second differences of neighbouring ticks, a second at a time, so that "
          "drift does "
          "not enter; the standard deviation has it. A step shows where all differences are its multiples.")
      .table(reading_table(run))
      .chart(rest_chart(run));
  report::Section& motion = page.section("Valves and their chambers");
  if (run.answer.empty()) {
    motion.note(run.moving_fault.empty() ? fmt::format("Not run: {}.", run.not_moved)
                                         : fmt::format("Ended early: {}.", run.moving_fault));
  } else {
    add_motion(motion, run);
  }
  return page;
}

}  // namespace plenum::host::tools
