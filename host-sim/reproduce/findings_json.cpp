#include "host-sim/reproduce/findings_json.hpp"

#include <cmath>

namespace plenum::host::reproduce {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json to_json(const Finding& of) {
  return {{"item", of.item},
          {"quantity", of.quantity},
          {"unit", of.unit},
          {"paper", number(of.paper)},
          {"instead", of.instead},
          {"expect", name_of(of.expect)},
          {"tolerance", number(of.tolerance)},
          {"ours", number(of.ours)},
          {"source", name_of(of.source)},
          {"difference", number(difference(of))},
          {"verdict", name_of(verdict(of))},
          {"why", verdict(of) == Verdict::kReproduced ? "" : of.why}};
}

}  // namespace

Json to_json(const Paper& paper, const std::vector<Part>& parts) {
  Json listed = Json::array();
  for (const Part& part : parts) {
    Json findings = Json::array();
    for (const Finding& of : part.findings) findings.push_back(to_json(of));
    listed.push_back({{"title", part.title}, {"text", part.text}, {"findings", findings}});
  }
  Json verdicts = Json::object();
  for (const auto& [which, count] : verdict_counts(parts)) verdicts[std::string(name_of(which))] = count;
  return {{"number", paper.number},
          {"title", paper.title},
          {"verdicts", verdicts},
          {"reproduced_by_construction", reproduced_by_construction(parts)},
          {"parts", listed}};
}

}  // namespace plenum::host::reproduce
