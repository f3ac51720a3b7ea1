// The forms of the board's model side by side, on the same records: how far free runs drift from the measurement where volumes
// move violently, what the parameters and the model take on the board.
//
// Each of the 76 chambers whose volume doubles at 0.4 to 1.6 Hz is recorded for 100 s. Both forms of the 9-parameter model are
// fitted to that record as drift.cpp fits (one step, then free runs; c_gamma 0.1 V), and the record is predicted in 48 free runs
// of 2 s. The drift of a chamber is the largest standard deviation over its starts within the 2 s, in percent of P_c - P_r; the
// rows take the 95th percentile (nearest rank) of the chambers. Likewise the chambers of mpye_chambers.hpp. model.cpp measures the
// grey-box model on the same records.
//
// usage: plenum_model_form_bench [FILE]    FILE: one line a chamber, for looking into the worst
#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include "firmware/config/model_image.hpp"
#include "firmware/control/greybox.hpp"
#include "firmware/control/tassa9.hpp"
#include "firmware/control/tassa9r.hpp"
#include "host-sim/identify/fit.hpp"
#include "host-sim/identify/free_run.hpp"
#include "host-sim/identify/in_parallel.hpp"
#include "host-sim/reproduce/actuators/population.hpp"
#include "tests/bench/mpye_chambers.hpp"
#include "tests/bench/row.hpp"

namespace {

using namespace plenum::host;
using identify::Form;

constexpr std::size_t kStarts = 48;
constexpr double kHorizon_s = 2.0;
constexpr std::size_t kRows = 10000;  ///< of an MPYE chamber, as of the others
constexpr std::array<Form, 2> kForms = {Form::published, Form::repaired};

using Drifts = std::array<double, kForms.size()>;  ///< of one chamber, in percent of span

Drifts drifts_of(const trace::Log& log, const trace::RigDescription& rig) {
  Drifts drifts{};
  for (std::size_t i = 0; i < kForms.size(); ++i) {
    identify::FitOptions options;
    options.form = kForms[i];
    const identify::Tassa9Fit fit = identify::fit_tassa9({log}, rig, options);
    drifts[i] = identify::drift(log, fit.model, kStarts, kHorizon_s).worst_std_percent;
  }
  return drifts;
}

void print_bytes(const std::string& kind, plenum::config::ModelKind as, std::size_t of_model) {
  const std::size_t parameters = 4 * plenum::config::parameter_schema(as).size();
  plenum::bench::print({"model." + kind + "_parameter_bytes", static_cast<double>(parameters), "bytes"});
  plenum::bench::print({"model." + kind + "_ram_bytes", static_cast<double>(of_model), "bytes"});
}

}  // namespace

int main(int count, char** words) {
  std::vector<Drifts> drifts(reproduce::actuators::kPopulation);
  std::vector<Drifts> mpye(plenum::bench::kMpyeChambers);
  identify::in_parallel(drifts.size() + mpye.size(), std::thread::hardware_concurrency(), [&](std::size_t i) {
    if (i < drifts.size()) {
      drifts[i] = drifts_of(reproduce::actuators::record_chamber(static_cast<unsigned>(i + 1),
                                                                 reproduce::actuators::Motion::violent),
                            reproduce::actuators::population_rig());
    } else {
      const std::size_t chamber = i - drifts.size();
      mpye[chamber] = drifts_of(plenum::bench::record_mpye(static_cast<unsigned>(chamber + 1), kRows), {});
    }
  });
  if (count > 1) {
    if (std::FILE* const file = std::fopen(words[1], "w")) {
      for (const auto* all : {&drifts, &mpye}) {
        for (const Drifts& of : *all) std::fprintf(file, "%.3f %.3f\n", of[0], of[1]);
      }
      std::fclose(file);
    }
  }
  std::array<double, kForms.size()> p95{};
  for (std::size_t i = 0; i < kForms.size(); ++i) {
    const std::string kind(identify::kind_of(kForms[i]));
    const auto of_form = [&](const std::vector<Drifts>& all) {
      std::vector<double> values;
      for (const Drifts& of : all) values.push_back(of[i]);
      return values;
    };
    const std::vector<double> values = of_form(drifts);
    p95[i] = plenum::bench::p95(values);
    const double max = *std::max_element(values.begin(), values.end());
    plenum::bench::print({"model." + kind + "_drift_p95_percent_span", p95[i], "% of span"});
    plenum::bench::print({"model." + kind + "_drift_max_percent_span", max, "% of span"});
    plenum::bench::print(
        {"model." + kind + "_drift_mpye_p95_percent_span", plenum::bench::p95(of_form(mpye)), "% of span"});
  }
  plenum::bench::print({"model.tassa9r_drift_vs_tassa9", p95[1] / p95[0], "x", "lower", 0.6});
  print_bytes("tassa9", plenum::config::ModelKind::tassa9, sizeof(plenum::control::Tassa9));
  print_bytes("tassa9r", plenum::config::ModelKind::tassa9r, sizeof(plenum::control::Tassa9r));
  print_bytes("greybox", plenum::config::ModelKind::greybox, sizeof(plenum::control::Greybox));
}
