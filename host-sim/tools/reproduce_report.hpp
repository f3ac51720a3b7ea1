// The findings on papers, in words and as a page.
#pragma once

#include <string>
#include <vector>

#include "host-sim/report/page.hpp"
#include "host-sim/reproduce/finding.hpp"

namespace plenum::host::tools {

/// A paper with what came of it.
struct Reproduced {
  const reproduce::Paper* paper;
  std::vector<reproduce::Part> parts;
};

/// Five significant digits; "-" for what is not finite.
std::string number_text(double value);
/// The number and its tolerance: "0.528 ± 0.0005", "at most 10".
std::string stated_text(const reproduce::Finding& finding);
/// What ours is compared with: "paper 0.528 ± 0.0005", "the physical fit at least 96.8".
std::string paper_text(const reproduce::Finding& finding);
/// Whether the paper states a bound and ours keeps it: how far it is from it says nothing then.
bool within_bound(const reproduce::Finding& finding);
/// " kPa", or nothing where the number has no unit.
std::string unit_text(const reproduce::Finding& finding);
/// "reproduced", or "reproduced (two forms of ours)": where agreement was to be expected, why.
std::string verdict_text(const reproduce::Finding& finding);
/// "34 reproduced, 3 differ, 1 where the paper contradicts itself"
std::string verdicts_text(const std::vector<reproduce::Part>& parts);

report::Page reproduce_page(const std::vector<Reproduced>& papers);

}  // namespace plenum::host::tools
