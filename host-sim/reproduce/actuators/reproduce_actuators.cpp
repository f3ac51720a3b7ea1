#include "host-sim/reproduce/actuators/reproduce_actuators.hpp"

#include "host-sim/reproduce/actuators/parts.hpp"
#include "host-sim/reproduce/actuators/study.hpp"

namespace plenum::host::reproduce::actuators {

std::vector<Part> parts_of(const Study& study, const Progress& progress) {
  std::vector<Part> parts{numbers_of_the_text(),
                          gas_and_port_constants(),
                          thin_plate_flow(),
                          two_port_chamber(),
                          valve_areas(),
                          steady_state(),
                          proposed_model(),
                          volume_rate(study),
                          identified_curves(study),
                          identified_ports(study),
                          parameters(study),
                          convergence(study, progress),
                          pressure_change(study),
                          pressure_prediction(study),
                          drift_of_prediction(study)};
  for (Part& part : parts) {
    for (Finding& finding : part.findings) {
      if (verdict(finding) == Verdict::kReproduced) finding.why.clear();
    }
  }
  return parts;
}

std::vector<Part> reproduce_actuators(const Progress& progress) {
  constexpr double kStudyShare = 0.7;
  const auto from_to = [&](double from, double to) -> Progress {
    return [&progress, from, to](double done) {
      if (progress) progress(from + (to - from) * done);
    };
  };
  return parts_of(study_population(kPopulation, from_to(0.0, kStudyShare)), from_to(kStudyShare, 1.0));
}

}  // namespace plenum::host::reproduce::actuators
