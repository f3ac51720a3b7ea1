// How far free runs of the board's grey-box model drift from the measurement, where volumes move violently.
//
// Each chamber is recorded for 100 s and its model fitted to that record (fit_greybox, no figure of the valve given); the model
// file's parameters then configure the board's own model, in its own scalar, which predicts the record at 100 Hz in 48 free runs of
// 2 s as in drift.cpp: from the measured sample taken back through the tick before, with command, volume and speed of each tick.
// The drift of a chamber is the largest standard deviation over its starts within the 2 s, in percent of P_c - P_r; noise of start
// and measurement counts. `unseen`: the same on 40 s of the chamber after those that were fitted.
//
// Chambers: the population of 76 with volumes that double at 0.4 to 1.6 Hz; and those of mpye_chambers.hpp.
//
// usage: plenum_model_bench [FILE]    FILE: one line a chamber, for looking into the worst
#include <algorithm>
#include <cstdio>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "firmware/control/any_model.hpp"
#include "host-sim/identify/chamber/fit_greybox.hpp"
#include "host-sim/identify/free_run.hpp"
#include "host-sim/identify/in_parallel.hpp"
#include "host-sim/identify/ticks.hpp"
#include "host-sim/reproduce/actuators/population.hpp"
#include "tests/bench/board_run.hpp"
#include "tests/bench/mpye_chambers.hpp"
#include "tests/bench/row.hpp"
#include "tests/identify/board_parameters.hpp"

namespace {

using namespace plenum::host;
using plenum::bench::kMpyeChambers;
using plenum::bench::record_mpye;
using reproduce::actuators::Motion;

constexpr std::size_t kFittedRows = 10000;
constexpr std::size_t kUnseenRows = 4000;

trace::Log first_rows(trace::Log log, std::size_t rows) {
  for (auto* column : {&log.time_s, &log.command_V, &log.pressure_Pa, &log.volume_m3}) column->resize(rows);
  return log;
}

struct ChamberDrift {
  double fitted_percent = 0.0;
  double unseen_percent = 0.0;
  std::string effects;
};

ChamberDrift drift_of(const trace::Log& log, const trace::RigDescription& rig) {
  const auto fit = identify::chamber::fit_greybox({first_rows(log, kFittedRows)}, rig);
  const trace::ModelFile file = identify::chamber::to_model_file(fit, {});
  const identify::Ticks ticks = identify::lay_out({log});
  plenum::control::AnyModel room;
  const plenum::bench::BoardRun run(
      *room.take_over(testing::board_parameters(file.kind, file.parameters), 0.0F, 10.0F), ticks);
  const auto percent = [&](std::size_t from_row, std::size_t to_row) {
    const double span_kPa = 1e-3 * (rig.supply.pressure_Pa - rig.ambient.pressure_Pa);
    return identify::drift(ticks, span_kPa, run, {.from_row = from_row, .to_row = to_row}).worst_std_percent;
  };
  ChamberDrift drift{percent(0, kFittedRows), percent(kFittedRows, log.size()), {}};
  for (const std::string& id : fit.kept) drift.effects += " " + id;
  return drift;
}

void print_drift(const std::string& name, double value, std::optional<double> target = {}) {
  plenum::bench::print(
      {"model.greybox_drift_" + name + "_percent_span", value, "% of span", "lower", target});
}

std::vector<double> all(const std::vector<ChamberDrift>& drifts, double ChamberDrift::*which) {
  std::vector<double> values;
  for (const ChamberDrift& drift : drifts) values.push_back(drift.*which);
  return values;
}

}  // namespace

int main(int count, char** words) {
  constexpr std::size_t kRows = kFittedRows + kUnseenRows;
  std::vector<ChamberDrift> violent(reproduce::actuators::kPopulation);
  std::vector<ChamberDrift> mpye(kMpyeChambers);
  identify::in_parallel(
      violent.size() + mpye.size(), std::thread::hardware_concurrency(), [&](std::size_t i) {
        if (i < violent.size()) {
          violent[i] = drift_of(
              reproduce::actuators::record_chamber(static_cast<unsigned>(i + 1), Motion::violent, kRows),
              reproduce::actuators::population_rig());
        } else {
          const std::size_t chamber = i - violent.size();
          mpye[chamber] =
              drift_of(record_mpye(static_cast<unsigned>(chamber + 1), kRows), trace::RigDescription{});
        }
      });
  if (count > 1) {
    if (std::FILE* const file = std::fopen(words[1], "w")) {
      for (const auto* drifts : {&violent, &mpye}) {
        for (const ChamberDrift& drift : *drifts) {
          std::fprintf(file, "%.3f %.3f%s\n", drift.fitted_percent, drift.unseen_percent,
                       drift.effects.c_str());
        }
      }
      std::fclose(file);
    }
  }
  const std::vector<double> drifts = all(violent, &ChamberDrift::fitted_percent);
  using plenum::bench::p95;
  print_drift("p95", p95(drifts), 0.5);
  print_drift("max", *std::max_element(drifts.begin(), drifts.end()), 1.0);
  print_drift("unseen_p95", p95(all(violent, &ChamberDrift::unseen_percent)));
  print_drift("mpye_p95", p95(all(mpye, &ChamberDrift::fitted_percent)), 1.5);
  print_drift("mpye_unseen_p95", p95(all(mpye, &ChamberDrift::unseen_percent)));
}
