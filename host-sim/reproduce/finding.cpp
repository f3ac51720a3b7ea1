#include "host-sim/reproduce/finding.hpp"

#include <cmath>
#include <stdexcept>

namespace plenum::host::reproduce {

std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kReproduced:
      return "reproduced";
    case Verdict::kDiffers:
      return "differs";
    case Verdict::kPaperContradictsItself:
      return "paper contradicts itself";
  }
  throw std::logic_error("name_of: no such verdict");
}

double difference(const Finding& finding) {
  return finding.ours - finding.paper;
}

Verdict verdict(const Finding& finding) {
  const double off = difference(finding);
  bool agrees = std::isfinite(off);
  if (finding.expect != Expect::kAtLeast) agrees = agrees && off <= finding.tolerance;
  if (finding.expect != Expect::kAtMost) agrees = agrees && off >= -finding.tolerance;
  if (agrees) return Verdict::kReproduced;
  return finding.source == Source::kOurModel ? Verdict::kDiffers : Verdict::kPaperContradictsItself;
}

}  // namespace plenum::host::reproduce
