// How far free runs of the board's grey-box model drift from the measurement, where volumes move violently.
//
// Each chamber is recorded for 100 s and its model fitted to that record (fit_greybox, no figure of the valve given); the model
// file's parameters then configure the board's own model, in its own scalar, which predicts the record at 100 Hz in 48 free runs of
// 2 s as in drift.cpp: from the measured sample taken back through the tick before, with command, volume and speed of each tick.
// The drift of a chamber is the largest standard deviation over its starts within the 2 s, in percent of P_c - P_r; noise of start
// and measurement counts. `unseen`: the same on 40 s of the chamber after those that were fitted.
//
// Chambers: the population of 76 with volumes that double at 0.4 to 1.6 Hz; and the measured MPYE tables, both channels, under the
// same controller (0 to 10 V) on 400 to 1100 mL, a size to the flow as the population's, moving as violently.
//
// usage: plenum_model_bench [FILE]    FILE: one line a chamber, for looking into the worst
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "firmware/control/any_model.hpp"
#include "host-sim/identify/chamber/fit_greybox.hpp"
#include "host-sim/identify/free_run.hpp"
#include "host-sim/identify/in_parallel.hpp"
#include "host-sim/identify/ticks.hpp"
#include "host-sim/reproduce/actuators/population.hpp"
#include "tests/bench/row.hpp"
#include "tests/identify/board_parameters.hpp"

namespace {

using namespace plenum::host;
using plenum::control::ChamberMotion;
using plenum::control::Prediction;
using plenum::numeric::Scalar;
using reproduce::actuators::Motion;

constexpr std::size_t kMpyeChambers = 6;
constexpr std::size_t kFittedRows = 10000;
constexpr std::size_t kUnseenRows = 4000;

/// The board's model in free run over one log.
class BoardRun {
 public:
  BoardRun(const plenum::control::PressureModel& model, const identify::Ticks& ticks)
      : model_(model), ticks_(ticks) {}

  /// An identify::Predictor.
  std::vector<double> operator()(std::size_t start, std::size_t rows) const {
    Scalar pressure_kPa = static_cast<float>(ticks_.pressure_kPa[start]);
    if (start > 0) pressure_kPa = through_tick_before(start);
    std::vector<double> readings_kPa;
    for (std::size_t row = start; row < start + rows; ++row) {
      const Prediction next = tick(row, pressure_kPa);
      readings_kPa.push_back(static_cast<double>(next.mean_kPa));
      pressure_kPa = next.end_kPa;
    }
    return readings_kPa;
  }

 private:
  Prediction tick(std::size_t row, Scalar pressure_kPa) const {
    const ChamberMotion motion{.volume_mL = static_cast<float>(ticks_.volume_mL[row]),
                               .volume_rate_mL_s = static_cast<float>(ticks_.volume_rate_mL_s[row])};
    return model_.step(pressure_kPa, static_cast<float>(ticks_.command_V[row]), motion, 1.0F);
  }

  /// The pressure at a row's time, from its sample: the end of the tick whose mean the sample is. The mean rises with the
  /// pressure at the tick's beginning.
  Scalar through_tick_before(std::size_t row) const {
    const auto sample_kPa = static_cast<float>(ticks_.pressure_kPa[row]);
    float low_kPa = 1.0F;
    float high_kPa = 5000.0F;
    for (int i = 0; i < 40; ++i) {
      const float middle_kPa = 0.5F * (low_kPa + high_kPa);
      (tick(row - 1, middle_kPa).mean_kPa < sample_kPa ? low_kPa : high_kPa) = middle_kPa;
    }
    return tick(row - 1, 0.5F * (low_kPa + high_kPa)).end_kPa;
  }

  const plenum::control::PressureModel& model_;
  const identify::Ticks& ticks_;
};

/// Channel A for odd seeds, B for even ones.
trace::Log record_mpye(unsigned seed, std::size_t rows) {
  std::mt19937_64 random(seed);
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const double mean_m3 = draw(400e-6, 1100e-6);
  const double share = draw(0.31, 0.355);
  const double frequency_Hz = draw(0.4, 1.6);
  const plant::VolumeSine sine{share * mean_m3, frequency_Hz, draw(0.0, 2.0 * std::numbers::pi)};
  plant::ChamberConfig config;
  config.gas = plant::reference_atmosphere();
  config.initial_pressure_Pa = 200e3;
  const auto channel = seed % 2 == 1 ? plant::MpyeChannel::a : plant::MpyeChannel::b_mirrored;
  plant::ChamberPlant chamber(plant::MpyeValve(channel, config.gas), config,
                              plant::VolumeMotion(mean_m3, {sine}));
  return reproduce::actuators::record_under_pid(random, chamber, 0.0, 10.0, rows);
}

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
  const BoardRun run(*room.take_over(testing::board_parameters(file.kind, file.parameters), 0.0F, 10.0F),
                     ticks);
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
