// The three models on what others measured: the ventilator of tests/data/respiraworks.
//
// Each model is fitted to the oxygen runs of low resistance, 1, 3 and 5, with a supply of 110 kPa, as host-sim/identify/README.md
// tells; the model file's parameters configure the board's own model, in its own scalar, which predicts the runs 2, 4 and 6 at
// 100 Hz in free runs of 2 s, each from a measured start. The rows are the RMS error over all three.
//
// usage: plenum_model_measured_bench FOLDER    of ctl_OXY_1.csv ..
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "firmware/control/any_model.hpp"
#include "host-sim/identify/chamber/fit_greybox.hpp"
#include "host-sim/identify/fit.hpp"
#include "host-sim/identify/ticks.hpp"
#include "host-sim/trace/respiraworks.hpp"
#include "tests/bench/board_run.hpp"
#include "tests/bench/row.hpp"
#include "tests/identify/board_parameters.hpp"

namespace {

using namespace plenum::host;

constexpr std::size_t kRunRows = 200;  ///< 2 s

/// A sum of squared errors [kPa^2], and of how many rows.
struct Squares {
  double sum = 0.0;
  std::size_t rows = 0;
  double rms() const { return std::sqrt(sum / static_cast<double>(rows)); }
};

/// Of `predict` in free runs of 2 s over one log.
template <class Predict>
void add(Squares& squares, const identify::Ticks& ticks, const Predict& predict) {
  for (std::size_t start = 0; start + 1 < ticks.size(); start += kRunRows) {
    const std::size_t rows = std::min(kRunRows, ticks.size() - 1 - start);
    const std::vector<double> readings_kPa = predict(start, rows);
    for (std::size_t i = 0; i < rows; ++i) {
      const double error_kPa = readings_kPa[i] - ticks.pressure_kPa[start + 1 + i];
      squares.sum += error_kPa * error_kPa;
    }
    squares.rows += rows;
  }
}

}  // namespace

int main(int count, char** words) {
  if (count != 2) {
    std::fprintf(stderr, "usage: plenum_model_measured_bench FOLDER\n");
    return 2;
  }
  const auto run = [&](int test) {
    return trace::import_respiraworks(std::filesystem::path(words[1]) / fmt::format("ctl_OXY_{}.csv", test));
  };
  trace::RigDescription rig;
  rig.supply.pressure_Pa = 110e3;
  const std::vector<trace::Log> fitted{run(1), run(3), run(5)};
  std::vector<identify::Ticks> unseen;
  for (const int test : {2, 4, 6}) unseen.push_back(identify::lay_out({run(test)}));

  Squares held;
  for (const identify::Ticks& ticks : unseen) {
    add(held, ticks, [&](std::size_t start, std::size_t rows) {
      return std::vector<double>(rows, ticks.pressure_kPa[start]);
    });
  }
  const auto measure = [&](const trace::ModelFile& file) {
    plenum::control::AnyModel room;
    const plenum::control::PressureModel* const model =
        room.take_over(testing::board_parameters(file.kind, file.parameters), 0.0F, 10.0F);
    Squares squares;
    for (const identify::Ticks& ticks : unseen) add(squares, ticks, plenum::bench::BoardRun(*model, ticks));
    plenum::bench::print({.name = "model.ventilator_rms_" + file.kind,
                          .value = squares.rms(),
                          .unit = "kPa",
                          .peer = "holding the start",
                          .peer_value = held.rms()});
  };
  for (const identify::Form form : {identify::Form::published, identify::Form::repaired}) {
    identify::FitOptions options;
    options.form = form;
    measure(identify::to_model_file(identify::fit_tassa9(fitted, rig, options), {}));
  }
  measure(identify::chamber::to_model_file(identify::chamber::fit_greybox(fitted, rig), {}));
}
