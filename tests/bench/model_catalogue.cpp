// The three models side by side under each effect of the catalogue: what an identification makes of a machine that is not nominal.
//
// Each rig of effect_trials.hpp, and one without any effect, is excited by its board and recorded twice over CAN, from rest, for 20 s
// and by two seeds. To the four logs of the first recording a model of each kind is fitted as `plenum identify` fits it, the grey-box
// model with those effects that the logs demand; beside them stands the grey-box model of the rig's own figures, `told`, as far as
// the board has parameters for the effect (elsewhere nothing is in that column). Each model then
//   - predicts each log of the second recording in one free run of the board's own code, valve and sensor included, from the
//     pressure of its first row: RMS of the reading's error in percent of P_c - P_r (a sensor's bias counts, but for `told`);
//   - and regulates the rig along the references: RMS error of the true pressure [kPa].
//
// The table is printed on standard error, the rows are the medians over the catalogue's effects.
#include <fmt/core.h>

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/chamber/fit_greybox.hpp"
#include "host-sim/identify/greybox.hpp"
#include "host-sim/identify/in_parallel.hpp"
#include "host-sim/identify/profile.hpp"
#include "host-sim/identify/ticks.hpp"
#include "host-sim/tools/recorded_log.hpp"
#include "tests/bench/effect_trials.hpp"
#include "tests/bench/row.hpp"
#include "tests/identify/board_free_run.hpp"
#include "tests/identify/board_parameters.hpp"

namespace {

using namespace plenum::host;
using plenum::bench::kChambers;
using plenum::bench::kSensorBias;

constexpr double kSeconds = 20.0;
constexpr double kDiverged = std::numeric_limits<double>::infinity();  // worse than any other
constexpr std::array<const char*, 4> kColumns{"tassa9", "tassa9r", "greybox", "told"};

/// Logs of a rig's chambers, from rest.
std::vector<trace::Log> recorded(const trace::RigDescription& real, std::uint32_t seed) {
  tools::WatchedRig rig(plenum::bench::effect_rig(real), kChambers);
  const auto rows =
      client::capture(rig.session(), {.seconds = kSeconds, .seed = seed, .chambers = kChambers});
  std::vector<trace::Log> logs;
  for (unsigned c = 0; c < kChambers; ++c) logs.push_back(tools::log_of(rows, c));
  return logs;
}

struct Cell {
  double drift_percent = 0.0;  ///< infinite or no number of a free run that has diverged
  double tracking_kPa = 0.0;
};

struct Line {
  std::string effect = "none";
  std::array<std::optional<Cell>, kColumns.size()> cells;  ///< empty: no such model
  std::string found;                                       ///< by the identification
};

double drift_percent(const trace::ModelFile& model, const std::vector<trace::Log>& logs,
                     const trace::RigDescription& known) {
  const auto parameters = testing::board_parameters(model.kind, model.parameters);
  const auto bias = known.effects.find(kSensorBias);
  const double off_kPa = bias == known.effects.end() ? 0.0 : bias->second.at("offset_kPa");
  double squares = 0.0;
  std::size_t rows = 0;
  for (const trace::Log& log : logs) {
    const identify::Ticks ticks = identify::lay_out({log});
    const std::vector<double> shown_kPa =
        testing::board_free_run_kPa(parameters, ticks.pressure_kPa.front() - off_kPa, ticks.command_V,
                                    ticks.volume_mL, ticks.volume_rate_mL_s);
    for (std::size_t k = 0; k + 1 < ticks.size(); ++k, ++rows)
      squares += std::pow(shown_kPa[k] + off_kPa - ticks.pressure_kPa[k + 1], 2);
  }
  const double span_kPa = 1e-3 * (known.supply.pressure_Pa - known.ambient.pressure_Pa);
  return 100.0 * std::sqrt(squares / static_cast<double>(rows)) / span_kPa;
}

Line measured(const std::optional<plenum::bench::EffectTrial>& trial) {
  const trace::RigDescription sheet;
  trace::RigDescription real = sheet;
  Line line;
  if (trial) {
    line.effect = trial->effect;
    real.effects[trial->effect] = trial->figures;
  }
  const std::vector<trace::Log> fitted = recorded(real, 1), unseen = recorded(real, 2);
  const auto take = [&](std::size_t column, const trace::ModelFile& model,
                        const trace::RigDescription& known) {
    line.cells[column] = Cell{drift_percent(model, unseen, known),
                              plenum::bench::tracking_rms_kPa(real, known, model, client::Doubted::force)};
  };
  for (const identify::Form form : {identify::Form::published, identify::Form::repaired}) {
    identify::FitOptions options;
    options.stretch_s = 0.2;
    options.form = form;
    try {
      const auto fit = identify::fit_tassa9_profiled(fitted, sheet, options);
      take(form == identify::Form::published ? 0 : 1, identify::to_model_file(fit, {}), sheet);
    } catch (const identify::CannotIdentify& why) {
      fmt::print(stderr, "{}, {}: {}\n", line.effect, identify::kind_of(form), why.what());
    }
  }
  const auto fit = identify::chamber::fit_greybox(fitted, sheet);
  for (const std::string& id : fit.kept) line.found += (line.found.empty() ? "" : ", ") + id;
  take(2, identify::chamber::to_model_file(fit, {}), sheet);
  const auto own = identify::greybox_of(real);
  if (own.left_out.empty() || own.left_out.front() == kSensorBias) take(3, own.file, real);
  return line;
}

std::string text(const std::optional<Cell>& cell, double Cell::*value) {
  return cell ? fmt::format("{:.2g}", *cell.*value) : "";
}

void print_table(const std::vector<Line>& lines) {
  fmt::print(stderr,
             "| effect | drift [% of span] `tassa9` | `tassa9r` | `greybox` | told | "
             "tracking [kPa] `tassa9` | `tassa9r` | `greybox` | told | found |\n"
             "|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Line& line : lines) {
    fmt::print(stderr, "| `{}` |", line.effect);
    for (const auto& cell : line.cells) fmt::print(stderr, " {} |", text(cell, &Cell::drift_percent));
    for (const auto& cell : line.cells) fmt::print(stderr, " {} |", text(cell, &Cell::tracking_kPa));
    fmt::print(stderr, " {} |\n", line.found);
  }
}

}  // namespace

int main() {
  std::vector<std::optional<plenum::bench::EffectTrial>> trials{std::nullopt};
  for (const auto& trial : plenum::bench::effect_trials()) trials.emplace_back(trial);
  std::vector<Line> lines(trials.size());
  identify::in_parallel(trials.size(), std::thread::hardware_concurrency(),
                        [&](std::size_t i) { lines[i] = measured(trials[i]); });
  print_table(lines);
  for (std::size_t column = 0; column < kColumns.size(); ++column) {
    std::vector<double> drift, tracking;
    for (std::size_t i = 1; i < lines.size(); ++i) {
      const std::optional<Cell>& cell = lines[i].cells[column];
      if (!cell) continue;
      drift.push_back(std::isfinite(cell->drift_percent) ? cell->drift_percent : kDiverged);
      tracking.push_back(cell->tracking_kPa);
    }
    const std::string name = fmt::format("model.catalogue_{}", kColumns[column]);
    plenum::bench::print({name + "_drift_percent_span", plenum::bench::median(drift), "% of span"});
    plenum::bench::print({name + "_tracking_kPa", plenum::bench::median(tracking), "kPa"});
  }
}
