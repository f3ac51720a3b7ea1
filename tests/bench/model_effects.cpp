// model.effect_rmse_shrink_*: what a closed loop gains when the board's model is told of an effect.
//
// For each effect of the catalogue, on the rigs of effect_trials.hpp: two grey-box models are uploaded over CAN, that of the rig as its
// data sheet has it and that of the rig with the effect (identify::greybox_of, what `plenum diagnose --save-model` writes). A sensor's
// bias goes into the board's calibration instead, as by `plenum calibrate`. Both regulators learn while they run (trim, disturbance,
// compression): what that makes up for is no gain of the model.
//
// The effects that a controller can answer are those of valve, supply, line and sensor that delay, shift or distort what it
// commands or reads; the others are in the chamber's physics, which the model has or has not. Both medians count 1 for an effect
// for which the board has nothing. The figures are the rig's own: what an identification would add to the error is not in it
// (model_catalogue.cpp has that).
#include <fmt/core.h>

#include "host-sim/identify/greybox.hpp"
#include "tests/bench/effect_trials.hpp"
#include "tests/bench/row.hpp"

namespace {

using namespace plenum::host;
using plenum::bench::EffectTrial;
using plenum::bench::median;

double rms_kPa(const trace::RigDescription& real, const trace::RigDescription& known) {
  return plenum::bench::tracking_rms_kPa(real, known, identify::greybox_of(known).file);
}

}  // namespace

int main() {
  const trace::RigDescription sheet;
  fmt::print(stderr, "no effect: {:.2f} kPa RMS\n", rms_kPa(sheet, sheet));
  std::vector<double> of_all, of_answerable;
  for (const EffectTrial& trial : plenum::bench::effect_trials()) {
    trace::RigDescription real = sheet;
    real.effects[trial.effect] = trial.figures;
    const auto left_out = identify::greybox_of(real).left_out;
    const bool answered = left_out.empty() || left_out.front() == plenum::bench::kSensorBias;
    const double without_kPa = rms_kPa(real, sheet);
    const double with_kPa = answered ? rms_kPa(real, real) : without_kPa;
    const double ratio = with_kPa / without_kPa;
    of_all.push_back(ratio);
    if (trial.answerable) of_answerable.push_back(ratio);
    fmt::print(stderr, "{}: {:.2f} kPa RMS without, {:.2f} with{}\n", trial.effect, without_kPa, with_kPa,
               answered ? "" : ": the board has nothing for it");
    if (answered)
      plenum::bench::print({fmt::format("model.effect_rmse_shrink.{}", trial.effect), ratio, "x"});
  }
  plenum::bench::print({"model.effect_rmse_shrink_median", median(of_answerable), "x", "lower", 0.5});
  plenum::bench::print({"model.effect_rmse_shrink_median_catalogue", median(of_all), "x"});
}
