#include "host-sim/diagnose/gap_json.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

namespace plenum::host::diagnose {
namespace {

using Json = nlohmann::ordered_json;

Json rounded(double value) {
  if (!std::isfinite(value)) return nullptr;
  return std::strtod(fmt::format("{:.5g}", value).c_str(), nullptr);  // unlike stod, takes the tiniest
}

Json kPa(double pressure_Pa) {
  return rounded(1e-3 * pressure_Pa);
}

Json to_json(const Estimate& of) {
  Json json{{"value", rounded(of.value)}, {"ci95", {rounded(of.low95), rounded(of.high95)}}};
  if (of.at_bound) json["at_bound"] = true;
  return json;
}

Json to_json(const std::vector<Estimate>& parameters) {
  Json json = Json::object();
  for (const Estimate& of : parameters) json[of.name] = to_json(of);
  return json;
}

Json to_json(const NamedEffect& of) {
  return {{"id", of.id},
          {"confidence", rounded(of.confidence)},
          {"gap_without_kPa", kPa(of.gap_without_Pa)},
          {"gap_with_kPa", kPa(of.gap_with_Pa)},
          {"parameters", to_json(of.parameters)},
          {"aliases", of.aliases},
          {"share", rounded(of.share)}};
}

Json to_json(const Candidate& of) {
  return {{"id", of.id},
          {"heldout_kPa", kPa(of.heldout_Pa)},
          {"confidence", rounded(of.confidence)},
          {"parameters", to_json(of.parameters)}};
}

Json to_json(const std::optional<Blame>& of) {
  if (!of) return nullptr;
  return {{"id", of->equation}, {"confidence", rounded(of->confidence)}};
}

Json to_json(const RegimeShare& of) {
  return {{"regime", of.regime}, {"share", rounded(of.share)}};
}

Json to_json(const std::optional<NextExperiment>& of) {
  if (!of) return nullptr;
  return {{"excitation", of->excitation},
          {"why", of->why},
          {"separates", of->separates},
          {"power", rounded(of->power)},
          {"instruction", of->instruction}};
}

Json to_json(const std::vector<CalibratedFigure>& calibration) {
  Json json = Json::object();
  for (const CalibratedFigure& of : calibration) {
    Json figure{{"configured", rounded(of.configured)}};
    figure.update(to_json(of.fitted));
    figure["with_effects"] = rounded(of.with_effects);
    json[of.name] = figure;
  }
  return json;
}

Json to_json(const Detectable& of) {
  return {{"id", of.id}, {"parameter", of.parameter}, {"smallest", rounded(of.smallest)}};
}

Json to_json(const Disturbance& of) {
  return {{"equation", of.equation},     {"probability", rounded(of.probability)},
          {"size", rounded(of.size)},    {"unit", of.unit},
          {"depends_on", of.depends_on}, {"dependence", rounded(of.dependence)}};
}

Json to_json(const std::optional<Baseline>& of) {
  if (!of) return nullptr;
  Json ids = Json::array();
  Json parameters = Json::object();
  for (const NamedEffect& effect : of->effects) {
    ids.push_back(effect.id);
    parameters[effect.id] = to_json(effect.parameters);
  }
  return {{"verdict", name_of(of->verdict)},
          {"as_configured_kPa", kPa(of->as_configured_Pa)},
          {"with_effects_kPa", kPa(of->with_effects_Pa)},
          {"effects", ids},
          {"parameters", parameters}};
}

template <class One>
Json each(const std::vector<One>& all) {
  Json json = Json::array();
  for (const One& one : all) json.push_back(to_json(one));
  return json;
}

}  // namespace

nlohmann::ordered_json to_json(const GapReport& report) {
  return {{"schema", "plenum-gap/1"},
          {"gap_kPa",
           {{"as_configured", kPa(report.as_configured_Pa)},
            {"recalibrated", kPa(report.recalibrated_Pa)},
            {"with_effects", kPa(report.with_effects_Pa)},
            {"noise_floor", kPa(report.noise_floor_Pa)}}},
          {"closed_fraction", rounded(report.closed_fraction)},
          {"verdict", name_of(report.verdict)},
          {"effects", each(report.effects)},
          {"candidates", each(report.candidates)},
          {"equation", to_json(report.equation)},
          {"where", each(report.where)},
          {"next_experiment", to_json(report.next)},
          {"gap_p_value", rounded(report.gap_p_value)},
          {"calibration", to_json(report.calibration)},
          {"detectable", each(report.detectable)},
          {"alias_classes", report.alias_classes},
          {"disturbances", each(report.disturbances)},
          {"baseline", to_json(report.baseline)},
          {"stamped_early_s", rounded(report.stamped_early_s)}};
}

}  // namespace plenum::host::diagnose
