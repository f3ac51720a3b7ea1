// The control core in fixed point against itself in double: the largest differences found, and what they do to a closed loop.
#include <algorithm>
#include <array>
#include <cmath>

#include "tests/bench/row.hpp"
#include "tests/equivalence/closed_loop.hpp"
#include "tests/equivalence/core.hpp"
#include "tests/equivalence/states.hpp"

namespace {

using namespace equivalence;
using plenum::config::ModelKind;

constexpr std::array kKinds = {ModelKind::tassa9, ModelKind::tassa9r, ModelKind::greybox};

/// Of many states, the largest differences and the share of commands that are farther apart than they may be [%].
class Compared {
 public:
  /// The prediction's difference: of the span, or of the way where the tick goes farther.
  void operator()(const Asked& asked) {
    const Prediction got = asked.fixed.step(asked.from, asked.command_V);
    const Prediction want = asked.exact.step(asked.from, asked.command_V);
    const double apart_kPa =
        std::max(std::fabs(got.end_kPa - want.end_kPa), std::fabs(got.mean_kPa - want.mean_kPa));
    prediction_percent_ = std::max(prediction_percent_, 100.0 * apart_kPa / reach_kPa(asked, want));
    const double found_V = asked.fixed.inverse(asked.from, asked.target_kPa, asked.command_V).command_V;
    const double exact_V = asked.exact.inverse(asked.from, asked.target_kPa, asked.command_V).command_V;
    if (!commands_matter(asked, found_V, exact_V)) return;
    const double steps = std::fabs(found_V - exact_V) / kConverterStep_V;
    command_steps_ = std::max(command_steps_, steps);
    ++commands_;
    apart_ += steps > kMostSteps;
  }
  double prediction_percent() const { return prediction_percent_; }
  double command_steps() const { return command_steps_; }
  double commands_apart_percent() const { return 100.0 * apart_ / commands_; }

 private:
  double prediction_percent_ = 0, command_steps_ = 0;
  int commands_ = 0, apart_ = 0;
};

}  // namespace

int main() {
  constexpr int kModels = 10'000, kStates = 10;
  constexpr unsigned kChambers = 20;
  using plenum::bench::print;
  Compared built, admissible;
  double loop_ratio = 0, parted = 0, ticks = 0;
  for (const ModelKind kind : kKinds) {
    for_each_state(kind, 77, kModels, kStates, built);
    for_each_admissible_state(kind, 77, kModels, kStates, admissible);
    const Loops loops = compare_loops(kind, kChambers);
    loop_ratio = std::max(loop_ratio, loops.worst_ratio);
    parted += loops.parted;
    ticks += loops.ticks;
  }
  print({.name = "fixed.prediction_error_percent_span",
         .value = built.prediction_percent(),
         .unit = "%",
         .target = 0.02});
  print({.name = "fixed.prediction_error_percent_any_admissible",
         .value = admissible.prediction_percent(),
         .unit = "%",
         .target = 0.02});
  print({.name = "fixed.command_error_lsb",
         .value = built.command_steps(),
         .unit = "LSB",
         .target = kMostSteps});
  print({.name = "fixed.commands_apart_percent_any_admissible",
         .value = admissible.commands_apart_percent(),
         .unit = "%"});
  print({.name = "fixed.closed_loop_commands_apart_percent", .value = 100.0 * parted / ticks, .unit = "%"});
  print({.name = "fixed.closed_loop_rmse_ratio", .value = loop_ratio, .unit = "x", .target = 1.01});
}
