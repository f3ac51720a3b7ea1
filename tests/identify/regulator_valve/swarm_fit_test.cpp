#include "host-sim/identify/regulator_valve/swarm_fit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "host-sim/identify/cannot_identify.hpp"
#include "host-sim/identify/regulator_valve/fit_measure.hpp"
#include "host-sim/identify/regulator_valve/least_squares.hpp"
#include "tests/identify/regulator_valve/made_branch.hpp"

namespace plenum::host::identify::regulator_valve {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

double free_run_fit(const DiscreteModel& model, const Branch& branch) {
  return fit_percent(branch.pressure_Pa, free_run(model, branch.screw_m, branch.pressure_Pa));
}

// The fastest pole is lost in the noise and may come out anywhere, so what counts is the answer to a step.
TEST(SwarmFit, NoiseThatBiasesLeastSquaresLeavesItAtTheTruth) {
  const DiscreteModel truth = made::known_model();
  const std::vector<double> step(200, 0.25e-3);
  const std::vector<double> rest(200, 0.0);
  const std::vector<double> answer = free_run(truth, step, rest);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Branch branch = made::branch_by(truth, 3000, 2000.0, seed);
    const DiscreteModel found = fit_swarm(branch, {.seed = seed}).model;
    const DiscreteModel least_squares = fit_least_squares(branch);
    EXPECT_NEAR(found.static_gain_Pa_m() / 1.5e8, 1.0, 0.01) << "seed " << seed;
    EXPECT_GT(fit_percent(answer, free_run(found, step, rest)), 97.0) << "seed " << seed;
    EXPECT_LT(fit_percent(answer, free_run(least_squares, step, rest)), 90.0) << "seed " << seed;
  }
}

TEST(SwarmFit, IsNeverBelowLeastSquaresOnTheValve) {
  namespace valve = plant::regulator_valve;
  for (const double noise_Pa : {50.0, 1000.0, 3000.0}) {
    const valve::Recording recording = valve::record(valve::bench_valve(), {.noise_Pa = noise_Pa, .seed = 11},
                                                     1e5, valve::staircase(0.25e-3, 13, 5.0));
    for (const Direction direction : {Direction::kRising, Direction::kFalling}) {
      const Branch branch = branch_of(recording, direction);
      const double least_squares = free_run_fit(fit_least_squares(branch), branch);
      for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        EXPECT_GT(free_run_fit(fit_swarm(branch, {.seed = seed}).model, branch), least_squares)
            << noise_Pa << " Pa, seed " << seed;
      }
    }
  }
}

TEST(SwarmFit, ItsCostIsThatOfTheFreeRun) {
  const Branch branch = made::branch_by(made::known_model(), 500, 500.0, 2);
  const SwarmFit fit = fit_swarm(branch, {.particles = 10, .iterations = 30});
  const std::vector<double> run = free_run(fit.model, branch.screw_m, branch.pressure_Pa);
  double squares = 0.0;
  for (std::size_t k = 0; k < run.size(); ++k)
    squares += (run[k] - branch.pressure_Pa[k]) * (run[k] - branch.pressure_Pa[k]);
  EXPECT_NEAR(fit.search.cost / squares, 1.0, 1e-9);
}

TEST(SwarmFit, SaysWhyItCannot) {
  Branch branch = made::branch_by(made::known_model(), 200, 100.0, 5);
  Branch still = branch;
  still.screw_m.assign(200, 0.0);
  EXPECT_THAT([&] { fit_swarm(still); }, ThrowsMessage<CannotIdentify>(HasSubstr("the screw never changes")));
  Branch instant = branch;  // the pressure is the screw: settled within a sample
  for (std::size_t k = 1; k < 200; ++k) instant.pressure_Pa[k] = 1.5e8 * branch.screw_m[k - 1];
  EXPECT_THAT([&] { fit_swarm(instant); },
              ThrowsMessage<CannotIdentify>(HasSubstr("residue ends at its bound")));
  branch.pressure_Pa.resize(7);
  branch.screw_m.resize(7);
  EXPECT_THAT([&] { fit_swarm(branch); }, ThrowsMessage<CannotIdentify>(HasSubstr("7 samples")));
}

TEST(SwarmFit, RefusesABranchThatIsNone) {
  const Branch branch = made::branch_by(made::known_model(), 100, 100.0, 5);
  Branch wrong = branch;
  wrong.screw_m.pop_back();
  EXPECT_THAT([&] { fit_swarm(wrong); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("99 screw positions and 100 pressures")));
  wrong = branch;
  wrong.pressure_Pa[40] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT([&] { fit_swarm(wrong); }, ThrowsMessage<std::invalid_argument>(HasSubstr("sample 40")));
  wrong = branch;
  wrong.sample_s = 0.0;
  EXPECT_THAT([&] { fit_swarm(wrong); }, ThrowsMessage<std::invalid_argument>(HasSubstr("sample_s = 0")));
}

}  // namespace
}  // namespace plenum::host::identify::regulator_valve
