#include "host-sim/reproduce/finding.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
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

std::string_view name_of(Expect expect) {
  switch (expect) {
    case Expect::kNear:
      return "near";
    case Expect::kAtMost:
      return "at most";
    case Expect::kAtLeast:
      return "at least";
  }
  throw std::logic_error("name_of: no such expectation");
}

std::string_view name_of(Source source) {
  switch (source) {
    case Source::kOurModel:
      return "our model";
    case Source::kPapersOwnEquation:
      return "the paper's own equations";
    case Source::kDoubtfulReading:
      return "a doubtful reading of the paper";
    case Source::kSetToPaper:
      return "set to the paper's number";
    case Source::kTwoForms:
      return "two forms of ours";
  }
  throw std::logic_error("name_of: no such source");
}

bool by_construction(Source source) {
  return source == Source::kSetToPaper || source == Source::kTwoForms;
}

double difference(const Finding& finding) {
  return finding.ours - finding.paper;
}

Verdict verdict(const Finding& finding) {
  const double off = difference(finding);
  // 5.15 is within 0.05 of 5.10, though not in binary
  const double rounding = 4.0 * std::numeric_limits<double>::epsilon() *
                          std::max(std::abs(finding.paper), std::abs(finding.ours));
  const double room = finding.tolerance + rounding;
  bool agrees = std::isfinite(off) && std::isfinite(room);
  if (finding.expect != Expect::kAtLeast) agrees = agrees && off <= room;
  if (finding.expect != Expect::kAtMost) agrees = agrees && off >= -room;
  if (agrees) return Verdict::kReproduced;
  return finding.source == Source::kPapersOwnEquation ? Verdict::kPaperContradictsItself : Verdict::kDiffers;
}

std::map<Verdict, int> verdict_counts(const std::vector<Part>& parts) {
  std::map<Verdict, int> counts{
      {Verdict::kReproduced, 0}, {Verdict::kDiffers, 0}, {Verdict::kPaperContradictsItself, 0}};
  for (const Part& part : parts) {
    for (const Finding& finding : part.findings) ++counts[verdict(finding)];
  }
  return counts;
}

int reproduced_by_construction(const std::vector<Part>& parts) {
  int count = 0;
  for (const Part& part : parts) {
    for (const Finding& finding : part.findings)
      count += by_construction(finding.source) && verdict(finding) == Verdict::kReproduced ? 1 : 0;
  }
  return count;
}

}  // namespace plenum::host::reproduce
