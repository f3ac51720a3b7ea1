#include "host-sim/tools/effects.hpp"

#include <cmath>
#include <memory>

#include "host-sim/tools/command.hpp"
#include "host-sim/tools/output.hpp"
#include "host-sim/trace/input_error.hpp"

namespace plenum::host::tools {
namespace {

using effects::Effect;
using effects::Parameter;

struct Options {
  std::vector<std::string> ids;
  Output output;
};

std::string text_of(double value) {
  return std::isfinite(value) ? fmt::format("{:g}", value) : std::string("infinity");
}

void print(const Output& output, const Effect& effect) {
  output.print("{}: {}\n", effect.id, effect.summary);
  output.print("  equation   {}\n", effects::name_of(effect.equation));
  output.print("  formula    {}\n", effect.formula);
  const char* title = "parameters";
  for (const Parameter& one : effect.parameters) {
    const Parameter of = one.of_any_size();
    output.print("  {:<10} {:<24} {} to {}, vanishes at {}: {}\n", title, of.name, text_of(of.low),
                 text_of(of.high), text_of(of.vanishes_at), of.what);
    title = "";
  }
  output.print("  source     {}\n\n", effect.source);
}

/// A finite number, or the word for what JSON cannot write as one.
Json json_of(double value) {
  return std::isfinite(value) ? Json(value) : Json(text_of(value));
}

Json json_of(const Effect& effect) {
  Json parameters = Json::array();
  for (const Parameter& one : effect.parameters) {
    const Parameter of = one.of_any_size();
    parameters.push_back({{"name", of.name},
                          {"what", of.what},
                          {"low", json_of(of.low)},
                          {"high", json_of(of.high)},
                          {"vanishes_at", json_of(of.vanishes_at)}});
  }
  return {{"id", effect.id},           {"equation", effects::name_of(effect.equation)},
          {"summary", effect.summary}, {"formula", effect.formula},
          {"parameters", parameters},  {"source", effect.source}};
}

int run(const Options& options) {
  std::vector<const Effect*> listed;
  for (const std::string& id : options.ids) listed.push_back(&effect_of(id, "ID"));
  if (listed.empty()) listed.assign(effects::catalogue().begin(), effects::catalogue().end());
  Json list = Json::array();
  for (const Effect* effect : listed) {
    print(options.output, *effect);
    list.push_back(json_of(*effect));
  }
  options.output.finish({{"effects", list}});
  return kDone;
}

}  // namespace

const Effect& effect_of(std::string_view id, std::string_view where) {
  if (const auto found = effects::find(id)) return *effects::kCatalogue[*found];
  std::string ids;
  for (const Effect* effect : effects::catalogue()) {
    ids += fmt::format("{}{}", ids.empty() ? "" : ", ", effect->id);
  }
  throw trace::InputError(fmt::format("{}: '{}' is no effect, expected {}", where, id, ids));
}

Command add_effects(Program& program) {
  const auto options = std::make_shared<Options>();
  Arguments arguments = program.command(
      "effects", "List the effects that a diagnosis knows: equation, parameters, bounds, source");
  arguments.option("ID", options->ids, "Only these (default: all)").type_name("ID");
  options->output.add_to(arguments);
  arguments.footer(example("  plenum effects spool_lag dead_time"));
  return {arguments, [options] { return run(*options); }};
}

}  // namespace plenum::host::tools
