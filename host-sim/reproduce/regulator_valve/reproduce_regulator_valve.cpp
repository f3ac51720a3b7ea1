#include "host-sim/reproduce/regulator_valve/reproduce_regulator_valve.hpp"

#include "host-sim/reproduce/regulator_valve/parts.hpp"

namespace plenum::host::reproduce::regulator_valve {

std::vector<Part> reproduce_regulator_valve(const Progress& progress) {
  constexpr int kRuns = 3;
  constexpr double kCampaignShare = 0.3;
  const auto from_to = [&](double from, double to) -> Progress {
    return [&progress, from, to](double done) {
      if (progress) progress(from + (to - from) * done);
    };
  };
  const Campaign campaign = measure_campaign(kRuns, from_to(0.0, kCampaignShare));
  std::vector<Part> parts{constants(),
                          mass_conservation(),
                          nozzle(),
                          linear_models(),
                          discretisation(),
                          time_constant(),
                          step_experiment(campaign),
                          printed_models(),
                          printed_coefficients(campaign),
                          methods(campaign),
                          accuracy(campaign),
                          other_staircases(campaign),
                          influence_of_noise(from_to(kCampaignShare, 1.0)),
                          internal_parameters(),
                          valve_of_table2(),
                          recovered_parameters(campaign)};
  for (Part& part : parts) {
    for (Finding& finding : part.findings) {
      if (verdict(finding) == Verdict::kReproduced) finding.why.clear();
    }
  }
  return parts;
}

}  // namespace plenum::host::reproduce::regulator_valve
