#include "host-sim/reproduce/findings_json.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace {

using namespace plenum::host::reproduce;
using Json = nlohmann::ordered_json;

std::vector<Part> nothing(const Progress&) {
  return {};
}

TEST(FindingsJson, HoldsEachNumberItsVerdictAndTheCounts) {
  const Paper paper{7, "On Valves", nothing};
  Finding near{.item = "(3)", .quantity = "critical ratio", .paper = 0.528, .ours = 0.5285};
  near.tolerance = 0.0005;
  near.why = "Not told, since it agrees.";
  Finding bound{.item = "Table 2", .quantity = "error", .unit = "kPa", .paper = 10.0, .ours = 12.0};
  bound.expect = Expect::kAtMost;
  bound.instead = "Table 3";
  bound.why = "The valve is ours.";
  Finding lost{
      .item = "Fig. 1", .quantity = "slope", .paper = 1.0, .ours = std::numeric_limits<double>::quiet_NaN()};
  lost.source = Source::kPapersOwnEquation;
  lost.why = "(3) against Fig. 1.";
  const Json expected = Json::parse(R"json({
    "number": 7, "title": "On Valves",
    "verdicts": {"reproduced": 1, "differs": 1, "paper contradicts itself": 1}, "reproduced_by_construction": 0,
    "parts": [{"title": "Flow", "text": "At rest.", "findings": [
      {"item": "(3)", "quantity": "critical ratio", "unit": "", "paper": 0.528, "instead": "", "expect": "near", "tolerance": 0.0005,
       "ours": 0.5285, "source": "our model", "difference": 0.0005, "verdict": "reproduced", "why": ""},
      {"item": "Table 2", "quantity": "error", "unit": "kPa", "paper": 10.0, "instead": "Table 3", "expect": "at most", "tolerance": 0.0,
       "ours": 12.0, "source": "our model", "difference": 2.0, "verdict": "differs", "why": "The valve is ours."},
      {"item": "Fig. 1", "quantity": "slope", "unit": "", "paper": 1.0, "instead": "", "expect": "near", "tolerance": 0.0,
       "ours": null, "source": "the paper's own equations", "difference": null, "verdict": "paper contradicts itself", "why": "(3) against Fig. 1."}]}]})json");
  Json json = to_json(paper, {{.title = "Flow", .text = "At rest.", .findings = {near, bound, lost}}});
  Json& difference = json["parts"][0]["findings"][0]["difference"];
  EXPECT_NEAR(difference.get<double>(), 0.0005, 1e-15);
  difference = 0.0005;
  EXPECT_EQ(json.dump(1), expected.dump(1));
}

}  // namespace
