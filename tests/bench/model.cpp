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
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "firmware/control/greybox.hpp"
#include "host-sim/identify/chamber/fit_greybox.hpp"
#include "host-sim/identify/in_parallel.hpp"
#include "host-sim/identify/ticks.hpp"
#include "host-sim/reproduce/actuators/population.hpp"

namespace {

using namespace plenum::host;
using plenum::control::ChamberMotion;
using plenum::control::Greybox;
using plenum::control::Prediction;
using reproduce::actuators::Motion;

constexpr std::size_t kMpyeChambers = 6;
constexpr std::size_t kStarts = 48;
constexpr std::size_t kHorizon = 200;
constexpr std::size_t kFittedRows = 10000;
constexpr std::size_t kUnseenRows = 4000;

Greybox board_model(const trace::ModelFile& file) {
  std::array<plenum::control::Scalar, Greybox::kParameters> parameters{};
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    parameters[i] = plenum::control::Scalar(static_cast<float>(file.parameters[i]));
  }
  Greybox model;
  model.configure(parameters, 0.0F, 10.0F);
  return model;
}

class Predictor {
 public:
  Predictor(const Greybox& model, const trace::Log& log) : model_(model), ticks_(identify::lay_out({log})) {}

  /// Readings of the rows start + 1 .. start + kHorizon [kPa].
  std::vector<double> run(std::size_t start) const {
    float pressure_kPa = static_cast<float>(ticks_.pressure_kPa[start]);
    if (start > 0) pressure_kPa = through_tick_before(start);
    std::vector<double> readings;
    for (std::size_t row = start; row < start + kHorizon; ++row) {
      const Prediction next = tick(row, pressure_kPa);
      readings.push_back(static_cast<double>(next.mean_kPa));
      pressure_kPa = next.end_kPa;
    }
    return readings;
  }

  /// Of starts spread evenly over the rows `from` to `to` - 1.
  double drift_percent(const trace::RigDescription& rig, std::size_t from, std::size_t to) const {
    const double to_percent = 1e5 / (rig.supply.pressure_Pa - rig.ambient.pressure_Pa);
    std::vector<double> sum(kHorizon, 0.0);
    std::vector<double> square(kHorizon, 0.0);
    for (std::size_t i = 0; i < kStarts; ++i) {
      const std::size_t start = from + i * (to - from - 1 - kHorizon) / (kStarts - 1);
      const std::vector<double> predicted = run(start);
      for (std::size_t k = 0; k < kHorizon; ++k) {
        const double error = to_percent * (predicted[k] - ticks_.pressure_kPa[start + 1 + k]);
        sum[k] += error;
        square[k] += error * error;
      }
    }
    double worst = 0.0;
    constexpr auto n = static_cast<double>(kStarts);
    for (std::size_t k = 0; k < kHorizon; ++k) {
      const double mean = sum[k] / n;
      worst = std::max(worst, std::sqrt(std::max(0.0, square[k] - n * mean * mean) / (n - 1.0)));
    }
    return worst;
  }

 private:
  Prediction tick(std::size_t row, float pressure_kPa) const {
    const ChamberMotion motion{.volume_mL = static_cast<float>(ticks_.volume_mL[row]),
                               .volume_rate_mL_s = static_cast<float>(ticks_.volume_rate_mL_s[row])};
    return model_.step(pressure_kPa, static_cast<float>(ticks_.command_V[row]), motion, 1.0F);
  }

  /// The pressure at a row's time, from its sample: the end of the tick whose mean the sample is. The mean rises with the
  /// pressure at the tick's beginning.
  float through_tick_before(std::size_t row) const {
    const auto sample_kPa = static_cast<float>(ticks_.pressure_kPa[row]);
    float low_kPa = 1.0F;
    float high_kPa = 5000.0F;
    for (int i = 0; i < 40; ++i) {
      const float middle_kPa = 0.5F * (low_kPa + high_kPa);
      (tick(row - 1, middle_kPa).mean_kPa < sample_kPa ? low_kPa : high_kPa) = middle_kPa;
    }
    return tick(row - 1, 0.5F * (low_kPa + high_kPa)).end_kPa;
  }

  const Greybox& model_;
  identify::Ticks ticks_;
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
  const Greybox model = board_model(identify::chamber::to_model_file(fit, {}));
  const Predictor predictor(model, log);
  ChamberDrift drift{predictor.drift_percent(rig, 0, kFittedRows),
                     predictor.drift_percent(rig, kFittedRows, log.size()),
                     {}};
  for (const std::string& id : fit.kept) drift.effects += " " + id;
  return drift;
}

double p95(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[(95 * values.size() + 99) / 100 - 1];  // nearest rank
}

void row(const char* name, double value, const char* target) {
  std::printf(R"({"name": "model.greybox_drift_%s_percent_span", "value": %.4g, "unit": "%% of span", )"
              R"("better": "lower", "target": %s})"
              "\n",
              name, value, target);
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
  row("p95", p95(drifts), "0.5");
  row("max", *std::max_element(drifts.begin(), drifts.end()), "1.0");
  row("unseen_p95", p95(all(violent, &ChamberDrift::unseen_percent)), "null");
  row("mpye_p95", p95(all(mpye, &ChamberDrift::fitted_percent)), "1.5");
  row("mpye_unseen_p95", p95(all(mpye, &ChamberDrift::unseen_percent)), "null");
}
