// What a paper states, what Plenum computes, and whether they agree.
//
// A finding compares one number. A property is compared as a number too: the jump at the choked limit against
// 0, the count of falling steps of a curve that should rise against 0. The verdict follows from the numbers
// alone; nobody types it.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "host-sim/report/chart.hpp"

namespace plenum::host::reproduce {

enum class Verdict {
  kReproduced,              ///< ours agrees with the paper's
  kDiffers,                 ///< it does not; `why` says why
  kPaperContradictsItself,  ///< the paper's own equations do not give its own number; `why` names both
};
/// "reproduced", "differs", "paper contradicts itself".
std::string_view name_of(Verdict verdict);

enum class Expect {
  kNear,     ///< |ours - paper| <= tolerance
  kAtMost,   ///< ours <= paper + tolerance
  kAtLeast,  ///< ours >= paper - tolerance
};
/// "near", "at most", "at least".
std::string_view name_of(Expect expect);

/// Where `ours` comes from, which decides what a disagreement means.
enum class Source {
  kOurModel,           ///< computed by Plenum's models and methods: a disagreement is ours to explain
  kPapersOwnEquation,  ///< only the paper's equations put to the paper's numbers: a disagreement is its own
  kDoubtfulReading,  ///< the same, to a number that the scan of the paper may have damaged: says nothing of the paper
  kSetToPaper,  ///< our model, of which a constant was set to this very number: only a slip could make it differ
  kTwoForms,  ///< two forms of one thing of ours: that they agree shows that we are consistent, no more
};
/// "our model", "the paper's own equations", "a doubtful reading of the paper", "set to the paper's number", "two forms of ours".
std::string_view name_of(Source source);
/// Agreement was to be expected of such a finding: it is counted apart.
bool by_construction(Source source);

/// One number of a paper beside ours.
struct Finding {
  std::string item;      ///< where the paper states it: "(11)", "Table 2", "Fig. 13"
  std::string quantity;  ///< what it is
  std::string unit{};    ///< of paper, ours and tolerance; empty for counts and ratios
  double paper;
  double ours;
  double tolerance = 0.0;  ///< from the digits printed, the noise stated, or the issue's own claim
  Expect expect = Expect::kNear;
  Source source = Source::kOurModel;
  /// What stands in `paper` where the paper prints no number: "the physical fit", "the measured tables".
  std::string instead{};
  std::string why{};  ///< in a sentence; never empty where the verdict is not kReproduced
};

/// ours - paper.
double difference(const Finding& finding);
/// A value or a tolerance that is not finite never agrees.
Verdict verdict(const Finding& finding);

/// What belongs to one equation set, table or figure of a paper.
struct Part {
  std::string title;  ///< "Fig. 3 and 4: flow through a thin plate"
  std::string text;   ///< what was done, in a paragraph: the model, the data, the method
  std::vector<Finding> findings;
  std::vector<report::Chart> charts{};
};

/// Told how far a paper is, from 0 to 1.
using Progress = std::function<void(double fraction)>;

struct Paper {
  int number;              ///< as `plenum reproduce --paper` names it, from 1
  std::string_view title;  ///< of the paper
  std::vector<Part> (*reproduce)(const Progress& progress);  ///< throws where a computation fails
};

/// How many findings have each verdict, every verdict listed.
std::map<Verdict, int> verdict_counts(const std::vector<Part>& parts);
/// How many are reproduced by construction.
int reproduced_by_construction(const std::vector<Part>& parts);

}  // namespace plenum::host::reproduce
