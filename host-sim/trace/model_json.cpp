#include "host-sim/trace/model_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host-sim/trace/input_error.hpp"
#include "host-sim/trace/whole_file.hpp"

namespace plenum::host::trace {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kSchema = "plenum-model/1";
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Open ranges of the parameters, as kTassa9Names: the paper's Table I, and what is a voltage or a pressure
/// is positive.
struct Range {
  double above;
  double below;
};
constexpr std::array<Range, kTassa9Count> kRanges{{{2.0, 8.0},
                                                   {-kInfinity, kInfinity},
                                                   {-1.0, kInfinity},
                                                   {-kInfinity, kInfinity},
                                                   {-kInfinity, kInfinity},
                                                   {-kInfinity, kInfinity},
                                                   {-kInfinity, kInfinity},
                                                   {-1.0, 1.0},
                                                   {0.0, kInfinity},
                                                   {0.0, kInfinity},
                                                   {0.0, kInfinity},
                                                   {0.0, kInfinity}}};

std::string shown(const Json& value) {
  std::string text = value.dump();
  if (text.size() > 40) text = text.substr(0, 37) + "...";
  return text;
}

const Json& field(const Json& object, std::string_view name, std::string_view file,
                  std::string_view expected) {
  const auto found = object.find(name);
  if (found == object.end()) {
    throw InputError(fmt::format("{}: field '{}' is missing, expected {}", file, name, expected));
  }
  return *found;
}

void expect_text(const Json& object, std::string_view name, std::string_view expected,
                 std::string_view file) {
  const Json& value = field(object, name, file, fmt::format("\"{}\"", expected));
  if (!value.is_string() || value.get<std::string>() != expected) {
    throw InputError(
        fmt::format("{}: field '{}' is {}, expected \"{}\"", file, name, shown(value), expected));
  }
}

void check_values(const std::array<double, kTassa9Count>& values, std::string_view file) {
  for (std::size_t i = 0; i < kTassa9Count; ++i) {
    const auto [above, below] = kRanges[i];
    if (!(values[i] > above && values[i] < below)) {
      throw InputError(fmt::format("{}: field 'parameters.{}' is {}, expected a number above {} and below {}",
                                   file, kTassa9Names[i], values[i], above, below));
    }
  }
  if (!(values[10] > values[11])) {
    throw InputError(fmt::format("{}: field 'parameters.supply_kPa' is {}, expected above ambient_kPa = {}",
                                 file, values[10], values[11]));
  }
}

}  // namespace

ModelFile parse_model(std::string_view text, std::string_view file) {
  Json document;
  try {
    document = Json::parse(text);
  } catch (const Json::parse_error& error) {
    throw InputError(
        fmt::format("{}: byte {}: not JSON, expected a model of schema {}", file, error.byte, kSchema));
  } catch (const Json::out_of_range&) {
    throw InputError(fmt::format("{}: a number is too large, expected numbers of double precision", file));
  }
  if (!document.is_object()) {
    throw InputError(fmt::format("{}: {}, expected an object of schema {}", file, shown(document), kSchema));
  }
  expect_text(document, "schema", kSchema, file);
  ModelFile model;
  expect_text(document, "kind", model.kind, file);
  if (const auto chamber = document.find("chamber"); chamber != document.end() && !chamber->is_null()) {
    if (!chamber->is_number_unsigned() || chamber->get<std::uint64_t>() > 255) {
      throw InputError(fmt::format("{}: field 'chamber' is {}, expected a whole number from 0 to 255", file,
                                   shown(*chamber)));
    }
    model.chamber = chamber->get<unsigned>();
  }
  const Json& parameters = field(document, "parameters", file, "an object of named numbers");
  if (!parameters.is_object()) {
    throw InputError(fmt::format("{}: field 'parameters' is {}, expected an object of named numbers", file,
                                 shown(parameters)));
  }
  for (const auto& [name, value] : parameters.items()) {
    if (std::find(kTassa9Names.begin(), kTassa9Names.end(), name) == kTassa9Names.end()) {
      throw InputError(fmt::format("{}: field 'parameters.{}' is unknown, expected {}", file, name,
                                   fmt::join(kTassa9Names, ", ")));
    }
  }
  for (std::size_t i = 0; i < kTassa9Count; ++i) {
    const auto found = parameters.find(kTassa9Names[i]);
    if (found == parameters.end()) {
      throw InputError(
          fmt::format("{}: field 'parameters.{}' is missing, expected a number", file, kTassa9Names[i]));
    }
    if (!found->is_number()) {
      throw InputError(fmt::format("{}: field 'parameters.{}' is {}, expected a number", file,
                                   kTassa9Names[i], shown(*found)));
    }
    model.parameters[i] = found->get<double>();
  }
  check_values(model.parameters, file);
  if (const auto fit = document.find("fit"); fit != document.end()) {
    if (!fit->is_object()) {
      throw InputError(fmt::format("{}: field 'fit' is {}, expected an object", file, shown(*fit)));
    }
    model.fit = *fit;
  }
  return model;
}

ModelFile read_model(const std::filesystem::path& path) {
  return parse_model(read_whole_file(path), path.string());
}

std::string format_model(const ModelFile& model) {
  Json document;
  document["schema"] = kSchema;
  document["kind"] = model.kind;
  if (model.chamber) document["chamber"] = *model.chamber;
  for (std::size_t i = 0; i < kTassa9Count; ++i)
    document["parameters"][kTassa9Names[i]] = model.parameters[i];
  document["fit"] = model.fit;
  return document.dump(2) + '\n';
}

void write_model(const std::filesystem::path& path, const ModelFile& model) {
  const std::string text = format_model(model);
  parse_model(text, "model to write");
  write_whole_file(path, text);
}

}  // namespace plenum::host::trace
